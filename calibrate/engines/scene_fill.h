// Particles into a scene: where the scene puts them, on a lattice, or raining in one by one.
#pragma once

#include <boost/random/mersenne_twister.hpp>
#include <optional>
#include <vector>

#include "calibrate/engines/scene_build.h"

namespace graintruth::calibrate {

using Generator = boost::random::mt19937_64;

// The types of all counted particles, in random order.
std::vector<int> draw_types(const datasets::SceneFile& file,
                            const BuiltScene& built,
                            Generator& generator);

// The particles that the scene places itself.
void add_places(const datasets::SceneFile& file, BuiltScene& built);

// One of each type on the sites of a simple cubic (in the plane square) lattice from below, where
// neither walls nor other bodies are near and nothing stands between the site and the top of the
// region. The pitch is the largest enclosing diameter plus the
// clearance. Throws datasets::InputError when the region has too few sites.
void add_lattice(const datasets::SceneFile& file,
                 const std::vector<int>& types,
                 Generator& generator,
                 BuiltScene& built);

// A body of this type at the top of the region, at a random place free of walls and of bodies;
// nothing when none was found in many tries.
std::optional<sim::Body> rain_drop(const datasets::SceneFile& file,
                                   const BuiltScene& built,
                                   const sim::Scene& now,
                                   int type,
                                   Generator& generator);

// Throws datasets::InputError naming the first body that overlaps a wall or another body by more
// than a particle does that rests on the ground, or that lies behind a plane.
void check_start(const datasets::SceneFile& file, const BuiltScene& built);

}  // namespace graintruth::calibrate
