// Short runs whose state hash must be the same in every build: release, debug and sanitize.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/simulation.h"
#include "tests/sim/scenes.h"

namespace graintruth::sim {

struct HashedRun {
  const char* name;
  Scene scene;
  SimulationOptions options;
  double duration;  // s
  std::uint64_t hash() const {
    Simulation simulation(scene, options);
    simulation.run_until(duration);
    return simulation.state_hash();
  }
};

inline std::vector<HashedRun> hashed_runs() {
  const Surfaces surfaces{.friction = 0.3, .restitution = 0.6};
  Surfaces held = surfaces;
  held.static_friction = 0.5;
  Surfaces rolling = surfaces;
  rolling.rolling_friction = 0.05;
  Scene rig = scenes::micro_rig();
  relax_overlaps(rig);
  const scenes::BedSize flat{.columns = 8, .rows = 6, .depth = 1, .spheres = 3};
  const scenes::BedSize deep{.columns = 4, .rows = 4, .depth = 4, .spheres = 3};
  const scenes::BedSize balls{.columns = 5, .rows = 5, .depth = 5, .spheres = 1};
  return {{"micro rig, default law", rig, {}, 0.1},
          {"bed in the layer, default law", scenes::falling_bed(flat, true, surfaces), {}, 0.1},
          {"bed in space, default law", scenes::falling_bed(deep, false, surfaces), {}, 0.1},
          {"balls in space, default law", scenes::falling_bed(balls, false, surfaces), {}, 0.1},
          {"bed in the layer, thesis's law, static friction",
           scenes::falling_bed(flat, true, held),
           {.coulomb_limit = CoulombLimit::spring,
            .damping_form = DampingForm::thesis,
            .tension = Tension::allowed,
            .damping_sharing = DampingSharing::none},
           0.1},
          {"bed in space, linear springs, global damping",
           scenes::falling_bed(deep, false, surfaces),
           {.normal_spring = NormalSpring::linear,
            .linear_stiffness = 1e4,
            .tangential_spring = TangentialSpring::constant,
            .tangential_stiffness = 8e3,
            .global_damping = 1.0},
           0.1},
          {"bed in space, rolling friction, scaled tangential springs",
           scenes::falling_bed(deep, false, rolling),
           {.tangential_spring = TangentialSpring::mindlin_scaled},
           0.1}};
}

}  // namespace graintruth::sim
