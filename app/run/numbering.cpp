#include "app/run/numbering.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/compare/start_poses.h"
#include "tracking/bodies/link.h"

namespace graintruth::app {

namespace {

using datasets::Experiment;
using datasets::Recording;
using datasets::StartPlace;

double distance(const StartPlace& a, const StartPlace& b) {
  return std::hypot(a.x - b.x, a.z - b.z);
}

// Half the smallest distance between two places; of a single one any distance will do.
double reach_of(const std::vector<StartPlace>& places) {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < places.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b)
      smallest = std::min(smallest, distance(places[a], places[b]));
  }
  return 0.5 * smallest;
}

// Numbers, from 1, of those that lie beyond reach of their place.
std::vector<std::size_t> astray(const std::vector<StartPlace>& places,
                                const std::vector<StartPlace>& own,
                                double reach) {
  std::vector<std::size_t> numbers;
  for (std::size_t n = 0; n < places.size(); ++n) {
    if (!(distance(places[n], own[n]) < reach)) numbers.push_back(n + 1);
  }
  return numbers;
}

// Whether they lie at the same places under other numbers.
bool lie_alike(const std::vector<StartPlace>& places,
               const std::vector<StartPlace>& own,
               double reach) {
  std::vector<Eigen::Vector2d> centres;
  for (const StartPlace& place : own) centres.emplace_back(place.x, place.z);
  std::vector<StartPlace> reordered;
  for (const int index : tracking::number_by_start(
           centres, places, static_cast<int>(places.size()), /*row_height=*/0.0))
    reordered.push_back(own[static_cast<std::size_t>(index)]);
  return astray(places, reordered, reach).empty();
}

std::optional<datasets::Warning> warning_on(const Experiment& experiment,
                                            const std::string& name,
                                            const std::string& like,
                                            const std::vector<StartPlace>& places,
                                            const std::vector<StartPlace>& own) {
  constexpr std::size_t most_named = 10;
  const double reach = reach_of(places);
  const std::vector<std::size_t> numbers = astray(places, own, reach);
  if (numbers.empty()) return std::nullopt;
  const std::string named = fmt::format(
      "{}", fmt::join(std::span(numbers).first(std::min(numbers.size(), most_named)), ", "));
  if (lie_alike(places, own, reach)) {
    return datasets::first_line(
        fmt::format("{}: its particles lie where those of {} do, but bear other numbers ({}); give "
                    "the same place the same number in all tracks, or name the height y so that "
                    "the program numbers them.",
                    name,
                    like,
                    named),
        fmt::format("particles of {} bear other numbers than those of {}", name, like),
        "Give every place one number in all tracks");
  }
  double farthest = 0.0;
  for (const std::size_t number : numbers)
    farthest = std::max(farthest, distance(places[number - 1], own[number - 1]));
  const std::string what_to_do = experiment.starts.empty()
                                     ? "state every starting place as [[start]], or leave it out"
                                     : "leave it out, or give it an experiment file of its own";
  const std::string next = experiment.starts.empty()
                               ? fmt::format("State every [[start]], or leave {} out", name)
                               : fmt::format("Look at the start of {}, or leave it out", name);
  if (2 * numbers.size() > places.size()) {
    return datasets::first_line(
        fmt::format(
            "{}: starts from another arrangement than {}: {} of {} particles lie up to "
            "{:.3g} mm from the place of their number, more than half the smallest distance "
            "between two places ({:.3g} mm), so their numbers mean nothing; {}.",
            name,
            like,
            numbers.size(),
            places.size(),
            1e3 * farthest,
            1e3 * reach,
            what_to_do),
        fmt::format("{} starts from another arrangement than {}", name, like),
        next);
  }
  return datasets::first_line(
      fmt::format(
          "{}: particle{} {} start{} up to {:.3g} mm from where {} in {}, more than half the "
          "smallest distance between two places ({:.3g} mm), and may be other ones; {}.",
          name,
          numbers.size() == 1 ? "" : "s",
          named,
          numbers.size() == 1 ? "s" : "",
          1e3 * farthest,
          numbers.size() == 1 ? "it starts" : "they start",
          like,
          1e3 * reach,
          what_to_do),
      fmt::format("particles of {} start elsewhere than those of {}", name, like),
      next);
}

}  // namespace

bool are_numbered_alike(const Experiment& experiment) {
  return experiment.particle.count > 0 &&
         (experiment.rig.kind.empty() ||
          experiment.rig.begins_from == datasets::BeginsFrom::mean_of_replicates);
}

std::size_t numbered_like(const Experiment& experiment, std::size_t replicate) {
  const auto& settings = experiment.replicates[replicate].rig.settings;
  std::size_t first = 0;
  while (experiment.replicates[first].rig.settings != settings) ++first;
  return first;
}

std::optional<std::vector<StartPlace>> places_in(const Experiment& experiment,
                                                 const Recording& recording) {
  if (!recording.tracks || recording.tracks->particles != experiment.particle.count)
    return std::nullopt;
  std::vector<StartPlace> places;
  for (const datasets::Pose& pose : calibrate::start_places(*recording.tracks)) {
    if (!std::isfinite(pose.x) || !std::isfinite(pose.z)) return std::nullopt;
    places.push_back({pose.x, pose.z, std::isfinite(pose.angle) ? pose.angle : 0.0});
  }
  return places;
}

std::vector<datasets::Warning> compare_starts(const Experiment& experiment,
                                              std::span<const Recording> recordings) {
  std::vector<datasets::Warning> warnings;
  if (!are_numbered_alike(experiment)) return warnings;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const std::size_t like = numbered_like(experiment, i);
    if (like == i) continue;
    const auto places = places_in(experiment, recordings[like]);
    const auto own = places_in(experiment, recordings[i]);
    if (!places || !own) continue;
    auto warning = warning_on(
        experiment, experiment.replicates[i].name, experiment.replicates[like].name, *places, *own);
    if (warning) warnings.push_back(*std::move(warning));
  }
  return warnings;
}

}  // namespace graintruth::app
