// One row of equal spheres above a plane: what most studies of chapter 3 look at.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "sim/simulation.h"

namespace graintruth::app {

inline constexpr double standard_gravity = 9.81;  // m/s2; as the thesis rounds it

struct LoneRow {
  int spheres = 1;
  double radius = 0.0;   // m
  double spacing = 0.0;  // m
  double mass = 0.0;     // kg
  sim::Material material;
  double friction = 0.0;
  double restitution = 1.0;
  bool is_upright = false;  // else along x
  sim::Vec3 gravity = sim::Vec3(0.0, 0.0, -standard_gravity);
  double gap = 0.0;  // m; between the lowest sphere and the plane
  sim::Vec3 velocity = sim::Vec3::Zero();
  double picture_spin = 0.0;  // rad/s
  double belt_speed = 0.0;    // m/s along x, of the plane's surface
};

// In the x-z plane, on a rigid plane at z = 0 (wall 0), with exactly this time step as far as it
// divides the time.
sim::Simulation on_plane(const LoneRow& row, double time_step, sim::SimulationOptions options = {});

// Steps of exactly this length, whatever the thesis's reasons for it. Throws std::invalid_argument
// where it is longer than Rayleigh's.
sim::TimeStepOptions exactly(double time_step);

// `count` numbers in [0, 1), spread by a seed and what they are for.
std::vector<double> shares_of_seed(std::uint64_t seed, std::string_view purpose, int count);

}  // namespace graintruth::app
