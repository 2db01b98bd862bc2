#include "calibrate/problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibrate/prior.h"
#include "datasets/input_error.h"
#include "datasets/run_folder.h"
#include "datasets/store/fingerprint.h"
#include "datasets/table.h"

namespace graintruth::calibrate {

namespace {

constexpr double still_window = 0.2;  // s before the event in which nothing moves yet

// Changes whenever the simulator or a measuring function gives other numbers for the same input, so
// that a journal of an older program is never mixed with new runs.
constexpr const char* numbers_version = "3";

// The mean pose of each particle while it rests, as a one-frame trajectory.
datasets::Trajectories resting_poses(const datasets::Trajectories& track) {
  std::vector<datasets::Trajectories> still_frames;
  for (std::size_t frame = 0; frame < track.frames(); ++frame) {
    if (track.time[frame] > 0.0 || track.time[frame] < -still_window) continue;
    datasets::Trajectories one = datasets::make_trajectories(1, track.particles, false);
    for (std::size_t particle = 0; particle < one.poses.size(); ++particle) {
      one.poses[particle] = track.poses[track.index(frame, particle)];
    }
    still_frames.push_back(std::move(one));
  }
  if (still_frames.empty()) return datasets::sample(track, {0.0});
  return mean_track(measure(still_frames));
}

void append(std::string& text, double value) { text += datasets::number_text(value) + ";"; }

std::string text_of(const datasets::Particle& particle) {
  std::string text;
  for (const datasets::AxialSphere& sphere : particle.spheres) {
    append(text, sphere.offset);
    append(text, sphere.radius);
  }
  append(text, particle.mass);
  return text;
}

std::string text_of(const datasets::Rig& rig) {
  std::string text;
  for (const datasets::Wall& wall : rig.walls) {
    for (const double value : {wall.from_x, wall.from_z, wall.to_x, wall.to_z}) append(text, value);
  }
  if (const auto& piston = rig.piston) {
    for (const double value : {piston->face_z, piston->left_x, piston->right_x, piston->velocity_z})
      append(text, value);
  }
  append(text, rig.gravity);
  return text;
}

std::string text_of(const StartPoses& starts) {
  std::string text;
  for (const datasets::Pose& pose : starts.mean) {
    for (const Quantity quantity : quantities) append(text, value_of(pose, quantity));
  }
  for (const Quantity quantity : quantities)
    append(text, value_of(starts.standard_deviation, quantity));
  return text;
}

std::string text_of(const TrackComparison& comparison) {
  std::string text;
  for (const datasets::Trajectories& replicate : comparison.replicates()) {
    for (const double time : replicate.time) append(text, time);
    for (const datasets::Pose& pose : replicate.poses) {
      for (const Quantity quantity : quantities) append(text, value_of(pose, quantity));
    }
  }
  for (const auto& widths : comparison.target().widths.half_width) {
    for (const double width : widths) append(text, width);
  }
  return text;
}

void add_hashes(Problem& problem) {
  std::string elasticity;
  append(elasticity, problem.experiment.material.elastic_modulus);
  append(elasticity, problem.experiment.material.poisson_ratio);
  std::string all;
  for (const auto& [name, text] :
       {std::pair("the program's numbers", std::string(numbers_version)),
        std::pair("particle", text_of(problem.experiment.particle)),
        std::pair("material", elasticity),
        std::pair("rig", text_of(problem.experiment.rig)),
        std::pair("starting poses", text_of(problem.starts)),
        std::pair("tracks or times of measurement", text_of(*problem.comparison))}) {
    problem.parts.emplace_back(name, datasets::content_hash(text));
    all += text;
  }
  if (const std::string priors = text_of_priors(problem.experiment); !priors.empty()) {
    problem.parts.emplace_back("priors", datasets::content_hash(priors));
    all += priors;
  }
  problem.hash = datasets::content_hash(all);
}

void check_fit(const datasets::Experiment& experiment,
               std::span<const datasets::Trajectories> tracks) {
  const double last = experiment.measurement.frame_interval * (experiment.measurement.frames - 1);
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const datasets::Replicate& replicate = experiment.replicates[i];
    const std::string& name = replicate.file().string();
    if (tracks[i].particles != experiment.particle.count) {
      throw datasets::InputError(
          fmt::format("{}: {} particles are tracked, but the experiment has {}.",
                      name,
                      tracks[i].particles,
                      experiment.particle.count));
    }
    const std::vector<double>& time = tracks[i].time;
    const double step =
        time.size() < 2 ? 0.0 : (time.back() - time.front()) / static_cast<double>(time.size() - 1);
    if (time.empty() || time.front() > 0.5 * step || time.back() < last - 0.5 * step) {
      throw datasets::InputError(
          fmt::format("{}: the recording spans {:.3f} to {:.3f} s from the start event, but the "
                      "comparison needs 0 to "
                      "{:.3f} s; lower measure.frames or film for longer.",
                      name,
                      time.empty() ? 0.0 : time.front(),
                      time.empty() ? 0.0 : time.back(),
                      last));
    }
  }
}

// Where tracks tell no angles: those of the stated starting places, or none for a body that is
// round in the picture.
void complete_angles(const datasets::Experiment& experiment, StartPoses& starts) {
  const bool known = std::any_of(starts.mean.begin(), starts.mean.end(), [](const auto& pose) {
    return std::isfinite(pose.angle);
  });
  if (known) return;
  const auto& spheres = experiment.particle.spheres;
  const bool round = std::all_of(
      spheres.begin(), spheres.end(), [](const auto& sphere) { return sphere.offset == 0.0; });
  if (!round && experiment.starts.empty()) {
    throw datasets::InputError(
        fmt::format("{}: the tracks tell no angles, and the particles are not round; add a column "
                    "angle_rad, or state every particle's starting place and angle as [[start]].",
                    experiment.file.string()));
  }
  for (std::size_t i = 0; i < starts.mean.size(); ++i)
    starts.mean[i].angle = round ? 0.0 : experiment.starts[i].angle;
}

}  // namespace

