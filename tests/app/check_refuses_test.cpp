// What a verb refuses, check refuses before it, with the same sentence and exit status.
#include <fmt/format.h>

#include <fstream>

#include "tests/app/bad_input.h"

namespace graintruth::tests {
namespace {

class CheckRefuses : public BadInput {
 protected:
  // The sentence of a refusal, without the program's name and the last point.
  static std::string sentence_of(const ProgramOutcome& outcome) {
    std::string text = outcome.err;
    const std::string name = "graintruth: ";
    if (text.starts_with(name)) text.erase(0, name.size());
    while (!text.empty() && (text.back() == '\n' || text.back() == '.')) text.pop_back();
    return text;
  }

  void expect_same(const std::string& what,
                   const std::filesystem::path& file,
                   const char* verb = "calibrate",
                   const std::string& place = "") {
    const std::string out = place.empty() ? (folder_ / "out/run").string() : place;
    const ProgramOutcome refused = run_program({verb, file, "--out", out, "--quiet"});
    EXPECT_EQ(refused.status, 2) << what << ": " << refused.out << refused.err;
    const std::string sentence = sentence_of(refused);
    EXPECT_FALSE(sentence.empty()) << what;
    const ProgramOutcome check = run_program({"check", file, "--out", out});
    EXPECT_EQ(check.status, 2) << what << ": " << check.out << check.err;
    EXPECT_TRUE(contains(check.out + check.err, sentence))
        << what << ": '" << sentence << "' is not in:\n"
        << check.out << check.err;
    EXPECT_FALSE(contains(check.out, "Ready")) << what;
  }
  void expect_same_of(const std::string& what,
                      const std::string& text,
                      const char* verb = "calibrate") {
    expect_same(what, folder_.write("experiment.toml", text), verb);
  }
};

TEST_F(CheckRefuses, ExperimentsThatCannotBe) {
  write_tracks_of_truth(folder_);
  const std::string good = track_experiment();
  expect_same_of("not TOML", "title = ");
  expect_same_of("an unknown key", with(good, "front_back_gap_mm", "front_bak_gap_mm"));
  expect_same_of("an unknown observable",
                 with(good, "frames = 7", "frames = 7\nobservables = [\"trakcs\"]"));
  expect_same_of("a curve that nobody records",
                 with(good,
                      "frames = 7",
                      "frames = 7\nobservables = [\"push\"]\n[measure.push]\ncolumn = \"push_n\"\n"
                      "engine_curve = \"wall_force_roof_z_n\"\nunit = \"N\""));
  expect_same_of("replicates that are held out by halves",
                 with(good, "tracks = \"rep1.csv\"", "tracks = \"rep1.csv\"\nheld_out = true"));
  std::string speeds = good;
  for (int n = 1; n <= 5; ++n) {
    const std::string tracks = fmt::format("tracks = \"rep{}.csv\"", n);
    speeds = with(speeds, tracks, tracks + fmt::format("\npiston_speed_mm_per_s = {}", 40 + n));
  }
  expect_same_of("conditions without repeats", speeds);
}

TEST_F(CheckRefuses, TracksThatDoNotFit) {
  write_tracks_of_truth(folder_);
  const std::string good = track_experiment();
  expect_same_of("tracks that end too soon", with(good, "frames = 7", "frames = 70"));
  std::string ten_starts = good.substr(0, good.find("# Nominal starting places"));
  expect_same_of("another number of particles", with(ten_starts, "count = 10", "count = 12"));
  const std::string tracks = content_of(folder_ / "rep3.csv");
  const auto spoilt = [&](const std::string& content) { folder_.write("rep3.csv", content); };
  spoilt(with(tracks, "0.0", "left"));
  expect_same_of("text in a cell", good);
  spoilt(tracks.substr(0, tracks.find('\n') + 1));
  expect_same_of("no rows", good);
  spoilt(with(tracks, "x_m", "x_furlong"));
  expect_same_of("an unknown unit", good, "track");
  spoilt(tracks + tracks.substr(tracks.find('\n') + 1));
  expect_same_of("a particle twice", good, "track");
  // No angle and no stated one: the case of fail-01 without [[start]]
  for (int n = 1; n <= 5; ++n) {
    std::ofstream file(folder_ / fmt::format("rep{}.csv", n));
    file << "time_s,particle,x_m,z_m\n";
    for (int frame = 0; frame < 60; ++frame)
      for (int p = 1; p <= 10; ++p)
        file << 0.03 * (frame - 3) << ',' << p << ',' << 0.05 * p << ',' << 0.0001 * n * p << '\n';
  }
  expect_same_of("no angles", ten_starts);
}

TEST_F(CheckRefuses, FilmsThatNobodyCanFollow) {
  // The bundled experiment with two of its films
  std::string good = film_experiment();
  for (int n = 3; n <= 5; ++n) {
    good = with(good,
                fmt::format("[[replicate]]\nvideo = \"{}\"\n",
                            (bundled_micro() / fmt::format("rep{}.mp4", n)).string()),
                "");
  }
  const std::string film = (bundled_micro() / "rep2.mp4").string();
  expect_same_of(
      "no film", with(good, film, folder_.write("bad.mp4", "no film").string()), "track");
  expect_same_of("three balls",
                 with(good,
                      "  {offset_mm = 13.915, radius_mm = 22.225},\n",
                      "  {offset_mm = 0, radius_mm = 22.225},\n"
                      "  {offset_mm = 13.915, radius_mm = 22.225},\n"),
                 "track");
  expect_same_of(
      "no scale", with(good, "fiducial_diameter_mm = 14", "fiducial_diameter_mm = 90"), "track");
  expect_same_of("a region outside the picture",
                 with(good, "noted_event_s", "region_px = [900, 0, 1000, 100]\nnoted_event_s"),
                 "track");
  std::string large = good;
  for (int ball = 0; ball < 2; ++ball) large = with(large, "radius_mm = 22.225", "radius_mm = 111");
  expect_same_of("grains of another size", large, "track");
}

TEST_F(CheckRefuses, FoldersThatCannotBeWritten) {
  write_tracks_of_truth(folder_);
  expect_same("a folder in /proc",
              folder_.write("experiment.toml", track_experiment()),
              "calibrate",
              "/proc/run");
}

// A scene that cannot be filled is refused by simulate; of an experiment, every simulation would
// end so.
TEST_F(CheckRefuses, ScenesThatSimulateRefuses) {
  run_program({"new", "scene", folder_ / "box"});
  for (int n = 1; n <= 3; ++n) {
    std::ofstream table(folder_ / fmt::format("box/cell{}.csv", n));
    table << "time_s,mass_g\n";
    for (int reading = 0; reading <= 100; ++reading)
      table << 0.01 * reading << ',' << std::min(100.0, (2.4 + 0.1 * n) * reading) << '\n';
  }
  const std::string good = content_of(folder_ / "box/box.toml");
  for (const auto& [what, from, to] :
       {std::tuple("no room", "count = 200", "count = 2000"),
        std::tuple("a wall that is none", "[50, 25, 0], [25, 25, 0]", "[25, -25, 0], [50, -25, 0]"),
        std::tuple("no such shape", "radius_mm = 5", "radius_mm = -5")}) {
    const auto scene = folder_.write("box/box.toml", with(good, from, to));
    const ProgramOutcome refused = run_program({"simulate", scene, "--out", out(), "--quiet"});
    EXPECT_EQ(refused.status, 2) << what << refused.err;
    std::string sentence = sentence_of(refused);
    sentence = sentence.substr(sentence.find(": ") + 2);  // who says it differs
    const ProgramOutcome check =
        run_program({"check", folder_ / "box/experiment.toml", "--out", out()});
    EXPECT_EQ(check.status, 2) << what << check.out;
    EXPECT_TRUE(contains(check.out + check.err, sentence))
        << what << ": '" << sentence << "' is not in:\n"
        << check.out << check.err;
  }
}

// --- What is only doubtful
// --------------------------------------------------------------------------

TEST_F(CheckRefuses, NoExperimentOfAngleFreeTracksWithStatedAngles) {
  const auto cases = std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "../shared/cases/fail-01";
  if (!std::filesystem::exists(cases)) GTEST_SKIP() << cases << " is not here";
  std::filesystem::copy(cases, folder_ / "case");
  for (const char* verb : {"check", "track"}) {
    const ProgramOutcome outcome =
        run_program({verb, folder_ / "case/experiment.toml", "--out", out()});
    EXPECT_EQ(outcome.status, 0) << verb << outcome.err;
    if (verb == std::string("check")) {
      EXPECT_TRUE(contains(outcome.out, "Ready")) << outcome.out;
    }
  }
}

class Pairs : public CheckRefuses {
 protected:
  // Pairs of balls that lie still on a floor from -60 to 60 mm, tracked without angles; some are
  // placed up to half a millimetre apart in their replicates.
  std::string pairs(const std::string& changed_from = "", const std::string& changed_to = "") {
    for (int n = 1; n <= 3; ++n) {
      std::ofstream file(folder_ / fmt::format("run{}.csv", n));
      file << "y,x,frame,particle\n";
      for (int frame = 0; frame < 30; ++frame)
        for (int p = 0; p < 2; ++p)
          file << 80 << ',' << 120 + 160 * p + (p + 1) * n << ',' << frame << ',' << p << '\n';
    }
    std::string text =
        "title = \"Pairs\"\n[particle]\ncount = 2\nmass_g = 8\n"
        "spheres = [{offset_mm = -3, radius_mm = 5}, {offset_mm = 3, radius_mm = 5}]\n"
        "[material]\nelastic_modulus_mpa = 20\npoisson_ratio = 0.3\n"
        "friction_particle_particle = 0.3\nfriction_particle_wall = 0.3\nrestitution = 0.5\n"
        "[rig]\nkind = \"walls\"\nfront_back_gap_mm = 11\n"
        "[[rig.wall]]\nfrom_x_mm = -60\nfrom_z_mm = 0\nto_x_mm = 60\nto_z_mm = 0\n"
        "[measure]\nframe_interval_s = 0.1\nframes = 4\n"
        "[tune]\nfriction_particle_wall = {}\n"
        "[[start]]\nx_mm = -20\nz_mm = 5\nangle_deg = 0\n"
        "[[start]]\nx_mm = 20\nz_mm = 5\nangle_deg = 0\n";
    for (int n = 1; n <= 3; ++n)
      text += fmt::format(
          "[[replicate]]\ntracks = \"run{}.csv\"\nscale_px_per_mm = 4\norigin_px = [200, 100]\n"
          "frame_rate_hz = 50\n",
          n);
    return changed_from.empty() ? text : with(text, changed_from, changed_to);
  }

