#include "app/run/given_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "datasets/imports/curve_files.h"
#include "datasets/imports/discharge_curve.h"
#include "datasets/imports/track_files.h"
#include "datasets/store/input_error.h"
#include "tracking/bodies/link.h"

namespace graintruth::app {

namespace {

// Where each particle was first seen, (x, z) in m.
std::vector<Eigen::Vector2d> first_places(const datasets::Trajectories& tracks) {
  std::vector<Eigen::Vector2d> places;
  for (std::size_t particle = 0; particle < static_cast<std::size_t>(tracks.particles);
       ++particle) {
    for (std::size_t frame = 0; frame < tracks.frames(); ++frame) {
      const datasets::Pose& pose = tracks.poses[tracks.index(frame, particle)];
      if (!std::isfinite(pose.x) || !std::isfinite(pose.z)) continue;
      places.emplace_back(pose.x, pose.z);
      break;
    }
  }
  return places;
}

datasets::Trajectories reordered(const datasets::Trajectories& tracks,
                                 const std::vector<int>& order) {
  datasets::Trajectories made =
      datasets::make_trajectories(tracks.frames(), tracks.particles, !tracks.sigmas.empty());
  made.time = tracks.time;
  for (std::size_t frame = 0; frame < tracks.frames(); ++frame) {
    for (std::size_t place = 0; place < order.size(); ++place) {
      const std::size_t from = tracks.index(frame, static_cast<std::size_t>(order[place]));
      const std::size_t to = made.index(frame, place);
      made.poses[to] = tracks.poses[from];
      if (tracks.sigmas.empty()) continue;
      made.sigmas[to] = tracks.sigmas[from];
      made.scores[to] = tracks.scores[from];
    }
  }
  return made;
}

datasets::Trajectories read_given_tracks(const datasets::Experiment& experiment,
                                         const datasets::Replicate& replicate) {
  const datasets::ReadTracks read = datasets::read_track_file(replicate.tracks, replicate.source);
  const std::vector<Eigen::Vector2d> places = first_places(read.tracks);
  // Another number of particles than stated is said by whoever compares them.
  if (read.numbered_by_place || static_cast<int>(places.size()) != experiment.particle.count)
    return read.tracks;
  // Particles that differ by less than half their extent in height lie in one row
  return reordered(
      read.tracks,
      tracking::number_by_start(
          places, experiment.starts, experiment.particle.count, experiment.particle.half_width));
}

datasets::DischargeCurve read_given_curve(const datasets::Experiment& experiment,
                                          const datasets::Replicate& replicate) {
  const datasets::Particle& particle = experiment.particle;
  return datasets::read_discharge_curve(replicate.discharge,
                                        {.event_time = replicate.source.event_time,
                                         .full_mass = particle.count * particle.mass,
                                         .particle_mass = particle.mass});
}

}  // namespace

datasets::Recording read_given_data(const datasets::Experiment& experiment,
                                    const datasets::Replicate& replicate) {
  datasets::Recording recording;
  if (!replicate.tracks.empty()) recording.tracks = read_given_tracks(experiment, replicate);
  if (!replicate.discharge.empty()) recording.discharge = read_given_curve(experiment, replicate);
  if (!replicate.curves.empty()) {
    recording.curves = datasets::read_curves(replicate.curves, replicate.source.event_time);
  }
  return recording;
}

}  // namespace graintruth::app
