// Engines that are other programs: a command of the user's, LAMMPS and LIGGGHTS.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "calibrate/engines/command.h"
#include "datasets/store/external_program.h"
#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

using tests::TemporaryFolder;

// What a run of a shell script gives, in place of a simulator.
class BadCommand : public testing::Test {
 protected:
  EngineRun run(const std::string& script, double time_limit = 0.0) {
    folder_.write("simulator.sh", script);
    SimulationSpec spec;
    spec.engine = "command";
    spec.record = {.tracks = false, .curves = {"way_m"}};
    spec.foreign = datasets::ForeignEngine{.command = {"sh", "simulator.sh"}};
    return command_engine().run(spec, {.time_limit = time_limit, .folder = folder_.path()});
  }
  void expect(const EngineRun& run, RunStatus status, const std::string& words) {
    EXPECT_EQ(name_of(run.status), name_of(status)) << run.message;
    EXPECT_NE(run.message.find(words), std::string::npos) << run.message;
    EXPECT_TRUE(run.recording.curves.empty());
  }
  TemporaryFolder folder_;
};

TEST_F(BadCommand, ThatHangsIsEnded) {
  expect(run("sleep 60 & sleep 60\n", 0.3), RunStatus::timed_out, "did not end within 0.3 s");
}

TEST_F(BadCommand, ThatCrashesIsUnstable) {
  expect(run("kill -SEGV $$\n"), RunStatus::unstable, "was ended by signal 11");
  expect(run("echo first; echo 'no such grain' >&2; exit 3\n"),
         RunStatus::unstable,
         "ended with status 3: no such grain");
  expect(run("exit 75\n"), RunStatus::unstable, "says that it is unstable");
}

TEST_F(BadCommand, ThatWritesRubbishIsUnstable) {
  expect(run("echo hello\n"), RunStatus::unstable, "wrote no recording.json");
  expect(run("echo hello >recording.json\n"), RunStatus::unstable, "is not valid JSON");
  expect(run("echo '{}' >recording.json\n"), RunStatus::unstable, "without 'recording'");
  const std::string half = R"({"recording": {"curves": {"way_m": {"time_s": [0, 1], "value": [)";
  expect(
      run("printf '%s' '" + half + "' >recording.json\n"), RunStatus::unstable, "not valid JSON");
  for (const auto& [curve, words] :
       {std::pair(R"({"time_s": [0, 1], "value": [0]})", "has 2 times and 1 values"),
        std::pair(R"({"time_s": [0, 0], "value": [0, 1]})", "do not rise"),
        std::pair(R"({"time_s": [0, 1], "value": [0, null]})", "what is no number"),
        std::pair(R"({"time_s": [0, "x"], "value": [0, 1]})", "must be a number")}) {
    expect(run("echo '{\"recording\": {\"curves\": {\"way_m\": " + std::string(curve) +
               "}}}' >recording.json\n"),
           RunStatus::unstable,
           words);
  }
  expect(run("echo '{\"recording\": {\"curves\": {}}}' >recording.json\n"),
         RunStatus::unstable,
         "the curve 'way_m' is missing");
}

TEST_F(BadCommand, ThatCannotBeStartedIsRefused) {
  SimulationSpec spec;
  spec.foreign = datasets::ForeignEngine{.command = {"/nowhere/simulator"}};
  EXPECT_THROW(command_engine().run(spec, {}), datasets::InputError);
}

TEST_F(BadCommand, MayBeStopped) {
  folder_.write("simulator.sh", "sleep 60\n");
  SimulationSpec spec;
  spec.foreign = datasets::ForeignEngine{.command = {"sh", "simulator.sh"}};
  EXPECT_THROW(command_engine().run(spec, {.stop = [] { return true; }, .folder = folder_.path()}),
               Interrupted);
}

// --- LAMMPS and LIGGGHTS

struct Program {
  const char* engine;
  const char* command;
  int ranks;
};

class GranularProgram : public testing::TestWithParam<Program> {
 protected:
  void SetUp() override {
    for (const char* needed : {GetParam().command, GetParam().ranks > 1 ? "mpirun" : "sh"}) {
      if (!datasets::find_program(needed)) GTEST_SKIP() << needed << " is not installed";
    }
  }

