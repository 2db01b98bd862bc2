// Quantities of the user's own: curves in time, and tables of one number.
#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/problem.h"
#include "datasets/imports/curve_files.h"
#include "datasets/store/input_error.h"
#include "tests/app/small_scene.h"
#include "tests/support/closed_engine.h"
#include "tests/support/parameters.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

constexpr const char* curve_name = "wall_force_box_bottom_z_n";

// A box of balls whose replicates have these tables of forces.
struct ForceExperiment {
  explicit ForceExperiment(const std::string& settings, const std::vector<std::string>& tables) {
    folder.write("box.toml", tests::small_scene());
    std::string text = R"(title = "Forces on a floor"
[rig]
kind = "scene"
scene = "box.toml"
[measure]
frame_interval_s = 0.005
frames = 5
observables = ["floor_force"]
[measure.floor_force]
column = "force_n"
unit = "N"
)" + settings + "\n[tune]\nrestitution = {}\n";
    for (std::size_t i = 0; i < tables.size(); ++i) {
      const std::string name = "force" + std::to_string(i + 1) + ".csv";
      text += "[[replicate]]\ncurves = \"" + name + "\"\n";
      folder.write(name, tables[i]);
    }
    experiment = datasets::load_experiment(folder.write("experiment.toml", text));
    for (const datasets::Replicate& replicate : experiment.replicates)
      recordings.push_back({.curves = datasets::read_curves(replicate.curves, 0.0)});
  }

  std::string complaint(const Engine& engine) const {
    try {
      make_problem(experiment, recordings, engine);
    } catch (const datasets::InputError& error) {
      return error.what();
    }
    return "";
  }

  tests::TemporaryFolder folder;
  datasets::Experiment experiment;
  std::vector<datasets::Recording> recordings;
};

// Rises to 3 N at 0.012 s, then falls to 1 N at the last moment, 0.02 s.
EngineRun rising_and_falling() {
  EngineRun run{.time_step = 1e-5};
  datasets::Curve& curve = run.recording.curves[curve_name];
  for (int i = 0; i <= 20; ++i) {
    const double time = 0.001 * i;
    curve.time.push_back(time);
    curve.value.push_back(time < 0.012 ? 250.0 * time : 3.0 - 250.0 * (time - 0.012));
  }
  return run;
}

const tests::ClosedEngine engine([](const SimulationSpec&) { return rising_and_falling(); },
                                 {"highest_grain_m", curve_name});

std::string settings(const std::string& more = "") {
  return std::string("engine_curve = \"") + curve_name + "\"\n" + more;
}

double simulated_number(const std::string& at) {
  const ForceExperiment made(settings(at), {"force_n\n1.0\n", "force_n\n1.2\n"});
  const Problem problem = make_problem(made.experiment, made.recordings, engine);
  const auto channels = problem.observables->measure(
      rising_and_falling().recording, problem.situations[0], &problem.measured[0]);
  EXPECT_EQ(channels[0].values.size(), 1U);
  return channels[0].values[0];
}

TEST(OwnCurve, ATableWithoutTimeIsComparedWithOneNumberOfTheCurve) {
  // The value of a moment is the mean over half an interval before and after it
  EXPECT_NEAR(simulated_number(""), 1.0, 1e-12);
  EXPECT_NEAR(simulated_number("at = \"end\""), 1.0, 1e-12);
  EXPECT_NEAR(simulated_number("at = \"mean\""), (0.0 + 1.25 + 2.4875 + 2.25 + 1.0) / 5.0, 1e-12);
  EXPECT_NEAR(simulated_number("at = \"largest\""), 3.0, 1e-12);
}

TEST(OwnCurve, OfTheSameNumbersNothingDiffers) {
  const ForceExperiment made(settings(), {"force_n\n0.9\n", "force_n\n1.1\n"});
  const Problem problem = make_problem(made.experiment, made.recordings, engine);
  SimulatedRun run{.channels = problem.observables->measure(rising_and_falling().recording,
                                                            problem.situations[0],
                                                            &problem.measured[0])};
  EXPECT_NEAR(problem.all->score_run(run, 0).objective, 0.0, 1e-9);
}

