#include "app/run/given_data.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/run/numbering.h"
#include "calibrate/compare/start_poses.h"
#include "datasets/imports/curve_files.h"
#include "datasets/imports/discharge_curve.h"
#include "datasets/imports/track_files.h"
#include "datasets/store/input_error.h"
#include "tracking/bodies/link.h"

namespace graintruth::app {

namespace {

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
  constexpr double far = std::numeric_limits<double>::infinity();
  double left = far, right = -far, first = far, last = -far;
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

std::vector<Eigen::Vector2d> centres_of(const datasets::Trajectories& tracks) {
  std::vector<Eigen::Vector2d> centres;
  for (const datasets::Pose& pose : calibrate::start_places(tracks)) {
    if (std::isfinite(pose.x) && std::isfinite(pose.z)) centres.emplace_back(pose.x, pose.z);
  }
  return centres;
}

void read_given_tracks(const datasets::Experiment& experiment,
                       const datasets::Replicate& replicate,
                       GivenData& given) {
  datasets::ReadTracks read = datasets::read_track_file(replicate.tracks, replicate.source);
  std::vector<std::string>& notes = given.recording.notes;
  notes.insert(notes.end(), read.notes.begin(), read.notes.end());
  const std::vector<Eigen::Vector2d> centres = centres_of(read.tracks);
  require_likely_scale(experiment, replicate, centres);
  // Another number of particles than stated is said by whoever compares them.
  if (!read.numbered_by_place && static_cast<int>(centres.size()) == experiment.particle.count) {
    // Particles that differ by less than half their extent in height lie in one row
    read.tracks = reordered(
        read.tracks,
        tracking::number_by_start(
            centres, experiment.starts, experiment.particle.count, experiment.particle.half_width));
    given.is_numbered_by_us = experiment.starts.empty();
  }
  given.recording.tracks = std::move(read.tracks);
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

// With times from the start event. Surfaces are those of the rig.
std::vector<datasets::Outline> read_given_outlines(const datasets::Replicate& replicate) {
  std::vector<datasets::Outline> outlines = datasets::read_outlines(replicate.outline);
  const auto& surfaces = replicate.rig.seen_outline->surfaces;
  for (datasets::Outline& outline : outlines) {
    if (!datasets::surface_named(*replicate.rig.seen_outline, outline.surface)) {
      std::vector<std::string> names;
      for (const auto& surface : surfaces) names.push_back(fmt::format("'{}'", surface.name));
      throw datasets::InputError(
          surfaces.empty()
              ? fmt::format("{}: column 'surface' names '{}', but a rig of kind '{}' has one "
                            "surface; leave the column out.",
                            replicate.outline.string(),
                            outline.surface,
                            replicate.rig.kind)
          : outline.surface.empty()
              ? fmt::format("{}: a column 'surface' is missing; it says for every row which "
                            "surface it is of, {}.",
                            replicate.outline.string(),
                            fmt::join(names, " or "))
              : fmt::format("{}: column 'surface' names '{}', but a rig of kind '{}' has {}.",
                            replicate.outline.string(),
                            outline.surface,
                            replicate.rig.kind,
                            fmt::join(names, " and ")));
    }
    for (double& time : outline.time) time -= replicate.source.event_time;
    outline.eye = replicate.eye;
  }
  return outlines;
}

}  // namespace

GivenData read_given_data(const datasets::Experiment& experiment,
                          const datasets::Replicate& replicate) {
  GivenData given;
  if (!replicate.tracks.empty()) read_given_tracks(experiment, replicate, given);
  datasets::Recording& recording = given.recording;
  if (!replicate.outline.empty()) recording.outlines = read_given_outlines(replicate);
  if (!replicate.discharge.empty())
    recording.discharge = read_given_curve(experiment, replicate, recording.notes);
  if (!replicate.curves.empty()) {
    recording.curves =
        datasets::read_curves(replicate.curves, replicate.source.event_time, &recording.notes);
  }
  return given;
}

void number_alike(const datasets::Experiment& experiment, std::vector<GivenData>& given) {
  if (!are_numbered_alike(experiment)) return;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const std::size_t like = numbered_like(experiment, i);
    if (like == i || !given[i].is_numbered_by_us) continue;
    const auto places = places_in(experiment, given[like].recording);
    if (!places) continue;
    datasets::Trajectories& tracks = *given[i].recording.tracks;
    tracks = reordered(tracks,
                       tracking::number_by_start(
                           centres_of(tracks), *places, tracks.particles, /*row_height=*/0.0));
  }
}

}  // namespace graintruth::app
