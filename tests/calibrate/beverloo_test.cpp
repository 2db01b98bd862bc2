#include "calibrate/flow/beverloo.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include "tests/support/read_rows.h"

namespace graintruth::calibrate {
namespace {

using tests::number;

constexpr double centimetre = 0.01;
constexpr double gram = 1e-3;
constexpr double gravity = 9.81;
// Semi-axes 0.69 and 0.53 cm (errata 12)
const double equivalent_diameter = 2.0 * std::sqrt(0.69 * 0.53) * centimetre;

std::vector<DischargeRate> thesis_rates(const std::string& table, double diameter) {
  std::vector<DischargeRate> rates;
  for (const tests::Row& row : tests::read_rows(std::filesystem::path(GRAINTRUTH_SOURCE_DIR) /
                                                "datasets/thesis" / (table + ".csv"))) {
    rates.push_back({.orifice = number(row, "orifice_D_cm") * centimetre,
                     .rate = number(row, "flow_rate_q_g_per_s") * gram,
                     .density = number(row, "areal_density_rho_g_per_cm2") * 10.0,
                     .particle_diameter = diameter});
  }
  return rates;
}
const std::string experiment = "table_4_4_beverloo_experiment";
const std::string simulation = "table_4_5_beverloo_simulation";

double mean_coefficient(const std::vector<DischargeRate>& rates, double k) {
  double mean = 0.0;
  for (const DischargeRate& rate : rates)
    mean += beverloo_coefficient(BeverlooLaw::slot, rate, k, gravity) /
            static_cast<double>(rates.size());
  return mean;
}

TEST(Beverloo, LineIsTheThesiss) {
  const struct {
    std::string table;
    double zero_cm, k_with_printed_d, k;
  } cases[] = {{experiment, 0.889, 0.741, 0.735}, {simulation, 2.104, 1.753, 1.740}};
  for (const auto& expected : cases) {
    const auto rates = thesis_rates(expected.table, equivalent_diameter);
    ASSERT_EQ(rates.size(), 5U);
    const BeverlooLine line = fit_beverloo_line(BeverlooLaw::slot, rates);
    EXPECT_NEAR(line.zero / centimetre, expected.zero_cm, 5e-4);
    EXPECT_NEAR(line.zero / (1.2 * centimetre), expected.k_with_printed_d, 5e-4);
    EXPECT_NEAR(line.zero / equivalent_diameter, expected.k, 5e-4);
  }
}

TEST(Beverloo, CoefficientsAreTheThesiss) {
  const auto measured = thesis_rates(experiment, equivalent_diameter);
  const double printed[] = {0.3935, 0.3691, 0.3965, 0.3907, 0.3969};  // errata 10
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(thesis_coefficient(measured[i], 0.74, gravity), printed[i], 5e-5);
  EXPECT_NEAR(mean_coefficient(thesis_rates(experiment, 1.2 * centimetre), 0.74), 0.470, 5e-4);
  EXPECT_NEAR(mean_coefficient(thesis_rates(simulation, 1.2 * centimetre), 0.74), 0.465, 5e-4);
}

TEST(Beverloo, JointFitOfTheThesissTables) {
  const struct {
    std::string table;
    double C, k;
  } cases[] = {{experiment, 0.497, 0.928}, {simulation, 0.702, 1.976}};
  for (const auto& expected : cases) {
    const LeastSquaresFit fit =
        fit_beverloo(BeverlooLaw::slot, thesis_rates(expected.table, equivalent_diameter), gravity);
    EXPECT_TRUE(fit.converged);
    EXPECT_NEAR(fit.parameters[0], expected.C, 0.005);
    EXPECT_NEAR(fit.parameters[1], expected.k, 0.005);
    const double correlation =
        fit.covariance(0, 1) / (fit.standard_error(0) * fit.standard_error(1));
    EXPECT_GT(correlation, 0.9) << "C and k trade off";
  }
}

TEST(Beverloo, LawOf1961GivesItsOwnConstants) {
  const auto file = tests::outside_reference("beverloo/beverloo_1961_law_values.csv");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not here";
  std::vector<DischargeRate> rates;
  for (const tests::Row& row : tests::read_rows(file))
    rates.push_back({.orifice = number(row, "D0_cm") * centimetre,
                     .rate = number(row, "W_g_s") * gram,
                     .density = number(row, "rho_g_cm3") * 1000.0,
                     .particle_diameter = number(row, "d_cm") * centimetre});
  const LeastSquaresFit fit = fit_beverloo(BeverlooLaw::circular, rates, gravity);
  EXPECT_NEAR(fit.parameters[0], 35.0 / 60.0, 1e-8);
  EXPECT_NEAR(fit.parameters[1], 1.4, 1e-8);
}

// Intervals of repeated noisy rates hold the truth as often as they say: 95 % of 1000 is 950 +- 7.
TEST(Beverloo, IntervalsCover) {
  std::mt19937 random(11);
  std::normal_distribution<double> noise;
  int with_C = 0, with_k = 0;
  constexpr int repeats = 1000;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    std::vector<DischargeRate> rates = thesis_rates(experiment, equivalent_diameter);
    for (DischargeRate& rate : rates) {
      rate.rate = beverloo_rate(BeverlooLaw::slot, rate, 0.55, 1.3, gravity);
      rate.standard_uncertainty = 0.02 * rate.rate;
      rate.rate += rate.standard_uncertainty * noise(random);
    }
    const LeastSquaresFit fit = fit_beverloo(BeverlooLaw::slot, rates, gravity);
    with_C += std::abs(fit.parameters[0] - 0.55) < fit.half_width_95(0);
    with_k += std::abs(fit.parameters[1] - 1.3) < fit.half_width_95(1);
  }
  EXPECT_GE(with_C, 930);
  EXPECT_LE(with_C, 970);
  EXPECT_GE(with_k, 930);
  EXPECT_LE(with_k, 970);
}

// Rates that follow the law to the last digit leave residuals of rounding alone.
TEST(Beverloo, ExactRatesConverge) {
  for (const BeverlooLaw law : {BeverlooLaw::slot, BeverlooLaw::circular}) {
    for (const double k : {0.14, 1.0, 1.4, 2.9, 3.9}) {
      for (const double C : {5.8e-4, 0.58, 580.0}) {
        std::vector<DischargeRate> rates;
        for (const double orifice : {0.012, 0.015, 0.018, 0.022, 0.026, 0.030}) {
          DischargeRate at{.orifice = orifice, .density = 1450.0, .particle_diameter = 0.003};
          at.rate = beverloo_rate(law, at, C, k, 9.81);
          rates.push_back(at);
        }
        const LeastSquaresFit fit = fit_beverloo(law, rates, 9.81);
        EXPECT_TRUE(fit.converged) << k << ' ' << C;
        EXPECT_NEAR(fit.parameters[0], C, 1e-9 * C);
        EXPECT_NEAR(fit.parameters[1], k, 1e-9 * k);
      }
    }
  }
}

TEST(Beverloo, UncertaintiesAreOfAllOrOfNone) {
  std::vector<DischargeRate> rates;
  for (const double orifice : {0.02, 0.03, 0.04, 0.05}) {
    DischargeRate at{.orifice = orifice, .density = 1450.0, .particle_diameter = 0.003};
    at.rate = beverloo_rate(BeverlooLaw::circular, at, 0.58, 1.4, 9.81);
    at.standard_uncertainty = 0.01 * at.rate;
    rates.push_back(at);
  }
  EXPECT_NO_THROW(fit_beverloo(BeverlooLaw::circular, rates, 9.81));
  rates[1].standard_uncertainty = 0.0;
  EXPECT_THROW(fit_beverloo(BeverlooLaw::circular, rates, 9.81), std::invalid_argument);
}

}  // namespace
}  // namespace graintruth::calibrate
