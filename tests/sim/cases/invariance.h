// The micro rig seen from elsewhere: how far two runs of the same physics come apart.
#pragma once

#include <span>
#include <vector>

#include "tests/sim/cases/check.h"

namespace graintruth::sim::cases {

// How long the runs are, s. Half a second of the rig is chaotic; the first hundredths are not, and
// have every kind of contact in them.
constexpr double kInvarianceTime = 0.03;
// Round-off of 1e-17 m grown through some twenty contacts, and what it does to angles.
constexpr double kClosePlaces = 1e-10;  // m
constexpr double kCloseAngles = 1e-7;   // rad

struct Apart {
  double place = 0.0;  // m; largest of all bodies
  double angle = 0.0;  // rad
};

Apart apart_in_space();                              // instead of in the layer
Apart apart_turned(double angle);                    // the whole scene, in the picture
Apart apart_mirrored();                              // left and right
Apart apart_renumbered(std::span<const int> order);  // bodies in this order, walls backwards
Apart apart_doubled();      // lengths x 2, densities and stiffness kept, g x 1/2, times x 2
Apart apart_in_cm_and_g();  // the same numbers in centimetres and grams

std::vector<Check> invariance_checks();

}  // namespace graintruth::sim::cases