  ProgramOutcome check(const std::string& text) {
    return run_program({"check", folder_.write("pairs.toml", text), "--out", out()});
  }
};

TEST_F(Pairs, StartWithStatedAnglesWhereTracksHaveNone) {
  const ProgramOutcome outcome = check(pairs());
  EXPECT_EQ(outcome.status, 0) << outcome.out << outcome.err;
  EXPECT_TRUE(contains(outcome.out, "Ready")) << outcome.out;
  for (const char* never : {"fall out", "centre of mass", "may not belong"})
    EXPECT_FALSE(contains(outcome.out, never)) << outcome.out;
}

TEST_F(Pairs, ThatFallBesideTheFloorAreNoticed) {
  const ProgramOutcome outcome = check(pairs("to_x_mm = 60", "to_x_mm = 5"));
  EXPECT_EQ(outcome.status, 0) << outcome.out << outcome.err;
  EXPECT_TRUE(
      contains(outcome.out, "1 of 2 particles fall out of the rig within 0.3 s, particle 2"))
      << outcome.out;
}

TEST_F(Pairs, WhoseCentreOfMassLiesElsewhereAreNoticed) {
  const ProgramOutcome outcome =
      check(pairs("{offset_mm = 3, radius_mm = 5}", "{offset_mm = 6, radius_mm = 5}"));
  EXPECT_TRUE(contains(outcome.out, "centre of mass")) << outcome.out;
  EXPECT_TRUE(contains(outcome.out, "by x -1.5, y 0, z 0 mm")) << outcome.out;
}

}  // namespace
}  // namespace graintruth::tests
