// Several comparisons as one: sums where sums belong, squares where chance adds up.
#include "calibrate/joint_comparison.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/ensemble.h"
#include "tests/calibrate/toy_experiment.h"

namespace graintruth::calibrate {
namespace {

constexpr double noise = 0.002;  // m

// Two experiments with `scenes` scenes each, and evaluations of both at once.
struct Pair {
  std::shared_ptr<const TrackComparison> first = toy::problem({}, 5, 1).comparison;
  std::shared_ptr<const TrackComparison> second = toy::problem({}, 4, 2).comparison;
  JointComparison joint{{{first, 2, 1.0}, {second, 1, 3.0}}};

  // Scene after scene, two seeds each: the first experiment's four runs, then the second's two.
  static Evaluation at(const ParameterSet& parameters) {
    Evaluation evaluation{.parameters = parameters};
    for (std::uint64_t seed = 0; seed < 6; ++seed)
      evaluation.runs.push_back(
          {.trajectories = toy::run(parameters, noise, 50 + seed), .seconds = 1.0});
    return evaluation;
  }
  static std::span<const SimulatedRun> of_first(const Evaluation& evaluation) {
    return std::span(evaluation.runs).first(4);
  }
  static std::span<const SimulatedRun> of_second(const Evaluation& evaluation) {
    return std::span(evaluation.runs).last(2);
  }
};

TEST(JointComparison, AddsObjectivesByTheirWeights) {
  const Pair pair;
  const Evaluation evaluation = Pair::at({0.3, 0.2, 0.7});
  EXPECT_DOUBLE_EQ(pair.joint.objective(evaluation.runs),
                   pair.first->objective(Pair::of_first(evaluation)) +
                       3.0 * pair.second->objective(Pair::of_second(evaluation)));
  EXPECT_DOUBLE_EQ(pair.joint.noise(evaluation.runs),
                   std::hypot(pair.first->noise(Pair::of_first(evaluation)),
                              3.0 * pair.second->noise(Pair::of_second(evaluation))));
}

TEST(JointComparison, ItsObjectiveIsTheLossOfItsResiduals) {
  const Pair pair;
  const Evaluation evaluation = Pair::at({0.3, 0.2, 0.7});
  const std::vector<double> residuals = pair.joint.residuals(evaluation.runs);
  EXPECT_EQ(residuals.size(), pair.joint.residual_count());
  EXPECT_EQ(pair.joint.residual_count(),
            pair.first->residual_count() + pair.second->residual_count());
  EXPECT_DOUBLE_EQ(pair.joint.loss(residuals), pair.joint.objective(evaluation.runs));
  // Where an experiment has none, there are none: the emulator leaves such evaluations out
  Evaluation failed = evaluation;
  for (std::size_t run = 4; run < 6; ++run)
    failed.runs[run] = {.status = RunStatus::unstable, .seconds = 1.0};
  EXPECT_TRUE(pair.joint.residuals(failed.runs).empty());
  EXPECT_TRUE(std::isfinite(pair.joint.objective(failed.runs)));
  const Evaluation second = pair.joint.part_of(failed, 1);
  EXPECT_EQ(second.failed, 2);
  EXPECT_EQ(second.seconds, 2.0);
  EXPECT_EQ(pair.joint.part_of(failed, 0).failed, 0);
}

TEST(JointComparison, ScoresARunByItsOwnExperiment) {
  const Pair pair;
  const SimulatedRun run = Pair::at({0.3, 0.2, 0.7}).runs.front();
  for (const std::size_t scene : {0U, 1U})
    EXPECT_EQ(pair.joint.score_run(run, scene).objective, pair.first->score_run(run, 0).objective);
  EXPECT_EQ(pair.joint.score_run(run, 2).objective, pair.second->score_run(run, 0).objective);
}

// One experiment as a whole is that experiment.
TEST(JointComparison, OfOneIsThatOne) {
  const auto alone = toy::problem({}, 5, 1).comparison;
  const JointComparison joint({{alone, 1, 1.0}});
  const Evaluation best = Pair::at({0.2, 0.3, 0.7});
  for (const double friction : {0.2, 0.21, 0.25, 0.4}) {
    const Evaluation other = Pair::at({friction, 0.3, 0.7});
    EXPECT_DOUBLE_EQ(joint.objective(other.runs), alone->objective(other.runs));
    EXPECT_DOUBLE_EQ(joint.half_width_of_difference(best, other, {}, {}),
                     alone->half_width_of_difference(best, other, {}, {}));
    EXPECT_NEAR(joint.allowed_excess(best, other, {}, {}),
                alone->allowed_excess(best, other, {}, {}),
                1e-12);
  }
}

// n experiments of the same kind: their excesses add up n times, what chance allows sqrt(n) times,
// so that together they tell apart what each of them cannot.
TEST(JointComparison, TellsMoreApartThanEachAlone) {
  const auto alone = toy::problem({}, 5, 1).comparison;
  const JointComparison four({{alone}, {alone}, {alone}, {alone}});
  const auto fourfold = [](Evaluation evaluation) {
    const std::vector<SimulatedRun> once = evaluation.runs;
    for (int time = 1; time < 4; ++time)
      evaluation.runs.insert(evaluation.runs.end(), once.begin(), once.end());
    return evaluation;
  };
  const Evaluation best = Pair::at({0.2, 0.3, 0.7}), other = Pair::at({0.215, 0.3, 0.7});
  const double half_width = alone->half_width_of_difference(best, other, {}, {});
  EXPECT_DOUBLE_EQ(four.half_width_of_difference(fourfold(best), fourfold(other), {}, {}),
                   2.0 * half_width);
  EXPECT_DOUBLE_EQ(four.objective(fourfold(other).runs), 4.0 * alone->objective(other.runs));
  // t S - D of one; 2 t S - 4 D of four
  const double distance = half_width - alone->allowed_excess(best, other, {}, {});
  EXPECT_NEAR(four.allowed_excess(fourfold(best), fourfold(other), {}, {}),
              std::max(0.0, 2.0 * half_width - 4.0 * distance),
              1e-12);
}

TEST(JointComparison, HasAFormWhereAllHaveIt) {
  const Pair pair;
  const auto requested = pair.joint.with_form(datasets::ObjectiveForm::requested);
  ASSERT_NE(requested, nullptr);
  EXPECT_EQ(requested->form(), datasets::ObjectiveForm::requested);
  const Evaluation evaluation = Pair::at({0.3, 0.2, 0.7});
  EXPECT_DOUBLE_EQ(requested->objective(evaluation.runs),
                   pair.first->with_form(datasets::ObjectiveForm::requested)
                           ->objective(Pair::of_first(evaluation)) +
                       3.0 * pair.second->with_form(datasets::ObjectiveForm::requested)
                                 ->objective(Pair::of_second(evaluation)));
}

}  // namespace
}  // namespace graintruth::calibrate
