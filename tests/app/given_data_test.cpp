// Tracks of other programs and discharge curves in place of films, by the program as users run it:
// the rest of it must not know the difference.
#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "tests/app/bad_input.h"
#include "tests/app/weighed_bin.h"
#include "tests/support/read_rows.h"

namespace graintruth::tests {
namespace {

constexpr double frame_rate = 50.0;  // Hz
constexpr double scale = 2.5;        // px/mm of the picture that the other program saw
constexpr double origin_column = 400.0, origin_row = 310.0;
constexpr double event_time = 0.2;  // s of film
constexpr int frames_kept = 90;     // enough for the small experiment's seven moments

// One detection of the bundled truth as another program would have found it.
struct Seen {
  int frame, particle;
  double column, row, angle_deg;
};

std::vector<Seen> seen_in(int replicate) {
  std::vector<Seen> all;
  const std::string file = fmt::format("rep{}_tracks.csv", replicate);
  for (const Row& row : read_rows(bundled_micro() / "truth" / file)) {
    const int frame = static_cast<int>(std::lround(number(row, "time_s") * frame_rate));
    if (frame >= frames_kept) continue;
    // Numbers as they are found: other ones in every film
    const int found = (static_cast<int>(number(row, "particle")) * 7 + replicate) % 11;
    all.push_back({frame,
                   found,
                   origin_column + 1e3 * scale * number(row, "x_m"),
                   origin_row - 1e3 * scale * number(row, "z_m"),
                   number(row, "angle_rad") * 180.0 / std::numbers::pi});
  }
  return all;
}

std::string trackpy(const std::vector<Seen>& all) {
  std::string text = "y,x,mass,frame,particle\n";
  for (const Seen& one : all)
    text += fmt::format("{},{},100,{},{}\n", one.row, one.column, one.frame, one.particle);
  return text;
}

std::string imagej(const std::vector<Seen>& all) {
  std::string text = " \tTrack\tSlice\tX\tY\tAngle\n";
  int number = 0;
  for (const Seen& one : all)
    text += fmt::format("{}\t{}\t{}\t{}\t{}\t{}\n",
                        ++number,
                        one.particle,
                        one.frame + 1,
                        one.column,
                        one.row,
                        std::fmod(one.angle_deg + 3600.0, 180.0));
  return text;
}

std::string trackmate(const std::vector<Seen>& all) {
  std::string text =
      "LABEL,TRACK_ID,POSITION_X,POSITION_Y,POSITION_Z,POSITION_T,FRAME\n"
      "Label,Track ID,X,Y,Z,T,Frame\nLabel,Track ID,X,Y,Z,T,Frame\n,,(mm),(mm),(mm),(sec),\n";
  for (const Seen& one : all)
    text += fmt::format("ID,{},{},{},0,{},{}\n",
                        one.particle,
                        one.column / scale,
                        one.row / scale,
                        one.frame / frame_rate,
                        one.frame);
  return text;
}

std::string trackmate_xml(const std::vector<Seen>& all) {
  std::map<int, std::string> particles;
  for (const Seen& one : all)
    particles[one.particle] += fmt::format(
        "<detection t=\"{}\" x=\"{}\" y=\"{}\" z=\"0\" />\n", one.frame, one.column, one.row);
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n<Tracks spaceUnits=\"pixel\" frameInterval=\"{}\" "
      "timeUnits=\"sec\">\n",
      1.0 / frame_rate);
  for (const auto& [particle, detections] : particles)
    text += "<particle>\n" + detections + "</particle>\n";
  return text + "</Tracks>\n";
}

class GivenTracks : public BadInput {
 protected:
  // The small experiment with tracks of another program.
  std::string experiment(const std::string& extension,
                         const std::string& how,
                         std::string (*write)(const std::vector<Seen>&)) {
    std::string text = track_experiment();
    for (int n = 1; n <= 5; ++n) {
      const std::string file = fmt::format("rep{}.{}", n, extension);
      folder_.write(file, write(seen_in(n)));
      text = with(text,
                  fmt::format("tracks = \"rep{}.csv\"", n),
                  fmt::format("tracks = \"{}\"\nevent_s = {}\n{}", file, event_time, how));
    }
    return text;
  }

