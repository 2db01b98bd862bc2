#include "calibrate/engines/embedded.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <iterator>
#include <set>

#include "calibrate/engines/scene_runner.h"
#include "datasets/store/input_error.h"
#include "datasets/store/silhouette.h"
#include "sim/laws/time_step.h"

namespace graintruth::calibrate {

namespace {

using datasets::Recording;

// Changes whenever the simulator gives other numbers for the same spec: tests/calibrate/
// numbers_version_test.cpp says when. 9: impacts are of second order in the step.
constexpr const char* numbers_version = "9";

// What rain may wait for room beyond the time of all that is simulated, before it is given up:
// times the steps that filling and phases take.
constexpr double step_allowance = 20.0;

// Processor time of this thread, s.
double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1.0e-9 * static_cast<double>(now.tv_nsec);
}

RunStatus status_of(sim::RunStatus status) {
  switch (status) {
    case sim::RunStatus::completed:
      return RunStatus::completed;
    case sim::RunStatus::unstable:
      return RunStatus::unstable;
    case sim::RunStatus::timed_out:
      return RunStatus::timed_out;
  }
  return RunStatus::unstable;
}

std::size_t count_of(const SimulationSpec& spec) {
  if (!spec.start.poses.empty()) return spec.start.poses.size();
  std::size_t count = spec.scene.places.size();
  for (const datasets::SceneParticle& particle : spec.scene.particles)
    count += static_cast<std::size_t>(particle.count);
  return count;
}

// Frames of the phases from the event on.
std::size_t frames_of(const datasets::SceneData& scene) {
  std::size_t frames = 0;
  for (auto p = static_cast<std::size_t>(scene.event_phase); p < scene.phases.size(); ++p) {
    const datasets::ScenePhase& phase = scene.phases[p];
    if (phase.output_interval > 0.0)
      frames += static_cast<std::size_t>(std::floor(phase.duration / phase.output_interval + 0.5));
  }
  return frames + 1;
}

constexpr const char* highest_grain = "highest_grain_m";

// The force on a wall of the scene along one axis.
struct WallForce {
  std::string curve;  // wall_force_<wall>_z_n
  std::size_t wall = 0;
  int axis = 0;
};

// Of every wall that has a name, of its own.
std::vector<WallForce> wall_forces_of(const datasets::SceneData& scene) {
  std::vector<WallForce> forces;
  std::set<std::string> names;
  for (std::size_t wall = 0; wall < scene.walls.size(); ++wall) {
    const std::string& name = scene.walls[wall].name;
    if (name.empty() || !names.insert(name).second) continue;
    for (int axis = 0; axis < 3; ++axis)
      forces.push_back({fmt::format("wall_force_{}_{}_n", name, "xyz"[axis]), wall, axis});
  }
  return forces;
}

class RecordedRun final : public SceneRunner {
 public:
  RecordedRun(const SimulationSpec& spec, const SceneRunOptions& options)
      : SceneRunner(spec.scene, "The scene", options), spec_(spec) {
    const auto is_asked_for = [&](const std::string& curve) {
      const std::vector<std::string>& curves = spec.record.curves;
      return std::find(curves.begin(), curves.end(), curve) != curves.end();
    };
    keeps_highest_ = is_asked_for(highest_grain);
    for (const OutlinePlan& plan : spec.record.outlines) {
      datasets::Outline& outline = outlines_.emplace_back();
      outline.column = plan.columns;
      outline.eye = plan.eye;
      outline.surface = plan.surface;
    }
    for (WallForce& force : wall_forces_of(spec.scene)) {
      if (is_asked_for(force.curve)) wall_forces_.push_back(std::move(force));
    }
  }

  BuiltScene start() {
    if (!fill()) throw std::invalid_argument(message_);
    return std::move(built_);
  }

