#include "calibrate/problem_scenes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "calibrate/compare/start_poses.h"
#include "calibrate/observables/moments.h"
#include "datasets/parameters/parameter.h"
#include "datasets/rigs/rig.h"
#include "datasets/store/input_error.h"

namespace graintruth::calibrate {

namespace {

using datasets::BeginsFrom;
using datasets::Experiment;
using datasets::InputError;
using datasets::Recording;

constexpr double falling_time = 0.5;  // s that a prepared bed needs to rest after its last fall
constexpr double curve_frame_interval = 0.01;  // s; as finely as a film shows when grains leave

void check_number(const datasets::Replicate& replicate, int tracked, int stated) {
  if (tracked == stated) return;
  throw InputError(fmt::format("{}: {} particles are tracked, but the experiment has {}.",
                               replicate.file().string(),
                               tracked,
                               stated));
}

// Grains and surfaces, where the rig does not bring its own; what these are is set by parameters.
void add_grains(const Experiment& experiment, double modulus, datasets::SceneData& scene) {
  scene.materials = {{.name = "particle",
                      .elastic_modulus = modulus,
                      .poisson_ratio = experiment.material.poisson_ratio},
                     {.name = "wall", .is_rigid = true}};
  scene.surfaces = {{.first = datasets::grain_material, .second = datasets::grain_material},
                    {.first = datasets::grain_material, .second = datasets::wall_material}};
  scene.particles = {experiment.particle.model};
  scene.particles.front().material = datasets::grain_material;
}

//   overlap = (5 m* v^2 / (4 k))^(2/5), k = 4/3 E* sqrt(R*)   (Hertz; sim/laws/time_step.h)
// solved for E* of two equal particles, m* = m/2, R* = R/2, E* = E / (2 (1 - nu^2)).
double softened_modulus(const Experiment& experiment, double impact_speed) {
  const datasets::Material& material = experiment.material;
  const datasets::Particle& particle = experiment.particle;
  const bool is_tuned = std::any_of(
      experiment.tuned.begin(), experiment.tuned.end(), [](const datasets::TunedParameter& tuned) {
        return datasets::parameter_named(tuned.name).kind->sets_stiffness;
      });
  if (is_tuned || !(experiment.rig.softened_overlap > 0.0)) return material.elastic_modulus;
  const double overlap = experiment.rig.softened_overlap * particle.diameter;
  const double stiffness =
      1.25 * 0.5 * particle.mass * impact_speed * impact_speed / std::pow(overlap, 2.5);
  const double reduced_modulus = 0.75 * stiffness / std::sqrt(0.25 * particle.diameter);
  const double poisson = material.poisson_ratio;
  return std::min(material.elastic_modulus, 2.0 * (1.0 - poisson * poisson) * reduced_modulus);
}

// Where tracks tell no angles: those of the stated starting places, or none for a grain that is
// round in the picture.
void complete_angles(const Experiment& experiment, StartPoses& starts) {
  const bool known = std::any_of(starts.mean.begin(), starts.mean.end(), [](const auto& pose) {
    return std::isfinite(pose.angle);
  });
  if (known) return;
  const bool round = !experiment.particle.shows_angle;
  if (!round && experiment.starts.empty()) {
    throw InputError(
        fmt::format("{}: the tracks tell no angles, and the particles are not round; add a column "
                    "angle_rad, or state every particle's starting place and angle as [[start]].",
                    experiment.file.string()));
  }
  for (std::size_t i = 0; i < starts.mean.size(); ++i)
    starts.mean[i].angle = round ? 0.0 : experiment.starts[i].angle;
}

// The same start for all replicates of a condition: their mean, and the spread of placing.
void begin_from_mean(const Problem& problem,
                     const Condition& condition,
                     std::span<const Recording> recordings,
                     SimulationSpec& spec) {
  const Experiment& experiment = problem.experiment;
  std::vector<const datasets::Trajectories*> tracks;
  for (const std::size_t r : condition.replicates) {
    if (!recordings[r].tracks) {
      throw InputError(
          fmt::format("{}: gives no tracks, and simulations of this rig begin from them.",
                      experiment.replicates[r].file().string()));
    }
    check_number(
        experiment.replicates[r], recordings[r].tracks->particles, experiment.particle.count);
    tracks.push_back(&*recordings[r].tracks);
  }
  StartPoses starts = measure_starts(tracks);
  complete_angles(experiment, starts);
  for (std::size_t particle = 0; particle < starts.mean.size(); ++particle) {
    const datasets::Pose& pose = starts.mean[particle];
    if (std::isfinite(pose.x) && std::isfinite(pose.z) && std::isfinite(pose.angle)) continue;
    throw InputError(
        fmt::format("{}: particle {} is not seen in any replicate before the start "
                    "event.",
                    experiment.file.string(),
                    particle + 1));
  }
  spec.start = {starts.mean, starts.standard_deviation};
  datasets::ScenePhase& run = spec.scene.phases.back();
  run.output_interval = experiment.measurement.frame_interval;
  run.duration = measurement_times(run.output_interval, experiment.measurement.frames).back();
}

// A bed of its own: the filmed one, each pose with the tracker's error; empty where the film does
// not tell it.
std::vector<datasets::Pose> bed_of(const Experiment& experiment,
                                   const datasets::Replicate& replicate,
                                   const datasets::Trajectories& track) {
  const datasets::Trajectories* one = &track;
  std::vector<datasets::Pose> bed = measure_starts({&one, 1}).mean;
  int unseen = 0, turned = 0;
  for (const datasets::Pose& pose : bed) {
    unseen += std::isfinite(pose.x) && std::isfinite(pose.z) ? 0 : 1;
    turned += std::isfinite(pose.angle) ? 1 : 0;
  }
  if (turned > 0) unseen = std::max(unseen, static_cast<int>(bed.size()) - turned);
  if (static_cast<int>(bed.size()) != experiment.particle.count || unseen > 0) {
    throw InputError(fmt::format(
        "{}: {} particles are seen at rest before the orifice opens, but particle.count is {}; "
        "correct particle.count, or the tracks with a file of corrections.",
        replicate.name,
        static_cast<int>(bed.size()) - unseen,
        experiment.particle.count));
  }
  if (turned > 0) return bed;
  // Discs lie the same whichever way they are turned
  if (experiment.particle.shows_angle) return {};
  for (datasets::Pose& pose : bed) pose.angle = 0.0;
  return bed;
}

// Rows of grains that fall and settle without friction, as in thesis 4.3.4, before all else.
void prepare_bed(const Experiment& experiment, int number, datasets::SceneData& scene) {
  datasets::SceneFill& fill = scene.fill;
  fill.length = experiment.particle.length;
  fill.number = number;
  const int columns =
      std::max(1, static_cast<int>((fill.high.x() - fill.low.x()) / (1.02 * fill.length)));
  const int last_row = (experiment.particle.count - 1) / columns;
  const double top =  // of what falls
      (last_row + 0.5) * 1.02 * fill.length + experiment.particle.diameter;
  for (datasets::SceneWall& wall : scene.walls) {
    // Side walls reach up to it
    if (wall.points[0].x() == wall.points[1].x())
      wall.points[1].z() = std::max(wall.points[1].z(), top);
  }
  datasets::ScenePhase& settle = scene.phases.front();
  double opening = settle.duration;
  opening += std::sqrt(2.0 * top / experiment.rig.gravity) + falling_time;
  datasets::ScenePhase fall = settle;
  fall.name = "fall";
  fall.duration = opening - settle.duration;
  fall.friction_between_particles = fall.friction_with_walls = 0.0;
  settle.duration = opening - fall.duration;
  scene.phases.insert(scene.phases.begin(), fall);
  ++scene.event_phase;
}

// The start of one replicate, as long as that lasted.
void begin_from_own(const Experiment& experiment,
                    const datasets::Replicate& replicate,
                    const Recording& recording,
                    SimulationSpec& spec) {
  double duration = 0.0, interval = curve_frame_interval;
  if (const auto& tracks = recording.tracks) {
    spec.start.poses = bed_of(experiment, replicate, *tracks);
    spec.start.standard_deviation = typical_error(*tracks);
    duration = tracks->time.back();
    interval =
        (tracks->time.back() - tracks->time.front()) / static_cast<double>(tracks->frames() - 1);
  } else if (recording.discharge) {
    duration = recording.discharge->time.back();
  }
  datasets::ScenePhase& run = spec.scene.phases.back();
  run.output_interval = interval;
  run.duration = std::floor(duration / interval + 0.5) * interval;
  if (replicate.rig.opening)
    spec.scene.leaves_below = replicate.rig.opening->z - experiment.particle.diameter;
}

// Whether nothing is there for a grain to touch once it lies below this height.
bool falls_freely_below(double height, const datasets::SceneData& scene) {
  if (scene.gravity.x() != 0.0 || scene.gravity.y() != 0.0 || !(scene.gravity.z() < 0.0))
    return false;
  return std::all_of(scene.walls.begin(), scene.walls.end(), [&](const datasets::SceneWall& wall) {
    const datasets::SceneMotion& motion = wall.motion;
    if (wall.kind == datasets::SceneWall::Kind::plane) return false;
    if (!motion.velocity.isZero(0.0) || !motion.angular_velocity.isZero(0.0)) return false;
    return std::all_of(wall.points.begin(), wall.points.end(), [&](const Eigen::Vector3d& point) {
      return point.z() - wall.radius >= height;
    });
  });
}

// Grains that have left would fall faster and faster, until they move too far in any step.
void take_out_what_left(const Experiment& experiment, datasets::SceneData& scene) {
  if (!scene.exit_height || scene.leaves_below) return;
  if (falls_freely_below(*scene.exit_height, scene))
    scene.leaves_below = *scene.exit_height - experiment.particle.length;
}

// A rig that the grains are filled into, as long as it was recorded, if it does not say how long.
void begin_from_filling(const Experiment& experiment,
                        const Condition& condition,
                        std::span<const Recording> recordings,
                        SimulationSpec& spec) {
  take_out_what_left(experiment, spec.scene);
  datasets::ScenePhase& run = spec.scene.phases.back();
  if (run.duration > 0.0) return;
  double last = 0.0;
  for (const std::size_t r : condition.replicates) {
    const Recording& recording = recordings[r];
    if (recording.tracks) last = std::max(last, recording.tracks->time.back());
    if (recording.discharge) last = std::max(last, recording.discharge->time.back());
    for (const datasets::Outline& outline : recording.outlines)
      if (!outline.time.empty()) last = std::max(last, outline.time.back());
  }
  if (!(last > 0.0)) last = experiment.measurement.last_time();
  run.output_interval = curve_frame_interval;
  run.duration = std::ceil(last / run.output_interval) * run.output_interval;
}

RecordPlan plan_of(const Observables& observables) {
  RecordPlan plan{.tracks = false, .curves = {}};
  for (const auto& observable : observables.all()) {
    plan.tracks = plan.tracks || observable->needs_tracks();
    for (const std::string& curve : observable->curves()) plan.curves.push_back(curve);
  }
  return plan;
}

// The columns in which outlines are compared, seen from where the film was taken.
void plan_outlines(const Observables& observables,
                   const Experiment& experiment,
                   const datasets::Replicate& replicate,
                   const Recording& recording,
                   RecordPlan& plan) {
  const auto& all = observables.all();
  if (!replicate.rig.seen_outline ||
      std::none_of(all.begin(), all.end(), [](const auto& one) { return one->needs_outline(); }))
    return;
  for (const auto& surface : datasets::surfaces_of(*replicate.rig.seen_outline)) {
    OutlinePlan& outline = plan.outlines.emplace_back();
    outline.columns = datasets::outline_columns(surface, experiment.particle.diameter);
    outline.surface = surface.name;
    if (!surface.name.empty()) outline.from_z = surface.floor_z;
    outline.to_z = surface.top_z;
    if (const datasets::Outline* seen = recording.outline_of(surface.name)) outline.eye = seen->eye;
  }
}

}  // namespace

void make_scenes(std::span<const Recording> recordings, Problem& problem) {
  const Experiment& experiment = problem.experiment;
  // 1. The fastest impact of any replicate, and how soft grains may be for it
  double fastest = 0.0;
  for (const datasets::Replicate& replicate : experiment.replicates) {
    for (const datasets::ScenePhase& phase : replicate.rig.scene.phases)
      fastest = std::max(fastest, phase.fastest_impact);
  }
  problem.simulated_modulus = softened_modulus(experiment, fastest);
  // 2. A scene for every condition, or for every replicate
  const RecordPlan plan = plan_of(*problem.observables);
  const bool each = experiment.rig.begins_from == BeginsFrom::each_replicate;
  int prepared = 0;
  std::vector<SimulationSpec> specs(experiment.replicates.size());
  for (std::size_t r = 0; r < experiment.replicates.size(); ++r) {
    const datasets::Replicate& replicate = experiment.replicates[r];
    SimulationSpec& spec = specs[r];
    spec.engine = problem.engine->name();
    spec.engine_version = problem.engine->version();
    if (problem.engine->is_another_program()) spec.foreign = experiment.simulator.foreign;
    spec.scene = replicate.rig.scene;
    spec.record = plan;
    plan_outlines(*problem.observables, experiment, replicate, recordings[r], spec.record);
    if (!experiment.rig.brings_grains) {
      add_grains(experiment, problem.simulated_modulus, spec.scene);
      for (datasets::ScenePhase& phase : spec.scene.phases) phase.fastest_impact = fastest;
    }
    if (!each) continue;
    begin_from_own(experiment, replicate, recordings[r], spec);
    if (spec.start.poses.empty()) prepare_bed(experiment, ++prepared, spec.scene);
  }
  for (std::size_t c = 0; c < problem.conditions.size(); ++c) {
    Condition& condition = problem.conditions[c];
    for (const std::size_t r : condition.replicates) {
      if (!each && r != condition.replicates.front()) continue;
      condition.scenes.push_back(problem.scenes.size());
      problem.scenes.push_back({c, r, each, std::move(specs[r])});
      if (experiment.rig.begins_from == BeginsFrom::mean_of_replicates)
        begin_from_mean(problem, condition, recordings, problem.scenes.back().spec);
      if (experiment.rig.begins_from == BeginsFrom::filling)
        begin_from_filling(experiment, condition, recordings, problem.scenes.back().spec);
    }
  }
}

void say_what_is_prepared(std::span<const Recording> recordings, Problem& problem) {
  std::vector<std::string> weighed, unturned;
  for (const ProblemScene& scene : problem.scenes) {
    if (!scene.is_of_one_replicate || !scene.spec.start.poses.empty()) continue;
    (recordings[scene.replicate].tracks ? unturned : weighed)
        .push_back(problem.experiment.replicates[scene.replicate].name);
  }
  if (!weighed.empty()) {
    problem.warnings.push_back(fmt::format(
        "{}: A discharge curve does not show the bed, the velocities or an arch. So simulations "
        "start from prepared beds, and only rates and the number of grains that stay are compared.",
        fmt::join(weighed, ", ")));
  }
  if (!unturned.empty()) {
    problem.warnings.push_back(fmt::format(
        "{}: the tracks tell no angles; simulations start from prepared beds instead of this one.",
        fmt::join(unturned, ", ")));
  }
}

}  // namespace graintruth::calibrate