  // What `track` leaves of the first replicate, against the truth.
  void expect_truth(const std::string& text, bool with_angles) {
    const auto file = folder_.write("experiment.toml", text);
    const ProgramOutcome outcome = run_program({"track", file.string(), "--out", out()});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    std::map<std::pair<int, int>, Row> truth;
    for (const Row& row : read_rows(bundled_micro() / "truth/rep1_tracks.csv")) {
      const auto frame = static_cast<int>(std::lround(number(row, "time_s") * frame_rate));
      truth[{frame, static_cast<int>(number(row, "particle"))}] = row;
    }
    const auto rows = read_rows(std::filesystem::path(out()) / "tracks/rep1.csv");
    ASSERT_EQ(rows.size(), 10U * frames_kept);
    for (const Row& row : rows) {
      const Row& expected = truth.at(
          {static_cast<int>(number(row, "frame")), static_cast<int>(number(row, "particle"))});
      ASSERT_NEAR(number(row, "time_s"), number(expected, "time_s") - event_time, 1e-9);
      ASSERT_NEAR(number(row, "x_m"), number(expected, "x_m"), 1e-8);
      ASSERT_NEAR(number(row, "z_m"), number(expected, "z_m"), 1e-8);
      ASSERT_EQ(row.at("angle_rad").empty(), !with_angles);
      if (!with_angles) continue;
      const double turned = number(row, "angle_rad") - number(expected, "angle_rad");
      ASSERT_NEAR(std::remainder(turned, std::numbers::pi), 0.0, 1e-8);
    }
  }
};

constexpr const char* pixels = "scale_px_per_mm = 2.5\norigin_px = [400, 310]\n";

TEST_F(GivenTracks, OfTrackpyGetTheirPlacesNumbersAndClock) {
  expect_truth(experiment("csv", pixels, trackpy), false);
}

TEST_F(GivenTracks, OfImageJKeepTheirAngles) {
  expect_truth(experiment("xls", pixels, imagej), true);
}

TEST_F(GivenTracks, OfTrackMateMayBeInMillimetresOrXml) {
  expect_truth(experiment("csv", "origin_mm = [160, 124]\n", trackmate), false);
  expect_truth(experiment("xml", pixels, trackmate_xml), false);
}

// The same tracks as our own file and as ImageJ's: the same objective at the same parameters.
TEST_F(GivenTracks, AreEvaluatedAsOurOwnAre) {
  const auto parameters = folder_.write("p.toml", "friction_particle_wall = 0.3\n");
  const auto evaluate = [&](const std::string& text, const std::string& name) {
    const auto file = folder_.write(name + ".toml", text);
    const ProgramOutcome outcome = run_program({"evaluate",
                                                file.string(),
                                                "--parameters",
                                                parameters.string(),
                                                "--runs",
                                                "1",
                                                "--json",
                                                "--out",
                                                (folder_ / name).string()});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  };
  const auto theirs = evaluate(experiment("xls", pixels, imagej), "theirs");
  write_tracks_of_truth(folder_);
  const auto ours = evaluate(track_experiment(), "ours");
  // Starting poses differ in their last bits, which a contact makes larger.
  EXPECT_NEAR(theirs["objective"], ours["objective"], 0.02 * double(ours["objective"]));
  EXPECT_NEAR(theirs["agreement_percent"], ours["agreement_percent"], 2.0);
}

TEST_F(GivenTracks, ThatCannotBeUsedAreRefusedInOneSentence) {
  expect_refusal(calibrate(experiment("csv", "origin_px = [400, 310]\n", trackpy)),
                 {"rep1.csv", "pixels", "scale_px_per_mm"});
  expect_refusal(calibrate(experiment("csv", "scale_px_per_mm = 2.5\norigin_px = [1]\n", trackpy)),
                 {"experiment.toml:", "origin_px"});
  expect_refusal(calibrate(experiment("csv", std::string(pixels) + "y_axis = \"left\"\n", trackpy)),
                 {"experiment.toml:", "y_axis", "\"down\""});
  expect_refusal(
      calibrate(experiment("csv", std::string(pixels) + "scale_px_per_m = 1\n", trackpy)),
      {"experiment.toml:", "scale_px_per_m", "second time"});
  const std::string text = experiment("csv", pixels, trackpy);
  folder_.write("rep3.csv", content_of(folder_ / "rep3.csv") + "1,1,100,0,4\n");
  expect_refusal(calibrate(text), {"rep3.csv:902", "second time"});
  folder_.write("rep3.csv", "y,x,frame,particle\n");
  expect_refusal(calibrate(text), {"rep3.csv", "no rows"});
}

std::string pixels_called_millimetres(const std::vector<Seen>& all) {
  std::vector<Seen> scaled = all;
  for (Seen& one : scaled) {
    one.column *= scale;
    one.row *= scale;
  }
  return trackmate(scaled);
}

std::string without_a_clock(const std::vector<Seen>& all) {
  return with(trackmate_xml(all),
              fmt::format("frameInterval=\"{}\"", 1.0 / frame_rate),
              "frameInterval=\"1.0\"");
}

// What the file says of time and place against what the experiment file says
TEST_F(GivenTracks, WithAnotherClockOrScaleThanStatedAreRefused) {
  const std::string no_clock = experiment("xml", pixels, without_a_clock);
  expect_refusal(calibrate(no_clock), {"rep1.xml", "1 frames a second", "frame_rate_hz is 50"});
  expect_refusal(
      calibrate(experiment("csv", "origin_mm = [160, 124]\n", pixels_called_millimetres)),
      {"rep1.csv", "spread over", "[[start]]", "scale_px_per_mm"});
  expect_refusal(
      calibrate(experiment("csv", "scale_px_per_mm = 25\norigin_px = [400, 310]\n", trackpy)),
      {"rep1.csv", "spread over", "[[start]]"});
  expect_truth(experiment("xml", std::string(pixels) + "frame_rate_hz = 50\n", without_a_clock),
               false);
}

// Angles that nobody tracked come from the stated starting places, or there is nothing to start
// from.
TEST_F(GivenTracks, WithoutAnglesNeedStartingPlaces) {
  std::string text = experiment("csv", pixels, trackpy);
  const std::size_t starts = text.find("[[start]]");
  ASSERT_NE(starts, std::string::npos);
  const std::size_t after = text.find("\n[", text.rfind("[[start]]") + 1);
  text.erase(starts, after == std::string::npos ? after : after - starts);
  expect_refusal(calibrate(text), {"tell no angles", "angle_rad", "[[start]]"});
}

using WeighedBin = BadInput;

TEST_F(WeighedBin, IsMeasuredByTheRulesOfFilms) {
  write_curves(folder_);
  const auto file = folder_.write("bin.toml", weighed_bin());
  const ProgramOutcome outcome = run_program({"track", file.string(), "--out", out()});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  std::ifstream stream(std::filesystem::path(out()) / "measured.json");
  const auto measured = nlohmann::json::parse(stream);
  ASSERT_EQ(measured["replicates"].size(), 4U);
  for (const auto& replicate : measured["replicates"]) {
    const double rate = weighed_rate(replicate["name"]);
    EXPECT_NEAR(replicate["steady"]["rate_kg_per_s"], rate, 0.01 * rate);
    // Nobody saw the bed: nothing is said of it.
    EXPECT_FALSE(replicate.contains("solid_fraction_at_rest"));
    EXPECT_FALSE(replicate.contains("jammed"));
    EXPECT_FALSE(replicate["steady"].contains("areal_density_kg_per_m2"));
  }
  EXPECT_FALSE(measured.contains("kinematic"));
  EXPECT_FALSE(measured.contains("beverloo"));
}

TEST_F(WeighedBin, IsCheckedAndSaysWhatIsLeftOut) {
  write_curves(folder_);
  const auto file = folder_.write("bin.toml", weighed_bin());
  const ProgramOutcome outcome = run_program({"check", file.string(), "--out", out()});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(contains(outcome.out, "does not show the bed, the velocities or an arch"))
      << outcome.out;
}

TEST_F(WeighedBin, ImpossibleCurvesAreRefusedInOneSentence) {
  write_curves(folder_);
  const std::string text = weighed_bin();
  folder_.write("narrow1.csv", "time_s,mass_g\n0,0\n0.2,3\n0.4,6\n0.6,1\n0.8,7\n");
  expect_refusal(calibrate(text), {"narrow1.csv:5", "'mass_g'", "cannot fall"});
  folder_.write("narrow1.csv", "time_s,mass_stone\n0,0\n0.2,3\n0.4,6\n0.6,6\n0.8,7\n");
  expect_refusal(calibrate(text), {"narrow1.csv", "mass", "'discharged_mass_kg'"});
  write_curves(folder_);
  expect_refusal(calibrate(with(text, "discharge = \"narrow1.csv\"", "discharge = \"none.csv\"")),
                 {"experiment.toml:", "replicate.discharge", "none.csv"});
  expect_refusal(
      calibrate(with(track_experiment(), "tracks = \"rep1.csv\"", "discharge = \"wide1.csv\"")),
      {"experiment.toml:", "'replicate.discharge'", "no grains leave"});
  expect_refusal(calibrate(with(text, "name = \"narrow1\"", "scale_px_per_mm = 3")),
                 {"experiment.toml:", "scale_px_per_mm", "only known of tracks"});
}

}  // namespace
}  // namespace graintruth::tests