StartPoses measure_starts(std::span<const datasets::Trajectories> tracks) {
  std::vector<datasets::Trajectories> resting;
  for (const datasets::Trajectories& track : tracks) resting.push_back(resting_poses(track));
  const Band band = measure(resting);
  StartPoses starts;
  std::array<double, 3> variance = {};
  std::array<int, 3> count = {};
  for (const auto& spreads : band.spreads) {
    starts.mean.push_back({spreads[0].mean, spreads[1].mean, spreads[2].mean});
    for (std::size_t q = 0; q < quantities.size(); ++q) {
      const double sd = spreads[q].standard_deviation;
      if (!std::isfinite(sd)) continue;
      variance[q] += sd * sd;
      ++count[q];
    }
  }
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    if (count[q] > 0) variance[q] /= count[q];
  }
  starts.standard_deviation = {
      std::sqrt(variance[0]), std::sqrt(variance[1]), std::sqrt(variance[2])};
  return starts;
}

void require_comparable(const datasets::Experiment& experiment) {
  if (experiment.rig.bin) {
    throw datasets::InputError(fmt::format(
        "{}: particles that run out of a bin are compared by what flows, not by their tracks.",
        experiment.file.string()));
  }
  if (experiment.particle.spheres.empty()) {
    throw datasets::InputError(
        fmt::format("{}: particle.spheres is missing; a plate can be tracked, but is simulated as "
                    "the spheres that make it up.",
                    experiment.file.string()));
  }
}

Problem make_problem(const datasets::Experiment& experiment,
                     std::span<const datasets::Trajectories> tracks) {
  require_comparable(experiment);
  check_fit(experiment, tracks);
  Problem problem{.experiment = experiment};
  const std::vector<double> times =
      measurement_times(experiment.measurement.frame_interval, experiment.measurement.frames);
  std::vector<datasets::Trajectories> replicates;
  for (const datasets::Trajectories& track : tracks)
    replicates.push_back(
        compared_part(datasets::sample(track, times), experiment.measurement.compared));
  problem.comparison =
      std::make_shared<TrackComparison>(std::move(replicates), experiment.objective);
  problem.starts = measure_starts(tracks);
  complete_angles(experiment, problem.starts);
  for (std::size_t particle = 0; particle < problem.starts.mean.size(); ++particle) {
    const datasets::Pose& pose = problem.starts.mean[particle];
    if (std::isfinite(pose.x) && std::isfinite(pose.z) && std::isfinite(pose.angle)) continue;
    throw datasets::InputError(
        fmt::format("{}: particle {} is not seen in any replicate before the start event.",
                    experiment.file.string(),
                    particle + 1));
  }
  add_hashes(problem);
  return problem;
}

}  // namespace graintruth::calibrate
