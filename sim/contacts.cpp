#include "sim/contacts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/contact_batch.h"

namespace graintruth::sim {
namespace {

bool comes_before(const ContactGroup& a, const ContactGroup& b) {
  return a.first != b.first ? a.first < b.first : a.second < b.second;
}

// Both lists are sorted by (first, second) and, inside a group, by sphere: one walk through both.
template <int D>
void keep_springs(const ContactList<D>& old_list, ContactList<D>& new_list) {
  std::size_t old_index = 0;
  for (const ContactGroup& group : new_list.groups) {
    while (old_index < old_list.groups.size() && comes_before(old_list.groups[old_index], group)) {
      ++old_index;
    }
    if (old_index == old_list.groups.size()) return;
    const ContactGroup& old_group = old_list.groups[old_index];
    if (comes_before(group, old_group)) continue;
    int k = old_group.begin;
    for (int c = group.begin; c < group.end; ++c) {
      const auto key = std::pair(new_list.first_sphere[c], new_list.second_sphere[c]);
      while (k < old_group.end &&
             std::pair(old_list.first_sphere[k], old_list.second_sphere[k]) < key) {
        ++k;
      }
      if (k == old_group.end) break;
      if (std::pair(old_list.first_sphere[k], old_list.second_sphere[k]) != key) continue;
      new_list.spring[c] = old_list.spring[k];
      new_list.is_touching[c] = old_list.is_touching[k];
      if (new_list.remembers()) new_list.memory[c] = old_list.memory[k];
    }
  }
}

// The row after the last contact of a batch is written ahead.
constexpr int kLargestRange = kBatchRows - 1;

void add_to_ranges(int begin, int end, std::vector<CandidateRange>& ranges) {
  const auto fits = [&](const CandidateRange& range) {
    return !range.is_part && range.end - range.begin < kCandidatesInRange &&
           end - range.begin <= kLargestRange;
  };
  if (end - begin > kLargestRange) {
    for (int part = begin; part < end; part += kLargestRange) {
      ranges.push_back({part, std::min(part + kLargestRange, end), true});
    }
  } else if (!ranges.empty() && fits(ranges.back())) {
    ranges.back().end = end;
  } else {
    ranges.push_back({begin, end, false});
  }
}

}  // namespace

template <int D>
void ContactList<D>::clear() {
  groups.clear();
  ranges.clear();
  group_of.clear();
  first_sphere.clear();
  second_sphere.clear();
  reach.clear();
  stiffness_factor.clear();
  spring.clear();
  is_touching.clear();
  memory.clear();
}

template <int D>
void ContactList<D>::remember(bool yes) {
  if (remembers_ == yes) return;
  remembers_ = yes;
  memory.assign(yes ? reach.size() : 0, {});
}

template <int D>
void ContactList<D>::add(int first, int second, double sum_of_radii, double factor) {
  first_sphere.push_back(first);
  second_sphere.push_back(second);
  reach.push_back(sum_of_radii);
  stiffness_factor.push_back(factor);
  spring.push_back(Motion<D>::no_tangent());
  is_touching.push_back(0);
  if (remembers_) memory.emplace_back();
}

template <int D>
void ContactList<D>::close_group(int first, int second, int pair, double reduced_mass) {
  const int begin = groups.empty() ? 0 : groups.back().end;
  const int end = count();
  if (end == begin) return;
  add_to_ranges(begin, end, ranges);
  group_of.resize(end, static_cast<int>(groups.size()));
  groups.push_back({first, second, begin, end, pair, reduced_mass});
}

template <int D>
void ContactSearch<D>::find(const Bodies<D>& bodies,
                            const std::vector<Wall>& walls,
                            const PairTable& pairs,
                            int material_count,
                            double margin,
                            ContactList<D>& between_bodies,
                            ContactList<D>& with_walls) {
  new_between_.remember(between_bodies.remembers());
  new_walls_.remember(with_walls.remembers());
  find_pairs(bodies, pairs, material_count, margin);
  find_walls(bodies, walls, pairs, material_count, margin);
  keep_springs(between_bodies, new_between_);
  keep_springs(with_walls, new_walls_);
  std::swap(between_bodies, new_between_);
  std::swap(with_walls, new_walls_);
}

template <int D>
void ContactSearch<D>::find_pairs(const Bodies<D>& bodies,
                                  const PairTable& pairs,
                                  int material_count,
                                  double margin) {
  new_between_.clear();
  centres_.resize(bodies.motion.size());
  for (int i = 0; i < bodies.count(); ++i) centres_[i] = to_eigen(bodies.motion[i].position);
  find_near_pairs<D>(centres_, bodies.bounding_radius, margin, cells_, near_);
  for (const IndexPair& near : near_) {
    const int i = near.first, j = near.second;
    const int pair = bodies.material[i] * material_count + bodies.material[j];
    const double modulus = pairs[pair].normal_modulus;
    for (int s = bodies.first_sphere[i]; s < bodies.first_sphere[i + 1]; ++s) {
      for (int t = bodies.first_sphere[j]; t < bodies.first_sphere[j + 1]; ++t) {
        const double rs = bodies.sphere_radius[s], rt = bodies.sphere_radius[t];
        const double far = rs + rt + margin;
        const auto apart = bodies.sphere_position[t] - bodies.sphere_position[s];
        if (dot(apart, apart) >= far * far) continue;
        // 1/R* = 1/R1 + 1/R2 (thesis 1.4)
        new_between_.add(s, t, rs + rt, 2.0 * modulus * std::sqrt(rs * rt / (rs + rt)));
      }
    }
    new_between_.close_group(
        i, j, pair, bodies.mass[i] * bodies.mass[j] / (bodies.mass[i] + bodies.mass[j]));
  }
}

template <int D>
void ContactSearch<D>::find_walls(const Bodies<D>& bodies,
                                  const std::vector<Wall>& walls,
                                  const PairTable& pairs,
                                  int material_count,
                                  double margin) {
  new_walls_.clear();
  wall_boxes_.clear();
  for (const Wall& wall : walls) wall_boxes_.push_back(box_of(wall));
  for (int i = 0; i < bodies.count(); ++i) {
    const Vec3 centre = to_space(to_eigen(bodies.motion[i].position), bodies.layer);
    for (int w = 0; w < static_cast<int>(walls.size()); ++w) {
      const double reach = bodies.bounding_radius[i] + margin;
      if (wall_boxes_[w].distance_bound(centre) >= reach) continue;
      if (look_at(walls[w], centre).distance >= reach) continue;
      const int pair = bodies.material[i] * material_count + walls[w].material;
      for (int s = bodies.first_sphere[i]; s < bodies.first_sphere[i + 1]; ++s) {
        const double radius = bodies.sphere_radius[s];
        const Vec3 point = to_space(to_eigen(bodies.sphere_position[s]), bodies.layer);
        if (look_at(walls[w], point).distance >= radius + margin) continue;
        // R* = R1 at a flat wall
        new_walls_.add(s, 0, radius, 2.0 * pairs[pair].normal_modulus * std::sqrt(radius));
      }
      new_walls_.close_group(i, w, pair, bodies.mass[i]);
    }
  }
}

template struct ContactList<2>;
template struct ContactList<3>;
template class ContactSearch<2>;
template class ContactSearch<3>;

}  // namespace graintruth::sim
