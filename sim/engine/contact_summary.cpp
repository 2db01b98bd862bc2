#include "sim/engine/contact_summary.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace graintruth::sim {
namespace {

int count_different(std::vector<std::pair<int, int>>& pairs) {
  std::sort(pairs.begin(), pairs.end());
  return static_cast<int>(std::unique(pairs.begin(), pairs.end()) - pairs.begin());
}

}  // namespace

Partners count_partners(std::span<const ContactReport> contacts, std::span<const int> wall_group) {
  std::vector<std::pair<int, int>> between, with_walls;
  for (const ContactReport& contact : contacts) {
    if (!contact.with_wall) {
      between.emplace_back(contact.first, contact.second);
    } else {
      const int wall = wall_group.empty() ? contact.second : wall_group[contact.second];
      with_walls.emplace_back(contact.first, wall);
    }
  }
  return {count_different(between), count_different(with_walls)};
}

std::vector<double> normal_force_by_strip(std::span<const ContactReport> contacts,
                                          int wall,
                                          const Strips& strips) {
  std::vector<double> force(strips.count, 0.0);
  for (const ContactReport& contact : contacts) {
    if (!contact.with_wall || contact.second != wall) continue;
    const double strip = std::floor((contact.point.z() - strips.low) / strips.height());
    if (strip < 0.0 || strip >= strips.count) continue;
    force[static_cast<std::size_t>(strip)] += contact.normal_force;
  }
  return force;
}

}  // namespace graintruth::sim
