#include "calibrate/engines/scene_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>

#include "datasets/input_error.h"

namespace graintruth::calibrate {

namespace {

using datasets::InputError;
using datasets::SceneFile;
using datasets::ScenePhase;

// At rest (specification 13): over this time the coordination number changes by less than this
// share and in the end the kinetic energy of a particle is below this share of m g d.
constexpr double rest_window = 0.05;  // s
constexpr double rest_change = 0.005;
constexpr double rest_energy = 1e-6;

// Frames are kept until the end; more than this would not fit beside anything else.
constexpr double most_frame_bytes = 2e9;
constexpr double bytes_a_body = 13 * sizeof(double);

// Rain that finds no free place so often in a row is blocked.
constexpr int most_waits = 400;

BedState bed_state(const SceneFile& file,
                   const sim::Scene& scene,
                   const sim::State& state,
                   const std::vector<int>& owner,
                   const std::vector<sim::ContactReport>& contacts) {
  BedState bed;
  bed.contacts = static_cast<int>(contacts.size());
  int sliding = 0;
  for (const sim::ContactReport& contact : contacts) {
    bed.mean_force += contact.normal_force / bed.contacts;
    bed.largest_force = std::max(bed.largest_force, contact.normal_force);
    sliding += contact.slides ? 1 : 0;
  }
  bed.coordination =
      sim::count_partners(contacts, owner).per_body(static_cast<int>(state.position.size()));
  if (bed.contacts > 0) bed.sliding_share = static_cast<double>(sliding) / bed.contacts;
  if (file.exit_height) {
    for (std::size_t i = 0; i < state.position.size(); ++i) {
      if (state.position[i].z() >= *file.exit_height) continue;
      ++bed.discharged;
      bed.discharged_mass += scene.types[scene.bodies[i].type].mass;
    }
  }
  return bed;
}

class SceneRunner {
 public:
  SceneRunner(const SceneFile& file, const SceneRunOptions& options)
      : file_(file), options_(options), generator_(options.seed), built_(build_scene(file)) {
    run_.warnings = file.warnings;
    run_.warnings.insert(run_.warnings.end(), built_.warnings.begin(), built_.warnings.end());
  }

  SceneRun run() {
    fill();
    for (std::size_t p = 0; p < file_.phases.size() && goes_on(); ++p) {
      run_phase(static_cast<int>(p));
    }
    run_.scene = simulation_->scene_now();
    note_lost_particles();
    run_.kinds = built_.kinds;
    run_.owner = built_.owner;
    run_.contacts = simulation_->contacts();
    return std::move(run_);
  }

 private:
  bool goes_on() const { return run_.status == sim::RunStatus::completed; }

  sim::TimeStepOptions pace_of(const ScenePhase& phase) const {
    return {.fraction = phase.time_step_fraction, .impact_speed = phase.fastest_impact};
  }

  // Particles below every wall fall for ever.
  void note_lost_particles() {
    double lowest = std::numeric_limits<double>::infinity();
    for (const sim::Wall& wall : run_.scene.walls) {
      lowest = std::min(lowest, sim::box_of(wall).low.z());
    }
    const auto lost = std::count_if(
        run_.scene.bodies.begin(), run_.scene.bodies.end(), [&](const sim::Body& body) {
          return body.position.z() < lowest - run_.scene.types[body.type].bounding_radius;
        });
    if (lost == 0) return;
    run_.warnings.push_back(
        fmt::format("{} of {} particles fell out of the scene: they are below every wall.",
                    lost,
                    run_.scene.bodies.size()));
  }

  // A thread for every so many particles: fewer would wait for each other.
  int threads_for(std::size_t particles) const {
    constexpr std::size_t particles_a_thread = 1000;
    const auto useful = static_cast<int>(particles / particles_a_thread);
    return std::clamp(useful, 1, options_.threads);
  }

  void start_simulation(std::size_t particles) {
    const ScenePhase& first = file_.phases.front();
    use_surfaces(file_, first, built_.scene.surfaces);
    sim::SimulationOptions options;
    options.time_step = pace_of(first);
    options.global_damping = first.global_damping;
    options.largest_step_count = options_.step_limit;
    options.tally_work = true;
    options.keep_peaks = true;
    options.threads = threads_for(particles);
    use_law(file_.law, options);
    simulation_ = std::make_unique<sim::Simulation>(built_.scene, options);
  }

  void fill() {
    const std::vector<int> types = draw_types(file_, built_, generator_);
    refuse_too_many_frames(types.size() + file_.places.size());
    add_places(file_, built_);
    const bool rains = !types.empty() && file_.fill.method == datasets::SceneFill::Method::rain;
    if (rains && built_.scene.bodies.empty()) {
      add_drop(types.front());
      if (built_.scene.bodies.empty()) refuse_rain(0, types.size());
    } else if (!rains && !types.empty()) {
      add_lattice(file_, types, generator_, built_);
    }
    check_start(file_, built_);
    start_simulation(types.size() + file_.places.size());
    if (rains) rain(types);
  }