TEST(OwnCurve, AtMakesOneNumberOfACurveInTimeToo) {
  const std::string table = "time_s,force_n\n0,0\n0.01,2\n0.02,1\n";
  const std::string other = "time_s,force_n\n0,0\n0.01,2.2\n0.02,1.1\n";
  const ForceExperiment in_time(settings(), {table, other});
  const std::vector<double> values =
      make_problem(in_time.experiment, in_time.recordings, engine).measured[0][0].values;
  const std::vector<double> expected = {0.0, 1.0, 1.8125, 1.5, 1.0};
  ASSERT_EQ(values.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(values[i], expected[i], 1e-12);
  const ForceExperiment largest(settings("at = \"largest\""), {table, other});
  EXPECT_EQ(make_problem(largest.experiment, largest.recordings, engine).measured[0][0].values,
            (std::vector<double>{2.0}));
}

TEST(OwnCurve, DoesNotDependOnWhereACurveWasSampled) {
  // A straight line is the same at every rate and phase, and its kink at the event too
  const auto line = [](double first, double step) {
    datasets::Curve curve;
    for (double time = first; time < 0.0205 + step; time += step) {
      curve.time.push_back(time);
      curve.value.push_back(1.0 + 100.0 * std::max(0.0, time));
      curve.sigma.push_back(0.3);
    }
    return curve;
  };
  const ForceExperiment made(settings(), {"force_n\n1.0\n", "force_n\n1.2\n"});
  const Problem problem = make_problem(made.experiment, made.recordings, engine);
  const auto measured = [&](const datasets::Curve& curve) {
    datasets::Recording recording;
    recording.curves[curve_name] = curve;
    return problem.observables->measure(recording, problem.situations[0])[0];
  };
  for (const auto& [first, step] : std::vector<std::pair<double, double>>{
           {0.0, 0.005}, {-0.0011, 0.0011}, {0.0009, 0.002}, {0.0, 0.00013}, {0.0021, 0.0047}}) {
    SCOPED_TRACE(testing::Message() << "first " << first << " s, every " << step << " s");
    const Channel channel = measured(line(first, step));
    ASSERT_EQ(channel.values.size(), 5U);
    for (std::size_t i = 0; i < 5; ++i)
      EXPECT_NEAR(channel.values[i], 1.0 + 0.5 * static_cast<double>(i), 1e-12) << "moment " << i;
  }
  // Twenty samples in a window: a mean of about twenty independent errors
  EXPECT_NEAR(measured(line(0.0, 0.00025)).errors[2], 0.3 / std::sqrt(20.0), 0.003);
  // A window that holds half of one line and half of the next
  datasets::Curve kinked{.time = {0.0, 0.01, 0.03}, .value = {0.0, 1.0, 1.0}};
  EXPECT_NEAR(measured(kinked).values[2], (0.5 * 0.875 + 0.5), 1e-12);
}

TEST(OwnCurve, NumbersAndCurvesOfOneQuantityAreRefused) {
  const ForceExperiment made(settings(), {"force_n\n1.0\n", "time_s,force_n\n0,0\n0.02,1\n"});
  const std::string said = made.complaint(engine);
  for (const char* part :
       {"experiment.toml", "'floor_force'", "force1", "force2", "time_s", "all replicates"})
    EXPECT_NE(said.find(part), std::string::npos) << said;
}

TEST(OwnCurve, ReplicatesThatAreEqualToTheLastDigitAreRefused) {
  const ForceExperiment made(settings(), {"force_n\n1.15\n", "force_n\n1.15\n"});
  EXPECT_NE(made.complaint(engine).find("do not differ"), std::string::npos)
      << made.complaint(engine);
}

TEST(OwnCurve, AnotherRuleIsRefused) {
  const ForceExperiment made(settings("at = \"start\""), {"force_n\n1\n", "force_n\n2\n"});
  const std::string said = made.complaint(engine);
  for (const char* part : {"experiment.toml:", "measure.floor_force.at", "\"mean\""})
    EXPECT_NE(said.find(part), std::string::npos) << said;
}

TEST(OwnCurve, ACurveThatTheSimulatorDoesNotRecordIsRefusedWithThoseThatItDoes) {
  const ForceExperiment made("engine_curve = \"wall_force_lid_z_n\"",
                             {"force_n\n1.0\n", "force_n\n1.2\n"});
  const std::string said = made.complaint(engine_named("embedded"));
  for (const char* part : {"experiment.toml",
                           "'measure.floor_force.engine_curve'",
                           "'wall_force_lid_z_n'",
                           "highest_grain_m",
                           curve_name,
                           "wall_force_box_left_x_n"})
    EXPECT_NE(said.find(part), std::string::npos) << said;
}

TEST(OwnCurve, ARunThatEndsBeforeTheLastMomentIsRefused) {
  ForceExperiment made(settings(), {"force_n\n1.0\n", "force_n\n1.2\n"});
  made.experiment.measurement.frames = 50;
  const std::string said = made.complaint(engine);
  for (const char* part : {"experiment.toml", "'floor_force'", "0.245 s", "lasts 0.02 s"})
    EXPECT_NE(said.find(part), std::string::npos) << said;
}

TEST(Observables, OnlyAQuantityThatATableDescribesIsOnesOwn) {
  ForceExperiment made(settings(), {"force_n\n1.0\n", "force_n\n1.2\n"});
  for (const char* name : {"own", "lid_force"}) {
    made.experiment.measurement.observables = {{.name = name}};
    const std::string said = made.complaint(engine);
    EXPECT_NE(said.find(std::string("names '") + name + "'"), std::string::npos) << said;
    EXPECT_NE(said.find("known are tracks"), std::string::npos) << said;
    EXPECT_EQ(said.find(", own"), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace graintruth::calibrate
