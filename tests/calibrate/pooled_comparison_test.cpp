// Numbers whose scatter is pooled over conditions: rates, what stays, profiles; and the laws that
// are fitted to them. What the comparison makes of replicates and runs that agree, differ, fail and
// jam.
#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/compare/channel_comparison.h"
#include "calibrate/compare/pooled_rule.h"
#include "calibrate/flow/beverloo.h"
#include "calibrate/flow/bulk_measure.h"
#include "calibrate/observables/flow_results.h"
#include "tests/calibrate/closed_bin.h"

namespace graintruth::calibrate {
namespace {

using closed_bin::parameters;

// The closed bin as a film would show it: a density and a profile beside each rate.
ComparedExperiment filmed(double noise, std::uint64_t seed) {
  const Problem problem = closed_bin::problem(parameters(0.3, 0.3, 0.7), noise, seed);
  ComparedExperiment compared = problem.calibrated->experiments().front();
  const Observables& observables = *compared.observables;
  for (std::size_t r = 0; r < compared.measured.size(); ++r) {
    std::vector<Channel>& channels = compared.measured[r];
    channels[*observables.find("flowing_density")].values = {6.0};
    Channel& profile = channels[*observables.find("velocity_profile")];
    const double rate = channels[*observables.find("discharge_rate")].values.front();
    profile.details["height_m"] = {0.08};
    profile.values.clear();
    // Films of one orifice differ in how wide it is
    const double width = 0.002 * (1.0 + 0.1 * static_cast<double>(r % 3));
    const std::size_t place = *observables.find("velocity_profile");
    for (const double x : observables.all()[place]->axis(compared.situations[r])) {
      profile.values.push_back(rate * std::exp(-x * x / width));
      for (const double value : {x, profile.values.back(), 0.0})
        profile.details["samples"].push_back(value);
    }
  }
  return compared;
}

// Runs that show what the replicates do.
std::vector<SimulatedRun> runs_of(const ComparedExperiment& compared) {
  std::vector<SimulatedRun> runs;
  for (const ComparedCondition& condition : compared.layout.conditions) {
    for (const std::size_t r : condition.replicates)
      runs.push_back({.channels = compared.measured[r]});
  }
  return runs;
}

Channel& channel_of(SimulatedRun& run, const ComparedExperiment& of, std::string_view observable) {
  return run.channels[*of.observables->find(observable)];
}

TEST(PooledComparison, RunsThatEqualTheReplicatesHaveNoObjective) {
  const ComparedExperiment bin = filmed(0.03, 1);
  EXPECT_NEAR(ChannelComparison({bin}).objective(runs_of(bin)), 0.0, 1e-15);
}

// z = (S - D)/(s sqrt(2/n)) for the rates alone, all other quantities being equal.
TEST(PooledComparison, RatesCountByTheirOwnScatter) {
  const ComparedExperiment bin = filmed(0.03, 1);
  const ChannelComparison comparison({bin});
  std::vector<SimulatedRun> runs = runs_of(bin);
  const double change = 0.05;
  for (SimulatedRun& run : runs) channel_of(run, bin, "discharge_rate").values[0] *= 1.0 + change;
  const auto& rule = static_cast<const PooledRule&>(*comparison.rule_of("discharge_rate"));
  EXPECT_EQ(rule.scatter().freedom, 6);  // three orifices of three
  const double z = change / (rule.scatter().standard_deviation * std::sqrt(2.0 / 3.0));
  for (const auto& [kind, value, weight] : comparison.shares(runs))
    EXPECT_NEAR(value, kind == "discharge_rate" ? pseudo_huber(z) : 0.0, 1e-9) << kind;
}

// Three replicates that agree by luck, of ten values each: a value is as uncertain as it says,
// however many there are.
TEST(PooledComparison, ValuesAreNoMoreExactThanTheySayAndNoLess) {
  constexpr double error = 0.1;
  constexpr std::size_t values = 10;
  const Channel channel{.values = std::vector<double>(values, 3.0),
                        .errors = std::vector<double>(values, error)};
  const Layout layout{.conditions = {{.replicates = {0, 1, 2}, .scenes = {0}}}, .scenes = 1};
  const PooledRule rule(0,
                        ChannelShape{},
                        [](const Channel& measured) { return measured.values; },
                        layout,
                        {channel, channel, channel});
  EXPECT_NEAR(rule.scatter().standard_deviation, error, 1e-12);
}

TEST(PooledComparison, FailedAndJammedRunsAreResults) {
  const ComparedExperiment bin = filmed(0.03, 1);
  const ChannelComparison comparison({bin});
  std::vector<SimulatedRun> runs = runs_of(bin);
  double last = comparison.objective(runs);
  for (SimulatedRun& run : runs) {
    run.status = RunStatus::unstable;
    run.channels.clear();
    const double objective = comparison.objective(runs);
    ASSERT_TRUE(std::isfinite(objective));
    EXPECT_GT(objective, last);
    last = objective;
  }
  EXPECT_TRUE(std::isfinite(comparison.noise(runs)));
  // A jam after three particles
  runs = runs_of(bin);
  for (SimulatedRun& run : runs) {
    channel_of(run, bin, "discharge_rate").values = {0.0};
    channel_of(run, bin, "what_stays").values = {197.0};
    for (double& v : channel_of(run, bin, "velocity_profile").values) v = std::nan("");
  }
  EXPECT_GT(comparison.objective(runs), 1.0);
  EXPECT_TRUE(std::isfinite(comparison.score_run(runs[0], 0).objective));
}

// Rates that all change by the same share change C by that share and nothing else.
TEST(PooledComparison, ComparesLawsInTheRequestedForm) {
  const ComparedExperiment bin = filmed(0.03, 1);
  const ChannelComparison smooth({bin});
  const ChannelComparison laws({bin}, datasets::ObjectiveForm::requested);
  std::vector<SimulatedRun> runs = runs_of(bin);
  EXPECT_NEAR(laws.objective(runs), 0.0, 1e-12);
  const double change = 0.05;
  for (SimulatedRun& run : runs) channel_of(run, bin, "discharge_rate").values[0] *= 1.0 + change;
  const std::vector<double> z = laws.residuals(runs);
  ASSERT_EQ(z.size(), 2U + 3U);  // C, k, and B of three orifices
  // The standard error of C as the fit to the means states it; both means scatter alike.
  const auto& rule = static_cast<const PooledRule&>(*smooth.rule_of("discharge_rate"));
  std::vector<DischargeRate> rates;
  for (std::size_t c = 0; c < bin.layout.conditions.size(); ++c) {
    const BulkRig rig = bulk_rig(bin.situations[bin.layout.conditions[c].replicates.front()]);
    const double rate = rule.means()[c].values.front();
    rates.push_back(
        {.orifice = rig.orifice,
         .rate = rate,
         .density = 6.0,
         .particle_diameter = rig.particle_diameter,
         .standard_uncertainty = rule.scatter().standard_deviation * rate / std::sqrt(3.0)});
  }
  const LeastSquaresFit fit = fit_beverloo(BeverlooLaw::slot, rates, 9.81);
  const double expected = change * fit.parameters[0] / (std::sqrt(2.0) * fit.standard_error(0));
  EXPECT_NEAR(z[0], expected, 0.02 * expected);
  EXPECT_NEAR(z[1], 0.0, 1e-3);
  for (std::size_t i = 2; i < z.size(); ++i) EXPECT_NEAR(z[i], 0.0, 1e-9);
  EXPECT_EQ(laws.loss(z), laws.objective(runs));
  EXPECT_EQ(smooth.loss(smooth.residuals(runs)), smooth.objective(runs));
  EXPECT_NEAR(laws.objective(runs), pseudo_huber(z[0]) / 3.0, 1e-6);
  EXPECT_GT(laws.noise(runs), 0.0);
  // Profiles twice as wide have a larger B, and nothing else changes
  runs = runs_of(bin);
  for (SimulatedRun& run : runs) {
    for (double& velocity : channel_of(run, bin, "velocity_profile").values)
      velocity = std::sqrt(velocity);
  }
  const std::vector<double> wide = laws.residuals(runs);
  EXPECT_NEAR(wide[0], 0.0, 1e-9);
  for (std::size_t i = 2; i < wide.size(); ++i) EXPECT_GT(wide[i], 1.0);
}

TEST(PooledComparison, ScoresJamsByTheirLawsAndRefusesCurvesThatTellNone) {
  const ComparedExperiment bin = filmed(0.03, 1);
  const ChannelComparison laws({bin}, datasets::ObjectiveForm::requested);
  std::vector<SimulatedRun> runs = runs_of(bin);
  double last = 0.0;
  for (SimulatedRun& run : runs) {
    run.status = RunStatus::unstable;
    run.channels.clear();
    last = laws.objective(runs);
    ASSERT_TRUE(std::isfinite(last));
  }
  EXPECT_GT(last, 1.0);
  EXPECT_TRUE(std::isfinite(laws.noise(runs)));
  const Problem weighed = closed_bin::problem(parameters(0.3, 0.3, 0.7), 0.03, 1);
  EXPECT_EQ(weighed.calibrated->with_form(datasets::ObjectiveForm::requested), nullptr);
  EXPECT_NE(weighed.calibrated->with_form(datasets::ObjectiveForm::smooth), nullptr);
}

TEST(Probability, IsJeffreysInterval) {
  // Brown, Cai and DasGupta (2001), table 5: n = 7, x = 0 and x = 2
  EXPECT_NEAR(probability_of(0, 7).upper, 0.292, 5e-4);
  EXPECT_EQ(probability_of(0, 7).lower, 0.0);
  EXPECT_NEAR(probability_of(2, 7).lower, 0.065, 5e-4);
  EXPECT_NEAR(probability_of(2, 7).upper, 0.648, 5e-4);
}

}  // namespace
}  // namespace graintruth::calibrate
