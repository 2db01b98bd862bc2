// A flat-bottomed box of spheres with a slot in its floor, in space: filled once a seed, opened at
// time 0, and what runs out recorded against time.
#pragma once

#include <filesystem>
#include <string>

#include "calibrate/dem_simulator.h"
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

// Every number of it and of how it is simulated: two that differ have other beds and other runs.
std::string text_of(const Hopper& hopper);

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

// A run of `duration` (s) from the bed of the request's seed: settled with the friction of the
// request and this friction against rolling, on spheres and walls alike, then the slot opened at
// once over its whole width. A sphere has left when its centre is below the floor, and is taken out
// a diameter further down.
calibrate::Simulator make_hopper_simulator(const Hopper& hopper,
                                           double rolling_friction,
                                           double duration,
                                           const std::filesystem::path& folder);

// What ran out of such a run. Runs are sampled, and of one read back from the journal it is no
// longer known how many leave between two samples: their times say nothing of how regularly they
// left.
calibrate::Discharge discharge_of(const calibrate::SimulatedRun& run);

}  // namespace graintruth::bench
