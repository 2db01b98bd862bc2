#include "calibrate/engines/scene_runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "datasets/store/input_error.h"
#include "sim/engine/contact_summary.h"

namespace graintruth::calibrate {

namespace {

using datasets::InputError;
using datasets::ScenePhase;

// At rest (specification 13): over this time the coordination number changes by less than this
// share and in the end the kinetic energy of a particle is below this share of m g d.
constexpr double rest_window = 0.05;  // s
constexpr double rest_change = 0.005;
constexpr double rest_energy = 1e-6;

// Rain that finds no free place so often in a row is blocked.
constexpr int most_waits = 400;

sim::TimeStepOptions pace_of(const ScenePhase& phase) {
  return {.fraction = phase.time_step_fraction, .impact_speed = phase.fastest_impact};
}

}  // namespace

SceneRunner::SceneRunner(const datasets::SceneData& scene,
                         const std::string& origin,
                         const SceneRunOptions& options)
    : scene_(scene),
      options_(options),
      generator_(options.seed),
      built_(build_scene(scene, origin)),
      warnings_(built_.warnings) {}

void SceneRunner::run_phases() {
  if (!fill()) {
    status_ = sim::RunStatus::unstable;
    return;
  }
  start_simulation(types_.size() + scene_.places.size());
  const std::size_t present = simulation_->state().position.size();
  const std::size_t falling = types_.size() + scene_.places.size() - present;
  allow_steps(0, static_cast<double>(falling) * scene_.fill.interval);
  if (falling > 0) rain();
  numbers_.resize(simulation_->state().position.size());
  std::iota(numbers_.begin(), numbers_.end(), 0);
  for (std::size_t p = 0; p < scene_.phases.size() && goes_on(); ++p)
    run_phase(static_cast<int>(p));
}

bool SceneRunner::fill() {
  types_ = draw_types(scene_, built_, generator_);
  add_places(scene_, built_);
  const bool rains = !types_.empty() && scene_.fill.method == datasets::SceneFill::Method::rain;
  if (rains && built_.scene.bodies.empty()) {
    add_drop(types_.front());
    if (built_.scene.bodies.empty()) refuse_rain(0, types_.size());
  } else if (!rains && !types_.empty()) {
    add_lattice(scene_, types_, generator_, built_);
  }
  check_start(scene_, built_);
  return true;
}

void SceneRunner::start_simulation(std::size_t particles) {
  // A thread for every so many particles: fewer would wait for each other.
  constexpr std::size_t particles_a_thread = 1000;
  const ScenePhase& first = scene_.phases.front();
  use_surfaces(scene_, first, built_.scene.surfaces);
  sim::SimulationOptions options;
  options.time_step = pace_of(first);
  options.global_damping = first.global_damping;
  options.largest_step_count = options_.step_limit;
  options.threads =
      std::clamp(static_cast<int>(particles / particles_a_thread), 1, options_.threads);
  use_law(scene_.law, options);
  choose(options);
  simulation_ = std::make_unique<sim::Simulation>(built_.scene, options);
}

// What rains comes after what is placed, in the order of its types.
int SceneRunner::type_of(std::size_t number) const {
  const std::vector<sim::Body>& bodies = built_.scene.bodies;
  return number < bodies.size() ? bodies[number].type : types_[number - scene_.places.size()];
}

void SceneRunner::add_drop(int type) {
  const auto drop = rain_drop(scene_, built_, built_.scene, type, generator_);
  if (drop) built_.scene.bodies.push_back(*drop);
}

void SceneRunner::refuse_rain(std::size_t fallen, std::size_t wanted) const {
  throw InputError(
      fmt::format("{}: the rain of [fill] is blocked after {} of {} particles; make the region "
                  "higher, or the interval longer.",
                  built_.origin,
                  fallen,
                  wanted));
}

void SceneRunner::rain() {
  PhaseRecord record{.name = "rain", .time_step = simulation_->time_step()};
  const std::size_t placed = scene_.places.size();
  int waits = 0;
  std::size_t fallen = simulation_->state().position.size() - placed;
  while (fallen < types_.size() && goes_on()) {
    const double share = static_cast<double>(fallen) / static_cast<double>(types_.size());
    report("filling", share, fmt::format("{} of {}", fallen, types_.size()));
    advance(scene_.fill.interval, scene_.phases.front().output_interval, record);
    const auto drop =
        rain_drop(scene_, built_, simulation_->scene_now(), types_[fallen], generator_);
    if (!drop) {
      if (++waits > most_waits) refuse_rain(fallen, types_.size());
      continue;
    }
    waits = 0;
    simulation_->add_bodies({*drop});
    ++fallen;
  }
  record.end = simulation_->time();
  phases_.push_back(record);
}

void SceneRunner::run_phase(int index) {
  const ScenePhase& phase = scene_.phases[index];
  PhaseRecord record{.name = phase.name, .start = simulation_->time()};
  sim::SurfaceTable surfaces;
  use_surfaces(scene_, phase, surfaces);
  for (const datasets::SceneSurfaces& given : scene_.surfaces) {
    simulation_->set_surfaces(given.first, given.second, surfaces.of(given.first, given.second));
  }
  simulation_->set_time_step(pace_of(phase));
  simulation_->set_global_damping(phase.global_damping);
  allow_steps(static_cast<std::size_t>(index), 0.0);
  if (index == scene_.event_phase) {
    event_time_ = simulation_->time();
    reached_event_ = true;
    on_event();
    start_walls(scene_, built_, event_time_, *simulation_);
  }
  job_ = phase.name;
  job_start_ = record.start;
  job_length_ = phase.duration;
  if (phase.until_rest) {
    settle(phase, record);
  } else if (scene_.leaves_below && reached_event_ && phase.output_interval > 0.0) {
    advance_taking_out(phase, record);
  } else {
    advance(phase.duration, phase.output_interval, record);
  }
  record.end = simulation_->time();
  record.time_step = last_step_;
  phases_.push_back(record);
}

// Window after window until nothing moves any more.
void SceneRunner::settle(const ScenePhase& phase, PhaseRecord& record) {
  const double interval = phase.output_interval;
  const double window = interval > 0.0 ? interval * std::ceil(rest_window / interval) : rest_window;
  double coordination_before = -1.0;
  while (goes_on() && simulation_->time() < record.start + phase.duration * (1.0 - 1e-9)) {
    const double left = record.start + phase.duration - simulation_->time();
    advance(std::min(window, left), interval, record);
    const double coordination = coordination_now();
    const bool is_steady =
        std::abs(coordination - coordination_before) <= rest_change * std::max(coordination, 1e-12);
    coordination_before = coordination;
    if (is_steady && is_still()) {
      record.came_to_rest = true;
      return;
    }
  }
  if (goes_on()) {
    warnings_.push_back(
        fmt::format("The particles did not come to rest within {:.4g} s; kinetic energy {:.3g} J.",
                    phase.duration,
                    simulation_->energy().kinetic));
  }
}

double SceneRunner::coordination_now() const {
  return sim::count_partners(simulation_->contacts(), built_.owner)
      .per_body(static_cast<int>(simulation_->state().position.size()));
}

// In space a ball can spin in place about the normal of what it touches. Nothing stops it, and it
// moves nothing.
bool SceneRunner::is_still() const {
  const sim::Scene now = simulation_->scene_now();
  const double gravity = now.gravity.norm() > 0.0 ? now.gravity.norm() : 9.81;
  double allowed = 0.0, spinning = 0.0;  // J
  for (const sim::Body& body : now.bodies) {
    const sim::Clump& type = now.types[body.type];
    const double own = rest_energy * type.mass * gravity * 2.0 * type.bounding_radius;
    allowed += own;
    const bool is_ball = !now.planar && type.spheres.size() == 1;
    if (is_ball && 0.5 * type.mass * body.velocity.squaredNorm() <= own)
      spinning += 0.5 * type.inertia.x() * body.angular_velocity.squaredNorm();
  }
  return simulation_->energy().kinetic - spinning <= allowed;
}

void SceneRunner::run_until(double time, const sim::Sampling& sampling, PhaseRecord& record) {
  const sim::RunSummary summary = simulation_->run_until(time, sampling);
  record.steps += summary.steps;
  steps_ += summary.steps;
  if (summary.steps > 0) last_step_ = summary.time_step;
  status_ = summary.status;
  message_ = summary.message;
  const bool is_stopped = options_.stop && status_ == sim::RunStatus::timed_out && options_.stop();
  if (allowed_ == 0 || status_ == sim::RunStatus::unstable || is_stopped) return;
  if (goes_on() && steps_ <= allowed_) return;
  status_ = sim::RunStatus::timed_out;
  message_ = fmt::format("it takes more than {} steps", allowed_);
}

// From here on: of the phases to come, and of `filling` seconds before them.
void SceneRunner::allow_steps(std::size_t next_phase, double filling) {
  allowed_ = options_.step_limit;
  if (allowed_ > 0 || !(options_.step_allowance > 0.0)) return;
  double time = filling, frames = 0.0;
  for (std::size_t p = next_phase; p < scene_.phases.size(); ++p) {
    const ScenePhase& phase = scene_.phases[p];
    time += phase.duration;
    if (phase.output_interval > 0.0) frames += phase.duration / phase.output_interval;
  }
  const double expected = time / simulation_->time_step() + frames + 1.0;
  allowed_ = steps_ + static_cast<std::int64_t>(options_.step_allowance * expected);
}

// Runs for a while, with a frame at the start and after every interval (s; 0 for none).
void SceneRunner::advance(double duration, double interval, PhaseRecord& record) {
  sim::Sampling sampling;
  sampling.interval = interval;
  sampling.observer = [&](const sim::State& state) {
    if (interval > 0.0) on_frame(state);
    show_progress(state.time);
  };
  sampling.should_stop = [&] {
    show_progress(simulation_->time());
    return options_.stop && options_.stop();
  };
  run_until(simulation_->time() + duration, sampling, record);
}

// Frame by frame, until nothing is left to see.
void SceneRunner::advance_taking_out(const ScenePhase& phase, PhaseRecord& record) {
  sim::Sampling sampling;
  sampling.should_stop = [&] {
    show_progress(simulation_->time());
    return options_.stop && options_.stop();
  };
  const auto last = static_cast<long>(std::floor(phase.duration / phase.output_interval + 0.5));
  for (long frame = 0; frame <= last && goes_on() && !is_empty_; ++frame) {
    const double time = record.start + static_cast<double>(frame) * phase.output_interval;
    if (frame > 0) run_until(time, sampling, record);
    if (!goes_on()) return;
    on_frame(simulation_->state());
    is_empty_ = !take_out();
  }
}

// False when nothing is left.
bool SceneRunner::take_out() {
  const sim::State& state = simulation_->state();
  std::vector<int> leaving;
  std::vector<std::size_t> staying;
  for (std::size_t i = 0; i < numbers_.size(); ++i) {
    if (state.position[i].z() < *scene_.leaves_below) {
      leaving.push_back(static_cast<int>(i));
    } else {
      staying.push_back(numbers_[i]);
    }
  }
  if (staying.empty()) return false;
  for (const int body : leaving) taken_out_.push_back(numbers_[static_cast<std::size_t>(body)]);
  if (!leaving.empty()) simulation_->remove_bodies(leaving);
  numbers_ = std::move(staying);
  return true;
}

void SceneRunner::show_progress(double time) {
  if (job_.empty()) return;
  report(job_,
         std::clamp((time - job_start_) / job_length_, 0.0, 1.0),
         fmt::format("{:.3f} of {:.3f} s", time - job_start_, job_length_));
}

void SceneRunner::report(const std::string& job, double share, const std::string& detail) const {
  if (options_.progress) options_.progress(job, share, detail);
}

}  // namespace graintruth::calibrate