  void add_drop(int type) {
    const auto drop = rain_drop(file_, built_, built_.scene, type, generator_);
    if (drop) built_.scene.bodies.push_back(*drop);
  }

  [[noreturn]] void refuse_rain(std::size_t fallen, std::size_t wanted) const {
    throw InputError(
        fmt::format("{}: the rain of [fill] is blocked after {} of {} particles; make the region "
                    "higher, or the interval longer.",
                    file_.file.string(),
                    fallen,
                    wanted));
  }

  void rain(const std::vector<int>& types) {
    PhaseRecord record{.name = "rain", .time_step = simulation_->time_step()};
    const std::size_t placed = file_.places.size();
    int waits = 0;
    std::size_t fallen = simulation_->state().position.size() - placed;
    while (fallen < types.size() && goes_on()) {
      const double share = static_cast<double>(fallen) / static_cast<double>(types.size());
      report("filling", share, fmt::format("{} of {}", fallen, types.size()));
      advance(file_.fill.interval, file_.phases.front().output_interval, record);
      const auto drop =
          rain_drop(file_, built_, simulation_->scene_now(), types[fallen], generator_);
      if (!drop) {
        if (++waits > most_waits) refuse_rain(fallen, types.size());
        continue;
      }
      waits = 0;
      simulation_->add_bodies({*drop});
      ++fallen;
    }
    record.end = simulation_->time();
    run_.phases.push_back(record);
  }

  void run_phase(int index) {
    const ScenePhase& phase = file_.phases[index];
    PhaseRecord record{.name = phase.name, .start = simulation_->time()};
    sim::SurfaceTable surfaces;
    use_surfaces(file_, phase, surfaces);
    for (const datasets::SceneSurfaces& given : file_.surfaces) {
      simulation_->set_surfaces(given.first, given.second, surfaces.of(given.first, given.second));
    }
    simulation_->set_time_step(pace_of(phase));
    simulation_->set_global_damping(phase.global_damping);
    if (index == file_.event_phase) {
      run_.event_time = simulation_->time();
      run_.reached_event = true;
      run_.strips = strips_of_bed();
      start_walls(file_, built_, run_.event_time, *simulation_);
    }
    job_ = phase.name;
    job_start_ = record.start;
    job_length_ = phase.duration;
    if (phase.until_rest) {
      settle(phase, record);
    } else {
      advance(phase.duration, phase.output_interval, record);
    }
    record.end = simulation_->time();
    record.time_step = last_step_;
    run_.phases.push_back(record);
  }

  // Window after window until nothing moves any more.
  void settle(const ScenePhase& phase, PhaseRecord& record) {
    const double interval = phase.output_interval;
    const double window =
        interval > 0.0 ? interval * std::ceil(rest_window / interval) : rest_window;
    double coordination_before = -1.0;
    while (goes_on() && simulation_->time() < record.start + phase.duration * (1.0 - 1e-9)) {
      const double left = record.start + phase.duration - simulation_->time();
      advance(std::min(window, left), interval, record);
      const double coordination = bed_now().coordination;
      const bool is_steady = std::abs(coordination - coordination_before) <=
                             rest_change * std::max(coordination, 1e-12);
      coordination_before = coordination;
      if (is_steady && is_still()) {
        record.came_to_rest = true;
        return;
      }
    }
    if (goes_on()) {
      run_.warnings.push_back(fmt::format(
          "The particles did not come to rest within {:.4g} s; kinetic energy {:.3g} J.",
          phase.duration,
          simulation_->energy().kinetic));
    }
  }

  BedState bed_now() const {
    return bed_state(
        file_, built_.scene, simulation_->state(), built_.owner, simulation_->contacts());
  }

  bool is_still() const {
    const sim::Scene now = simulation_->scene_now();
    const double gravity = now.gravity.norm() > 0.0 ? now.gravity.norm() : 9.81;
    double allowed = 0.0;  // J
    for (const sim::Body& body : now.bodies) {
      const sim::Clump& type = now.types[body.type];
      allowed += rest_energy * type.mass * gravity * 2.0 * type.bounding_radius;
    }
    return simulation_->energy().kinetic <= allowed;
  }

  // Runs for a while, keeping a frame at the start and after every interval (s; 0 for the end
  // only).
  void advance(double duration, double interval, PhaseRecord& record) {
    sim::Sampling sampling;
    sampling.interval = interval;
    sampling.observer = [&](const sim::State& state) {
      if (interval > 0.0) keep_frame(state);
      show_progress(state.time);
    };
    sampling.should_stop = [&] {
      show_progress(simulation_->time());
      return options_.stop && options_.stop();
    };
    const sim::RunSummary summary =
        simulation_->run_until(simulation_->time() + duration, sampling);
    record.steps += summary.steps;
    if (summary.steps > 0) last_step_ = summary.time_step;
    run_.status = summary.status;
    run_.message = summary.message;
  }

