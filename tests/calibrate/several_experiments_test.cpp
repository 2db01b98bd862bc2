// Several experiments compared as one: sums where sums belong, squares where chance adds up.
#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/compare/agreement.h"
#include "calibrate/compare/channel_comparison.h"
#include "tests/calibrate/toy_experiment.h"

namespace graintruth::calibrate {
namespace {

constexpr double noise = 0.002;  // m

// The toy as it is compared, with `scenes` scenes for its one condition.
ComparedExperiment compared(const Problem& problem, std::size_t scenes, double weight) {
  ComparedExperiment one = problem.all->experiments().front();
  one.weight = weight;
  one.layout.scenes = scenes;
  one.layout.conditions.front().scenes.clear();
  for (std::size_t scene = 0; scene < scenes; ++scene)
    one.layout.conditions.front().scenes.push_back(scene);
  return one;
}

// Two experiments, with two scenes and with one, and evaluations of both at once.
struct Pair {
  Problem one = toy::problem({}, 5, 1), other = toy::problem({}, 4, 2);
  ChannelComparison first{{compared(one, 2, 1.0)}}, second{{compared(other, 1, 1.0)}};
  ChannelComparison both{{compared(one, 2, 1.0), compared(other, 1, 3.0)}};

  // Scene after scene, two seeds each: the first experiment's four runs, then the second's two.
  Evaluation at(const ParameterSet& parameters, std::uint64_t seeds = 6) const {
    Evaluation evaluation{.parameters = parameters};
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
      evaluation.runs.push_back(toy::compared(one, toy::run(parameters, noise, 50 + seed)));
      evaluation.runs.back().seconds = 1.0;
    }
    return evaluation;
  }
  static std::span<const SimulatedRun> of_first(const Evaluation& evaluation) {
    return std::span(evaluation.runs).first(4);
  }
  static std::span<const SimulatedRun> of_second(const Evaluation& evaluation) {
    return std::span(evaluation.runs).last(2);
  }
};

TEST(SeveralExperiments, AddTheirObjectivesByTheirWeights) {
  const Pair pair;
  const Evaluation evaluation = pair.at(toy::parameters(0.3, 0.2, 0.7));
  EXPECT_DOUBLE_EQ(pair.both.objective(evaluation.runs),
                   pair.first.objective(Pair::of_first(evaluation)) +
                       3.0 * pair.second.objective(Pair::of_second(evaluation)));
  EXPECT_DOUBLE_EQ(pair.both.noise(evaluation.runs),
                   std::hypot(pair.first.noise(Pair::of_first(evaluation)),
                              3.0 * pair.second.noise(Pair::of_second(evaluation))));
}

TEST(SeveralExperiments, TheirObjectiveIsTheLossOfTheirResiduals) {
  const Pair pair;
  const Evaluation evaluation = pair.at(toy::parameters(0.3, 0.2, 0.7));
  const std::vector<double> residuals = pair.both.residuals(evaluation.runs);
  EXPECT_EQ(residuals.size(), pair.both.residual_count());
  EXPECT_EQ(pair.both.residual_count(), pair.first.residual_count() + pair.second.residual_count());
  EXPECT_DOUBLE_EQ(pair.both.loss(residuals), pair.both.objective(evaluation.runs));
  // Where an experiment has none, there are none: the emulator leaves such evaluations out
  Evaluation failed = evaluation;
  for (std::size_t run = 4; run < 6; ++run)
    failed.runs[run] = {.status = RunStatus::unstable, .seconds = 1.0};
  EXPECT_TRUE(pair.both.residuals(failed.runs).empty());
  EXPECT_TRUE(std::isfinite(pair.both.objective(failed.runs)));
  const Evaluation second = pair.both.part_of(failed, 1);
  EXPECT_EQ(second.failed, 2);
  EXPECT_EQ(second.seconds, 2.0);
  EXPECT_EQ(pair.both.part_of(failed, 0).failed, 0);
}

TEST(SeveralExperiments, ARunIsScoredByItsOwn) {
  const Pair pair;
  const SimulatedRun run = pair.at(toy::parameters(0.3, 0.2, 0.7)).runs.front();
  for (const std::size_t scene : {0U, 1U})
    EXPECT_EQ(pair.both.score_run(run, scene).objective, pair.first.score_run(run, 0).objective);
  EXPECT_EQ(pair.both.score_run(run, 2).objective, pair.second.score_run(run, 0).objective);
}

// n experiments of the same kind: their excesses add up n times, what chance allows sqrt(n) times
// (less, as n times the degrees of freedom know it better), so that together they tell apart what
// each of them cannot.
TEST(SeveralExperiments, TellMoreApartThanEachAlone) {
  const Pair pair;
  const ChannelComparison alone{{compared(pair.one, 1, 1.0)}};
  const ChannelComparison four{std::vector(4, compared(pair.one, 1, 1.0))};
  const auto fourfold = [](Evaluation evaluation) {
    const std::vector<SimulatedRun> once = evaluation.runs;
    for (int time = 1; time < 4; ++time)
      evaluation.runs.insert(evaluation.runs.end(), once.begin(), once.end());
    return evaluation;
  };
  const Evaluation best = pair.at(toy::parameters(0.2, 0.3, 0.7)),
                   other = pair.at(toy::parameters(0.215, 0.3, 0.7));
  const double half_width = alone.half_width_of_difference(best, other, {});
  const double of_four = four.half_width_of_difference(fourfold(best), fourfold(other), {});
  EXPECT_LT(of_four, 2.0 * half_width);
  EXPECT_GT(of_four, 2.0 * half_width * 1.96 / critical_value(Critical::student_t, 5));
  EXPECT_NEAR(four.objective(fourfold(other).runs), 4.0 * alone.objective(other.runs), 1e-12);
  // t S - D of one, and of four 2 t S - 4 D
  const double distance = half_width - alone.allowed_excess(best, other, {});
  EXPECT_NEAR(four.allowed_excess(fourfold(best), fourfold(other), {}),
              std::max(0.0, of_four - 4.0 * distance),
              1e-12);
}

TEST(SeveralExperiments, HaveAFormWhereAllHaveIt) {
  const Pair pair;
  const auto form = datasets::ObjectiveForm::requested;
  const auto requested = pair.both.with_form(form);
  ASSERT_NE(requested, nullptr);
  EXPECT_EQ(requested->form(), form);
  const Evaluation evaluation = pair.at(toy::parameters(0.3, 0.2, 0.7));
  EXPECT_DOUBLE_EQ(requested->objective(evaluation.runs),
                   pair.first.with_form(form)->objective(Pair::of_first(evaluation)) +
                       3.0 * pair.second.with_form(form)->objective(Pair::of_second(evaluation)));
}

}  // namespace
}  // namespace graintruth::calibrate
