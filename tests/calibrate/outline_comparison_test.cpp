// What chance does to outlines: columns err together, and so few seeds that they know little of
// themselves.
#include <gtest/gtest.h>

#include "calibrate/compare/repeated_rule.h"
#include "calibrate/knowledge/uncertainty.h"
#include "tests/calibrate/toy_heap.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

constexpr double sliding = 0.4, rolling = 0.12;

class OutlineComparison : public testing::Test {
 protected:
  // Two seeds at every one of these rolling frictions.
  static std::vector<Evaluation> evaluated(const Problem& problem,
                                           const std::vector<double>& frictions,
                                           toy::Contacts contacts,
                                           std::uint64_t first_seed = 5) {
    const tests::ClosedEngine engine = toy::heap_engine(contacts);
    std::vector<Evaluation> all;
    for (const double friction : frictions) {
      Evaluation& one = all.emplace_back();
      one.parameters = datasets::bench_parameters(problem.experiment);
      one.parameters.set("friction_particle_particle", sliding);
      one.parameters.set("rolling_friction_particle_particle", friction);
      for (const std::uint64_t seed : make_seeds(first_seed, "outline seeds", 2)) {
        const EngineRun made = engine.run(problem.spec_of(0, one.parameters, 0.05, seed), {});
        one.runs.push_back(
            {.channels = problem.observables->measure(
                 made.recording, problem.situations.front(), &problem.measured.front())});
      }
      one.objective = problem.calibrated->objective(one.runs);
    }
    return all;
  }

  tests::TemporaryFolder folder_;
};

TEST_F(OutlineComparison, SeedsThatScatterAnewAtEveryPlaceTellOfEachOther) {
  const Problem problem =
      toy::heap_problem(toy::heap_experiment(folder_.path(), 3), sliding, rolling, 1);
  std::vector<double> near;
  for (int i = 0; i < 9; ++i) near.push_back(rolling + 0.002 * (i - 4));
  // One degree of freedom from each of nine pairs of runs; but one in all where every pair differs
  // in the same way
  const auto freedom = [&](toy::Contacts contacts) {
    const auto seeds = problem.calibrated->seed_scatter(evaluated(problem, near, contacts));
    EXPECT_EQ(seeds.size(), 1U);
    return seeds.front().freedom;
  };
  EXPECT_GT(freedom(toy::Contacts::chaotic), 6.0);
  EXPECT_LE(freedom(toy::Contacts::chaotic), 9.0);
  EXPECT_NEAR(freedom(toy::Contacts::alike), 1.0, 0.2);
}

// At one place, with other seeds every time: what the objective differs by from the first of forty,
// against what is allowed for seeds as all of them together know it.
TEST_F(OutlineComparison, PooledSeedsScatterAsManyEvaluationsDo) {
  constexpr int many = 40;
  const Problem problem =
      toy::heap_problem(toy::heap_experiment(folder_.path(), 5), sliding, rolling, 1);
  std::vector<double> near;
  for (int i = 0; i < many; ++i) near.push_back(rolling + 1e-6 * i);
  const auto evaluations = evaluated(problem, near, toy::Contacts::chaotic);
  PooledChance chance;
  chance.seeds = problem.calibrated->seed_scatter(evaluations);
  int inside = 0;
  for (int i = 1; i < many; i += 2) {
    const Evaluation& one = evaluations[static_cast<std::size_t>(i)];
    const Evaluation& other = evaluations[static_cast<std::size_t>(i) - 1];
    inside += std::abs(one.objective - other.objective) <=
              problem.calibrated->half_width_of_difference(other, one, chance);
  }
  // Of 20 pairs at 95 %, fewer than 15 lie inside with probability 0.03 % (binomial)
  EXPECT_GE(inside, 15);
  // Nor is everything inside of what so many seeds allow
  double largest = 0.0;
  for (const Evaluation& one : evaluations) largest = std::max(largest, one.objective);
  const Evaluation& best = best_of(evaluations);
  EXPECT_LT(problem.calibrated->half_width_of_difference(best, evaluations[1], chance),
            2.0 * largest);
}

// At its edge a bed is seen in some replicates only, and a simulated one may not reach there: there
// are as many residuals whatever is left out, and what is bare counts as the bottom.
TEST(RepeatedRule, HasAsManyResidualsWhateverIsNotSeen) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Channel> replicates = {
      {.values = {5.0, 4.0, nan}}, {.values = {5.2, 4.4, 1.0}}, {.values = {5.4, 4.1, 2.0}}};
  const Layout layout{.conditions = {{.replicates = {0, 1, 2}, .scenes = {0}}}, .scenes = 1};
  const RepeatedRule rule(0,
                          ChannelShape{.widths = Widths::own_replicates},
                          datasets::ObjectiveForm::smooth,
                          layout,
                          replicates,
                          {0.1, 0.1, 0.2});
  const std::vector<SimulatedRun> runs = {{.channels = {{.values = {5.0, nan, nan}}}}};
  const auto digest = rule.digest(runs);
  const std::vector<double> all = rule.residuals(*digest, {}, {});
  ASSERT_EQ(all.size(), 3U);
  const auto& target = rule.target(0);
  EXPECT_DOUBLE_EQ(all[1], (0.1 - target.mean[1]) / target.half_widths[1]);
  EXPECT_DOUBLE_EQ(all[2], (0.2 - 1.5) / target.half_widths[2]);
  for (const std::size_t replicate : {0U, 1U, 2U}) {
    for (const auto mean : {Otherwise::Mean::as_it_is, Otherwise::Mean::without}) {
      const Otherwise otherwise{.mean = mean, .replicate = replicate, .widths_without = replicate};
      EXPECT_EQ(rule.residuals(*digest, {}, otherwise).size(), 3U) << replicate;
    }
  }
}

}  // namespace
}  // namespace graintruth::calibrate
