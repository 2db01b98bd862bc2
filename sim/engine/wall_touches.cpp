#include "sim/engine/wall_touches.h"

#include <algorithm>
#include <span>

#include "sim/engine/contact_batch.h"

namespace graintruth::sim {
namespace {

// Normals of one body closer than 0.01 rad are one: cosine. Corners that are off by what a file or
// a drawing rounds, a micrometre of a facet of a tenth of a millimetre, turn a facet by no more;
// neighbours on a round wall do from 628 facets a turn on, where the sphere then sees the nearest.
constexpr double kOneNormal = 1.0 - 0.5 * 0.01 * 0.01;

// All touches of one body side by side.
template <int D>
struct TouchesOfBody {
  const std::vector<Wall>& walls;
  const WallBodies& wall_bodies;
  const Bodies<D>& bodies;
  const ContactList<D>& list;
  std::span<WallTouch<D>> touches;

  int sphere_of(const WallTouch<D>& touch) const { return list.first_sphere[touch.candidate]; }
  int wall_of(const WallTouch<D>& touch) const { return list.second[touch.candidate]; }
  bool are_of_one_surface(const WallTouch<D>& a, const WallTouch<D>& b) const {
    return sphere_of(a) == sphere_of(b) &&
           wall_bodies.of_wall[wall_of(a)] == wall_bodies.of_wall[wall_of(b)];
  }

  // Whether the rim at which a sphere touches a wall is part of another wall that has the contact.
  bool edge_belongs_to_another(const WallTouch<D>& touch) const {
    const int wall = wall_of(touch);
    const Vec3 centre = to_space(to_eigen(bodies.spheres[sphere_of(touch)].centre), bodies.layer);
    return std::any_of(touches.begin(), touches.end(), [&](const WallTouch<D>& one) {
      const int other = wall_of(one);
      return other != wall && sphere_of(one) == sphere_of(touch) &&
             edge_belongs_to(walls[other], other < wall, walls[wall], centre);
    });
  }

  // Whether another part of the same surface, of the same normal, is touched deeper.
  bool has_deeper_twin(const WallTouch<D>& touch) const {
    return std::any_of(touches.begin(), touches.end(), [&](const WallTouch<D>& other) {
      const bool is_deeper = other.overlap > touch.overlap ||
                             (other.overlap == touch.overlap && other.candidate < touch.candidate);
      return is_deeper && other.counts && are_of_one_surface(other, touch) &&
             dot(other.normal, touch.normal) >= kOneNormal;
    });
  }

  void hand_over(const WallTouch<D>& old) const {
    WallTouch<D>* heir = nullptr;
    double nearest = 0.0;
    for (WallTouch<D>& touch : touches) {
      if (!touch.counts || !are_of_one_surface(old, touch)) continue;
      const double nearness = dot(old.normal, touch.normal);
      if (!(nearness > nearest)) continue;
      nearest = nearness;
      heir = &touch;
    }
    if (heir == nullptr || heir->was_touching != kOpen) return;
    heir->carries_on = old.candidate;
    heir->was_touching = old.was_touching;
  }

  void count_each_surface_once() const {
    if (touches.size() == 1) return;
    for (WallTouch<D>& touch : touches) {
      touch.counts = !(touch.is_edge && edge_belongs_to_another(touch));
    }
    if (wall_bodies.are_all_alone) return;
    for (WallTouch<D>& touch : touches) {
      touch.has_deeper_twin = touch.counts && has_deeper_twin(touch);
    }
    for (WallTouch<D>& touch : touches) touch.counts = touch.counts && !touch.has_deeper_twin;
    for (const WallTouch<D>& touch : touches) {
      if (!touch.counts && touch.was_touching != kOpen) hand_over(touch);
    }
  }
};

}  // namespace

template <int D>
void find_wall_touches(const std::vector<Wall>& walls,
                       const WallBodies& wall_bodies,
                       const Bodies<D>& bodies,
                       const ContactList<D>& list,
                       std::vector<WallTouch<D>>& touches) {
  touches.clear();
  for (int c = 0; c < list.count(); ++c) {
    const PlacedSphere<D>& sphere = bodies.spheres[list.first_sphere[c]];
    const Vec3 centre = to_space(to_eigen(sphere.centre), bodies.layer);
    const WallView view = look_at(walls[list.second[c]], centre);
    const double overlap = sphere.radius - view.distance;
    if (!(overlap > 0.0)) continue;
    touches.push_back({c,
                       c,
                       list.is_touching[c],
                       overlap,
                       plain(to_motion<D>(view.direction)),
                       view.is_edge,
                       true,
                       false});
  }
  const auto body_of = [&](const WallTouch<D>& touch) {
    return bodies.body_of_sphere[list.first_sphere[touch.candidate]];
  };
  for (std::size_t begin = 0, end = 0; begin < touches.size(); begin = end) {
    while (end < touches.size() && body_of(touches[end]) == body_of(touches[begin])) ++end;
    const auto of_body = std::span(touches).subspan(begin, end - begin);
    TouchesOfBody<D>{walls, wall_bodies, bodies, list, of_body}.count_each_surface_once();
  }
  std::erase_if(touches, [](const WallTouch<D>& touch) { return !touch.counts; });
}

template void find_wall_touches<2>(const std::vector<Wall>&,
                                   const WallBodies&,
                                   const Bodies<2>&,
                                   const ContactList<2>&,
                                   std::vector<WallTouch<2>>&);
template void find_wall_touches<3>(const std::vector<Wall>&,
                                   const WallBodies&,
                                   const Bodies<3>&,
                                   const ContactList<3>&,
                                   std::vector<WallTouch<3>>&);

}  // namespace graintruth::sim