  // The end of one stretch is the start of the next: kept once.
  void keep_frame(const sim::State& state) {
    if (!run_.frames.empty() && run_.frames.back().state.time == state.time &&
        run_.frames.back().state.position.size() == state.position.size()) {
      return;
    }
    SceneFrame frame;
    frame.state = state;
    frame.energy = simulation_->energy();
    const sim::Scene now = simulation_->scene_now();
    if (run_.frames.empty() || has_moving_walls()) frame.walls = now.walls;
    const std::vector<sim::ContactReport> contacts = simulation_->contacts();
    frame.bed = bed_state(file_, now, state, built_.owner, contacts);
    note_wall_forces(contacts, frame);
    run_.frames.push_back(std::move(frame));
  }

  // Of walls that are made of several, such as meshes, all parts together.
  void note_wall_forces(const std::vector<sim::ContactReport>& contacts, SceneFrame& frame) {
    const sim::ContactPeaks peaks = simulation_->take_peaks();
    frame.bed.peak_force = std::max(peaks.normal_force, frame.bed.largest_force);
    frame.wall_force.assign(file_.walls.size(), sim::Vec3::Zero());
    frame.wall_peak.assign(file_.walls.size(), 0.0);
    for (std::size_t w = 0; w < built_.owner.size(); ++w) {
      frame.wall_force[built_.owner[w]] += simulation_->wall_force(static_cast<int>(w));
      double& peak = frame.wall_peak[built_.owner[w]];
      peak = std::max(peak, peaks.of_wall[w]);
    }
    if (!run_.reached_event) return;
    std::vector<sim::ContactReport> of_owners = contacts;
    for (sim::ContactReport& contact : of_owners) {
      if (contact.with_wall) contact.second = built_.owner[contact.second];
    }
    for (std::size_t w = 0; w < file_.walls.size(); ++w) {
      frame.strip_force.push_back(
          sim::normal_force_by_strip(of_owners, static_cast<int>(w), run_.strips));
    }
  }

  // From the lowest to the highest point of any particle.
  sim::Strips strips_of_bed() const {
    sim::Strips strips{std::numeric_limits<double>::infinity(),
                       -std::numeric_limits<double>::infinity()};
    for (const sim::Body& body : simulation_->scene_now().bodies) {
      for (const sim::ElementSphere& sphere : built_.scene.types[body.type].spheres) {
        const double z = (body.position + body.orientation * sphere.centre).z();
        strips.low = std::min(strips.low, z - sphere.radius);
        strips.high = std::max(strips.high, z + sphere.radius);
      }
    }
    return strips;
  }

  bool has_moving_walls() const {
    return run_.reached_event &&
           std::any_of(file_.walls.begin(), file_.walls.end(), [](const datasets::SceneWall& wall) {
             return !wall.motion.velocity.isZero(0.0) ||
                    !wall.motion.angular_velocity.isZero(0.0) || std::isfinite(wall.opens_at);
           });
  }

  void show_progress(double time) {
    if (job_.empty()) return;
    report(job_,
           std::clamp((time - job_start_) / job_length_, 0.0, 1.0),
           fmt::format("{:.3f} of {:.3f} s", time - job_start_, job_length_));
  }

  void report(const std::string& job, double share, const std::string& detail) const {
    if (options_.progress) options_.progress(job, share, detail);
  }

  void refuse_too_many_frames(std::size_t bodies) const {
    double frames = 0.0;
    for (const ScenePhase& phase : file_.phases) {
      if (phase.output_interval > 0.0) frames += phase.duration / phase.output_interval;
    }
    const double bytes = frames * static_cast<double>(bodies) * bytes_a_body;
    if (bytes > most_frame_bytes) {
      throw InputError(fmt::format(
          "{}: {:.0f} frames of {} particles would take {:.1f} GB; make output_interval longer.",
          file_.file.string(),
          frames,
          bodies,
          1e-9 * bytes));
    }
  }

  const SceneFile& file_;
  const SceneRunOptions& options_;
  Generator generator_;
  BuiltScene built_;
  std::unique_ptr<sim::Simulation> simulation_;
  SceneRun run_;
  std::string job_;
  double job_start_ = 0.0, job_length_ = 1.0, last_step_ = 0.0;  // s
};

}  // namespace

const std::vector<sim::Wall>& SceneRun::walls_at(std::size_t frame) const {
  while (frame > 0 && frames[frame].walls.empty()) --frame;
  return frames[frame].walls;
}

SceneRun run_scene(const SceneFile& file, const SceneRunOptions& options) {
  try {
    return SceneRunner(file, options).run();
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format("{}: {}.", file.file.string(), error.what()));
  }
}

}  // namespace graintruth::calibrate
