// The emulator where the compared numbers are known functions of the parameters, and what it
// proposes.
#include "calibrate/search/emulator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calibrate/compare/objective.h"
#include "calibrate/search/proposals.h"
#include "tests/calibrate/stub_comparison.h"

namespace graintruth::calibrate {
namespace {

constexpr int numbers = 40;

// z_k = (f_k(x) - f_k(truth)) / u: waves through the square, far finer known than they differ. A
// run's only channel holds its parameters.
class Waves final : public StubComparison {
 public:
  explicit Waves(UnitPoint truth, double uncertainty)
      : truth_(std::move(truth)), uncertainty_(uncertainty) {}

  std::vector<double> residuals_at(const UnitPoint& x) const {
    std::vector<double> z;
    for (int k = 0; k < numbers; ++k) z.push_back((wave(k, x) - wave(k, truth_)) / uncertainty_);
    return z;
  }
  double objective(std::span<const SimulatedRun> runs) const override {
    return loss(residuals(runs));
  }
  std::vector<double> residuals(std::span<const SimulatedRun> runs) const override {
    if (runs.front().status != RunStatus::completed) return {};
    return residuals_at(runs.front().channels[0].values);
  }
  double loss(std::span<const double> residuals) const override {
    double sum = 0.0;
    for (const double z : residuals) sum += pseudo_huber(z);
    return sum / static_cast<double>(residuals.size());
  }
  double noise(std::span<const SimulatedRun>) const override { return 1e-3; }

