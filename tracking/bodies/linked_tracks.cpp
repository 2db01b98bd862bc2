#include "tracking/bodies/linked_tracks.h"

#include <algorithm>
#include <cmath>

#include "tracking/bodies/assignment.h"
#include "tracking/bodies/link.h"
#include "tracking/median.h"

namespace graintruth::tracking {

namespace {

constexpr double gate = 5.0;  // standard deviations
constexpr double forbidden = 1.0e9;

// A round body has no angle, and expects none.
BodyPose known_pose(const datasets::Pose& pose) {
  return {pose.x, pose.z, std::isfinite(pose.angle) ? pose.angle : 0.0};
}

}  // namespace

datasets::Pose TrackLinker::Track::expected() const {
  const double frames = unseen + 1.0;
  return {last.x + frames * step[0], last.z + frames * step[1], last.angle + frames * step[2]};
}

std::vector<Sighting> TrackLinker::expected() const {
  std::vector<Sighting> result;
  for (const Track& track : tracks_)
    if (track.unseen <= options_.memory)
      result.push_back({.pose = track.expected(), .colour = track.colour, .length = track.length});
  return result;
}

std::vector<std::vector<int>> TrackLinker::tracks() const {
  std::vector<std::vector<int>> result;
  for (const Track& track : tracks_) result.push_back(track.sightings);
  return result;
}

void TrackLinker::accept(Track& track, const Sighting& sighting, int index) {
  BodyPose pose = known_pose(sighting.pose);
  const bool first = track.seen == 0;
  if (!first) {
    const datasets::Pose expected = track.expected();
    pose.angle = expected.angle + axis_difference(pose.angle, expected.angle);
    if (track.seen > 1 && track.unseen == 0)
      misses_.push_back(std::hypot(pose.x - expected.x, pose.z - expected.z));
    const double frames = track.unseen + 1.0;
    track.step << (pose.x - track.last.x) / frames, (pose.z - track.last.z) / frames,
        (pose.angle - track.last.angle) / frames;
  }
  track.last = {pose.x, pose.z, pose.angle};
  // Light and apparent length change along the way
  constexpr double kept = 0.8;
  track.colour = first ? sighting.colour
                       : Eigen::Vector3f(static_cast<float>(kept) * track.colour +
                                         static_cast<float>(1.0 - kept) * sighting.colour);
  track.length = first ? sighting.length : kept * track.length + (1.0 - kept) * sighting.length;
  track.unseen = 0;
  ++track.seen;
  track.sightings.back() = index;
}

// Per axis, m; grows while it is not seen.
double TrackLinker::spread_of(const Track& track) const {
  const double widest = options_.reach / gate;
  const double next = track.seen > 1 ? learned_.value_or(widest) : widest;
  return std::min(widest, next) * (track.unseen + 1.0);
}

Eigen::MatrixXd TrackLinker::costs(const std::vector<std::size_t>& waiting,
                                   const std::vector<Sighting>& sightings) const {
  Eigen::MatrixXd cost(static_cast<Eigen::Index>(waiting.size()),
                       static_cast<Eigen::Index>(sightings.size()));
  for (std::size_t i = 0; i < waiting.size(); ++i) {
    const Track& track = tracks_[waiting[i]];
    const double sigma = spread_of(track);
    const double reach = options_.reach * (track.unseen + 1.0);
    const BodyPose at = known_pose(track.expected());
    const Expectation expected{at, sigma, sigma / options_.lever, track.colour};
    for (std::size_t j = 0; j < sightings.size(); ++j) {
      const BodyPose pose = known_pose(sightings[j].pose);
      const Mismatch off = mismatch(expected, {pose, sightings[j].colour});
      const double jump = std::hypot(pose.x - at.x, pose.z - at.z);
      const double turn = std::abs(axis_difference(pose.angle, at.angle));
      // A part of a rod is as far off as its middle is from that of the whole
      const double shorter = 0.5 * (sightings[j].length - track.length) / sigma;
      const bool fits =
          jump <= reach && turn * options_.lever <= reach && off.colour <= gate * gate;
      cost(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          fits ? off.sum() + shorter * shorter : forbidden;
    }
  }
  return cost;
}

void TrackLinker::add(const std::vector<Sighting>& sightings) {
  std::vector<std::size_t> waiting;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    tracks_[i].sightings.push_back(-1);
    if (tracks_[i].unseen <= options_.memory) waiting.push_back(i);
  }
  std::vector<int> of_track(waiting.size(), -1);
  if (!waiting.empty() && !sightings.empty()) {
    const Eigen::MatrixXd cost = costs(waiting, sightings);
    of_track = assign(cost, forbidden);
    note_doubts(cost, of_track);
  }
  std::vector<char> taken(sightings.size(), 0);
  for (std::size_t i = 0; i < waiting.size(); ++i) {
    Track& track = tracks_[waiting[i]];
    if (of_track[i] < 0) {
      ++track.unseen;
      continue;
    }
    taken[static_cast<std::size_t>(of_track[i])] = 1;
    accept(track, sightings[static_cast<std::size_t>(of_track[i])], of_track[i]);
  }
  ++frames_;
  for (std::size_t j = 0; j < sightings.size(); ++j) {
    if (taken[j]) continue;
    tracks_.emplace_back().sightings.assign(frames_, -1);
    accept(tracks_.back(), sightings[j], static_cast<int>(j));
  }
  learn_spread();
}

void TrackLinker::note_doubts(const Eigen::MatrixXd& cost, const std::vector<int>& of_track) {
  constexpr double plain = 9.0;  // three standard deviations, squared
  for (Eigen::Index a = 0; a < cost.rows(); ++a) {
    const int own = of_track[static_cast<std::size_t>(a)];
    if (own < 0) continue;
    for (Eigen::Index b = a + 1; b < cost.rows(); ++b) {
      const int other = of_track[static_cast<std::size_t>(b)];
      if (other < 0) continue;
      const double exchanged = cost(a, other) + cost(b, own);
      doubts_ += exchanged < forbidden && exchanged < cost(a, own) + cost(b, other) + plain;
    }
  }
}

// Of distances in a plane one in twenty exceeds about two and a half standard deviations of an
// axis; twice is on the safe side, because collisions make more of them.
void TrackLinker::learn_spread() {
  constexpr std::size_t fewest = 20;
  if (misses_.size() < fewest) return;
  std::vector<double> sorted = misses_;
  const auto at =
      sorted.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(sorted.size()));
  std::nth_element(sorted.begin(), at, sorted.end());
  constexpr double least = 0.01;  // of the reach: nothing is predicted without error
  learned_ = std::max(least * options_.reach, 0.5 * *at);
}

