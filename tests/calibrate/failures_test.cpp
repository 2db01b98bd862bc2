#include "calibrate/result/failures.h"

#include <gtest/gtest.h>

#include <array>

namespace graintruth::calibrate {
namespace {

constexpr std::array<std::size_t, 3> scenes = {0, 1, 2};

// Two conditions, the second with two scenes; two seeds each. `failed` says which runs did.
Failures of(const std::vector<std::size_t>& failed) {
  Problem problem;
  problem.conditions = {{.name = "orifice width 40 mm"}, {.name = "orifice width 60 mm"}};
  problem.scenes = {{.condition = 0}, {.condition = 1}, {.condition = 1}};
  Evaluation evaluation;
  evaluation.runs.resize(6);
  for (const std::size_t run : failed) {
    evaluation.runs[run].status = RunStatus::unstable;
    evaluation.runs[run].message = "a particle moved too far";
  }
  count_runs(evaluation);
  return failures_of(problem, scenes, evaluation);
}

TEST(Failures, AreSilentWhereThereAreNone) {
  EXPECT_EQ(of({}).sentence, "");
  EXPECT_FALSE(of({}).are_too_many);
}

TEST(Failures, AreToldWhereTheyAreFew) {
  const Failures failures = of({0, 3});
  EXPECT_EQ(failures.sentence, "2 of 6 simulations failed (unstable: a particle moved too far)");
  EXPECT_FALSE(failures.are_too_many);
}

// Half of them may fail, and no more.
TEST(Failures, AreTooManyAboveHalf) {
  EXPECT_FALSE(of({0, 2, 4}).are_too_many);
  EXPECT_TRUE(of({0, 2, 3, 4}).are_too_many);
}

TEST(Failures, AreTooManyWhereNothingOfAConditionIsLeft) {
  const Failures failures = of({0, 1});
  EXPECT_TRUE(failures.are_too_many);
  EXPECT_EQ(failures.sentence,
            "2 of 6 simulations failed, all of orifice width 40 mm (unstable: a particle moved too "
            "far)");
  EXPECT_FALSE(of({2, 3}).are_too_many) << "another scene of the condition is left";
}

}  // namespace
}  // namespace graintruth::calibrate
