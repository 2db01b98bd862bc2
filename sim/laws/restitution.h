// Damping ratio that makes a damped Hertz contact rebound with an asked coefficient of restitution.
#pragma once

#include "sim/laws/material.h"

namespace graintruth::sim {

// Coefficient of restitution of a central impact with damping ratio beta, independent of speed,
// mass and stiffness.
double restitution_of(double damping_ratio,
                      Tension tension,
                      NormalSpring spring = NormalSpring::hertz);

// The damping ratio beta whose impact rebounds with `restitution`, in (0, 1]. Throws
// std::invalid_argument when no damping ratio up to 100 rebounds so little.
double damping_ratio_for(double restitution,
                         Tension tension,
                         NormalSpring spring = NormalSpring::hertz);

}  // namespace graintruth::sim
