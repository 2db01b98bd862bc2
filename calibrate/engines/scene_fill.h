// Particles into a scene: where the scene puts them, on a lattice, or raining in one by one.
#pragma once

#include <boost/random/mersenne_twister.hpp>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "calibrate/engines/scene_build.h"
#include "datasets/store/trajectories.h"

namespace graintruth::calibrate {

using Generator = boost::random::mt19937_64;

// The types of all counted particles, in random order.
std::vector<int> draw_types(const datasets::SceneData& file,
                            const BuiltScene& built,
                            Generator& generator);

// The particles that the scene places itself.
void add_places(const datasets::SceneData& file, BuiltScene& built);

// One of each type on the sites of a simple cubic (in the plane square) lattice from below, where
// neither walls nor other bodies are near and nothing stands between the site and the top of the
// region. The pitch is the largest enclosing diameter plus the
// clearance. Throws datasets::InputError when the region has too few sites.
void add_lattice(const datasets::SceneData& file,
                 const std::vector<int>& types,
                 Generator& generator,
                 BuiltScene& built);

// Where the counted particles of a planar scene begin that are filled in rows, one a particle.
std::vector<datasets::Pose> rows_of(const datasets::SceneData& file, std::uint64_t seed);

// Bodies of these types in one layer, at these poses of the centres of mass plus a draw of their
// spread, moved apart where they overlap. What is left of the overlap, m; 0 where nothing is.
double place_poses(std::span<const datasets::Pose> poses,
                   const datasets::Pose& standard_deviation,
                   std::span<const int> types,
                   Generator& generator,
                   BuiltScene& built);

// A body of this type at the top of the region, at a random place free of walls and of bodies;
// nothing when none was found in many tries.
std::optional<sim::Body> rain_drop(const datasets::SceneData& file,
                                   const BuiltScene& built,
                                   const sim::Scene& now,
                                   int type,
                                   Generator& generator);

// Throws datasets::InputError naming the first body that overlaps a wall or another body by more
// than a particle does that rests on the ground, or that lies behind a plane.
void check_start(const datasets::SceneData& file, const BuiltScene& built);

}  // namespace graintruth::calibrate
