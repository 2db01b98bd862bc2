// State: where every body is and how it moves, one array per quantity, in world axes and SI units.
#pragma once

#include <vector>

#include "sim/types.h"

namespace graintruth::sim {

struct State {
  double time = 0.0;                   // s
  std::vector<Vec3> position;          // m
  std::vector<Quat> orientation;       // world from body
  std::vector<Vec3> velocity;          // m/s
  std::vector<Vec3> angular_velocity;  // rad/s, right-handed
  std::vector<double> picture_angle;   // rad, unwrapped; empty unless the scene is planar
};

}  // namespace graintruth::sim
