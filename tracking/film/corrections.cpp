#include "tracking/film/corrections.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "datasets/store/input_error.h"
#include "datasets/store/table.h"

namespace graintruth::tracking {

using datasets::InputError;

namespace {

// A hand places a centre to a pixel, and a long axis to a few degrees.
constexpr double hand_angle = 0.1;  // rad
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

void exchange(datasets::Trajectories& tracks, std::size_t i, std::size_t j) {
  std::swap(tracks.poses[i], tracks.poses[j]);
  std::swap(tracks.sigmas[i], tracks.sigmas[j]);
  std::swap(tracks.scores[i], tracks.scores[j]);
}

}  // namespace

std::vector<std::string> apply_corrections(const std::filesystem::path& file,
                                           double pixel,
                                           bool shows_angle,
                                           datasets::Trajectories& tracks) {
  const datasets::Table table = datasets::read_csv(file);
  for (const char* needed : {"frame", "action", "particle"}) {
    if (!table.has(needed))
      throw InputError(
          fmt::format("{}: column '{}' is missing; corrections need frame, action and "
                      "particle{}.",
                      file.string(),
                      needed,
                      table.header_words()));
  }
  std::vector<std::string> applied;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const auto refuse = [&](const std::string& complaint) {
      throw InputError(fmt::format("{}:{}: {}", file.string(), table.line(row), complaint));
    };
    const auto particle_in = [&](const char* column) {
      if (!table.has(column)) refuse(fmt::format("column '{}' is missing", column));
      const int number = table.integer(row, column);
      if (number < 1 || number > tracks.particles)
        refuse(fmt::format("{} {} does not exist; there are {}", column, number, tracks.particles));
      return static_cast<std::size_t>(number - 1);
    };
    const int frame = table.integer(row, "frame");
    if (frame < 0 || frame >= static_cast<int>(tracks.frames()))
      refuse(
          fmt::format("frame {} does not exist; the film has 0 to {}", frame, tracks.frames() - 1));
    const auto first = static_cast<std::size_t>(frame);
    const std::size_t particle = particle_in("particle");
    const std::string action = table.text(row, "action");
    if (action == "move") {
      const auto given = [&](const char* column) {
        return table.has(column) ? table.number(row, column) : nan;
      };
      for (const char* needed : {"x_m", "z_m"})
        if (!std::isfinite(given(needed))) refuse(fmt::format("'move' needs {}", needed));
      if (std::isfinite(given("angle_rad")) != shows_angle) {
        refuse(shows_angle ? "'move' needs angle_rad"
                           : "this kind of body shows no angle; leave angle_rad empty");
      }
      const std::size_t i = tracks.index(first, particle);
      tracks.poses[i] = {given("x_m"), given("z_m"), given("angle_rad")};
      tracks.sigmas[i] = {pixel, pixel, shows_angle ? hand_angle : nan};
      tracks.scores[i] = 1.0;
    } else if (action == "delete") {
      for (std::size_t k = first; k < tracks.frames(); ++k)
        tracks.poses[tracks.index(k, particle)] = {};
    } else if (action == "swap") {
      const std::size_t other = particle_in("other");
      for (std::size_t k = first; k < tracks.frames(); ++k)
        exchange(tracks, tracks.index(k, particle), tracks.index(k, other));
    } else {
      refuse(fmt::format("action '{}' is unknown; it must be move, delete or swap", action));
    }
    applied.push_back(fmt::format(
        "Corrected by hand: {} particle {} from frame {}.", action, particle + 1, frame));
  }
  // A hand states an angle within half a turn, and tracks that change places turned otherwise
  if (shows_angle) datasets::unwrap_angles(tracks);
  return applied;
}

}  // namespace graintruth::tracking