 private:
  static double wave(int k, const UnitPoint& x) {
    return std::sin(1.0 + 0.1 * k + (0.5 + 0.05 * k) * x[0] + (2.5 - 0.05 * k) * x[1]);
  }
  UnitPoint truth_;
  double uncertainty_;
};

ParameterSpace square() {
  return ParameterSpace(
      {{"friction_particle_particle", 0.0, 1.0}, {"friction_particle_wall", 0.0, 1.0}}, {});
}

Evaluation evaluation_at(const Comparison& comparison, const UnitPoint& x, bool fails = false) {
  Evaluation evaluation{.parameters = square().from_unit(x), .runs = std::vector<SimulatedRun>(1)};
  SimulatedRun& run = evaluation.runs.front();
  run.channels = {{.values = x}};
  run.status = fails ? RunStatus::unstable : RunStatus::completed;
  evaluation.failed = fails;
  evaluation.objective = fails ? 50.0 : comparison.objective(evaluation.runs);
  return evaluation;
}

std::vector<Evaluation> evaluations_at(const Comparison& comparison,
                                       const std::vector<UnitPoint>& places) {
  std::vector<Evaluation> evaluations;
  for (const UnitPoint& place : places) evaluations.push_back(evaluation_at(comparison, place));
  return evaluations;
}

TEST(Emulator, PredictsObjectivesBetweenItsPoints) {
  const Waves waves({0.4, 0.6}, 0.5);
  const Emulator emulator(waves, evaluations_at(waves, low_discrepancy_points(40, 2, 1)), square());
  const std::vector<UnitPoint> places = {{0.31, 0.62}, {0.7, 0.2}, {0.5, 0.5}, {0.4, 0.6}};
  const std::vector<double> objectives = emulator.objectives(places);
  for (std::size_t i = 0; i < places.size(); ++i)
    EXPECT_NEAR(objectives[i], waves.loss(waves.residuals_at(places[i])), 0.01) << i;
  EXPECT_LT(emulator.leave_one_out_error(), 0.1 * emulator.value_spread());
}

TEST(Emulator, DrawsWhatItPredictsNearItsPointsAndAnythingFarFromThem) {
  const Waves waves({0.4, 0.6}, 0.5);
  const Emulator emulator(
      waves,
      evaluations_at(waves, {{0.1, 0.1}, {0.3, 0.1}, {0.1, 0.3}, {0.3, 0.3}, {0.2, 0.2}}),
      square());
  const auto spread_of = [](const Emulator& one, const UnitPoint& place) {
    std::vector<double> drawn;
    for (const auto& draw : one.draw_objectives({&place, 1}, 64, 3)) drawn.push_back(draw.front());
    const auto [least, most] = std::minmax_element(drawn.begin(), drawn.end());
    return *most - *least;
  };
  const UnitPoint near = {0.21, 0.2}, far = {0.95, 0.95};
  EXPECT_LT(spread_of(emulator, near), 0.2 * spread_of(emulator, far));
  EXPECT_LT(spread_of(emulator.believing(far), far), 0.2 * spread_of(emulator, far));
  EXPECT_EQ(emulator.believing(far).objectives({&far, 1}), emulator.objectives({&far, 1}));
}

TEST(Emulator, ExpectsNothingWhereRunsFail) {
  const Waves waves({0.4, 0.6}, 0.5);
  std::vector<Evaluation> evaluations = evaluations_at(waves, low_discrepancy_points(20, 2, 1));
  evaluations.push_back(evaluation_at(waves, {0.9, 0.9}, true));
  const Emulator emulator(waves, evaluations, square());
  const UnitPoint place = {0.905, 0.9};
  EXPECT_EQ(emulator.objectives({&place, 1}).front(), 50.0);
  const std::vector<Evaluation> all_failed(3, evaluation_at(waves, {0.5, 0.5}, true));
  EXPECT_FALSE(Emulator(waves, all_failed, square()).knows_anything());
}

// The valley is 0.02 wide: of the objective itself twelve points show nothing but that it is high.
TEST(Propose, FindsANarrowValleyInAFewBatches) {
  for (const UnitPoint& truth :
       {UnitPoint{0.37, 0.81}, UnitPoint{0.72, 0.15}, UnitPoint{0.1, 0.5}}) {
    const Waves waves(truth, 0.02);
    std::vector<Evaluation> evaluations = evaluations_at(waves, low_discrepancy_points(12, 2, 3));
    const auto lowest = [&] {
      return std::min_element(evaluations.begin(), evaluations.end(), [](auto& a, auto& b) {
        return a.objective < b.objective;
      });
    };
    EXPECT_GT(lowest()->objective, 0.5);
    for (std::uint64_t round = 0; round < 8; ++round) {
      const Emulator emulator(waves, evaluations, square());
      const UnitPoint centre = square().to_unit(lowest()->parameters);
      const auto batch = propose(emulator, {lowest()->objective, 1e-3, {}}, {centre}, 2, round);
      ASSERT_EQ(batch.size(), 2U);
      EXPECT_NE(batch[0], batch[1]);
      EXPECT_EQ(propose(emulator, {lowest()->objective, 1e-3, {}}, {centre}, 2, round), batch);
      for (const UnitPoint& place : batch) evaluations.push_back(evaluation_at(waves, place));
    }
    EXPECT_LT(lowest()->objective, 0.05) << truth[0] << ", " << truth[1];
  }
}

// A dozen evaluations in the spot where the lowest prediction lies: with a crowd of eight it is
// left alone.
TEST(Propose, LeavesACrowdedPlaceAlone) {
  const UnitPoint truth = {0.5, 0.5};
  const Waves waves(truth, 0.02);
  std::vector<UnitPoint> places = low_discrepancy_points(12, 2, 3);
  for (int i = 0; i < 12; ++i) places.push_back({0.5 + 0.001 * i, 0.5 - 0.001 * i});
  const Emulator emulator(waves, evaluations_at(waves, places), square());
  constexpr double reach = 0.03;
  constexpr int crowd = 8;
  EXPECT_EQ(emulator.evaluations_near(truth, 0.0), 1);
  Aim aim{emulator.objectives({&truth, 1}).front() + 0.5, 1e-3, {}};
  EXPECT_GE(emulator.evaluations_near(propose(emulator, aim, {truth}, 1, 1).front(), reach), crowd);
  aim.crowd = crowd;
  const std::vector<UnitPoint> elsewhere = propose(emulator, aim, {truth}, 4, 1);
  EXPECT_EQ(elsewhere.size(), 4U);
  for (const UnitPoint& place : elsewhere)
    EXPECT_LT(emulator.evaluations_near(place, reach), crowd);
  aim.crowd = 0;
  EXPECT_TRUE(propose(emulator, aim, {truth}, 4, 1).empty());
}

// What is known of a place besides the data moves the proposals there.
TEST(Propose, HeedsWhatIsKnownBesides) {
  const Waves waves({0.5, 0.5}, 0.5);
  const std::vector<Evaluation> evaluations =
      evaluations_at(waves, low_discrepancy_points(30, 2, 3));
  const Emulator emulator(waves, evaluations, square());
  const Aim aim{1.0, 1e-3, [](const UnitPoint& place) {
                  return 1.0e3 * (place[0] - 0.2) * (place[0] - 0.2);
                }};
  EXPECT_NEAR(propose(emulator, aim, {{0.5, 0.5}}, 1, 1).front()[0], 0.2, 0.02);
}

}  // namespace
}  // namespace graintruth::calibrate
