// The six decks of Appendix D, run as they stand, with what they leave out from
// datasets/scenes/decks.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/run/data_folder.h"
#include "app/run/interrupt.h"
#include "app/scenes/scene_picture.h"
#include "app/thesis/targets.h"
#include "calibrate/engines/scene_run.h"
#include "datasets/store/fingerprint.h"
#include "datasets/store/run_folder.h"

namespace graintruth::app {

namespace {

using Json = Studies::Json;

struct Deck {
  const char* stem;   // of its file
  const char* start;  // its row in deck_start.csv
};

// The thesis's own file, which is not part of the repository but may lie beside it.
std::filesystem::path file_of(const Deck& deck) {
  return std::filesystem::weakly_canonical(data_folder()).parent_path().parent_path() / "shared" /
         "thesis" / "decks" / (std::string(deck.stem) + ".txt");
}

// Height of the upper of the surfaces that move, m; NaN where fewer than two do.
double upper_belt(const datasets::SceneFile& file) {
  std::vector<double> heights;
  for (const datasets::SceneWall& wall : file.walls) {
    if (!wall.drag.velocity.isZero(0.0)) heights.push_back(wall.points.front().z());
  }
  return heights.size() < 2 ? no_number : *std::max_element(heights.begin(), heights.end());
}

// The fastest surface, and from where to where it reaches along x.
struct FastBelt {
  double speed = 0.0, from = 0.0, to = 0.0;  // m/s, m
};
FastBelt fastest_belt(const datasets::SceneFile& file) {
  FastBelt belt;
  for (const datasets::SceneWall& wall : file.walls) {
    if (wall.drag.velocity.x() <= belt.speed) continue;
    belt = {wall.drag.velocity.x(), wall.points.front().x(), wall.points.front().x()};
    for (const auto& point : wall.points) {
      belt.from = std::min(belt.from, point.x());
      belt.to = std::max(belt.to, point.x());
    }
  }
  return belt;
}

Json run_deck(const Deck& deck, const ThesisData& thesis, Studies& studies) {
  const std::filesystem::path folder = studies.folder() / "decks" / deck.stem;
  std::filesystem::create_directories(folder);
  const datasets::SceneFile file =
      datasets::load_scene(file_of(deck), bundled_sidecar(file_of(deck)).value());
  calibrate::SceneRunOptions options;
  options.seed = studies.seed();
  options.stop = is_interrupted;
  options.progress = [&](const std::string& job, double share, const std::string& detail) {
    studies.progress().show(std::string(deck.stem) + ", " + job, share, detail);
  };
  const calibrate::SceneRun run = calibrate::run_scene(file, options);
  Json result = {{"completed", run.status == sim::RunStatus::completed},
                 {"message", run.message},
                 {"duration", run.phases.empty() ? 0.0 : run.phases.back().end}};
  if (run.frames.empty()) return result;
  render_scene(folder, file, run, [](double) {});

  // Where the particles are in the end, against the workspace and the belts
  const datasets::Table& start = thesis.table("deck_start");
  double width = 0.0;
  for (std::size_t row = 0; row < start.rows(); ++row) {
    if (start.text(row, "deck") == deck.start)
      width = start.number(row, "xdim_cm") * unit_in_si("cm");
  }
  const double belt = upper_belt(file);
  const FastBelt fast = fastest_belt(file);
  const sim::State& end = run.frames.back().state;
  int outside = 0, below = 0;
  std::vector<double> speeds;
  for (std::size_t i = 0; i < end.position.size(); ++i) {
    const sim::Vec3& place = end.position[i];
    const bool is_inside = place.x() > 0.0 && place.x() < width && place.z() > 0.0;
    outside += is_inside ? 0 : 1;
    below += place.z() < belt ? 1 : 0;
    if (place.x() > fast.from && place.x() < fast.to) speeds.push_back(end.velocity[i].x());
  }
  result["particles"] = end.position.size();
  result["outside"] = outside;
  result["below"] = below;
  result["fast_speed"] = fast.speed;
  result["speeds"] = speeds;
  return result;
}

// The rows that all decks have; null where the deck is absent or did not run.
Json examine_deck(const Deck& deck, Examination& exam, const ThesisData& thesis, Studies& studies) {
  const Printed runs{"runs", "s", "Appendix " + std::string(deck.start)};
  if (!std::filesystem::exists(file_of(deck))) {
    exam.not_run("the deck runs to its end",
                 runs,
                 "the thesis's decks are not bundled and do not lie beside this repository");
    return nullptr;
  }
  const std::filesystem::path sidecar = bundled_sidecar(file_of(deck)).value();
  const std::string inputs =
      datasets::file_hash(file_of(deck)) + " " + datasets::file_hash(sidecar);
  Json result =
      studies.result(exam.target(), inputs, [&] { return run_deck(deck, thesis, studies); });
  exam.claim("the deck runs to its end",
             runs,
             {.mean = result["duration"].get<double>()},
             no_number,
             result["completed"].get<bool>(),
             result["message"].get<std::string>());
  if (!result.contains("outside")) return nullptr;
  exam.claim("particles beside or below the workspace",
             {"0", "-", "START"},
             {.mean = result["outside"].get<double>()},
             0.0,
             result["outside"].get<int>() == 0);
  exam.add_note(fmt::format("A film of the run lies in decks/{}/simulation.mp4.", deck.stem));
  return result;
}

// Sections 3.9.1 to 3.9.3: from the upper conveyor onto the lower.
void examine_drop(const Deck& deck, Examination& exam, const ThesisData& thesis, Studies& studies) {
  const Json result = examine_deck(deck, exam, thesis, studies);
  if (result.is_null()) return;
  const int particles = result["particles"].get<int>();
  exam.claim("particles that dropped from the upper conveyor onto the lower",
             {std::to_string(particles), "-", "sec 3.9"},
             {.mean = result["below"].get<double>()},
             0.0,
             result["below"].get<int>() == particles);
}

}  // namespace

void simulate_deck_a(Examination& exam, const ThesisData& thesis, Studies& studies) {
  examine_drop({"D_a_conical_single", "D_a"}, exam, thesis, studies);
}
void simulate_deck_b(Examination& exam, const ThesisData& thesis, Studies& studies) {
  examine_drop({"D_b_irregular_single", "D_b"}, exam, thesis, studies);
}
void simulate_deck_c(Examination& exam, const ThesisData& thesis, Studies& studies) {
  examine_drop({"D_c_conical_bunch", "D_c"}, exam, thesis, studies);
}

// Section 3.9.5: on the faster conveyor the particles take up its speed.
void simulate_deck_d(Examination& exam, const ThesisData& thesis, Studies& studies) {
  const Json result = examine_deck({"D_d_singulation", "D_d"}, exam, thesis, studies);
  if (result.is_null()) return;
  const auto speeds = result["speeds"].get<std::vector<double>>();
  if (speeds.empty()) {
    exam.not_run("speed on the faster conveyor",
                 {"that of the conveyor", "m/s", "sec 3.9.5"},
                 "no particle had reached it in the end");
    return;
  }
  const double wanted = result["fast_speed"].get<double>();
  const double tolerance = thesis.setting("decks", "speed_tolerance") * wanted;
  const double mean = over_seeds(speeds).mean;
  Row& row = exam.claim("speed on the faster conveyor",
                        {"that of the conveyor", "m/s", "sec 3.9.5"},
                        {.mean = mean},
                        tolerance,
                        std::abs(mean - wanted) <= tolerance,
                        fmt::format("mean of {} particles in the end", speeds.size()));
  row.recomputed = wanted;
}
void simulate_deck_e(Examination& exam, const ThesisData& thesis, Studies& studies) {
  examine_deck({"D_e_rotating_disk", "D_e"}, exam, thesis, studies);
}
void simulate_deck_f(Examination& exam, const ThesisData& thesis, Studies& studies) {
  examine_deck({"D_f_micro_experiment", "D_f"}, exam, thesis, studies);
}

}  // namespace graintruth::app
