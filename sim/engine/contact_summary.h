// What the contacts of a moment say about the bed: who touches whom, and how hard it leans on a
// wall.
#pragma once

#include <span>
#include <vector>

#include "sim/simulation.h"

namespace graintruth::sim {

// Several contacts between the same two bodies, or of a body with the same wall, are one partner.
struct Partners {
  int body_pairs = 0;
  int wall_pairs = 0;
  // Coordination number: partners a body, walls included (thesis fig. 5.6).
  double per_body(int bodies) const {
    return bodies > 0 ? (2.0 * body_pairs + wall_pairs) / bodies : 0.0;
  }
};

// `wall_group` says which walls count as one, such as the facets of a mesh; without it each wall is
// its own.
Partners count_partners(std::span<const ContactReport> contacts,
                        std::span<const int> wall_group = {});

// Strips of equal height one above the other, from z = `low` to `high` (m).
struct Strips {
  double low = 0.0, high = 0.0;
  int count = 10;
  double height() const { return (high - low) / count; }
};

// Normal force on one wall by strips, N; what touches it below or above them is left out. Divided
// by the area of a strip it is the wall's pressure.
std::vector<double> normal_force_by_strip(std::span<const ContactReport> contacts,
                                          int wall,
                                          const Strips& strips);

}  // namespace graintruth::sim
