// Which of a few parameter sets wins where chance jams a run now and then.
#include "calibrate/search/choice.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/calibrate/stub_comparison.h"

namespace graintruth::calibrate {
namespace {

constexpr int seeds = 10;
constexpr double jam = 40.0;

// The objective of runs is the mean of what each holds as its place.
class MeanOfRuns final : public StubComparison {
 public:
  double objective(std::span<const SimulatedRun> runs) const override {
    double sum = 0.0;
    for (const SimulatedRun& run : runs) sum += run.channels[0].values[0];
    return sum / static_cast<double>(runs.size());
  }
};

// Seeds do the same to all: a wave of this size on top of `level`; `own` is what one parameter set
// makes of a seed beside that.
Evaluation evaluation(double level, double own = 0.0, const std::set<int>& jams = {}) {
  constexpr double common = 0.5;
  Evaluation evaluation;
  for (int seed = 0; seed < seeds; ++seed) {
    SimulatedRun run;
    const double x = level + common * std::sin(2.0 * seed) + own * std::cos(3.0 * seed);
    run.channels = {{.values = {jams.contains(seed) ? jam : x}}};
    evaluation.runs.push_back(run);
  }
  evaluation.objective = MeanOfRuns().objective(evaluation.runs);
  return evaluation;
}

struct ChoiceTest : testing::Test {
  MeanOfRuns comparison;
  Prior prior;
  Choice choice{comparison, prior, 1};
};

TEST_F(ChoiceTest, OneJamAmongTenRunsDoesNotDecide) {
  std::vector<Evaluation> candidates = {evaluation(1.2), evaluation(1.0, 0.0, {4})};
  ASSERT_GT(candidates[1].objective, candidates[0].objective);
  const double jammed = candidates[1].objective;
  choice.sort(candidates);
  EXPECT_EQ(candidates.front().objective, jammed);
}

TEST_F(ChoiceTest, JamsThatAreNotRareDo) {
  std::vector<Evaluation> candidates = {evaluation(1.0, 0.0, {1, 4, 7}), evaluation(1.2)};
  const double free = candidates[1].objective;
  choice.sort(candidates);
  EXPECT_EQ(candidates.front().objective, free);
}

TEST_F(ChoiceTest, TheLowerOfTwoWithoutJamsWins) {
  std::vector<Evaluation> candidates = {evaluation(1.1), evaluation(1.0), evaluation(1.2)};
  choice.sort(candidates);
  EXPECT_LT(candidates[0].objective, candidates[1].objective);
  EXPECT_LT(candidates[1].objective, candidates[2].objective);
}

// The difference's standard error comes from what the two do not have in common: about
// 0.3/sqrt(2 * 10) = 0.07 here, while either alone knows its mean to 0.11 only.
TEST_F(ChoiceTest, AsGoodMeansWithinOneStandardErrorOfTheDifference) {
  const Evaluation reference = evaluation(1.0);
  EXPECT_TRUE(choice.is_as_good(evaluation(1.03, 0.3), reference));
  EXPECT_FALSE(choice.is_as_good(evaluation(1.15, 0.3), reference));
  EXPECT_TRUE(choice.is_as_good(evaluation(0.9, 0.3), reference));
  EXPECT_FALSE(choice.is_as_good(evaluation(1.03, 0.03), reference));
}

TEST_F(ChoiceTest, AJamOfEitherDoesNotMakeThemAlike) {
  const Evaluation reference = evaluation(1.0, 0.0, {2});
  EXPECT_FALSE(choice.is_as_good(evaluation(1.4, 0.3, {6}), reference));
  EXPECT_TRUE(choice.is_as_good(evaluation(0.9, 0.3, {6}), reference));
}

TEST_F(ChoiceTest, ScenesShareTheirSeeds) {
  Evaluation two = evaluation(1.0, 0.0, {3});
  const Evaluation second = evaluation(2.0, 0.0, {3});
  two.runs.insert(two.runs.end(), second.runs.begin(), second.runs.end());
  two.objective = comparison.objective(two.runs);
  std::vector<SimulatedRun> rest;
  for (const double level : {1.0, 2.0}) {
    const Evaluation one = evaluation(level);
    for (int seed = 0; seed < seeds; ++seed) {
      if (seed != 3) rest.push_back(one.runs[static_cast<std::size_t>(seed)]);
    }
  }
  EXPECT_DOUBLE_EQ(Choice(comparison, prior, 2).typical_total(two), comparison.objective(rest));
}

}  // namespace
}  // namespace graintruth::calibrate
