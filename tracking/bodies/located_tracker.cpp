#include "tracking/bodies/located_tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "datasets/store/input_error.h"
#include "tracking/bodies/link.h"
#include "tracking/event/start_of_motion.h"
#include "tracking/film/clock.h"
#include "tracking/median.h"

namespace graintruth::tracking {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double degree = std::numbers::pi / 180.0;

// Dirt and noise are rarely seen three times where they are expected.
constexpr std::size_t fewest_sightings = 3;

}  // namespace

void LocatedTracker::find_first(const Picture& picture,
                                const FilmCamera& camera,
                                TrackingSummary& summary) {
  camera_ = camera;
  const cv::Rect& region = camera_.region;
  const Eigen::Vector2d middle =
      lens().unproject({region.x + 0.5 * (region.width - 1), region.y + 0.5 * (region.height - 1)});
  scale_ = lens().scale(middle.x(), middle.y());
  summary.scale_px_per_mm = 1.0e-3 * scale_;
  prepare_locator(picture.frame);
  linker_.emplace(link_options());
  follow(picture);
  if (frames_.front().empty()) {
    throw datasets::InputError(
        fmt::format("{}: no {} was found in the first frame; check the film, the particle's size "
                    "and the scale",
                    film_.video.string(),
                    spec_.body.kind));
  }
}

void LocatedTracker::follow(const Picture& picture) {
  frames_.push_back(locate(picture.frame, linker_->expected()));
  linker_->add(frames_.back());
}

datasets::Trajectories LocatedTracker::finish(TrackingSummary& summary) {
  summary.shows_angle = shows_angle();
  summary.suspected_swaps = linker_->doubts();
  datasets::Trajectories out = trajectories_of(summary);
  count_seen(out, summary);
  // Time zero
  const Event start = start_of_a_film(
      find_first_motion(out, lens(), spec_.camera.frame_rate, summary.clock.moments),
      spec_.camera,
      summary);
  summary.event_time_s = start.time;
  summary.event_uncertainty_s = start.uncertainty;
  summary.event_source = start.how;
  for (double& time : out.time) time -= start.time;
  for (std::string& sentence : tracking::describe(
           find_clock_faults(out, 1.0 / scale_, summary.clock), summary.repeated_frames))
    summary.warn(std::move(sentence));
  return out;
}

datasets::Trajectories LocatedTracker::trajectories_of(TrackingSummary& summary) {
  // 1. Tracks that are long enough to be believed
  const std::size_t least = std::min(fewest_sightings, frames_.size());
  const std::vector<std::vector<int>> tracks = linker_->tracks();
  std::vector<const std::vector<int>*> kept;
  for (const std::vector<int>& track : tracks) {
    const auto seen = static_cast<std::size_t>(
        std::count_if(track.begin(), track.end(), [](int index) { return index >= 0; }));
    if (seen >= least)
      kept.push_back(&track);
    else
      ++brief_tracks_;
  }
  // 2. Numbers: by place of those that are seen at first, then as they come
  std::vector<const std::vector<int>*> first, later;
  std::vector<Eigen::Vector2d> centres;
  for (const std::vector<int>* track : kept) {
    if (track->front() < 0) {
      later.push_back(track);
      continue;
    }
    first.push_back(track);
    const datasets::Pose& pose = frames_[0][static_cast<std::size_t>(track->front())].pose;
    centres.emplace_back(pose.x, pose.z);
  }
  std::vector<const std::vector<int>*> numbered;
  const int places =
      std::max(static_cast<int>(first.size()), static_cast<int>(spec_.starts.size()));
  for (const int index : number_by_start(centres, spec_.starts, places, row_height()))
    numbered.push_back(index < 0 ? nullptr : first[static_cast<std::size_t>(index)]);
  numbered.insert(numbered.end(), later.begin(), later.end());
  // 3. Poses; angles continuous along each track
  datasets::Trajectories out =
      datasets::make_trajectories(frames_.size(), static_cast<int>(numbered.size()), true);
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    out.time[k] = summary.clock.moments[k] / spec_.camera.frame_rate;
    for (std::size_t p = 0; p < numbered.size(); ++p) {
      if (numbered[p] == nullptr || (*numbered[p])[k] < 0) continue;
      const Sighting& sighting = frames_[k][static_cast<std::size_t>((*numbered[p])[k])];
      const std::size_t i = out.index(k, p);
      out.poses[i] = sighting.pose;
      out.sigmas[i] = sighting.sigma;
      out.scores[i] = sighting.score;
    }
  }
  datasets::unwrap_angles(out);
  // 4. Uncertainty: the locator's own, as much larger as the film shows, and the camera's
  const ScatterRatio ratio = scatter_ratio(out);
  scatter_ = ratio.position.value_or(1.0);
  const double floor = ratio.position ? 0.0 : usual_error_px() / scale_;
  std::vector<double> position_sigmas, angle_sigmas;
  for (std::size_t i = 0; i < out.poses.size(); ++i) {
    datasets::Pose& sigma = out.sigmas[i];
    if (!std::isfinite(out.poses[i].x)) continue;
    const Eigen::Matrix2d camera =
        camera_.calibration.point_covariance(out.poses[i].x, out.poses[i].z);
    const Eigen::Vector2d lasting = lasting_error(out.poses[i]);
    const auto total = [&](double own, int axis) {
      return std::sqrt(std::pow(std::max(floor, scatter_ * own), 2) + camera(axis, axis) +
                       lasting[axis] * lasting[axis]);
    };
    sigma.x = total(sigma.x, 0);
    sigma.z = total(sigma.z, 1);
    sigma.angle *= ratio.angle.value_or(1.0);
    position_sigmas.push_back(std::sqrt(0.5 * (sigma.x * sigma.x + sigma.z * sigma.z)));
    angle_sigmas.push_back(sigma.angle);
    summary.mean_score += out.scores[i];
  }
  summary.position_sigma_mm = 1.0e3 * median(position_sigmas, nan);
  summary.pixel_error_px = summary.position_sigma_mm * summary.scale_px_per_mm;
  summary.angle_sigma_deg = median(angle_sigmas, nan) / degree;
  summary.mean_score /= std::max<double>(1.0, static_cast<double>(position_sigmas.size()));
  return out;
}

