// Whatever cannot be used ends with exit status 2 and one sentence that names it, and leaves
// nothing behind.
#include "tests/app/bad_input.h"

namespace graintruth::tests {
namespace {

TEST_F(BadInput, MissingExperiment) {
  const std::string missing = (folder_ / "nowhere.toml").string();
  expect_refusal(run_program({"calibrate", missing, "--out", out()}), {missing});
}

TEST_F(BadInput, MissingVideo) {
  expect_refusal(
      calibrate(with(film_experiment(), (bundled_micro() / "rep3.mp4").string(), "rep9.mp4")),
      {"experiment.toml:", "replicate.video", "rep9.mp4"});
}

TEST_F(BadInput, VideoOfGarbage) {
  std::string garbage;
  for (int i = 0; i < 200000; ++i) garbage += static_cast<char>((i * 7919 + i / 251) % 256);
  expect_refusal(calibrate(with_film(garbage)), {"bad.mp4", "cannot be opened as a film"});
}

// Shorter than its index says; check tells it in the same words.
TEST_F(BadInput, CutOffVideoFile) {
  const std::string film = content_of(bundled_micro() / "rep3.mp4");
  const std::string text = with_film(film.substr(0, film.size() / 2));
  const ProgramOutcome refused = calibrate(text);
  expect_refusal(refused, {"bad.mp4"});
  const std::string prefix = "graintruth: ";
  const std::string sentence =
      refused.err.substr(prefix.size(), refused.err.size() - prefix.size() - 2);
  EXPECT_TRUE(contains(sentence, "cut off")) << sentence;
  const ProgramOutcome check =
      run_program({"check", (folder_ / "experiment.toml").string(), "--out", out()});
  EXPECT_EQ(check.status, 2);
  EXPECT_TRUE(contains(check.out, "missing: " + sentence)) << sentence << '\n' << check.out;
}

TEST_F(BadInput, EmptyVideoFile) { expect_refusal(calibrate(with_film("")), {"bad.mp4", "empty"}); }

// Everything of a film but its frames: the boxes up to 'mdat', and that one empty.
TEST_F(BadInput, VideoOfNoFrames) {
  const std::string film = content_of(bundled_micro() / "rep3.mp4");
  const std::size_t data = film.find("mdat");
  ASSERT_NE(data, std::string::npos);
  expect_refusal(calibrate(with_film(film.substr(0, data - 4) + std::string("\0\0\0\x08mdat", 8))),
                 {"bad.mp4"});
}

TEST_F(BadInput, ThreeFiducials) {
  std::string text = film_experiment();
  const std::size_t from = text.find("  [-290, 220]");
  const std::size_t to = text.find("]\n\n[measure]");
  text.replace(from, to - from, "  [-290, 220],\n  [290, 220],\n  [-290, 110],\n");
  expect_refusal(calibrate(text), {"experiment.toml:", "camera.fiducials_mm", "at least 4"});
}

TEST_F(BadInput, UnknownKeyGetsTheNearestSpelling) {
  expect_refusal(calibrate(with(film_experiment(), "noted_event_s", "notd_event_s")),
                 {"experiment.toml:", "camera.notd_event_s", "'noted_event_s'"});
}

TEST_F(BadInput, JointOfOne) {
  folder_.write("rep.toml", film_experiment());
  expect_refusal(calibrate("title = \"One\"\n[[experiment]]\nfile = \"rep.toml\"\n"
                           "[tune]\nrestitution = {lower = 0.3, upper = 0.9}\n"),
                 {"experiment.toml", "'experiment'", "at least 2"});
}

TEST_F(BadInput, JointOfOtherGrains) {
  folder_.write("first.toml", film_experiment());
  folder_.write(
      "second.toml",
      with(film_experiment(), "friction_particle_wall = 0.35", "friction_particle_wall = 0.25"));
  const std::string joint =
      "title = \"Two\"\n[[experiment]]\nfile = \"first.toml\"\n"
      "[[experiment]]\nfile = \"second.toml\"\n"
      "[tune]\nrestitution = {lower = 0.3, upper = 0.9}\n";
  expect_refusal(calibrate(joint),
                 {"experiment.toml:", "material.friction_particle_wall of 0.25", "0.35"});
  folder_.write("second.toml", film_experiment());
  expect_refusal(calibrate(with(joint, "second.toml", "first.toml")),
                 {"second experiment called 'first'"});
  expect_refusal(calibrate(with(joint, "second.toml", "third.toml")), {"third.toml", "no such"});
}

TEST_F(BadInput, JointFileWhereOneExperimentIsNeeded) {
  const auto file = folder_.write("joint.toml", "title = \"Two\"\n[[experiment]]\n");
  expect_refusal(run_program({"track", file.string(), "--out", out()}),
                 {"joint.toml", "calibrated together", "'calibrate' and 'check'"});
}

TEST_F(BadInput, NegativeFriction) {
  expect_refusal(
      calibrate(with(
          film_experiment(), "friction_particle_wall = 0.35", "friction_particle_wall = -0.35")),
      {"experiment.toml:", "material.friction_particle_wall", "-0.35"});
}

TEST_F(BadInput, OneReplicate) {
  std::string text = film_experiment();
  for (int n = 2; n <= 5; ++n) {
    const std::string film = (bundled_micro() / ("rep" + std::to_string(n) + ".mp4")).string();
    text = with(text, "[[replicate]]\nvideo = \"" + film + "\"\n", "");
  }
  expect_refusal(calibrate(text), {"experiment.toml", "replicate", "at least 2"});
}

TEST_F(BadInput, TextInANumberColumn) {
  write_tracks_of_truth(folder_);
  const auto tracks = folder_ / "rep4.csv";
  folder_.write("rep4.csv", with(content_of(tracks), "0.0", "left"));
  expect_refusal(calibrate(track_experiment()), {"rep4.csv:2", "left"});
}

TEST_F(BadInput, TracksThatEndTooSoon) {
  write_tracks_of_truth(folder_);
  expect_refusal(calibrate(with(track_experiment(), "frames = 7", "frames = 700")),
                 {"rep1.csv", "139.8"});
}

// The second of these holds for root too, who may write everywhere else.
TEST_F(BadInput, OutFolderThatCannotBeWritten) {
  write_tracks_of_truth(folder_);
  const auto file = folder_.write("experiment.toml", track_experiment());
  folder_.write("a-file", "");
  for (const std::string& place : {(folder_ / "a-file/run").string(), std::string("/proc/run")}) {
    expect_refusal(run_program({"calibrate", file.string(), "--out", place, "--quiet"}),
                   {place, "cannot be written", "--out"});
  }
}

TEST_F(BadInput, UnknownVerb) {
  expect_refusal(run_program({"calibrat", "experiment.toml"}), {"'calibrat'", "calibrate, track"});
  expect_refusal(run_program({}), {"verb", "--help"});
}

TEST_F(BadInput, UnknownOption) {
  expect_refusal(run_program({"calibrate", "experiment.toml", "--buget", "30"}), {"--buget"});
  expect_refusal(run_program({"calibrate", "experiment.toml", "--budget", "many"}), {"--budget"});
  expect_refusal(run_program({"calibrate"}), {"experiment"});
}

TEST_F(BadInput, ParameterFile) {
  write_tracks_of_truth(folder_);
  const auto file = folder_.write("experiment.toml", track_experiment());
  const auto validate = [&](const std::filesystem::path& parameters) {
    return run_program({"validate", file, "--parameters", parameters, "--out", out(), "--quiet"});
  };
  expect_refusal(validate(folder_ / "nowhere.toml"), {"nowhere.toml"});
  expect_refusal(validate(folder_.write("bad.toml", "friction_partikle_wall = 0.2\n")),
                 {"bad.toml:1", "friction_partikle_wall", "'friction_particle_wall'"});
  expect_refusal(validate(folder_.write("low.toml", "restitution = -0.2\n")),
                 {"low.toml:1", "restitution", "-0.2"});
  expect_refusal(validate(folder_.write("bad.json", "{\"parameters\":")), {"bad.json"});
}

// A result.json that another program wrote, or a hand changed.
TEST_F(BadInput, ImpossibleParametersInAResult) {
  write_tracks_of_truth(folder_);
  const auto file = folder_.write("experiment.toml", track_experiment());
  const auto result = [&](const std::string& friction, const std::string& fraction) {
    return folder_.write(
        "result.json",
        "{\"parameters\": {\"friction_particle_particle\": {\"value\": " + friction +
            "}, \"friction_particle_wall\": {\"value\": 0.2}, \"restitution\": "
            "{\"value\": 0.8}}, \"time_step\": {\"fraction\": " +
            fraction + "}}");
  };
  for (const char* verb : {"validate", "evaluate"}) {
    const auto run = [&](const std::filesystem::path& parameters) {
      return run_program({verb, file, "--parameters", parameters, "--out", out(), "--quiet"});
    };
    expect_refusal(run(result("-0.1", "0.5")),
                   {"result.json",
                    "friction_particle_particle",
                    "is -0.1, but a friction from 0 to 5 is needed"});
    expect_refusal(run(result("9", "0.5")), {"is 9, but a friction from 0 to 5 is needed"});
    expect_refusal(run(result("null", "0.5")), {"holds no number"});
    expect_refusal(run(result("0.1", "50")), {"time_step.fraction", "is 50"});
  }
}

TEST_F(BadInput, TheCaseOfImpossibleParameters) {
  const auto cases = std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "../shared/cases/fail-05";
  if (!std::filesystem::exists(cases)) GTEST_SKIP() << cases << " is not here";
  for (const char* parameters : {"neg.json", "rest.json", "step.json", "friction9.json"}) {
    expect_refusal(run_program({"validate",
                                cases / "experiment.toml",
                                "--parameters",
                                cases / parameters,
                                "--out",
                                out(),
                                "--quiet"}),
                   {parameters, "needed"});
  }
}

// All files of a run are UTF-8
TEST_F(BadInput, NamesThatAreNotUtf8) {
  const auto file = folder_ / "caf\xe9.toml";
  std::ofstream(file) << track_experiment();
  for (const char* verb : {"check", "track", "calibrate"})
    expect_refusal(run_program({verb, file, "--out", out()}), {"not UTF-8"});
}

TEST_F(BadInput, UnknownTarget) {
  expect_refusal(run_program({"reproduce", "table-9.9"}), {"table-9.9", "--list"});
}

TEST_F(BadInput, RunFolderWithoutAResult) {
  expect_refusal(run_program({"report", out()}), {out()});
}

}  // namespace
}  // namespace graintruth::tests