  // A grain without weight, thrown at a floor.
  static SimulationSpec drop(double restitution, bool is_clump) {
    SimulationSpec spec;
    spec.engine = GetParam().engine;
    spec.foreign = datasets::ForeignEngine{.ranks = GetParam().ranks};
    datasets::SceneData& scene = spec.scene;
    scene.gravity.setZero();
    scene.materials = {{.name = "grain", .elastic_modulus = 1e7, .poisson_ratio = 0.3},
                       {.name = "floor", .is_rigid = true}};
    for (const int second : {0, 1}) {
      scene.surfaces.push_back(
          {.first = 0, .second = second, .friction = 0.3, .restitution = restitution});
    }
    scene.particles = {{.name = "ball", .spheres = {{{0.0, 0.0, 0.0}, 5e-3}}, .density = 2000.0}};
    if (is_clump) scene.particles.front().spheres.push_back({{6e-3, 0.0, 0.0}, 5e-3});
    datasets::SceneWall floor{.name = "floor", .material = 1};
    floor.points = {{0.0, 0.0, 0.0}};
    scene.walls = {floor};
    // Two, so that every rank has one; the clump upright on its lower sphere
    const double height = is_clump ? 9e-3 : 6e-3;
    for (const double x : {0.0, 0.1}) {
      scene.places.push_back({.position = {x, 0.0, height},
                              .angle = is_clump ? 1.5707963267948966 : 0.0,
                              .velocity = {0.0, 0.0, -0.2}});
    }
    scene.phases = {{.name = "fall", .duration = 0.06, .output_interval = 0.005}};
    scene.phases.front().time_step_fraction = 0.05;
    return spec;
  }

  static double rebound(const EngineRun& run) {
    EXPECT_EQ(name_of(run.status), "completed") << run.message;
    if (run.status != RunStatus::completed) return 0.0;
    const datasets::Trajectories& tracks = *run.recording.tracks;
    const auto z = [&](std::size_t frame) { return tracks.poses[tracks.index(frame, 1)].z; };
    const std::size_t last = tracks.frames() - 1;
    return (z(last) - z(last - 1)) / (tracks.time[last] - tracks.time[last - 1]) / 0.2;
  }
};

void PrintTo(const Program& program, std::ostream* out) { *out << program.engine; }

TEST_P(GranularProgram, ReboundsAsAsked) {
  for (const double restitution : {0.9, 0.7, 0.5, 0.3}) {
    const SimulationSpec spec = drop(restitution, false);
    EXPECT_NEAR(rebound(engine_named(spec.engine).run(spec, {})), restitution, 1e-3);
  }
}

TEST_P(GranularProgram, RefusesClumps) {
  const SimulationSpec spec = drop(0.6, true);
  EXPECT_THROW(engine_named(spec.engine).run(spec, {}), datasets::InputError);
}

TEST_P(GranularProgram, LeavesNothingOutInSilence) {
  SimulationSpec spec = drop(0.6, false);
  spec.scene.surfaces.front().rolling_friction = 0.1;
  EXPECT_THROW(engine_named(spec.engine).run(spec, {}), datasets::InputError);
}

TEST_P(GranularProgram, TellsWhatItCannotDoByAStatus) {
  SimulationSpec spec = drop(0.6, false);
  EXPECT_EQ(engine_named(spec.engine).run(spec, {.step_limit = 5}).status, RunStatus::timed_out);
  EXPECT_FALSE(engine_named(spec.engine).version().empty());
}

INSTANTIATE_TEST_SUITE_P(,
                         GranularProgram,
                         testing::Values(Program{"lammps", "lmp", 1},
                                         Program{"lammps", "lmp", 2},
                                         Program{"liggghts", "liggghts", 1}),
                         [](const auto& one) {
                           return std::string(one.param.engine) + "_" +
                                  std::to_string(one.param.ranks);
                         });

}  // namespace
}  // namespace graintruth::calibrate
