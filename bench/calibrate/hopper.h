// A flat-bottomed box of spheres with a slot in its floor, in space: filled once a seed, opened at
// time 0, and what runs out recorded against time.
#pragma once

#include <filesystem>
#include <string>

#include "calibrate/ensemble.h"
#include "calibrate/flow/bulk_measure.h"
#include "sim/simulation.h"

namespace graintruth::bench {

struct Hopper {
  // What is known of the box and of the spheres in it
  double width = 0.2;       // m, along x
  double depth = 0.04;      // m, along y; walls in front and behind, the slot reaches over it
  double slot = 0.04;       // m, along x
  int particles = 13018;    // -
  double diameter = 0.006;  // m
  double density = 1592.0;  // kg/m3

  // Pa; of spheres and walls. Not the plastic's: so soft that a run takes minutes, so hard that
  // spheres at rest overlap by less than a hundredth of their diameter in the mean.
  double youngs_modulus = 5.0e6;
  double poisson_ratio = 0.3;
  // -; with what friction a bed is poured, whatever is tried later: so it is filled once a seed
  double filling_friction = 0.3;

  double particle_mass() const;  // kg
  double total_mass() const { return particles * particle_mass(); }
};

// For the measures of a discharge, which know the picture plane alone.
calibrate::BulkRig rig_of(const Hopper& hopper);

// The bed of a seed at rest on the closed slot: rows of spheres that touch neither each other nor
// the walls fall with random velocities. Kept as a file of `folder`, and read from there when it is
// asked for again. Throws std::runtime_error where the filling goes wrong.
sim::Snapshot filled_bed(const Hopper& hopper,
                         std::uint64_t seed,
                         const std::filesystem::path& folder);

// What a bed at rest is like.
struct BedAtRest {
  double height = 0.0;           // m; of the highest sphere's top
  double solid_fraction = 0.0;   // - of the box up to there less a diameter
  double mean_overlap = 0.0;     // of the diameter; over contacts between spheres
  double largest_overlap = 0.0;  // of the diameter
  double fastest = 0.0;          // m/s
};
BedAtRest look_at_bed(const Hopper& hopper, std::uint64_t seed, const sim::Snapshot& bed);

// Simulates such a box. Of a spec it reads parameters, step and seed, the friction against rolling
// of the first surfaces, for spheres and walls alike, and the duration of the last phase. From the
// bed of the seed: settled with the friction of the spec, then the slot opened at once over its
// whole width. A sphere has left when its centre is below the floor, and is taken out a diameter
// further down. Records the discharge.
class HopperEngine final : public calibrate::Engine {
 public:
  // Beds are kept in the folder.
  HopperEngine(const Hopper& hopper, std::filesystem::path folder)
      : hopper_(hopper), folder_(std::move(folder)) {}

  std::string_view name() const override { return "hopper"; }
  // Every number of the box and of how it is simulated: two that differ give other runs.
  std::string version() const override;
  std::vector<std::string> curves(const calibrate::SimulationSpec&) const override { return {}; }
  double largest_time_step_fraction(const calibrate::SimulationSpec&) const override { return 1.0; }
  calibrate::EngineRun run(const calibrate::SimulationSpec& spec,
                           const calibrate::EngineOptions& options) const override;

  // What an ensemble simulates with it: `duration` in s.
  calibrate::Scene scene(double rolling_friction, double duration) const;

 private:
  Hopper hopper_;
  std::filesystem::path folder_;
};

// What ran out of a run.
calibrate::Discharge discharge_of(const calibrate::SimulatedRun& run);

}  // namespace graintruth::bench
