// An overlap-free start from poses that overlap a little, such as measured ones: bodies are moved
// as little as needed.
#pragma once

#include "sim/scene.h"

namespace graintruth::sim {

struct RelaxationOptions {
  // m; what is left may be this deep. 0: the static overlap of one body resting on its stiffest
  // contact.
  double allowed_overlap = 0.0;
  int largest_sweep_count = 20000;
  double time = 0.0;  // s; at which the walls stand
};

struct RelaxationSummary {
  bool converged = false;
  int sweeps = 0;
  double overlap_before = 0.0;  // m; deepest
  double overlap_after = 0.0;   // m
  double largest_move = 0.0;    // m; of a centre of mass
  double largest_turn = 0.0;    // rad
  int worst_body = -1;          // the one that moved farthest
};

// Position-based projection over translations and rotations (Mueller et al. 2007), sweep after
// sweep in a fixed order, until no contact between bodies or with walls is deeper than allowed.
// Changes positions and orientations of the bodies only.
RelaxationSummary relax_overlaps(Scene& scene, const RelaxationOptions& options = {});

// Deepest overlap of any two spheres of different bodies, or of a sphere and a wall, m; 0 when
// nothing overlaps.
double deepest_overlap(const Scene& scene, double time = 0.0);

}  // namespace graintruth::sim
