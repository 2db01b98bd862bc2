// How other engines' own damping laws rebound when asked for a restitution: what their
// sources compute, checked against LAMMPS of September 2021, LIGGGHTS 3.8.0 and YADE 2023.02a.
#pragma once

#include <functional>
#include <optional>

namespace graintruth::calibrate {

// Rebound speed over impact speed of a particle that meets a wall with `contacts` equal contacts at
// once.
double liggghts_rebound(double restitution, int contacts);
double lammps_rebound(double restitution, int contacts);
// `mass_share`: mass of the element sphere in contact over that of the particle.
double yade_rebound(double restitution, int contacts, double mass_share);

// What to ask an engine for so that it rebounds by `wanted`; nothing where no value does.
std::optional<double> restitution_to_ask(const std::function<double(double)>& rebound,
                                         double wanted);

}  // namespace graintruth::calibrate
