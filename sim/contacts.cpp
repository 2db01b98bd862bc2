#include "sim/contacts.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "sim/contact_batch.h"

namespace graintruth::sim {
namespace {

// What touches in a list goes on touching in the list that follows it, unless it has parted since:
// one walk through both. `order` tells where a pair of spheres, or of sphere and wall, stands in
// them.
template <int D, class Order>
void carry_on(const ContactList<D>& before, const Order& order, ContactList<D>& list) {
  int c = 0;
  for (int old = 0; old < before.count(); ++old) {
    if (before.is_touching[old] == kOpen) continue;
    const auto place = order(before.first_sphere[old], before.second[old]);
    while (c < list.count() && order(list.first_sphere[c], list.second[c]) < place) ++c;
    if (c == list.count()) return;
    if (order(list.first_sphere[c], list.second[c]) != place) continue;
    list.spring[c] = before.spring[old];
    list.is_touching[c] = before.is_touching[old];
    if (list.remembers()) list.memory[c] = before.memory[old];
  }
}

// A range is closed when it holds this many candidates; those of one more group may come on top.
// The columns of a batch fill the first-level cache sooner in space.
template <int D>
constexpr int kCandidatesInRange = D == 2 ? 96 : 64;

// The row after the last contact of a batch is written ahead.
constexpr int kLargestRange = kBatchRows - 1;

template <int D>
void add_to_ranges(int begin, int end, std::vector<CandidateRange>& ranges) {
  const auto fits = [&](const CandidateRange& range) {
    return !range.is_part && range.end - range.begin < kCandidatesInRange<D> &&
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
  ranges.clear();
  first_sphere.clear();
  second.clear();
  spring.clear();
  is_touching.clear();
  memory.clear();
}

template <int D>
void ContactList<D>::remember(bool yes) {
  if (remembers_ == yes) return;
  remembers_ = yes;
  memory.assign(yes ? first_sphere.size() : 0, {});
}

template <int D>
void ContactList<D>::add(int first, int second_one) {
  first_sphere.push_back(first);
  second.push_back(second_one);
  spring.push_back(Motion<D>::no_tangent());
  is_touching.push_back(kOpen);
  if (remembers_) memory.emplace_back();
}

template <int D>
void ContactList<D>::close_group() {
  const int begin = ranges.empty() ? 0 : ranges.back().end;
  if (count() > begin) add_to_ranges<D>(begin, count(), ranges);
}

template <int D>
void ContactSearch<D>::find(const Bodies<D>& bodies,
                            const std::vector<Wall>& walls,
                            double margin,
                            std::vector<ContactList<D>>& between_bodies,
                            std::vector<ContactList<D>>& with_walls) {
  find_pairs(bodies, margin, between_bodies);
  find_walls(bodies, walls, margin, with_walls);
}

// The fresh list becomes that of its slab, no larger than it must be.
template <int D>
template <class Order>
void ContactSearch<D>::finish_slab(const Order& order, ContactList<D>& list) {
  carry_on(list, order, fresh_);
  list = fresh_;
  fresh_.clear();
}

template <int D>
void ContactSearch<D>::find_pairs(const Bodies<D>& bodies,
                                  double margin,
                                  std::vector<ContactList<D>>& lists) {
  const auto order = [&body = bodies.body_of_sphere](int first, int second) {
    return std::tuple(body[first], body[second], first, second);
  };
  fresh_.clear();
  fresh_.remember(lists.front().remembers());
  std::size_t slab = 0;
  const PointView<D> centres{bodies.count() > 0 ? &bodies.motion.front().position.x : nullptr,
                             sizeof(BodyMotion<D>) / sizeof(double),
                             bodies.motion.size()};
  std::vector<double> radii;
  for (const BodyKind<D>& kind : bodies.kinds) radii.push_back(kind.bounding_radius);
  visit_near_pairs<D>(centres,
                      RadiusView{radii, bodies.kind.data()},
                      margin,
                      cells_,
                      [&](std::span<const IndexPair> of_body) {
                        const auto slab_here =
                            static_cast<std::size_t>(slab_of(of_body.front().first));
                        for (; slab < slab_here; ++slab) finish_slab(order, lists[slab]);
                        for (const IndexPair& near : of_body) add_pair(bodies, near, margin);
                      });
  for (; slab < lists.size(); ++slab) finish_slab(order, lists[slab]);
}

template <int D>
void ContactSearch<D>::add_pair(const Bodies<D>& bodies, const IndexPair& near, double margin) {
  const int i = near.first, j = near.second;
  for (int s = bodies.first_sphere[i]; s < bodies.first_sphere[i + 1]; ++s) {
    for (int t = bodies.first_sphere[j]; t < bodies.first_sphere[j + 1]; ++t) {
      const double far = bodies.spheres[s].radius + bodies.spheres[t].radius + margin;
      const auto apart = bodies.spheres[t].centre - bodies.spheres[s].centre;
      if (dot(apart, apart) < far * far) fresh_.add(s, t);
    }
  }
  fresh_.close_group();
}

template <int D>
void ContactSearch<D>::find_walls(const Bodies<D>& bodies,
                                  const std::vector<Wall>& walls,
                                  double margin,
                                  std::vector<ContactList<D>>& lists) {
  const auto order = [&body = bodies.body_of_sphere](int first, int wall) {
    return std::tuple(body[first], wall, first);
  };
  fresh_.clear();
  fresh_.remember(lists.front().remembers());
  wall_boxes_.clear();
  for (const Wall& wall : walls) wall_boxes_.push_back(box_of(wall));
  std::size_t slab = 0;
  for (int i = 0; i < bodies.count(); ++i) {
    if (slab_of(i) > static_cast<int>(slab)) finish_slab(order, lists[slab++]);
    const Vec3 centre = to_space(to_eigen(bodies.motion[i].position), bodies.layer);
    for (int w = 0; w < static_cast<int>(walls.size()); ++w) {
      const double reach = bodies.kind_of(i).bounding_radius + margin;
      if (wall_boxes_[w].distance_bound(centre) >= reach) continue;
      if (look_at(walls[w], centre).distance >= reach) continue;
      for (int s = bodies.first_sphere[i]; s < bodies.first_sphere[i + 1]; ++s) {
        const PlacedSphere<D>& sphere = bodies.spheres[s];
        const Vec3 point = to_space(to_eigen(sphere.centre), bodies.layer);
        if (look_at(walls[w], point).distance < sphere.radius + margin) fresh_.add(s, w);
      }
      fresh_.close_group();
    }
  }
  finish_slab(order, lists[slab]);
}

template struct ContactList<2>;
template struct ContactList<3>;
template class ContactSearch<2>;
template class ContactSearch<3>;

}  // namespace graintruth::sim
