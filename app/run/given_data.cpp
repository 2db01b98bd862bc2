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

// Places in millimetres of what lies centimetres apart are in pixels, or the other way round:
// refuses particles that at first are spread otherwise than the experiment file says. Where it
// states starting places, their distances from their middle (root mean square) may differ by half a
// particle. Else what was found must fit between the walls.
void require_likely_scale(const datasets::Experiment& experiment,
                          const datasets::Replicate& replicate,
                          const std::vector<Eigen::Vector2d>& places) {
  const double slack = experiment.particle.half_width;
  const auto spread = [](const std::vector<Eigen::Vector2d>& all) {
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (const auto& place : all) middle += place / static_cast<double>(all.size());
    double sum = 0.0;
    for (const auto& place : all) sum += (place - middle).squaredNorm();
    return std::sqrt(sum / static_cast<double>(all.size()));
  };
  const auto refuse = [&](double seen, double stated, std::string_view by) {
    throw datasets::InputError(fmt::format(
        "{}: the particles are spread over {:.4g} mm, {} {:.4g} mm: look at the unit of "
        "the columns of positions, and at scale_px_per_mm.",
        replicate.tracks.string(),
        1e3 * seen,
        by,
        1e3 * stated));
  };
  if (places.size() < 2) return;
  if (experiment.starts.size() == places.size()) {
    std::vector<Eigen::Vector2d> stated;
    for (const datasets::StartPlace& start : experiment.starts)
      stated.emplace_back(start.x, start.z);
    const double seen = spread(places), expected = spread(stated);
    if (std::abs(seen - expected) > slack)
      refuse(2.0 * seen, 2.0 * expected, "but by [[start]] over");
    return;
  }
  const std::vector<datasets::Wall>& walls = replicate.rig.walls;
  if (walls.size() < 2) return;
  double left = INFINITY, right = -INFINITY, first = INFINITY, last = -INFINITY;
  for (const datasets::Wall& wall : walls) {
    left = std::min({left, wall.from_x, wall.to_x});
    right = std::max({right, wall.from_x, wall.to_x});
  }
  for (const Eigen::Vector2d& place : places) {
    first = std::min(first, place.x());
    last = std::max(last, place.x());
  }
  if (last - first > right - left + slack)
    refuse(last - first, right - left, "but the walls only over");
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
                                         const datasets::Replicate& replicate,
                                         std::vector<std::string>& notes) {
  const datasets::ReadTracks read = datasets::read_track_file(replicate.tracks, replicate.source);
  notes.insert(notes.end(), read.notes.begin(), read.notes.end());
  const std::vector<Eigen::Vector2d> places = first_places(read.tracks);
  require_likely_scale(experiment, replicate, places);
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
                                          const datasets::Replicate& replicate,
                                          std::vector<std::string>& notes) {
  const datasets::Particle& particle = experiment.particle;
  return datasets::read_discharge_curve(replicate.discharge,
                                        {.event_time = replicate.source.event_time,
                                         .full_mass = particle.count * particle.mass,
                                         .particle_mass = particle.mass,
                                         .gravity = experiment.rig.gravity},
                                        &notes);
}

}  // namespace

datasets::Recording read_given_data(const datasets::Experiment& experiment,
                                    const datasets::Replicate& replicate) {
  datasets::Recording recording;
  std::vector<std::string>& notes = recording.notes;
  if (!replicate.tracks.empty()) recording.tracks = read_given_tracks(experiment, replicate, notes);
  if (!replicate.discharge.empty())
    recording.discharge = read_given_curve(experiment, replicate, notes);
  if (!replicate.curves.empty()) {
    recording.curves =
        datasets::read_curves(replicate.curves, replicate.source.event_time, &recording.notes);
  }
  return recording;
}

}  // namespace graintruth::app