// Of a stated number that many are expected in every frame; else each from its first frame to its
// last.
void LocatedTracker::count_seen(const datasets::Trajectories& tracks,
                                TrackingSummary& summary) const {
  summary.particles = tracks.particles;
  long expected = 0;
  double least = 1.0;
  int at_first = 0;
  for (std::size_t p = 0; p < static_cast<std::size_t>(tracks.particles); ++p) {
    int seen = 0, begin = -1, end = -1, turns = 0;
    double last_angle = nan;
    for (std::size_t k = 0; k < tracks.frames(); ++k) {
      const datasets::Pose& pose = tracks.poses[tracks.index(k, p)];
      if (!std::isfinite(pose.x)) continue;
      const auto frame = static_cast<int>(k);
      if (begin < 0) begin = frame;
      if (end >= 0 && end + 1 < frame) ++summary.gaps;
      if (end + 1 == frame && std::abs(pose.angle - last_angle) > 60.0 * degree) ++turns;
      end = frame;
      last_angle = pose.angle;
      ++seen;
    }
    if (seen == 0) continue;
    at_first += begin == 0;
    summary.angle_jumps += turns;
    summary.detections += seen;
    expected += end - begin + 1;
    least = std::min(least, seen / (end - begin + 1.0));
  }
  summary.least_complete_particle = least;
  if (const auto& count = spec_.body.count) {
    expected = static_cast<long>(*count) * static_cast<long>(tracks.frames());
    if (at_first != *count) {
      summary.warn(
          fmt::format("Frame 0 shows {} particles but the experiment says {}.", at_first, *count));
    }
  }
  // What is seen beyond the stated number is told above, and makes no film more than complete
  summary.completeness =
      std::min(1.0, summary.detections / std::max(1.0, static_cast<double>(expected)));
  summary.findings.push_back(
      fmt::format("{} particles in the first frame, {} tracks", at_first, tracks.particles));
  constexpr double least_complete = 0.9;
  if (summary.completeness < least_complete)
    summary.warn(
        fmt::format("Only {:.1f} % of all poses were found.", 100.0 * summary.completeness));
}

void LocatedTracker::describe(nlohmann::ordered_json& film) const {
  film["brief_tracks_left_out"] = brief_tracks_;
  film["scatter_over_locator_error"] = scatter_;
}

}  // namespace graintruth::tracking