  EngineRun run() {
    const std::size_t frames = frames_of(scene_);
    if (spec_.record.tracks) {
      tracks_ = datasets::make_trajectories(frames, static_cast<int>(count_of(spec_)), false);
      tracks_.time.clear();
    }
    run_phases();
    EngineRun run{.status = status_of(status_), .message = message_, .time_step = last_step_};
    if (run.status != RunStatus::completed) return run;
    if (spec_.record.tracks) {
      complete_times(frames);
      run.recording.tracks = std::move(tracks_);
    }
    run.recording.outlines = std::move(outlines_);
    if (scene_.exit_height) run.recording.discharge = std::move(discharge_);
    run.recording.curves = std::move(curves_);
    return run;
  }

 private:
  bool fill() override {
    const bool rows = scene_.fill.method == datasets::SceneFill::Method::rows;
    if (spec_.start.poses.empty() && !rows) return SceneRunner::fill();
    const std::vector<datasets::Pose> poses =
        rows && spec_.start.poses.empty() ? rows_of(scene_, spec_.seed) : spec_.start.poses;
    // Sizes are drawn apart from places, which are the same whatever the sizes
    Generator of_sizes(spec_.seed + 1);
    std::vector<int> types = draw_types(scene_, built_, of_sizes);
    types.resize(poses.size(), built_.kinds.front().types.front());
    const double overlap =
        place_poses(poses, spec_.start.standard_deviation, types, generator_, built_);
    if (!(overlap > 0.0)) return true;
    message_ =
        fmt::format("the starting poses cannot be freed of overlap ({:.2g} m is left)", overlap);
    return false;
  }

  void on_frame(const sim::State& state) override {
    if (!reached_event_) return;
    // The end of one phase is the start of the next: kept once
    if (frame_ > 0 && state.time == last_time_) return;
    last_time_ = state.time;
    if (spec_.record.tracks) keep_tracks(state);
    if (!outlines_.empty()) keep_outlines(state);
    const double time = state.time - event_time_;
    if (scene_.exit_height) keep_discharge(state, time);
    if (keeps_highest_) {
      double highest = -std::numeric_limits<double>::infinity();
      for (const sim::Vec3& position : state.position) highest = std::max(highest, position.z());
      keep(highest_grain, time, highest);
    }
    for (const WallForce& force : wall_forces_) {
      double sum = 0.0;
      for (std::size_t w = 0; w < built_.owner.size(); ++w) {
        if (static_cast<std::size_t>(built_.owner[w]) == force.wall)
          sum += simulation_->wall_force(static_cast<int>(w))[force.axis];
      }
      keep(force.curve, time, sum);
    }
    ++frame_;
  }

  void keep(const std::string& curve, double time, double value) {
    curves_[curve].time.push_back(time);
    curves_[curve].value.push_back(value);
  }

  void keep_tracks(const sim::State& state) {
    if (frame_ >= frames_of(scene_)) return;
    for (std::size_t i = 0; i < numbers().size(); ++i) {
      const sim::Vec3& position = state.position[i];
      datasets::Pose& pose = tracks_.poses[tracks_.index(frame_, numbers()[i])];
      pose.x = position.x();
      pose.z = position.z();
      if (!scene_.is_planar) continue;
      const sim::Clump& type = built_.scene.types[type_of(numbers()[i])];
      pose.angle = state.picture_angle[i] - sim::picture_angle_of(type.input_from_body);
    }
  }

  // Of all element spheres that are there.
  void keep_outlines(const sim::State& state) {
    std::vector<datasets::Ball> balls;
    for (std::size_t i = 0; i < numbers().size(); ++i) {
      for (const sim::ElementSphere& sphere : built_.scene.types[type_of(numbers()[i])].spheres) {
        balls.push_back({state.position[i] + state.orientation[i] * sphere.centre, sphere.radius});
      }
    }
    for (std::size_t i = 0; i < outlines_.size(); ++i) {
      const OutlinePlan& plan = spec_.record.outlines[i];
      std::vector<datasets::Ball> own;
      if (plan.from_z || plan.to_z) {
        std::copy_if(balls.begin(), balls.end(), std::back_inserter(own), [&](const auto& ball) {
          return !(plan.from_z && ball.centre.z() < *plan.from_z) &&
                 !(plan.to_z && ball.centre.z() > *plan.to_z);
        });
      }
      datasets::Outline& outline = outlines_[i];
      const std::vector<double> heights =
          datasets::silhouette(plan.from_z || plan.to_z ? own : balls, outline.column, outline.eye);
      outline.time.push_back(state.time - event_time_);
      outline.height.insert(outline.height.end(), heights.begin(), heights.end());
    }
  }

