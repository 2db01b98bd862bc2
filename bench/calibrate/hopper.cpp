#include "bench/calibrate/hopper.h"

#include <fmt/format.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <cmath>
#include <numbers>

#include "bench/calibrate/thread_seconds.h"
#include "calibrate/observables/discharge.h"
#include "datasets/store/fingerprint.h"
#include "datasets/store/run_folder.h"

namespace graintruth::bench {

namespace {

namespace fs = std::filesystem;

constexpr int particle_material = 0, wall_material = 1;
constexpr double gravity = 9.81;        // m/s2
constexpr double row_pitch = 1.03;      // diameters between the rows of a bed that has yet to fall
constexpr double stirring_speed = 0.3;  // m/s; largest of a component, so that no lattice lands
constexpr double filling_damping = 40.0;  // 1/s; nothing falls faster than g over it, 0.25 m/s
constexpr double falling_share = 0.5;     // of the height of the rows that they fall at most
constexpr double filling_restitution = 0.5;
constexpr double resting_time = 0.2;      // s after the last fall
constexpr double settling_time = 0.1;     // s on the closed slot with the friction of the request
constexpr double sample_interval = 0.02;  // s; in which less than half a percent leaves
constexpr double filling_step = 0.3;      // of the Rayleigh step
// Of an impact at 0.1 m/s. Not many: a bed under its own weight is unstable with 12 at restitution
// 0.2, and with 16 at 0.5 where friction is near 1.
constexpr double steps_per_contact = 16.0;
constexpr double largest_overlap = 0.3;  // of the radius; where rows fall on rows

sim::SurfaceTable surfaces_of(double between_particles,
                              double with_walls,
                              double restitution,
                              double rolling_friction) {
  sim::SurfaceTable surfaces;
  surfaces.set(particle_material,
               particle_material,
               {.friction = between_particles,
                .restitution = restitution,
                .rolling_friction = rolling_friction});
  surfaces.set(
      particle_material,
      wall_material,
      {.friction = with_walls, .restitution = restitution, .rolling_friction = rolling_friction});
  return surfaces;
}

// The slot is closed by the last wall. The spheres are still in rows above the floor.
sim::Scene closed_box(const Hopper& hopper, std::uint64_t seed) {
  sim::Scene scene;
  scene.gravity = sim::Vec3(0.0, 0.0, -gravity);
  scene.add_material({hopper.youngs_modulus, hopper.poisson_ratio});
  scene.add_material({hopper.youngs_modulus, hopper.poisson_ratio});
  scene.surfaces =
      surfaces_of(hopper.filling_friction, hopper.filling_friction, filling_restitution, 0.0);
  const double side = 0.5 * hopper.width, front = 0.5 * hopper.depth, edge = 0.5 * hopper.slot;
  for (const double sign : {-1.0, 1.0}) {
    scene.add_wall(sim::plane_wall({sign * side, 0.0, 0.0}, {-sign, 0.0, 0.0}, {}, wall_material));
    scene.add_wall(sim::plane_wall({0.0, sign * front, 0.0}, {0.0, -sign, 0.0}, {}, wall_material));
    scene.add_wall(sim::segment_wall({sign * edge, 0.0}, {sign * side, 0.0}, {}, wall_material));
  }
  scene.add_wall(sim::segment_wall({-edge, 0.0}, {edge, 0.0}, {}, wall_material));

  const int type = scene.add_type(sim::make_clump({{sim::Vec3::Zero(), 0.5 * hopper.diameter}},
                                                  {.density = hopper.density},
                                                  particle_material));
  boost::random::mt19937_64 generator(seed);
  boost::random::uniform_real_distribution<double> share(-0.5, 0.5);
  const auto along = static_cast<int>(hopper.width / (1.02 * hopper.diameter));
  const auto across = static_cast<int>(hopper.depth / (1.02 * hopper.diameter));
  const sim::Vec3 pitch(hopper.width / along, hopper.depth / across, row_pitch * hopper.diameter);
  const sim::Vec3 slack = pitch - sim::Vec3::Constant(hopper.diameter);
  const auto random = [&] {
    const double x = share(generator), y = share(generator), z = share(generator);
    return sim::Vec3(x, y, z);
  };
  for (int i = 0; i < hopper.particles; ++i) {
    const int row = i / along, layer = row / across;
    const sim::Vec3 site(i % along, row % across, layer);
    const sim::Vec3 middle = (site + sim::Vec3::Constant(0.5)).cwiseProduct(pitch);
    scene.add_body(type,
                   middle - sim::Vec3(side, front, 0.0) + slack.cwiseProduct(random()),
                   sim::Quat::Identity(),
                   2.0 * stirring_speed * random());
  }
  return scene;
}

sim::TimeStepOptions time_step_of(double fraction) {
  return {.fraction = fraction, .steps_per_contact = steps_per_contact};
}

sim::Simulation closed_simulation(const Hopper& hopper,
                                  std::uint64_t seed,
                                  double time_step_fraction) {
  sim::SimulationOptions options;
  options.time_step = time_step_of(time_step_fraction);
  options.largest_overlap = largest_overlap;
  return sim::Simulation(closed_box(hopper, seed), options);
}

sim::Snapshot fill(const Hopper& hopper, std::uint64_t seed) {
  sim::Simulation simulation = closed_simulation(hopper, seed, filling_step);
  double top = 0.0;
  for (const sim::Vec3& position : simulation.state().position) top = std::max(top, position.z());
  simulation.set_global_damping(filling_damping);
  const double falling_time = falling_share * top * filling_damping / gravity;
  const sim::RunSummary summary = simulation.run_until(falling_time + resting_time);
  simulation.set_global_damping(0.0);
  if (summary.status != sim::RunStatus::completed)
    throw std::runtime_error("the box cannot be filled: " + summary.message);
  return simulation.save();
}

// Every number of a box and of how it is filled and simulated.
std::string text_of(const Hopper& hopper) {
  return fmt::format("{} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {}",
                     hopper.width,
                     hopper.depth,
                     hopper.slot,
                     hopper.particles,
                     hopper.diameter,
                     hopper.density,
                     hopper.youngs_modulus,
                     hopper.poisson_ratio,
                     hopper.filling_friction,
                     row_pitch,
                     stirring_speed,
                     filling_damping,
                     falling_share,
                     filling_restitution,
                     resting_time,
                     settling_time,
                     sample_interval,
                     filling_step,
                     steps_per_contact);
}

// Whether a stretch ended well; `run` is told how.
bool ended_well(const sim::RunSummary& summary,
                const calibrate::EngineOptions& options,
                calibrate::EngineRun& run) {
  using calibrate::RunStatus;
  if (options.stop && options.stop()) throw calibrate::Interrupted();
  run.status = summary.status == sim::RunStatus::completed   ? RunStatus::completed
               : summary.status == sim::RunStatus::timed_out ? RunStatus::timed_out
                                                             : RunStatus::unstable;
  run.message = summary.message;
  if (summary.time_step > 0.0) run.time_step = summary.time_step;
  return run.status == RunStatus::completed;
}

}  // namespace

double Hopper::particle_mass() const {
  return density * std::numbers::pi / 6.0 * diameter * diameter * diameter;
}

calibrate::BulkRig rig_of(const Hopper& hopper) {
  return {.width = hopper.width,
          .orifice = hopper.slot,
          .particle_area = 0.25 * std::numbers::pi * hopper.diameter * hopper.diameter,
          .particle_diameter = hopper.diameter,
          .particle_mass = hopper.particle_mass(),
          .gravity = gravity};
}

sim::Snapshot filled_bed(const Hopper& hopper, std::uint64_t seed, const fs::path& folder) {
  const std::string name = datasets::content_hash(fmt::format("{} {}", text_of(hopper), seed));
  const fs::path file = folder / (name + ".bed");
  if (fs::exists(file)) {
    const std::string content = datasets::read_whole(file);
    return sim::snapshot_from_bytes(std::as_bytes(std::span(content)));
  }
  sim::Snapshot bed = fill(hopper, seed);
  const std::vector<std::byte> bytes = sim::to_bytes(bed);
  datasets::write_whole(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  return bed;
}

BedAtRest look_at_bed(const Hopper& hopper, std::uint64_t seed, const sim::Snapshot& bed) {
  sim::Simulation simulation = closed_simulation(hopper, seed, filling_step);
  simulation.restore(bed);
  BedAtRest at_rest;
  const sim::State& state = simulation.state();
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    at_rest.height = std::max(at_rest.height, state.position[i].z() + 0.5 * hopper.diameter);
    at_rest.fastest = std::max(at_rest.fastest, state.velocity[i].norm());
  }
  int contacts = 0;
  for (const sim::ContactReport& contact : simulation.contacts()) {
    if (contact.with_wall) continue;
    ++contacts;
    at_rest.mean_overlap += contact.overlap / hopper.diameter;
    at_rest.largest_overlap = std::max(at_rest.largest_overlap, contact.overlap / hopper.diameter);
  }
  at_rest.mean_overlap /= std::max(1, contacts);
  at_rest.solid_fraction = hopper.total_mass() / hopper.density /
                           (hopper.width * hopper.depth * (at_rest.height - hopper.diameter));
  return at_rest;
}

std::string HopperEngine::version() const { return text_of(hopper_); }

calibrate::EngineRun HopperEngine::run(const calibrate::SimulationSpec& spec,
                                       const calibrate::EngineOptions& options) const {
  const double started = thread_seconds();
  calibrate::EngineRun run;
  sim::Sampling sampling;
  sampling.should_stop = options.stop;
  sim::Simulation simulation = closed_simulation(hopper_, spec.seed, spec.time_step_fraction);
  const auto go_on_to = [&](double time) {
    const bool well = ended_well(simulation.run_until(time, sampling), options, run);
    run.seconds = thread_seconds() - started;
    return well;
  };

  // 1. The bed of this seed, settled with the friction of the spec
  const auto slot = static_cast<int>(simulation.scene_now().walls.size()) - 1;
  simulation.restore(filled_bed(hopper_, spec.seed, folder_));
  simulation.set_time_step(time_step_of(spec.time_step_fraction));
  const sim::SurfaceTable surfaces = surfaces_of(spec.parameters.of("friction_particle_particle"),
                                                 spec.parameters.of("friction_particle_wall"),
                                                 spec.parameters.of("restitution"),
                                                 spec.scene.surfaces.front().rolling_friction);
  for (const int other : {particle_material, wall_material})
    simulation.set_surfaces(particle_material, other, surfaces.of(particle_material, other));
  const double opening = simulation.time() + settling_time;
  if (!go_on_to(opening)) return run;
  simulation.open_wall(slot, opening);

  // 2. What has run out, sample by sample
  datasets::DischargeCurve curve{{0.0}, {0.0}};
  int taken_out = 0;
  const auto samples =
      static_cast<int>(std::ceil(spec.scene.phases.back().duration / sample_interval));
  for (int sample = 1; sample <= samples; ++sample) {
    const double time = sample * sample_interval;
    if (!go_on_to(opening + time)) return run;
    std::vector<int> fallen;
    int below = 0;
    const std::vector<sim::Vec3>& position = simulation.state().position;
    for (std::size_t i = 0; i < position.size(); ++i) {
      below += position[i].z() < 0.0;
      if (position[i].z() < -hopper_.diameter) fallen.push_back(static_cast<int>(i));
    }
    curve.time.push_back(time);
    curve.mass.push_back((taken_out + below) * hopper_.particle_mass());
    if (fallen.empty()) continue;
    simulation.remove_bodies(fallen);
    taken_out += static_cast<int>(fallen.size());
  }
  run.recording.discharge = std::move(curve);
  return run;
}

calibrate::Scene HopperEngine::scene(double rolling_friction, double duration) const {
  calibrate::SimulationSpec spec{.engine = std::string(name()), .engine_version = version()};
  spec.scene.surfaces = {{.rolling_friction = rolling_friction}};
  spec.scene.phases = {{.duration = duration}};
  return {.problem = calibrate::fingerprint_of(spec),
          .engine = this,
          .spec =
              [spec](const calibrate::ParameterSet& parameters, double fraction, auto seed) {
                calibrate::SimulationSpec one = spec;
                one.parameters = parameters;
                one.time_step_fraction = fraction;
                one.seed = seed;
                return one;
              },
          .measure =
              [hopper = hopper_](const datasets::Recording& recording) {
                const calibrate::Discharge discharge = calibrate::measure_discharge(
                    *recording.discharge, hopper.particles, rig_of(hopper));
                std::vector<calibrate::Channel> channels(1);
                calibrate::put_discharge(discharge, false, channels.front());
                return channels;
              }};
}

calibrate::Discharge discharge_of(const calibrate::SimulatedRun& run) {
  if (run.channels.empty()) return {};
  return calibrate::bulk_from([&](std::string_view observable) {
           return observable == "discharge_rate" ? &run.channels.front() : nullptr;
         })
      .discharge;
}

}  // namespace graintruth::bench
