#include "sim/contacts.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "sim/contact_batch.h"

namespace graintruth::sim {
namespace {

// A contact that touches, while the list that holds it is made anew. Of a list of millions only
// these are needed, a fraction of it.
template <int D>
struct TouchingContact {
  int first, second;  // body; body or wall
  int first_sphere, second_sphere;
  int state;
  typename Motion<D>::Tangent spring;
};

// In the order of the list: by bodies, then by spheres.
template <int D>
struct TouchingContacts {
  std::vector<TouchingContact<D>> contacts;
  std::vector<ContactMemory<D>> memory;  // one each, or none

  explicit TouchingContacts(const ContactList<D>& list) {
    for (const ContactGroup& group : list.groups) {
      for (int c = group.begin; c < group.end; ++c) {
        if (list.is_touching[c] == kOpen) continue;
        contacts.push_back({group.first,
                            group.second,
                            list.first_sphere[c],
                            list.second_sphere[c],
                            list.is_touching[c],
                            list.spring[c]});
        if (list.remembers()) memory.push_back(list.memory[c]);
      }
    }
  }

  // Every kept contact is still a candidate, or has parted since: one walk through both.
  void put_into(ContactList<D>& list) const {
    std::size_t next = 0;
    for (const ContactGroup& group : list.groups) {
      for (int c = group.begin; c < group.end && next < contacts.size(); ++c) {
        const auto key =
            std::tuple(group.first, group.second, list.first_sphere[c], list.second_sphere[c]);
        while (next < contacts.size() && key_of(contacts[next]) < key) ++next;
        if (next == contacts.size()) return;
        if (key_of(contacts[next]) != key) continue;
        list.spring[c] = contacts[next].spring;
        list.is_touching[c] = contacts[next].state;
        if (list.remembers()) list.memory[c] = memory[next];
      }
    }
  }

 private:
  static std::tuple<int, int, int, int> key_of(const TouchingContact<D>& contact) {
    return {contact.first, contact.second, contact.first_sphere, contact.second_sphere};
  }
};

// The row after the last contact of a batch is written ahead.
constexpr int kLargestRange = kBatchRows - 1;

void add_to_ranges(int begin, int end, bool in_new_slab, std::vector<CandidateRange>& ranges) {
  const auto fits = [&](const CandidateRange& range) {
    return !range.is_part && range.end - range.begin < kCandidatesInRange &&
           end - range.begin <= kLargestRange;
  };
  if (end - begin > kLargestRange) {
    for (int part = begin; part < end; part += kLargestRange) {
      ranges.push_back({part, std::min(part + kLargestRange, end), true});
    }
  } else if (!in_new_slab && !ranges.empty() && fits(ranges.back())) {
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
  const bool in_new_slab = !groups.empty() && slab_of(groups.back().first) != slab_of(first);
  add_to_ranges(begin, end, in_new_slab, ranges);
  group_of.resize(end, static_cast<int>(groups.size()));
  groups.push_back({first, second, begin, end, pair, reduced_mass});
}

template <int D>
void ContactList<D>::find_slabs(int slab_count) {
  first_range.assign(slab_count + 1, 0);
  for (const CandidateRange& range : ranges) {
    ++first_range[slab_of(groups[group_of[range.begin]].first) + 1];
  }
  for (int slab = 0; slab < slab_count; ++slab) first_range[slab + 1] += first_range[slab];
}

template <int D>
void ContactSearch<D>::find(const Bodies<D>& bodies,
                            const std::vector<Wall>& walls,
                            const PairTable& pairs,
                            int material_count,
                            double margin,
                            ContactList<D>& between_bodies,
                            ContactList<D>& with_walls) {
  const TouchingContacts<D> touching(between_bodies), touching_walls(with_walls);
  find_pairs(bodies, pairs, material_count, margin, between_bodies);
  find_walls(bodies, walls, pairs, material_count, margin, with_walls);
  between_bodies.find_slabs(slab_count_of(bodies.count()));
  with_walls.find_slabs(slab_count_of(bodies.count()));
  touching.put_into(between_bodies);
  touching_walls.put_into(with_walls);
}

template <int D>
void ContactSearch<D>::find_pairs(const Bodies<D>& bodies,
                                  const PairTable& pairs,
                                  int material_count,
                                  double margin,
                                  ContactList<D>& list) {
  list.clear();
  centres_.resize(bodies.motion.size());
  for (int i = 0; i < bodies.count(); ++i) centres_[i] = to_eigen(bodies.motion[i].position);
  visit_near_pairs<D>(
      centres_, bodies.bounding_radius, margin, cells_, [&](std::span<const IndexPair> of_body) {
        for (const IndexPair& near : of_body) {
          add_pair(bodies, near, pairs, material_count, margin, list);
        }
      });
}

template <int D>
void ContactSearch<D>::add_pair(const Bodies<D>& bodies,
                                const IndexPair& near,
                                const PairTable& pairs,
                                int material_count,
                                double margin,
                                ContactList<D>& list) {
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
      list.add(s, t, rs + rt, 2.0 * modulus * std::sqrt(rs * rt / (rs + rt)));
    }
  }
  list.close_group(i, j, pair, bodies.mass[i] * bodies.mass[j] / (bodies.mass[i] + bodies.mass[j]));
}

template <int D>
void ContactSearch<D>::find_walls(const Bodies<D>& bodies,
                                  const std::vector<Wall>& walls,
                                  const PairTable& pairs,
                                  int material_count,
                                  double margin,
                                  ContactList<D>& list) {
  list.clear();
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
        list.add(s, 0, radius, 2.0 * pairs[pair].normal_modulus * std::sqrt(radius));
      }
      list.close_group(i, w, pair, bodies.mass[i]);
    }
  }
}

template struct ContactList<2>;
template struct ContactList<3>;
template class ContactSearch<2>;
template class ContactSearch<3>;

}  // namespace graintruth::sim
