#include "sim/engine/contacts.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "sim/engine/contact_batch.h"

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

template <int D>
void begin_list(const ContactList<D>& before, ContactList<D>& fresh) {
  fresh.clear();
  fresh.remember(before.remembers());
}

// The fresh list becomes that of its slab, no larger than it must be.
template <int D, class Order>
void finish_list(const Order& order, ContactList<D>& fresh, ContactList<D>& list) {
  carry_on(list, order, fresh);
  list = fresh;
}

// A point, and where it is in the next cells if that is less than `reach` (m) from this one: a body
// that leaves the cell finds the walls of the other side among its candidates.
template <int D>
void find_images(const Bodies<D>& bodies,
                 typename Motion<D>::Vector point,
                 double reach,
                 std::vector<Vec3>& images) {
  images.assign(1, to_space(to_eigen(point), bodies.layer));
  if (!bodies.cell.is_periodic) return;
  const Vec3 low = to_space(to_eigen(bodies.cell.low)),
             length = to_space(to_eigen(bodies.cell.length));
  for (int axis = 0; axis < 3; ++axis) {
    if (!(length[axis] > 0.0)) continue;
    const double from_low = images.front()[axis] - low[axis];
    const std::size_t count = images.size();
    for (const double side : {1.0, -1.0}) {
      if ((side > 0.0 ? from_low : length[axis] - from_low) >= reach) continue;
      for (std::size_t k = 0; k < count; ++k)
        images.push_back(images[k] + side * length[axis] * Vec3::Unit(axis));
    }
  }
}

template <int D>
void add_pair(const Bodies<D>& bodies,
              const IndexPair& near,
              double margin,
              ContactList<D>& candidates) {
  const int i = near.first, j = near.second;
  for (int s = bodies.first_sphere[i]; s < bodies.first_sphere[i + 1]; ++s) {
    for (int t = bodies.first_sphere[j]; t < bodies.first_sphere[j + 1]; ++t) {
      const double far = bodies.spheres[s].radius + bodies.spheres[t].radius + margin;
      auto apart = bodies.spheres[t].centre - bodies.spheres[s].centre;
      if (bodies.cell.is_periodic) apart = apart + shift_to_nearest(bodies.cell, apart);
      if (dot(apart, apart) < far * far) candidates.add(s, t);
    }
  }
  candidates.close_group();
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
                            const WallBodies& wall_bodies,
                            double margin,
                            Team& team,
                            std::vector<ContactList<D>>& between_bodies,
                            std::vector<ContactList<D>>& with_walls) {
  radii_.clear();
  for (const BodyKind<D>& kind : bodies.kinds) radii_.push_back(kind.bounding_radius);
  wall_boxes_.clear();
  for (const Wall& wall : walls) wall_boxes_.push_back(box_of(wall));
  const PointView<D> centres{bodies.count() > 0 ? &bodies.motion.front().position.x : nullptr,
                             sizeof(BodyMotion<D>) / sizeof(double),
                             bodies.motion.size()};
  cells_.sort(centres, RadiusView{radii_, bodies.kind.data()}, margin, bodies.cell);
  desks_.resize(team.workers());
  for_each_shared(slab_count_of(bodies.count()), &team, [&](int worker, int slab) {
    const SlabRange range = slab_range(slab, bodies.count());
    Desk& desk = desks_[worker];
    find_pairs(bodies, margin, range, desk, between_bodies[slab]);
    find_walls(bodies, walls, wall_bodies, margin, range, desk.fresh, with_walls[slab]);
  });
}

template <int D>
void ContactSearch<D>::find_pairs(const Bodies<D>& bodies,
                                  double margin,
                                  const SlabRange& slab,
                                  Desk& desk,
                                  ContactList<D>& list) const {
  begin_list(list, desk.fresh);
  cells_.visit_near_pairs(
      slab.begin, slab.end, desk.pairs, [&](std::span<const IndexPair> of_body) {
        for (const IndexPair& near : of_body) add_pair(bodies, near, margin, desk.fresh);
      });
  const auto order = [&body = bodies.body_of_sphere](int first, int second) {
    return std::tuple(body[first], body[second], first, second);
  };
  finish_list(order, desk.fresh, list);
}

template <int D>
void ContactSearch<D>::find_walls(const Bodies<D>& bodies,
                                  const std::vector<Wall>& walls,
                                  const WallBodies& wall_bodies,
                                  double margin,
                                  const SlabRange& slab,
                                  ContactList<D>& fresh,
                                  ContactList<D>& list) const {
  begin_list(list, fresh);
  // Where a body and a sphere of it are, and where they may soon be
  std::vector<Vec3> body_places, sphere_places;
  const auto is_near = [&walls](int w, double reach, const std::vector<Vec3>& places) {
    return std::any_of(places.begin(), places.end(), [&](const Vec3& place) {
      return look_at(walls[w], place).distance < reach;
    });
  };
  for (int i = slab.begin; i < slab.end; ++i) {
    const double reach = bodies.kind_of(i).bounding_radius + margin;
    find_images(bodies, bodies.motion[i].position, reach, body_places);
    int of_group = -1;
    for (const int w : wall_bodies.order) {
      if (wall_bodies.of_wall[w] != of_group) fresh.close_group();
      of_group = wall_bodies.of_wall[w];
      const Box& box = wall_boxes_[w];
      const bool is_far =
          std::all_of(body_places.begin(), body_places.end(), [&](const Vec3& place) {
            return box.distance_bound(place) >= reach;
          });
      if (is_far || !is_near(w, reach, body_places)) continue;
      for (int s = bodies.first_sphere[i]; s < bodies.first_sphere[i + 1]; ++s) {
        const PlacedSphere<D>& sphere = bodies.spheres[s];
        find_images(bodies, sphere.centre, reach, sphere_places);
        if (is_near(w, sphere.radius + margin, sphere_places)) fresh.add(s, w);
      }
    }
    fresh.close_group();
  }
  const auto order = [&body = bodies.body_of_sphere, &rank = wall_bodies.rank](int first,
                                                                               int wall) {
    return std::tuple(body[first], rank[wall], first);
  };
  finish_list(order, fresh, list);
}

template struct ContactList<2>;
template struct ContactList<3>;
template class ContactSearch<2>;
template class ContactSearch<3>;

}  // namespace graintruth::sim
