#include "calibrate/engines/scene_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>

#include "datasets/store/input_error.h"

namespace graintruth::calibrate {

namespace {

using datasets::InputError;
using datasets::SceneFile;
using datasets::ScenePhase;

// Frames are kept until the end; more than this would not fit beside anything else.
constexpr double most_frame_bytes = 2e9;
constexpr double bytes_a_body = 13 * sizeof(double);

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

// Keeps every frame whole.
class WholeRun final : public SceneRunner {
 public:
  WholeRun(const SceneFile& file, const SceneRunOptions& options)
      : SceneRunner(file, file.file.string(), options), file_(file) {
    warnings_.insert(warnings_.begin(), file.warnings.begin(), file.warnings.end());
  }

  SceneRun run() {
    run_phases();
    run_.status = status_;
    run_.message = message_;
    run_.event_time = event_time_;
    run_.reached_event = reached_event_;
    run_.phases = phases_;
    run_.warnings = warnings_;
    run_.scene = simulation_->scene_now();
    note_lost_particles();
    run_.kinds = built_.kinds;
    run_.owner = built_.owner;
    run_.contacts = simulation_->contacts();
    return std::move(run_);
  }

 private:
  void choose(sim::SimulationOptions& options) const override {
    options.tally_work = true;
    options.keep_peaks = true;
  }

  bool fill() override {
    std::size_t bodies = file_.places.size();
    for (const datasets::SceneParticle& particle : file_.particles)
      bodies += static_cast<std::size_t>(particle.count);
    refuse_too_many_frames(bodies);
    return SceneRunner::fill();
  }

  void on_event() override { run_.strips = strips_of_bed(); }

  // The end of one stretch is the start of the next: kept once.
  void on_frame(const sim::State& state) override {
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
    if (!reached_event_) return;
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
    return reached_event_ &&
           std::any_of(file_.walls.begin(), file_.walls.end(), [](const datasets::SceneWall& wall) {
             return !wall.motion.velocity.isZero(0.0) ||
                    !wall.motion.angular_velocity.isZero(0.0) || std::isfinite(wall.opens_at);
           });
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
  SceneRun run_;
};

}  // namespace

const std::vector<sim::Wall>& SceneRun::walls_at(std::size_t frame) const {
  while (frame > 0 && frames[frame].walls.empty()) --frame;
  return frames[frame].walls;
}

SceneRun run_scene(const SceneFile& file, const SceneRunOptions& options) {
  try {
    return WholeRun(file, options).run();
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format("{}: {}.", file.file.string(), error.what()));
  }
}

}  // namespace graintruth::calibrate
