// Simulation: a scene in motion. Runs to a time, shows its state to an observer, stops when told or
// when a step cannot be trusted; the same scene and options give the same bits.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim/engine/snapshot.h"
#include "sim/engine/state.h"
#include "sim/laws/time_step.h"
#include "sim/scene.h"

namespace graintruth::sim {

enum class RunStatus { completed, unstable, timed_out };

struct SimulationOptions {
  TimeStepOptions time_step = {};
  NormalSpring normal_spring = NormalSpring::hertz;
  double linear_stiffness = 0.0;  // N/m; of every contact, with NormalSpring::linear alone
  TangentialSpring tangential_spring = TangentialSpring::mindlin;
  double tangential_stiffness = 0.0;  // N/m; with TangentialSpring::constant alone
  CoulombLimit coulomb_limit = CoulombLimit::whole;
  DampingForm damping_form = DampingForm::exact;
  Tension tension = Tension::clipped;
  DampingSharing damping_sharing = DampingSharing::inv_sqrt_n;
  double tangential_damping = 1.0;  // -; tangential over normal damping ratio, 0 for none
  double global_damping = 0.0;      // 1/s; f of thesis 1.76-1.83, for settling
  double skin = 0.0;                // m; how far apart candidates may be; 0: follows the motion
  double largest_move =
      0.1;  // smallest radii a step, rotation of the ends included (thesis 2.5.5, 6.1-ii)
  double largest_overlap = 0.1;         // of the smaller radius
  std::int64_t largest_step_count = 0;  // of one run_until; 0 for no limit
  // Workers on one bed; pays from some thousand bodies on. The same bits come out for any number.
  int threads = 1;
  bool tally_work = false;  // book the work of dashpots and friction; slows each step a little
  bool keep_peaks = false;  // look at every contact of every step for Simulation::take_peaks
};

void check(const SimulationOptions& options);

struct RunSummary {
  RunStatus status = RunStatus::completed;
  std::string message;         // empty when completed
  double time = 0.0;           // s; reached
  std::int64_t steps = 0;      // of this run
  double time_step = 0.0;      // s; of the last step
  double mean_contacts = 0.0;  // touching contacts a step, walls included, of this run
  std::int64_t searches = 0;   // contact searches of this run
};

// When the observer is called: at the start time plus whole multiples of the interval (s) up to the
// end; the time step is shortened so that it divides the interval. 0: only at the end.
struct Sampling {
  double interval = 0.0;
  std::function<void(const State&)> observer = nullptr;
  // Asked every few hundred steps; true ends the run as timed_out. Keeps clocks out of the
  // simulation.
  std::function<bool()> should_stop = nullptr;
};

// All in J. Losses are booked only with SimulationOptions::tally_work.
struct Energy {
  double kinetic = 0.0;
  double gravity = 0.0;        // relative to z = 0 (along the direction of gravity)
  double elastic = 0.0;        // normal and tangential springs
  double damping_loss = 0.0;   // normal dashpots
  double friction_loss = 0.0;  // sliding and tangential dashpots
  double wall_work = 0.0;      // done by moving walls on the bodies
  double total() const { return kinetic + gravity + elastic; }
};

// One touching pair, as the next step will see it.
struct ContactReport {
  int first = 0;   // body
  int second = 0;  // body or wall
  bool with_wall = false;
  int first_sphere = 0;                  // counted from the first of its body
  int second_sphere = 0;                 // as above; 0 with walls
  double overlap = 0.0;                  // m
  Vec3 normal = Vec3::Zero();            // unit, from first to second
  Vec3 point = Vec3::Zero();             // m; in the middle of the overlap
  double normal_force = 0.0;             // N; pushes apart
  Vec3 tangential_force = Vec3::Zero();  // N; on the second
  bool slides = false;
};

// Running maxima over all contacts of all steps, so that no peak falls between two looks.
struct ContactPeaks {
  double normal_force = 0.0;  // N; of one contact
  double time = 0.0;          // s; when
  int first = -1;             // body
  int second = -1;            // body or wall
  bool with_wall = false;
  std::vector<double> of_body;  // N; of the contacts of each body
  std::vector<double> of_wall;  // N; of the contacts of each wall
};

class Simulation {
 public:
  // Throws std::invalid_argument when scene or options are unusable, or when bodies start deeper in
  // each other or in a wall than SimulationOptions::largest_overlap.
  // A large scene that is no longer needed is moved in.
  explicit Simulation(Scene scene, const SimulationOptions& options = {});
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  // Runs until `time` (s). After an unstable step every value is still finite.
  RunSummary run_until(double time, const Sampling& sampling = {});

  const State& state() const;
  double time() const;
  double time_step() const;  // s; the longest that run_until will take

  // Between runs, without losing the state of the contacts.
  void set_surfaces(int first_material, int second_material, const Surfaces& surfaces);
  void set_global_damping(double per_second);
  void set_time_step(const TimeStepOptions& options);
  // Makes a wall move from now on, or at a later time; its place so far is kept.
  void set_wall_motion(int wall, const WallMotion& motion);
  // Makes the surface of a wall move from now on, or at a later time, while the wall stays.
  void set_wall_drag(int wall, const WallMotion& drag);
  // Takes a wall away at a time (s); now, when that is past.
  void open_wall(int wall, double time);
  void clear_velocities();
  // Places more bodies; they get the next indices. What is in motion goes on, contacts included.
  // Throws std::invalid_argument as check(Scene) does.
  void add_bodies(const std::vector<Body>& bodies);
  // Takes bodies out, such as those that have fallen out of a bin; the others keep their order and
  // their contacts, and get the indices that close the gaps. Throws std::invalid_argument for an
  // index that no body has, or when none would be left.
  void remove_bodies(const std::vector<int>& indices);

  // Everything that decides how it goes on. A simulation of the same scene and options that has
  // been put back to a snapshot goes on with the same bits, whatever it did before.
  Snapshot save() const;
  // Throws std::invalid_argument when the snapshot is of another scene.
  void restore(const Snapshot& snapshot);

  Energy energy() const;
  std::vector<ContactReport> contacts() const;
  // The largest normal forces since the last call, or the start. Empty without
  // SimulationOptions::keep_peaks; after bodies were added or taken out those so far are lost.
  ContactPeaks take_peaks();
  // Force of all contacts on a wall in the last step, N.
  Vec3 wall_force(int wall) const;
  // A scene whose bodies and walls are where this simulation has brought them.
  Scene scene_now() const;
  // Of every bit of positions, orientations, velocities and springs.
  std::uint64_t state_hash() const;

 private:
  struct Engines;
  std::unique_ptr<Engines> engines_;
};

}  // namespace graintruth::sim
