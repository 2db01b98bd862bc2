// check and new: what a user does before the first calibration.
#include <fstream>
#include <utility>

#include "datasets/rigs/rig_kind.h"
#include "tests/app/bad_input.h"

namespace graintruth::tests {
namespace {

using CheckAndNew = BadInput;

// The template belongs to the bundled rig, so the bundled films fit it.
TEST_F(CheckAndNew, TheTemplateIsReadyOnceItsFilmsAreThere) {
  const auto rig = folder_ / "rig";
  const ProgramOutcome made = run_program({"new", "micro", rig});
  ASSERT_EQ(made.status, 0) << made.err;
  const std::string experiment = rig / "experiment.toml";
  EXPECT_EQ(run_program({"check", experiment, "--out", out()}).status, 2);  // no films yet
  for (int n = 1; n <= 5; ++n) {
    const std::string number = std::to_string(n);
    std::filesystem::create_symlink(bundled_micro() / ("rep" + number + ".mp4"),
                                    rig / ("film" + number + ".mp4"));
  }
  const ProgramOutcome check = run_program({"check", experiment, "--out", out()});
  EXPECT_EQ(check.status, 0) << check.err;
  for (const char* part :
       {"10 of 2 sphere(s)", "8 of 8 fiducials found", "120 evaluations", "One took", "Ready: "}) {
    EXPECT_TRUE(contains(check.out, part)) << part << " is not in:\n" << check.out;
  }
  EXPECT_TRUE(contains(check.out, "calibrate " + experiment + " --out ")) << check.out;
  EXPECT_FALSE(contains(check.out, "doubtful")) << check.out;
  for (int n = 1; n <= 5; ++n) {
    const auto picture = folder_ / ("out/run/check/film" + std::to_string(n) + ".png");
    EXPECT_GT(std::filesystem::file_size(picture), 10000u);
  }
}

TEST_F(CheckAndNew, TheBinsTemplateIsReadyOnceItsFilmsAreThere) {
  const std::filesystem::path films =
      std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "../shared/lab-videos/macro";
  const auto rig = folder_ / "rig";
  const ProgramOutcome made = run_program({"new", "macro", rig});
  ASSERT_EQ(made.status, 0) << made.err;
  const std::string experiment = rig / "experiment.toml";
  EXPECT_EQ(run_program({"check", experiment, "--out", out()}).status, 2);  // no films yet
  if (!std::filesystem::exists(films)) GTEST_SKIP() << films << " is not here";
  for (const char* name :
       {"orifice075_rep1.mp4", "orifice075_rep2.mp4", "orifice085_rep1.mp4", "orifice100_rep1.mp4"})
    std::filesystem::create_symlink(films / name, rig / name);
  const ProgramOutcome check = run_program({"check", experiment, "--out", out()});
  EXPECT_EQ(check.status, 0) << check.out << check.err;
}

// Six balls that the piston takes down at once.
void write_sinking_balls(const std::filesystem::path& file, int number) {
  std::ofstream table(file);
  table << "time_s,particle,x_m,z_m\n";
  for (int frame = 0; frame <= 60; ++frame) {
    const double time = 0.05 * (frame - 5);
    int particle = 0;
    for (const auto& [x, z] : {std::pair(-22.0, 8.0),
                               std::pair(-5.0, 8.0),
                               std::pair(12.0, 8.0),
                               std::pair(-13.5, 22.0),
                               std::pair(3.5, 22.0),
                               std::pair(21.0, 22.0)}) {
      const double down = 40.0 * std::max(0.0, time) + 0.1 * number;
      table << time << ',' << ++particle << ',' << 1e-3 * x << ',' << 1e-3 * (z - down) << '\n';
    }
  }
}

TEST_F(CheckAndNew, TheTemplateOfWallsIsReadyOnceItsTablesAreThere) {
  const auto rig = folder_ / "rig";
  const ProgramOutcome made = run_program({"new", "walls", rig});
  ASSERT_EQ(made.status, 0) << made.err;
  const std::string experiment = rig / "experiment.toml";
  expect_refusal(run_program({"check", experiment, "--out", out()}), {"tracks1.csv"});
  for (int n = 1; n <= 5; ++n)
    write_sinking_balls(rig / ("tracks" + std::to_string(n) + ".csv"), n);
  const ProgramOutcome check = run_program({"check", experiment, "--out", out()});
  EXPECT_EQ(check.status, 0) << check.out << check.err;
  for (const char* part :
       {"6 of 1 sphere(s)", "walls, 4 walls", "friction_particle_chute", "Ready"})
    EXPECT_TRUE(contains(check.out, part)) << part << " is not in:\n" << check.out;
  EXPECT_FALSE(contains(check.out, "doubtful")) << check.out;
}

TEST_F(CheckAndNew, TheTemplateOfASceneIsReadyOnceItsTablesAreThere) {
  const auto rig = folder_ / "rig";
  const ProgramOutcome made = run_program({"new", "scene", rig});
  ASSERT_EQ(made.status, 0) << made.err;
  const std::string experiment = rig / "experiment.toml";
  expect_refusal(run_program({"check", experiment, "--out", out()}), {"cell1.csv"});
  for (int n = 1; n <= 3; ++n) {
    // 100 g of the 126 g leave within 0.4 s
    std::ofstream table(rig / ("cell" + std::to_string(n) + ".csv"));
    table << "time_s,mass_g\n";
    for (int reading = 0; reading <= 100; ++reading) {
      const double time = 0.01 * reading;
      table << time << ',' << std::min(100.0, 250.0 * time + 0.2 * n * (reading > 0)) << '\n';
    }
  }
  const ProgramOutcome check = run_program({"check", experiment, "--out", out()});
  EXPECT_EQ(check.status, 0) << check.out << check.err;
  for (const char* part : {"200 of 1 sphere(s)", "discharge_rate, what_stays", "Ready"})
    EXPECT_TRUE(contains(check.out, part)) << part << " is not in:\n" << check.out;
}

// Every kind of rig has a template, which loads but for the films or tables that it names.
TEST_F(CheckAndNew, EveryKindOfRigHasATemplateThatLacksNothingButItsFiles) {
  for (const datasets::RigKind* kind : datasets::rig_kinds()) {
    const std::string name(kind->template_name.empty() ? kind->name : kind->template_name);
    const auto rig = folder_ / name;
    const ProgramOutcome made = run_program({"new", name, rig});
    ASSERT_EQ(made.status, 0) << name << made.err;
    EXPECT_TRUE(contains(content_of(rig / "experiment.toml"),
                         "kind = \"" + std::string(kind->name) + "\""));
    expect_refusal(run_program({"check", rig / "experiment.toml", "--out", out()}),
                   {"'replicate.", "but there is no such file"});
  }
}

TEST_F(CheckAndNew, NewOverwritesNothing) {
  const auto rig = folder_ / "rig";
  std::filesystem::create_directories(rig);
  folder_.write("rig/experiment.toml", "mine");
  expect_refusal(run_program({"new", "micro", rig}), {"rig/experiment.toml", "not overwritten"});
  EXPECT_EQ(content_of(rig / "experiment.toml"), "mine");
  std::filesystem::rename(rig / "experiment.toml", rig / "box.toml");
  expect_refusal(run_program({"new", "scene", rig}), {"rig/box.toml", "not overwritten"});
  EXPECT_EQ(content_of(rig / "box.toml"), "mine");
  EXPECT_FALSE(std::filesystem::exists(rig / "experiment.toml"));
}

TEST_F(CheckAndNew, CheckNamesEverythingThatIsMissing) {
  const std::string garbage(5000, 'x');
  std::string text = with(with_film(garbage), "[-290, 220]", "[-250, 180]");
  text = with(text, "frames = 25", "frames = 250");
  const ProgramOutcome check =
      run_program({"check", folder_.write("experiment.toml", text), "--out", out()});
  EXPECT_EQ(check.status, 2);
  EXPECT_TRUE(contains(check.out, "bad.mp4: cannot be opened as a film")) << check.out;
  EXPECT_TRUE(contains(check.out, "rep1.mp4: the film lasts 5.22 s")) << check.out;
  EXPECT_TRUE(contains(check.out, "13 of 14 fiducials found")) << check.out;
  EXPECT_TRUE(contains(check.err, "experiment.toml: not ready, 5 thing(s)")) << check.err;
}

// By more than 1 % of a ball's width, 0.44 mm, or half a pixel, 0.46 mm.
TEST_F(CheckAndNew, CheckDoubtsMarksThatLieOffByMoreThanGrainsAndPixelsExplain) {
  // Marks measured too high and too low in turn
  const auto said_of = [&](double error_mm) {
    std::string text = film_experiment();
    for (const int z : {220, 0, -220}) {
      for (const int x : {-290, 290}) {
        const std::string place = std::to_string(x) + ", " + std::to_string(z);
        const double wrong = z + ((x < 0) == (z == 0) ? error_mm : -error_mm);
        text = with(
            text, "[" + place + "]", "[" + std::to_string(x) + ", " + std::to_string(wrong) + "]");
      }
    }
    return run_program({"check", folder_.write("experiment.toml", text), "--out", out()}).out;
  };
  EXPECT_FALSE(contains(said_of(0.2), "off their places"));
  const std::string said = said_of(2.0);
  EXPECT_TRUE(contains(said, "rep1.mp4: the fiducials lie")) << said;
  EXPECT_TRUE(contains(said, "off their places")) << said;
}

TEST_F(CheckAndNew, CheckLinesUpParametersHoweverLongTheirNames) {
  write_tracks_of_truth(folder_);
  const std::string text =
      with(track_experiment(), "[tune]\n", "[tune]\nrolling_friction_particle_particle = {}\n");
  const std::string said =
      run_program({"check", folder_.write("experiment.toml", text), "--out", out()}).out;
  for (const char* line : {"\nrolling_friction_particle_particle tuned from",
                           "\nfriction_particle_wall             tuned from",
                           "\nrestitution                        "})
    EXPECT_TRUE(contains(said, line)) << line << " is not in:\n" << said;
}

TEST_F(CheckAndNew, CheckDoubtsWhatIsUnusual) {
  write_tracks_of_truth(folder_);
  std::string text = with(track_experiment(), "mass_g = 142", "mass_g = 1.42");
  text = with(text, "front_back_gap_mm = 46", "front_back_gap_mm = 40");
  text = with(text, "{lower = 0.0, upper = 0.6}", "{lower = 0.0, upper = 0.3}");
  text = with(text, "[[replicate]]\ntracks = \"rep5.csv\"\n", "");
  const ProgramOutcome check =
      run_program({"check", folder_.write("experiment.toml", text), "--out", out()});
  EXPECT_EQ(check.status, 0) << check.err;
  for (const char* part :
       {"solids have 100 kg/m3", "closer together", "0.36 of friction", "4 replicates"})
    EXPECT_TRUE(contains(check.out, part)) << part << " is not in:\n" << check.out;
}

}  // namespace
}  // namespace graintruth::tests