  // Below the exit, or taken out below it.
  void keep_discharge(const sim::State& state, double time) {
    double mass = 0.0;
    for (const std::size_t number : taken_out()) mass += built_.scene.types[type_of(number)].mass;
    for (std::size_t i = 0; i < state.position.size(); ++i) {
      if (state.position[i].z() < *scene_.exit_height)
        mass += built_.scene.types[type_of(numbers()[i])].mass;
    }
    discharge_.time.push_back(time);
    discharge_.mass.push_back(mass);
  }

  // Times of frames are whole multiples of the interval where there is one phase to look at.
  void complete_times(std::size_t frames) {
    double start = 0.0;
    tracks_.time = {0.0};
    for (auto p = static_cast<std::size_t>(scene_.event_phase); p < scene_.phases.size(); ++p) {
      const datasets::ScenePhase& phase = scene_.phases[p];
      if (!(phase.output_interval > 0.0)) continue;
      const auto own =
          static_cast<std::size_t>(std::floor(phase.duration / phase.output_interval + 0.5));
      for (std::size_t frame = 1; frame <= own; ++frame)
        tracks_.time.push_back(start + static_cast<double>(frame) * phase.output_interval);
      start += phase.duration;
    }
    tracks_.time.resize(frames);
  }

  const SimulationSpec& spec_;
  std::vector<WallForce> wall_forces_;
  bool keeps_highest_ = false;
  std::size_t frame_ = 0;
  double last_time_ = 0.0;
  datasets::Trajectories tracks_;
  std::vector<datasets::Outline> outlines_;  // in the order of the plan
  datasets::DischargeCurve discharge_;
  std::map<std::string, datasets::Curve> curves_;
};

class Embedded final : public Engine {
 public:
  std::string_view name() const override { return "embedded"; }
  std::string version() const override { return numbers_version; }

  std::vector<std::string> curves(const SimulationSpec& spec) const override {
    std::vector<std::string> names = {highest_grain};
    for (const WallForce& force : wall_forces_of(spec.scene)) names.push_back(force.curve);
    return names;
  }

  double largest_time_step_fraction(const SimulationSpec& spec) const override {
    BuiltScene built = build_scene(spec.scene, "The scene");
    for (std::size_t type = 0; type < built.scene.types.size(); ++type)
      built.scene.add_body(static_cast<int>(type), sim::Vec3::Zero());
    double largest = 1.0;
    for (const datasets::ScenePhase& phase : spec.scene.phases) {
      use_surfaces(spec.scene, phase, built.scene.surfaces);
      const sim::TimeStepOptions options{.fraction = 1.0, .impact_speed = phase.fastest_impact};
      largest = std::min(
          largest,
          sim::choose_time_step(built.scene, options) / sim::critical_time_step(built.scene));
    }
    return largest;
  }

  EngineRun run(const SimulationSpec& spec, const EngineOptions& options) const override {
    const double started = thread_seconds();
    SceneRunOptions how{.seed = spec.seed};
    how.step_limit = options.step_limit;
    how.step_allowance = step_allowance;
    how.stop = options.stop;
    EngineRun run;
    try {
      run = RecordedRun(spec, how).run();
    } catch (const datasets::InputError& error) {
      // The scene was looked at before; what cannot start now is blocked rain, or grains that
      // parameters make too large
      run = {.status = RunStatus::unstable, .message = error.what()};
    } catch (const std::invalid_argument& error) {
      run = {.status = RunStatus::unstable, .message = error.what()};
    }
    if (options.stop && options.stop()) throw Interrupted();
    run.seconds = thread_seconds() - started;
    return run;
  }
};

}  // namespace

BuiltScene start_of(const SimulationSpec& spec) {
  const SceneRunOptions options{.seed = spec.seed};
  return RecordedRun(spec, options).start();
}

const Engine& embedded_engine() {
  static const Embedded engine;
  return engine;
}

}  // namespace graintruth::calibrate
