#include "calibrate/ensemble.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <set>

#include "calibrate/compare/repeated_rule.h"
#include "datasets/store/input_error.h"
#include "tests/calibrate/toy_experiment.h"
#include "tests/support/backwards_executor.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

using tests::TemporaryFolder;

const std::vector<EvaluationPoint> points = {{toy::parameters(0.1, 0.2, 0.8), 0.2},
                                             {toy::parameters(0.4, 0.5, 0.6), 0.2}};

const bool is_known = (make_known(tests::backwards), true);

TEST(Ensemble, GivesTheSameByAnyExecutorAndAnyNumberOfThreads) {
  ASSERT_TRUE(is_known);
  const TemporaryFolder folder;
  Problem problem = toy::problem({}, 5, 1);
  const auto seeds = make_seeds(3, "test", 6);
  const toy::ClosedEngine engine = toy::engine(0.01);
  std::vector<double> objectives;
  for (const auto& [name, jobs] :
       {std::pair("threads", 1), std::pair("threads", 4), std::pair("backwards", 1)}) {
    Journal journal(folder / (name + std::to_string(jobs)));
    const auto executor = make_executor(name, jobs);
    const auto ensemble = toy::ensemble(problem, engine, journal, *executor);
    for (const Evaluation& evaluation : ensemble->evaluate("test", points, seeds))
      objectives.push_back(evaluation.objective);
  }
  for (const std::size_t other : {2U, 4U}) {
    EXPECT_EQ(objectives[0], objectives[other]);
    EXPECT_EQ(objectives[1], objectives[other + 1]);
  }
}

TEST(Ensemble, RepeatsNoSimulationThatIsInTheJournal) {
  const TemporaryFolder folder;
  Problem problem = toy::problem({}, 5, 1);
  const auto seeds = make_seeds(3, "test", 6);
  Journal journal(folder / "j.db");
  const toy::ClosedEngine engine = toy::engine(0.01);
  const auto executor = make_executor("threads", 2);
  const auto first = toy::ensemble(problem, engine, journal, *executor);
  const auto before = first->evaluate("test", points, seeds);
  EXPECT_EQ(first->simulated(), 12);
  const auto second = toy::ensemble(problem, engine, journal, *executor);
  const auto after = second->evaluate("test", points, seeds);
  EXPECT_EQ(second->simulated(), 0);
  EXPECT_EQ(after[1].objective, before[1].objective);
}

TEST(Ensemble, ScoresRunsThatFailAndLivesOn) {
  const TemporaryFolder folder;
  Problem problem = toy::problem({}, 5, 1);
  Journal journal(folder / "j.db");
  const toy::ClosedEngine failing([](const SimulationSpec& spec) {
    EngineRun run = toy::engine(0.01).run(spec, {});
    if (spec.parameters.of("friction_particle_particle") > 0.3) run.status = RunStatus::unstable;
    return run;
  });
  const auto executor = make_executor("threads", 2);
  const auto evaluations = toy::ensemble(problem, failing, journal, *executor)
                               ->evaluate("test", points, make_seeds(3, "test", 4));
  EXPECT_EQ(evaluations[0].failed, 0);
  EXPECT_EQ(evaluations[1].failed, 4);
  datasets::Trajectories rest = toy::run(toy::Truth{}.parameters, 0.0, 1);
  for (std::size_t i = 0; i < rest.poses.size(); ++i) {
    const auto& start = static_cast<const RepeatedRule*>(problem.all->rule_of("tracks"))->target(0);
    const std::size_t particle = i % toy::particles;
    rest.poses[i] = {
        start.mean[3 * particle], start.mean[3 * particle + 1], start.mean[3 * particle + 2]};
  }
  const SimulatedRun still = toy::compared(problem, rest);
  EXPECT_NEAR(evaluations[1].objective, problem.all->objective({&still, 1}), 1e-12);
}

