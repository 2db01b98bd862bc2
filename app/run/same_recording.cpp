#include "app/run/same_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "calibrate/compare/start_poses.h"
#include "datasets/experiment/pictures.h"
#include "datasets/store/input_error.h"
#include "tracking/bodies/link.h"

namespace graintruth::app {

namespace {

using datasets::Trajectories;

// Of a grain's half width. Files round to their last digit; but no two recordings agree to so
// little in every particle and frame, because no tracker finds a grain so exactly and nobody can
// place it so.
constexpr double same_place = 1e-3;
// Of the largest value of a curve, where files round.
constexpr double same_value = 1e-6;
// Different values that two independent readings do not share by chance.
constexpr std::size_t telling_values = 20;

bool are_same_films(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code error;
  if (std::filesystem::equivalent(a, b, error)) return true;
  if (std::filesystem::is_regular_file(a, error) && std::filesystem::is_regular_file(b, error) &&
      std::filesystem::file_size(a, error) != std::filesystem::file_size(b, error))
    return false;
  return datasets::film_hash(a) == datasets::film_hash(b);
}

// Frames of both at the same time, as pairs; the shorter recording may be a part of the longer.
std::vector<std::pair<std::size_t, std::size_t>> common_frames(const Trajectories& a,
                                                               const Trajectories& b) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  if (a.frames() < 2 || b.frames() < 2) return pairs;
  const double interval = (a.time.back() - a.time.front()) / static_cast<double>(a.frames() - 1);
  for (std::size_t i = 0, j = 0; i < a.frames() && j < b.frames();) {
    const double later = a.time[i] - b.time[j];
    if (std::abs(later) < 0.01 * interval)
      pairs.emplace_back(i++, j++);
    else if (later > 0.0)
      ++j;
    else
      ++i;
  }
  return pairs;
}

bool are_same_tracks(const Trajectories& a, const Trajectories& b, double tolerance) {
  const auto frames = common_frames(a, b);
  if (a.particles != b.particles || 2 * frames.size() < std::min(a.frames(), b.frames()))
    return false;
  // 1. Who is who, whatever the numbers
  std::vector<datasets::StartPlace> places;
  std::vector<Eigen::Vector2d> centres;
  for (const datasets::Pose& pose : calibrate::start_places(a)) places.push_back({pose.x, pose.z});
  for (const datasets::Pose& pose : calibrate::start_places(b))
    centres.emplace_back(pose.x, pose.z);
  for (std::size_t n = 0; n < places.size(); ++n) {
    if (!std::isfinite(places[n].x + places[n].z + centres[n].sum())) return false;
  }
  const std::vector<int> other = tracking::number_by_start(centres, places, a.particles, 0.0);
  // 2. Whether all of them go the same way
  bool is_seen = false;
  for (const auto& [frame_a, frame_b] : frames) {
    for (std::size_t n = 0; n < places.size(); ++n) {
      const datasets::Pose& one = a.poses[a.index(frame_a, n)];
      const datasets::Pose& two = b.poses[b.index(frame_b, static_cast<std::size_t>(other[n]))];
      const bool seen = std::isfinite(one.x), too = std::isfinite(two.x);
      if (seen != too) return false;
      if (seen && !(std::hypot(one.x - two.x, one.z - two.z) <= tolerance)) return false;
      is_seen = is_seen || seen;
    }
  }
  return is_seen;
}

bool are_same_values(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) return false;
  double largest = 0.0;
  for (const double value : a) largest = std::max(largest, std::abs(value));
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!(std::abs(a[i] - b[i]) <= same_value * largest)) return false;
  }
  return std::set<double>(a.begin(), a.end()).size() >= telling_values;
}

bool are_same_curves(const datasets::Recording& a, const datasets::Recording& b) {
  for (const auto& [name, curve] : a.curves) {
    const auto other = b.curves.find(name);
    if (other != b.curves.end() && are_same_values(curve.value, other->second.value)) return true;
  }
  return false;
}

// Which file of both replicates is the same; null where none is.
const char* same_in(const datasets::Experiment& experiment,
                    std::span<const datasets::Recording> recordings,
                    std::size_t i,
                    std::size_t j) {
  const datasets::Replicate &one = experiment.replicates[i], &two = experiment.replicates[j];
  const datasets::Recording &shown = recordings[i], &too = recordings[j];
  if (!one.video.empty() && !two.video.empty())
    return are_same_films(one.video, two.video) ? "film" : nullptr;
  const bool are_given = one.video.empty() && two.video.empty();
  const double tolerance = same_place * experiment.particle.half_width;
  if (are_given && shown.tracks && too.tracks)
    return are_same_tracks(*shown.tracks, *too.tracks, tolerance) ? "tracks" : nullptr;
  if (are_given) {
    for (const datasets::Outline& outline : shown.outlines) {
      const datasets::Outline* other = too.outline_of(outline.surface);
      if (other && are_same_values(outline.height, other->height)) return "outline";
    }
  }
  if (shown.discharge && too.discharge &&
      are_same_values(shown.discharge->mass, too.discharge->mass))
    return "discharge curve";
  return are_same_curves(shown, too) ? "curve" : nullptr;
}

}  // namespace

void require_different(const datasets::Experiment& experiment,
                       std::span<const datasets::Recording> recordings) {
  for (std::size_t j = 0; j < experiment.replicates.size(); ++j) {
    for (std::size_t i = 0; i < j; ++i) {
      const char* same = same_in(experiment, recordings, i, j);
      if (same == nullptr) continue;
      throw datasets::InputError(
          fmt::format("{}: replicates {} and {} hold the same {}, in {} and {}; leave one of them "
                      "out, because a recording that is given twice is no repeat.",
                      experiment.file.string(),
                      experiment.replicates[i].name,
                      experiment.replicates[j].name,
                      same,
                      experiment.replicates[i].file().string(),
                      experiment.replicates[j].file().string()));
    }
  }
}

}  // namespace graintruth::app
