// Calibration data whose truth is known and that do not determine everything (GrainLearning's
// tutorials). Others' files, read from outside the repository.
#include <gtest/gtest.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <filesystem>

#include "calibrate/search/least_squares.h"
#include "tests/support/read_rows.h"

namespace graintruth::calibrate {
namespace {

using Vector = Eigen::VectorXd;

const std::filesystem::path folder =
    std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "../shared/references/calibration_known_truth";

struct Samples {
  Vector x, y;
};

Samples samples_of(const char* file, const char* x, const char* y) {
  const auto rows = tests::read_rows(folder / file);
  Samples samples{Vector(rows.size()), Vector(rows.size())};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    samples.x[static_cast<Eigen::Index>(i)] = tests::number(rows[i], x);
    samples.y[static_cast<Eigen::Index>(i)] = tests::number(rows[i], y);
  }
  return samples;
}

class KnownTruth : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
  }
};

TEST_F(KnownTruth, OfAStraightLine) {
  const Samples line = samples_of("linear.csv", "u", "f");
  const LeastSquaresFit fit = fit_least_squares(
      [&](const Vector& p) -> Vector { return ((p[0] * line.x).array() + p[1]).matrix() - line.y; },
      Vector{{0.9, 1.0}});
  EXPECT_NEAR(fit.parameters[0], 0.2, 1e-8);
  EXPECT_NEAR(fit.parameters[1], 5.0, 1e-8);
  EXPECT_EQ(fit.undetermined.cols(), 0);
}

// Two equal spheres of 1 mm:  F = 4/3 E* sqrt(R/2) u^(3/2),  E* = E / (2 (1 - nu^2))
constexpr double radius = 1.0;             // mm
constexpr double effective = 1.0391991e9;  // Pa

Vector hertz(double modulus, const Vector& overlap) {
  return 4.0 / 3.0 * modulus * std::sqrt(radius / 2.0) * overlap.array().pow(1.5);
}

double effective_modulus(const Vector& p) {
  return std::pow(10.0, p[0]) / (2.0 * (1.0 - p[1] * p[1]));
}

TEST_F(KnownTruth, OfTwoSpheresDeterminesTheEffectiveModulusAlone) {
  const Samples press = samples_of("hertz_two_spheres.csv", "overlap_mm", "normal_force");
  const auto residuals = [&](const Vector& p) -> Vector {
    if (!(std::abs(p[1]) < 1.0)) return Vector::Constant(press.x.size(), NAN);
    return hertz(effective_modulus(p), press.x) - press.y;
  };
  for (const double poisson : {0.05, 0.2, 0.45}) {
    const LeastSquaresFit fit = fit_least_squares(residuals, Vector{{8.5, poisson}});
    EXPECT_NEAR(effective_modulus(fit.parameters), effective, 1e-6 * effective) << poisson;
    EXPECT_FALSE(fit.determines(0) || fit.determines(1)) << poisson;
    ASSERT_EQ(fit.undetermined.cols(), 1) << poisson;
    // Along what is named E* stays: its derivative there is 0
    const Vector along = fit.undetermined.col(0).cwiseProduct(fit.parameters) * 1e-4;
    const double change = effective_modulus(fit.parameters + along) / effective - 1.0;
    const double across =
        effective_modulus(fit.parameters + Vector{{along[0], -along[1]}}) / effective - 1.0;
    EXPECT_LT(std::abs(change), 1e-3 * std::abs(across)) << poisson;
  }
}

TEST_F(KnownTruth, IsInsideTheIntervalAsOftenAsItSays) {
  const Samples press = samples_of("hertz_two_spheres.csv", "overlap_mm", "normal_force");
  const Samples line = samples_of("linear.csv", "u", "f");
  constexpr int repeats = 1000;
  boost::random::mt19937_64 generator(20);
  boost::random::normal_distribution<double> normal;
  int moduli = 0, slopes = 0, offsets = 0;
  const auto noisy = [&](const Vector& exact) {
    Vector values = exact;
    for (double& value : values) value *= 1.0 + 0.01 * normal(generator);
    return values;
  };
  for (int repeat = 0; repeat < repeats; ++repeat) {
    // Errors are relative, so residuals are too.
    const Vector force = noisy(hertz(effective, press.x));
    const LeastSquaresFit hertz_fit = fit_least_squares(
        [&](const Vector& p) -> Vector {
          return (hertz(1e9 * p[0], press.x).array() / force.array() - 1.0).matrix();
        },
        Vector{{1.0}});
    moduli += std::abs(hertz_fit.parameters[0] - effective / 1e9) <= hertz_fit.half_width_95(0);
    const Vector measured = noisy(((0.2 * line.x).array() + 5.0).matrix());
    const LeastSquaresFit line_fit = fit_least_squares(
        [&](const Vector& p) -> Vector {
          return (((p[0] * line.x).array() + p[1]) / measured.array() - 1.0).matrix();
        },
        Vector{{0.5, 1.0}});
    slopes += std::abs(line_fit.parameters[0] - 0.2) <= line_fit.half_width_95(0);
    offsets += std::abs(line_fit.parameters[1] - 5.0) <= line_fit.half_width_95(1);
  }
  for (const int held : {moduli, slopes, offsets}) {
    EXPECT_GE(held, 930);
    EXPECT_LE(held, 970);
  }
}

}  // namespace
}  // namespace graintruth::calibrate
