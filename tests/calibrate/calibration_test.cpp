// Truth in, truth out, on a model whose every result is known. How often intervals hold the truth
// is told by interval_coverage_test.cpp and bench_calibration_coverage.
#include "calibrate/calibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/calibrate/toy_experiment.h"

namespace graintruth::calibrate {
namespace {

using toy::calibrated;

CalibrationOptions quick(std::uint64_t seed) {
  return {
      .seed = seed, .jobs = 2, .budget = 60, .search_seeds = 5, .largest_time_step_fraction = 0.05};
}

TEST(Calibrate, RecoversAKnownTruthAndSaysWhatItCannotSee) {
  const toy::Truth truth{.parameters = toy::parameters(0.22, 0.35, 0.7), .noise = 0.001};
  const Problem problem = toy::problem(truth, 5, 11);
  const CalibrationResult result = calibrated(toy::engine(truth.noise), problem, quick(1));
  ASSERT_EQ(result.calibrated.size(), 3U);
  for (const CalibratedParameter& parameter : result.calibrated) {
    if (parameter.name == "restitution") {
      EXPECT_EQ(parameter.status, ParameterStatus::not_identified);
      EXPECT_FALSE(parameter.interval.has_value());
      EXPECT_EQ(parameter.value, parameter.bench);
      continue;
    }
    const double expected = truth.parameters.of(parameter.name);
    EXPECT_EQ(parameter.status, ParameterStatus::tuned) << parameter.name;
    ASSERT_TRUE(parameter.interval.has_value());
    EXPECT_NEAR(parameter.value, expected, 0.05) << parameter.name;
    EXPECT_LE(parameter.interval->lower, parameter.value) << parameter.name;
    EXPECT_GE(parameter.interval->upper, parameter.value) << parameter.name;
  }
  // The toy's replicates differ by offsets that last for the whole run, so the score is far from
  // 750 independent tests; the ceiling still is its mean over such experiments.
  EXPECT_GT(problem.all->percent_inside(result.experiments[0].confirmed.runs.runs), 60.0);
  ASSERT_TRUE(result.self_test.has_value());
  EXPECT_EQ(result.self_test->found, result.self_test->truths);
  EXPECT_EQ(result.failed, 0);
  EXPECT_LE(static_cast<int>(result.evaluations.size()), 60);
}

// Design and effects alone use up this budget; with more of it the same data do tell.
TEST(Calibrate, TellsAnEndedBudgetFromDataThatDoNotDetermine) {
  const toy::Truth truth{.parameters = toy::parameters(0.22, 0.35, 0.7), .noise = 0.001};
  CalibrationOptions options = quick(1);
  options.budget = 14;
  const CalibrationResult result =
      calibrated(toy::engine(truth.noise), toy::problem(truth, 5, 11), options);
  int unfinished = 0;
  for (const CalibratedParameter& parameter : result.calibrated) {
    if (parameter.name == "restitution") {  // without any effect, which the budget does not change
      EXPECT_EQ(interval_status(parameter), "not_determined");
      continue;
    }
    EXPECT_EQ(parameter.status, ParameterStatus::tuned) << parameter.name;
    EXPECT_EQ(interval_status(parameter), "budget_ended") << parameter.name;
    ASSERT_TRUE(parameter.interval.has_value());
    if (!is_unfinished(parameter)) continue;
    ++unfinished;
    EXPECT_EQ(parameter.interval->lower, parameter.lower_bound);
    EXPECT_EQ(parameter.interval->upper, parameter.upper_bound);
    EXPECT_TRUE(std::any_of(
        result.warnings.begin(), result.warnings.end(), [&](const datasets::Warning& warning) {
          return warning.text.find(
                     "The budget of 14 evaluations ended before either end of the "
                     "interval of " +
                     parameter.name) != std::string::npos;
        }));
  }
  EXPECT_GE(unfinished, 1);
}

TEST(Calibrate, TellsBeforeTheSearchWhereChanceHidesTheParameters) {
  constexpr double noise = 0.2;  // m; tracks are less than that apart
  const Problem problem = toy::problem({.noise = noise}, 5, 11);
  CalibrationOptions options = quick(1);
  std::vector<std::string> notices;
  options.notice = [&](const std::string& notice) { notices.push_back(notice); };
  const CalibrationResult result = calibrated(toy::engine(noise), problem, options);
  ASSERT_TRUE(result.self_test.has_value());
  EXPECT_LT(2 * result.self_test->found, result.self_test->truths);
  ASSERT_FALSE(notices.empty());
  EXPECT_NE(notices.front().find("Self-test"), std::string::npos) << notices.front();
}

TEST(Calibrate, IsTheSameForAnyNumberOfThreadsAndOnResuming) {
  const Problem problem = toy::problem({}, 5, 3);
  CalibrationOptions options = quick(5);
  const CalibrationResult two = calibrated(toy::engine(0.002), problem, options);
  options.jobs = 1;
  // Interrupted after 100 simulations, then run again on the same journal.
  Problem own = problem;
  Journal journal(":memory:");
  const auto executor = make_executor("threads", 1);
  const auto run = [&](const Engine& engine) {
    own.engine = &engine;
    const std::array experiments = {CalibratedExperiment{"toy", &own}};
    return calibrate(own.experiment, experiments, journal, *executor, {}, options);
  };
  int left = 100;
  const toy::ClosedEngine interrupted([&left](const SimulationSpec& spec) {
    if (left-- == 0) throw Interrupted();
    return toy::engine(0.002).run(spec, {});
  });
  EXPECT_THROW(run(interrupted), Interrupted);
  const CalibrationResult resumed = run(toy::engine(0.002));
  EXPECT_EQ(resumed.parameters.of("friction_particle_particle"),
            two.parameters.of("friction_particle_particle"));
  EXPECT_EQ(resumed.parameters.of("friction_particle_wall"),
            two.parameters.of("friction_particle_wall"));
  EXPECT_EQ(resumed.objective, two.objective);
  EXPECT_EQ(resumed.calibrated[0].interval->lower, two.calibrated[0].interval->lower);
  EXPECT_EQ(static_cast<int>(journal.rows().size()), 100 + resumed.simulated);
}

TEST(Calibrate, LivesThroughFailuresAndCountsThem) {
  const Problem problem = toy::problem({}, 5, 3);
  const toy::ClosedEngine sometimes_fails([](const SimulationSpec& spec) {
    EngineRun run = toy::engine(0.002).run(spec, {});
    if (spec.parameters.of("friction_particle_particle") > 0.5) {
      run.status = RunStatus::unstable;
      run.message = "a particle moved too far";
    }
    return run;
  });
  const CalibrationResult result = calibrated(sometimes_fails, problem, quick(2));
  EXPECT_GT(result.failed, 0);
  EXPECT_NEAR(result.parameters.of("friction_particle_particle"), 0.2, 0.08);
}

// One run in five ends badly whatever its parameters, in every way that runs can.
TEST(Calibrate, ConvergesThroughInjectedFailuresOfEveryClass) {
  const toy::Truth truth{.parameters = toy::parameters(0.22, 0.35, 0.7), .noise = 0.001};
  const Problem problem = toy::problem(truth, 5, 11);
  for (const RunStatus status : {RunStatus::unstable, RunStatus::timed_out}) {
    const toy::ClosedEngine injected([&](const SimulationSpec& spec) {
      EngineRun run = toy::engine(truth.noise).run(spec, {});
      const double mixed = 1e4 * spec.parameters.of("friction_particle_particle") +
                           1e-9 * static_cast<double>(spec.seed);
      if (std::fmod(mixed, 1.0) < 0.2) run.status = status;
      return run;
    });
    const CalibrationResult result = calibrated(injected, problem, quick(1));
    EXPECT_GT(result.failed, result.simulations / 10);
    for (const CalibratedParameter& parameter : result.calibrated) {
      if (parameter.name == "restitution") continue;
      EXPECT_NEAR(parameter.value, truth.parameters.of(parameter.name), 0.05)
          << parameter.name << ", " << name_of(status);
    }
  }
}

TEST(Calibrate, RunsUnstableOnesAgainAtHalfTheStep) {
  const Problem problem = toy::problem({}, 5, 3);
  const toy::ClosedEngine unstable_at_large_steps([](const SimulationSpec& spec) {
    EngineRun run = toy::engine(0.002).run(spec, {});
    if (spec.parameters.of("friction_particle_particle") > 0.3 && spec.time_step_fraction > 0.03)
      run.status = RunStatus::unstable;
    return run;
  });
  const CalibrationResult result = calibrated(unstable_at_large_steps, problem, quick(2));
  EXPECT_EQ(result.failed, 0);
  EXPECT_GT(result.retried, 0);
  EXPECT_NEAR(result.parameters.of("friction_particle_particle"), 0.2, 0.08);
}

// z depends on the sum of the two frictions only: any pair on that line fits.
TEST(Calibrate, SaysInWordsWhichParametersTradeOff) {
  const toy::ClosedEngine of_the_sum([](const SimulationSpec& spec) {
    SimulationSpec alike = spec;
    alike.parameters.set("friction_particle_particle", 0.0);
    alike.parameters.set("friction_particle_wall",
                         spec.parameters.of("friction_particle_particle") +
                             spec.parameters.of("friction_particle_wall"));
    return toy::engine(0.001).run(alike, {});
  });
  const Problem problem =
      toy::problem({.parameters = toy::parameters(0.0, 0.6, 0.7), .noise = 0.001}, 5, 11);
  CalibrationOptions options = quick(1);
  options.budget = CalibrationOptions{}.budget;
  const CalibrationResult result = calibrated(of_the_sum, problem, options);
  ASSERT_EQ(result.trade_offs.size(), 1U);
  EXPECT_NEAR(result.trade_offs[0].first_share, std::sqrt(0.5), 0.1);
  EXPECT_NEAR(result.trade_offs[0].second_share, -std::sqrt(0.5), 0.1);
  EXPECT_GT(result.trade_offs[0].half_length, 0.02);  // it is 0.6; the words say "at least"
  const bool is_said = std::any_of(
      result.warnings.begin(), result.warnings.end(), [](const datasets::Warning& warning) {
        return warning.text.find(
                   "friction_particle_particle and friction_particle_wall trade off") !=
               std::string::npos;
      });
  EXPECT_TRUE(is_said);
  // The toy itself tells them apart
  const Problem separate =
      toy::problem({.parameters = toy::parameters(0.22, 0.35, 0.7), .noise = 0.001}, 5, 11);
  EXPECT_TRUE(calibrated(toy::engine(0.001), separate, quick(1)).trade_offs.empty());
}

TEST(Identifiability, TwoWideIntervalsAreSaidToBeHardlySeparated) {
  const auto parameter = [](const char* name, double lower, double upper) {
    CalibratedParameter made{.name = name, .status = ParameterStatus::tuned};
    made.data_alone = DataAlone{.value = 0.5 * (lower + upper), .interval = {lower, upper}};
    made.lower_bound = 0.0;
    made.upper_bound = 0.6;
    return made;
  };
  std::vector<CalibratedParameter> all = {parameter("friction_particle_particle", 0.0, 0.2),
                                          parameter("friction_particle_wall", 0.1, 0.3)};
  const std::vector<OpenPair> open = find_open_pairs(all, {});
  ASSERT_EQ(open.size(), 1U);
  EXPECT_NE(words_on(open[0]).find("from 0.00 to 0.20 and of the second from 0.10 to 0.30"),
            std::string::npos);
  EXPECT_NE(words_on(open[0]).find("A sliding test of the particle on the wall"),
            std::string::npos);
  const TradeOff told{.first = all[0].name, .second = all[1].name};
  EXPECT_TRUE(find_open_pairs(all, std::span(&told, 1)).empty());
  all[1].data_alone->interval = {0.1, 0.2};
  EXPECT_TRUE(find_open_pairs(all, {}).empty());
  // Not identified without any effect: that is said of it. With one, the other makes up for it
  all[1].data_alone.reset();
  all[1].status = ParameterStatus::not_identified;
  EXPECT_TRUE(find_open_pairs(all, {}).empty());
  all[1].shows_effect = true;
  const std::vector<OpenPair> made_up = find_open_pairs(all, {});
  ASSERT_EQ(made_up.size(), 1U);
  EXPECT_NE(words_on(made_up[0]).find("of the second from 0.00 to 0.60"), std::string::npos);
}

// A model whose fit is best at the largest step: the gate is not moved by it, a joint search is,
// and says so.
TEST(Calibrate, ChoosesTheTimeStepByItsErrorUnlessAskedToSearchIt) {
  const toy::ClosedEngine better_when_coarse([](const SimulationSpec& spec) {
    EngineRun run = toy::engine(0.001).run(spec, {});
    for (datasets::Pose& pose : run.recording.tracks->poses)
      pose.x += 0.5 * (0.05 - spec.time_step_fraction);
    return run;
  });
  Problem problem =
      toy::problem({.parameters = toy::parameters(0.22, 0.35, 0.7), .noise = 0.001}, 5, 11);
  const CalibrationResult gated = calibrated(better_when_coarse, problem, quick(1));
  EXPECT_LT(gated.time_step.fraction, 0.05);
  EXPECT_FALSE(gated.time_step.joint);

  problem.experiment.time_step_rule = datasets::TimeStepRule::joint;
  const CalibrationResult joint = calibrated(better_when_coarse, problem, quick(1));
  EXPECT_TRUE(joint.time_step.joint);
  EXPECT_GE(joint.time_step.fraction, 0.0125 * (1.0 - 1e-9));
  EXPECT_LE(joint.time_step.fraction, 0.05 * (1.0 + 1e-9));
  EXPECT_TRUE(std::any_of(joint.warnings.begin(), joint.warnings.end(), [](const auto& warning) {
    return warning.text.find("searched together") != std::string::npos;
  }));
}

TEST(Calibrate, SearchesByTheAgreementItselfWhereAsked) {
  const toy::Truth truth{.parameters = toy::parameters(0.22, 0.35, 0.7), .noise = 0.001};
  datasets::Experiment experiment = toy::experiment(5);
  experiment.objective = datasets::ObjectiveForm::requested;
  const Problem problem = make_problem(experiment, toy::recordings(truth, 5, 11));
  const CalibrationResult result = calibrated(toy::engine(truth.noise), problem, quick(1));
  EXPECT_EQ(result.objective_form, datasets::ObjectiveForm::requested);
  EXPECT_NEAR(result.parameters.of("friction_particle_particle"), 0.22, 0.05);
  // Both forms are compared on the evaluations of the one search.
  ASSERT_EQ(result.by_objective.size(), 2U);
  const BestByObjective &smooth = result.by_objective[0], &requested = result.by_objective[1];
  EXPECT_LE(*smooth.smooth, *requested.smooth);
  EXPECT_LE(*requested.requested, *smooth.requested);
  EXPECT_NEAR(*requested.requested, best_of(result.evaluations).objective, 1e-12);
}

TEST(Calibrate, APriorCountsInTheAnswerAndNeverInTheScore) {
  const toy::Truth truth{.parameters = toy::parameters(0.22, 0.35, 0.7), .noise = 0.001};
  Problem problem = toy::problem(truth, 5, 11);
  problem.experiment.tuned[1].prior = {0.36, 0.003};
  const CalibrationResult result = calibrated(toy::engine(truth.noise), problem, quick(1));
  const CalibratedParameter& wall = result.calibrated[1];
  ASSERT_TRUE(wall.data_alone.has_value());
  EXPECT_LT(std::abs(wall.value - 0.36), std::abs(wall.data_alone->value - 0.36));
  EXPECT_LT(wall.interval->upper - wall.interval->lower,
            wall.data_alone->interval.upper - wall.data_alone->interval.lower);
  EXPECT_LE(wall.interval->lower, 0.36);
  EXPECT_EQ(result.objective,
            problem.calibrated->objective(result.experiments[0].confirmed.runs.runs));
  EXPECT_LE(static_cast<int>(result.evaluations.size()), 60);
}

TEST(Calibrate, WarnsBeforeItSpendsWhereTheDataLieBeyondTheModel) {
  const toy::Truth truth{.parameters = toy::parameters(0.55, 0.65, 0.7), .noise = 0.001};
  Problem problem = toy::problem(truth, 5, 11);
  problem.experiment.tuned[0].upper = 0.2;
  problem.experiment.tuned[1].upper = 0.2;
  CalibrationOptions options = quick(1);
  std::vector<std::string> notices;
  options.notice = [&](const std::string& sentence) { notices.push_back(sentence); };
  const CalibrationResult result = calibrated(toy::engine(truth.noise), problem, options);
  EXPECT_GT(result.out_of_reach, 0.3);
  ASSERT_EQ(notices.size(), 1U);
  EXPECT_NE(notices[0].find("outside everything that the model gave"), std::string::npos);
  // Within its bounds nothing is said
  const Problem within =
      toy::problem({.parameters = toy::parameters(0.22, 0.35, 0.7), .noise = 0.001}, 5, 11);
  EXPECT_LT(calibrated(toy::engine(0.001), within, quick(1)).out_of_reach, 0.1);
}

// One replicate was filmed at another friction: without it the rest agree on the truth.
TEST(Calibrate, ShowsWhichReplicateTheAnswerRestsOn) {
  std::vector<datasets::Recording> recordings =
      toy::recordings({.parameters = toy::parameters(0.22, 0.35, 0.7), .noise = 0.001}, 5, 11);
  recordings[3].tracks = toy::run(toy::parameters(0.42, 0.35, 0.7), 0.001, 7);
  const Problem problem = make_problem(toy::experiment(5), recordings);
  const CalibrationResult result = calibrated(toy::engine(0.001), problem, quick(1));
  const std::vector<InfluenceRow>& influence = result.experiments[0].influence;
  ASSERT_EQ(influence.size(), 5U + static_cast<std::size_t>(toy::particles));
  EXPECT_EQ(influence[3].left_out, "replicate 4");
  EXPECT_NEAR(influence[3].best.of("friction_particle_particle"), 0.22, 0.02);
  for (const InfluenceRow& row : influence)
    EXPECT_GE(row.best.of("friction_particle_particle"), 0.2) << row.left_out;
}

// What a clock cuts off is another result on another machine.
TEST(Calibrate, SaysThatAClockEndedTheSearch) {
  const Problem problem = toy::problem({}, 5, 3);
  CalibrationOptions options = quick(2);
  const auto says_it = [](const CalibrationResult& result) {
    return std::any_of(
        result.warnings.begin(), result.warnings.end(), [](const datasets::Warning& warning) {
          return warning.text.find("ended the search after") != std::string::npos;
        });
  };
  EXPECT_FALSE(says_it(calibrated(toy::engine(0.002), problem, options)));
  options.time_limit = 1e-9;
  const CalibrationResult cut_off = calibrated(toy::engine(0.002), problem, options);
  EXPECT_LT(static_cast<int>(cut_off.evaluations.size()), options.budget);
  EXPECT_TRUE(says_it(cut_off));
}

TEST(Calibrate, GivesUpWithASentenceWhenAllFails) {
  const Problem problem = toy::problem({}, 5, 3);
  const toy::ClosedEngine fails([](const SimulationSpec& spec) {
    EngineRun run = toy::engine(0.002).run(spec, {});
    run.status = RunStatus::unstable;
    run.message = "a particle moved too far";
    return run;
  });
  try {
    calibrated(fails, problem, quick(2));
    FAIL() << "nothing was thrown";
  } catch (const TooManyFailures& error) {
    EXPECT_NE(std::string(error.what()).find("a particle moved too far"), std::string::npos);
  }
}

}  // namespace
}  // namespace graintruth::calibrate