// With p the positions of four frames in a row and s their sigmas,
//   r = |p3 - 3 p2 + 3 p1 - p0| / sqrt(s3^2 + 9 s2^2 + 9 s1^2 + s0^2),
// whose median is 0.6745 where errors are as the sigmas say.
ScatterRatio scatter_ratio(const datasets::Trajectories& tracks) {
  std::vector<double> positions, angles;
  const auto add = [](std::vector<double>& list, const auto& value, const auto& sigma) {
    const double difference = value(3) - 3.0 * value(2) + 3.0 * value(1) - value(0);
    const double variance = sigma(3) * sigma(3) +
                            9.0 * (sigma(2) * sigma(2) + sigma(1) * sigma(1)) + sigma(0) * sigma(0);
    if (std::isfinite(difference) && variance > 0.0)
      list.push_back(std::abs(difference) / std::sqrt(variance));
  };
  for (std::size_t k = 3; k < tracks.frames(); ++k) {
    for (std::size_t p = 0; p < static_cast<std::size_t>(tracks.particles); ++p) {
      const auto pose = [&](std::size_t i) -> const datasets::Pose& {
        return tracks.poses[tracks.index(k - 3 + i, p)];
      };
      const auto sigma = [&](std::size_t i) -> const datasets::Pose& {
        return tracks.sigmas[tracks.index(k - 3 + i, p)];
      };
      add(
          positions,
          [&](std::size_t i) { return pose(i).x; },
          [&](std::size_t i) { return sigma(i).x; });
      add(
          positions,
          [&](std::size_t i) { return pose(i).z; },
          [&](std::size_t i) { return sigma(i).z; });
      add(
          angles,
          [&](std::size_t i) { return pose(i).angle; },
          [&](std::size_t i) { return sigma(i).angle; });
    }
  }
  constexpr std::size_t fewest = 30;
  const auto ratio = [](std::vector<double> list) -> std::optional<double> {
    if (list.size() < fewest) return std::nullopt;
    return std::max(1.0, median(std::move(list)) / 0.6745);
  };
  return {ratio(std::move(positions)), ratio(std::move(angles))};
}

}  // namespace graintruth::tracking
