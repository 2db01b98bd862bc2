#include "calibrate/compare/start_poses.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "calibrate/compare/weighted_means.h"
#include "calibrate/observables/moments.h"

namespace graintruth::calibrate {

namespace {

constexpr double still_window = 0.2;  // s before the event in which nothing moves yet
constexpr datasets::Pose least_error{1.0e-5, 1.0e-5, 1.0e-4};

Channel channel_of(std::span<const datasets::Pose> poses) {
  Channel channel;
  for (const datasets::Pose& pose : poses) {
    for (const double value : {pose.x, pose.z, pose.angle}) channel.values.push_back(value);
  }
  return channel;
}

ChannelShape shape_of_poses(std::size_t particles) {
  return {.series = 3 * particles,
          .difference = {Difference::plain, Difference::plain, Difference::half_turn}};
}

// The mean pose of each particle while it rests.
Channel resting_poses(const datasets::Trajectories& track) {
  const auto particles = static_cast<std::size_t>(track.particles);
  std::vector<Channel> still;
  for (std::size_t frame = 0; frame < track.frames(); ++frame) {
    if (track.time[frame] > 0.0 || track.time[frame] < -still_window) continue;
    still.push_back(channel_of(std::span(track.poses).subspan(track.index(frame, 0), particles)));
  }
  if (still.empty()) return channel_of(datasets::sample(track, {0.0}).poses);
  Channel mean;
  for (const Spread& spread : spreads_of(pointers_to(still), shape_of_poses(particles)))
    mean.values.push_back(spread.mean);
  return mean;
}

}  // namespace

StartPoses measure_starts(std::span<const datasets::Trajectories* const> tracks) {
  std::vector<Channel> resting;
  for (const datasets::Trajectories* track : tracks) resting.push_back(resting_poses(*track));
  const auto particles = static_cast<std::size_t>(tracks.front()->particles);
  const std::vector<Spread> spreads = spreads_of(pointers_to(resting), shape_of_poses(particles));
  StartPoses starts;
  std::array<double, 3> variance = {};
  std::array<int, 3> count = {};
  for (std::size_t i = 0; i < spreads.size(); i += 3) {
    starts.mean.push_back({spreads[i].mean, spreads[i + 1].mean, spreads[i + 2].mean});
    for (std::size_t q = 0; q < 3; ++q) {
      const double sd = spreads[i + q].standard_deviation;
      if (!std::isfinite(sd)) continue;
      variance[q] += sd * sd;
      ++count[q];
    }
  }
  for (std::size_t q = 0; q < 3; ++q) {
    if (count[q] > 0) variance[q] /= count[q];
  }
  starts.standard_deviation = {
      std::sqrt(variance[0]), std::sqrt(variance[1]), std::sqrt(variance[2])};
  return starts;
}

std::vector<datasets::Pose> start_places(const datasets::Trajectories& track) {
  const datasets::Trajectories* one = &track;
  std::vector<datasets::Pose> places = measure_starts({&one, 1}).mean;
  for (std::size_t particle = 0; particle < places.size(); ++particle) {
    datasets::Pose& place = places[particle];
    for (std::size_t frame = 0; frame < track.frames() && !std::isfinite(place.x + place.z);
         ++frame)
      place = track.poses[track.index(frame, particle)];
  }
  return places;
}

datasets::Pose typical_error(const datasets::Trajectories& track) {
  datasets::Pose typical = least_error;
  for (double datasets::Pose::*member :
       {&datasets::Pose::x, &datasets::Pose::z, &datasets::Pose::angle}) {
    std::vector<double> values;
    for (const datasets::Pose& sigma : track.sigmas) {
      if (std::isfinite(sigma.*member)) values.push_back(sigma.*member);
    }
    if (values.empty()) continue;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    typical.*member = *middle;
  }
  return typical;
}

}  // namespace graintruth::calibrate
