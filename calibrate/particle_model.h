// What stands for a particle of an experiment in every simulation of it.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "datasets/experiment.h"

namespace graintruth::calibrate {

// The element spheres, along the long axis: those of the experiment file; of a plate without any
// seven inscribed in its outline (thesis Appendix E), of a disc one of the same area.
std::vector<datasets::AxialSphere> element_spheres(const datasets::Particle& particle);

// Principal moments of inertia, kg m2, about the axes along the long axis, across the picture and
// upright to the long axis in the picture, where they are not those of the union of the spheres: a
// plate has those of a flat ellipse of its thickness, whatever spheres stand for it.
std::optional<std::array<double, 3>> stated_inertia(const datasets::Particle& particle);

}  // namespace graintruth::calibrate