// Where a limit ended them says nothing of the simulations: another limit, another end.
TEST(Ensemble, SimulatesAgainWhatTimedOut) {
  const TemporaryFolder folder;
  Problem problem = toy::problem({}, 5, 1);
  Journal journal(folder / "j.db");
  bool is_limited = true;
  const toy::ClosedEngine limited([&is_limited](const SimulationSpec& spec) {
    if (is_limited) return EngineRun{.status = RunStatus::timed_out, .message = "its limit"};
    return toy::engine(0.01).run(spec, {});
  });
  const auto executor = make_executor("threads", 2);
  const auto seeds = make_seeds(3, "test", 2);
  const auto ensemble = toy::ensemble(problem, limited, journal, *executor);
  EXPECT_EQ(ensemble->evaluate("test", points, seeds)[0].failed, 2);
  is_limited = false;
  const auto whole = ensemble->evaluate("test", points, seeds);
  EXPECT_EQ(whole[0].failed, 0);
  EXPECT_EQ(ensemble->simulated(), 8);
  EXPECT_EQ(journal.rows().size(), 4U);
  Journal other(folder / "other.db");
  EXPECT_EQ(toy::ensemble(problem, limited, other, *executor)
                ->evaluate("test", points, seeds)[0]
                .objective,
            whole[0].objective);
}

// A row that is sound by itself, but of another shape than what is compared.
TEST(Ensemble, RefusesResultsOfAnotherShape) {
  Problem problem = toy::problem({}, 5, 1);
  const toy::ClosedEngine engine = toy::engine(0.01);
  const auto executor = make_executor("threads", 1);
  const auto seeds = make_seeds(3, "test", 1);
  const auto refusal = [&](const std::function<void(std::vector<Channel>&)>& change) {
    const TemporaryFolder folder;
    Journal journal(folder / "j.db");
    toy::ensemble(problem, engine, journal, *executor)->evaluate("test", points, seeds);
    JournalRow row = journal.rows().front();
    journal.drop(std::vector<std::int64_t>{row.id});
    change(row.run.channels);
    journal.add(row);
    try {
      toy::ensemble(problem, engine, journal, *executor)->evaluate("test", points, seeds);
    } catch (const datasets::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refusal([](auto&) {}), "");
  EXPECT_NE(refusal([](auto& channels) {
              channels.front().values.resize(7);
            }).find("is damaged: it has 7 values of tracks, but 216 are compared"),
            std::string::npos);
  EXPECT_NE(refusal([](auto& channels) {
              channels.clear();
            }).find("is damaged: it has results of 0 observables, but 1 are measured"),
            std::string::npos);
}

TEST(Ensemble, KeepsWhatEndedBeforeAnInterruption) {
  const TemporaryFolder folder;
  Problem problem = toy::problem({}, 5, 1);
  Journal journal(folder / "j.db");
  int left = 5;
  const toy::ClosedEngine interrupted([&left](const SimulationSpec& spec) {
    if (left-- == 0) throw Interrupted();
    return toy::engine(0.01).run(spec, {});
  });
  const auto executor = make_executor("threads", 1);
  const auto ensemble = toy::ensemble(problem, interrupted, journal, *executor);
  EXPECT_THROW(ensemble->evaluate("test", points, make_seeds(3, "test", 6)), Interrupted);
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
  Problem problem = toy::problem({}, 5, 1);
  Journal journal(folder / "j.db");
  const toy::ClosedEngine engine = toy::engine(0.01);
  const auto executor = make_executor("threads", 2);
  const auto ensemble = toy::ensemble(problem, engine, journal, *executor);
  double mean = 0.0;
  double squares = 0.0;
  double jackknifed = 0.0;
  constexpr int repeats = 60;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    const auto evaluation =
        ensemble
            ->evaluate("test",
                       {points.data(), 1},
                       make_seeds(static_cast<std::uint64_t>(repeat), "noise", 8))
            .front();
    mean += evaluation.objective / repeats;
    squares += evaluation.objective * evaluation.objective / repeats;
    jackknifed += problem.calibrated->noise(evaluation.runs) / repeats;
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
