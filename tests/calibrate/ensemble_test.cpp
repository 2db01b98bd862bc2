#include "calibrate/ensemble.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/calibrate/toy_experiment.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

using tests::TemporaryFolder;

const std::vector<EvaluationPoint> points = {{{0.1, 0.2, 0.8}, 0.2}, {{0.4, 0.5, 0.6}, 0.2}};

TEST(Ensemble, GivesTheSameForAnyNumberOfThreads) {
  const TemporaryFolder folder;
  const Problem problem = toy::problem({}, 5, 1);
  const auto seeds = make_seeds(3, "test", 6);
  std::vector<double> objectives;
  for (const int jobs : {1, 4}) {
    Journal journal(folder / ("j" + std::to_string(jobs)));
    Ensemble ensemble(
        {Scene{problem.hash, toy::simulator(0.01)}}, journal, problem.comparison, jobs);
    for (const Evaluation& evaluation : ensemble.evaluate("test", points, seeds))
      objectives.push_back(evaluation.objective);
  }
  EXPECT_EQ(objectives[0], objectives[2]);
  EXPECT_EQ(objectives[1], objectives[3]);
}

TEST(Ensemble, RepeatsNoSimulationThatIsInTheJournal) {
  const TemporaryFolder folder;
  const Problem problem = toy::problem({}, 5, 1);
  const auto seeds = make_seeds(3, "test", 6);
  Journal journal(folder / "j.db");
  Ensemble first({Scene{problem.hash, toy::simulator(0.01)}}, journal, problem.comparison, 2);
  const auto before = first.evaluate("test", points, seeds);
  EXPECT_EQ(first.simulated(), 12);
  Ensemble second({Scene{problem.hash, toy::simulator(0.01)}}, journal, problem.comparison, 2);
  const auto after = second.evaluate("test", points, seeds);
  EXPECT_EQ(second.simulated(), 0);
  EXPECT_EQ(after[1].objective, before[1].objective);
}

TEST(Ensemble, ScoresRunsThatFailAndLivesOn) {
  const TemporaryFolder folder;
  const Problem problem = toy::problem({}, 5, 1);
  Journal journal(folder / "j.db");
  const Simulator failing = [](const SimulationRequest& request) {
    SimulatedRun run = toy::simulator(0.01)(request);
    if (request.parameters.friction_particle_particle > 0.3) run.status = RunStatus::unstable;
    return run;
  };
  Ensemble ensemble({Scene{problem.hash, failing}}, journal, problem.comparison, 2);
  const auto evaluations = ensemble.evaluate("test", points, make_seeds(3, "test", 4));
  EXPECT_EQ(evaluations[0].failed, 0);
  EXPECT_EQ(evaluations[1].failed, 4);
  EXPECT_EQ(
      evaluations[1].objective,
      objective_of_rest(problem.comparison->target().mean, problem.comparison->target().widths));
}

TEST(Ensemble, KeepsWhatEndedBeforeAnInterruption) {
  const TemporaryFolder folder;
  const Problem problem = toy::problem({}, 5, 1);
  Journal journal(folder / "j.db");
  int left = 5;
  const Simulator interrupted = [&left](const SimulationRequest& request) {
    if (left-- == 0) throw Interrupted();
    return toy::simulator(0.01)(request);
  };
  Ensemble ensemble({Scene{problem.hash, interrupted}}, journal, problem.comparison, 1);
  EXPECT_THROW(ensemble.evaluate("test", points, make_seeds(3, "test", 6)), Interrupted);
  EXPECT_EQ(journal.rows().size(), 5U);
}

TEST(MakeSeeds, AreDifferentAndFitIntoADouble) {
  std::set<std::uint64_t> all;
  for (const char* purpose : {"search", "choice", "confirmation"}) {
    for (const std::uint64_t seed : make_seeds(1, purpose, 1000)) {
      EXPECT_LT(seed, std::uint64_t{1} << 53);
      all.insert(seed);
    }
  }
  EXPECT_EQ(all.size(), 3000U);
  EXPECT_EQ(make_seeds(1, "search", 5), make_seeds(1, "search", 5));
  EXPECT_NE(make_seeds(1, "search", 5), make_seeds(2, "search", 5));
}

// The jackknife of the ensemble objective against the spread of many ensembles.
TEST(ObjectiveNoise, IsTheSpreadOverEnsembles) {
  const TemporaryFolder folder;
  const Problem problem = toy::problem({}, 5, 1);
  Journal journal(folder / "j.db");
  Ensemble ensemble({Scene{problem.hash, toy::simulator(0.01)}}, journal, problem.comparison, 2);
  double mean = 0.0;
  double squares = 0.0;
  double jackknifed = 0.0;
  constexpr int repeats = 60;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    const auto evaluation =
        ensemble
            .evaluate("test",
                      {points.data(), 1},
                      make_seeds(static_cast<std::uint64_t>(repeat), "noise", 8))
            .front();
    mean += evaluation.objective / repeats;
    squares += evaluation.objective * evaluation.objective / repeats;
    jackknifed += problem.comparison->noise(evaluation.runs) / repeats;
  }
  const double spread = std::sqrt((squares - mean * mean) * repeats / (repeats - 1));
  EXPECT_GT(jackknifed, 0.7 * spread);  // 60 ensembles know the spread to 9 %
  EXPECT_LT(jackknifed, 1.6 * spread);  // and the jackknife of a mean of 8 errs on the safe side
}

TEST(ParallelFor, DoesEveryTaskOnceAndPassesExceptionsOn) {
  std::vector<std::atomic<int>> counts(100);
  parallel_for(100, 4, [&](int i) { ++counts[static_cast<std::size_t>(i)]; });
  for (const auto& count : counts) EXPECT_EQ(count, 1);
  EXPECT_THROW(parallel_for(10,
                            4,
                            [](int i) {
                              if (i == 5) throw std::runtime_error("x");
                            }),
               std::runtime_error);
}

}  // namespace
}  // namespace graintruth::calibrate
