// Forces of all touching contacts, group by group: body pair after body pair, then body and wall.
#pragma once

#include <algorithm>
#include <vector>

#include "sim/contact_law.h"
#include "sim/contacts.h"

namespace graintruth::sim {

// One touching candidate, before the law is applied.
template <int D>
struct Touch {
  int candidate;
  double overlap;    // m
  double stiffness;  // N/m; tangent
  Vec<D> normal;     // unit, from first to second
};

// Everything about one contact after the law: what an observer may see.
template <int D>
struct ContactEvent {
  const ContactGroup* group;
  int candidate;
  bool with_wall;
  const Touch<D>* touch;
  const PairMaterial* pair;
  const SurfaceMotion<D>* motion;
  const ContactForce<D>* force;
  typename Motion<D>::Tangent spring;  // m
};

// What the force loop needs besides bodies and contacts.
template <int D>
struct ForceSetting {
  const PairTable* pairs;
  DampingSharing sharing;
  double slip_time;        // s; how long the half-step velocities have moved the bodies
  double largest_overlap;  // share of the smaller radius above which the run is no longer trusted
};

// The body and the partner of the worst overlap, when one was too large.
struct OverlapTrouble {
  bool found = false;
  int first = -1;
  int second = -1;
  bool with_wall = false;
  double overlap = 0.0;  // m
};

// Visitors of the loop. `commits`: springs are carried on and forces are summed.
struct StepOnly {
  static constexpr bool commits = true;
  template <int D>
  void operator()(const ContactEvent<D>&) const {}
};

// The surface of the wall, as a body without mass of its own: at p its velocity is
// velocity + spin x p.
template <int D>
struct WallSurface {
  using Spin = typename Motion<D>::Spin;
  Vec<D> velocity = Vec<D>::Zero();      // m/s, half a step back
  Vec<D> velocity_now = Vec<D>::Zero();  // m/s
  Vec<D> force = Vec<D>::Zero();         // N, on the wall
  bool turns = false;                    // else the spins are zero and the torque is not summed
  Spin spin = Motion<D>::no_spin();      // rad/s, half a step back
  Spin spin_now = Motion<D>::no_spin();  // rad/s
  Spin torque = Motion<D>::no_spin();    // N m, on the wall about the origin
};

namespace detail {

// Applies the law to the touches of one group. WithWall: the second body is a wall.
template <int D, bool Clipped, bool WithWall, class Visitor>
inline void apply_group(const ContactGroup& group,
                        const std::vector<Touch<D>>& touches,
                        int touch_count,
                        double sum_of_stiffness,
                        const ForceSetting<D>& setting,
                        ContactList<D>& list,
                        Bodies<D>& bodies,
                        WallSurface<D>* wall,
                        Visitor& visit) {
  using Tangent = typename Motion<D>::Tangent;
  const PairMaterial& pair = (*setting.pairs)[group.pair];
  const int a = group.first;
  const int b = group.second;
  const Vec<D> position_a = bodies.position[a];
  Vec<D> force_on_a = Vec<D>::Zero();
  auto torque_on_a = Motion<D>::no_spin();
  auto torque_on_b = Motion<D>::no_spin();
  for (int k = 0; k < touch_count; ++k) {
    const Touch<D>& touch = touches[k];
    const int c = touch.candidate;
    const Vec<D>& n = touch.normal;

    // 1. Relative motion of the two surfaces at the contact point, x1 + (R1 - overlap/2) n
    const int sphere_a = list.first_sphere[c];
    const double reach_a = bodies.sphere_radius[sphere_a] - 0.5 * touch.overlap;
    const Vec<D> lever_a = bodies.sphere_position[sphere_a] - position_a + reach_a * n;
    Vec<D> lever_b = Vec<D>::Zero();
    Vec<D> moved = -bodies.velocity[a] - spin_velocity(bodies.spin[a], lever_a);
    Vec<D> moving = -bodies.velocity_now[a] - spin_velocity(bodies.spin_now[a], lever_a);
    if constexpr (WithWall) {
      moved += wall->velocity;
      moving += wall->velocity_now;
      if (wall->turns) {
        const Vec<D> point = position_a + lever_a;
        moved += spin_velocity(wall->spin, point);
        moving += spin_velocity(wall->spin_now, point);
      }
    } else {
      lever_b = lever_a + position_a - bodies.position[b];
      moved += bodies.velocity[b] + spin_velocity(bodies.spin[b], lever_b);
      moving += bodies.velocity_now[b] + spin_velocity(bodies.spin_now[b], lever_b);
    }
    SurfaceMotion<D> motion;
    motion.normal_speed = moving.dot(n);
    motion.tangential = tangential_part(moving, n, motion.normal_speed);
    // A contact that is new has, on average, existed for half of the step
    const double slip_time = list.is_touching[c] ? setting.slip_time : 0.5 * setting.slip_time;
    motion.slip = slip_time * tangential_part(moved, n, moved.dot(n));

    // 2. Contact law
    const double dashpot = dashpot_per_stiffness(setting.sharing,
                                                 pair.normal_damping,
                                                 group.reduced_mass,
                                                 sum_of_stiffness,
                                                 touch.stiffness,
                                                 touch_count);
    Tangent spring = list.is_touching[c] ? list.spring[c] : Motion<D>::no_tangent();
    const ContactForce<D> force =
        contact_force<D, Clipped>(pair, motion, n, touch.overlap, touch.stiffness, dashpot, spring);

    // 3. Action and reaction
    visit(ContactEvent<D>{&group, c, WithWall, &touch, &pair, &motion, &force, spring});
    if constexpr (Visitor::commits) {
      list.spring[c] = spring;
      list.is_touching[c] = 1;
      const Vec<D> on_b = force.normal * n + as_vector(force.tangential, n);
      force_on_a -= on_b;
      torque_on_a -= moment(lever_a, on_b);
      if constexpr (WithWall) {
        if (wall->turns) wall->torque += moment(Vec<D>(position_a + lever_a), on_b);
      } else {
        torque_on_b += moment(lever_b, on_b);
      }
    }
  }
  if constexpr (Visitor::commits) {
    bodies.force[a] += force_on_a;
    bodies.torque[a] += torque_on_a;
    if constexpr (WithWall) {
      wall->force -= force_on_a;
    } else {
      bodies.force[b] -= force_on_a;
      bodies.torque[b] += torque_on_b;
    }
  }
}

// Whether the rim of a wall at which a sphere touches is part of another wall that has the contact.
// That wall is among the candidates of the same body, whose groups begin at `first_of_body`.
inline bool edge_belongs_to_another(const std::vector<Wall>& walls,
                                    const std::vector<ContactGroup>& groups,
                                    std::size_t first_of_body,
                                    int wall,
                                    const Vec3& centre) {
  const int body = groups[first_of_body].first;
  for (std::size_t g = first_of_body; g < groups.size() && groups[g].first == body; ++g) {
    const int other = groups[g].second;
    if (other != wall && edge_belongs_to(walls[other], other < wall, walls[wall], centre)) {
      return true;
    }
  }
  return false;
}

inline void note_overlap(double overlap,
                         const ContactGroup& group,
                         bool wall,
                         OverlapTrouble& trouble) {
  if (trouble.found && !(overlap > trouble.overlap)) return;
  trouble = {true, group.first, group.second, wall, overlap};
}

}  // namespace detail

// Adds the force of every touching pair of bodies to both; returns how many contacts there are.
// Linear in candidates; allocates nothing.
template <int D, bool Clipped, class Visitor>
int add_pair_forces(const ForceSetting<D>& setting,
                    ContactList<D>& list,
                    Bodies<D>& bodies,
                    std::vector<Touch<D>>& touches,
                    OverlapTrouble& trouble,
                    Visitor& visit) {
  int contact_count = 0;
  for (const ContactGroup& group : list.groups) {
    // 1. Which candidates touch: overlap = R1 + R2 - distance (thesis 1.30-1.33)
    int touch_count = 0;
    double sum_of_stiffness = 0.0;
    for (int c = group.begin; c < group.end; ++c) {
      const Vec<D> apart = bodies.sphere_position[list.second_sphere[c]] -
                           bodies.sphere_position[list.first_sphere[c]];
      const double squared = apart.squaredNorm();
      const double reach = list.reach[c];
      if (squared >= reach * reach) {
        if constexpr (Visitor::commits) list.is_touching[c] = 0;
        continue;
      }
      const double distance = std::sqrt(squared);
      const double overlap = reach - distance;
      // R* <= smaller radius <= 2 R*, and reach >= 2 smaller radius: a cheap bound on overlap /
      // radius
      if (overlap > 0.5 * setting.largest_overlap * reach) {
        const double smaller = std::min(bodies.sphere_radius[list.first_sphere[c]],
                                        bodies.sphere_radius[list.second_sphere[c]]);
        if (overlap > setting.largest_overlap * smaller) {
          detail::note_overlap(overlap, group, false, trouble);
        }
      }
      const double stiffness = hertz_stiffness(list.stiffness_factor[c], overlap);
      sum_of_stiffness += stiffness;
      touches[touch_count++] = {c, overlap, stiffness, apart * (1.0 / distance)};
    }
    if (touch_count == 0) continue;
    contact_count += touch_count;
    // 2. Law and sum
    detail::apply_group<D, Clipped, false>(
        group, touches, touch_count, sum_of_stiffness, setting, list, bodies, nullptr, visit);
  }
  return contact_count;
}

// The same for every sphere that touches a wall. `walls` are where they are now.
template <int D, bool Clipped, class Visitor>
int add_wall_forces(const ForceSetting<D>& setting,
                    const std::vector<Wall>& walls,
                    std::vector<WallSurface<D>>& surfaces,
                    ContactList<D>& list,
                    Bodies<D>& bodies,
                    std::vector<Touch<D>>& touches,
                    OverlapTrouble& trouble,
                    Visitor& visit) {
  int contact_count = 0;
  std::size_t first_of_body = 0;
  for (std::size_t g = 0; g < list.groups.size(); ++g) {
    const ContactGroup& group = list.groups[g];
    if (group.first != list.groups[first_of_body].first) first_of_body = g;
    int touch_count = 0;
    double sum_of_stiffness = 0.0;
    for (int c = group.begin; c < group.end; ++c) {
      const Vec3 centre = to_space(bodies.sphere_position[list.first_sphere[c]], bodies.layer);
      const WallView view = look_at(walls[group.second], centre);
      const double overlap = list.reach[c] - view.distance;
      if (!(overlap > 0.0) ||
          (view.is_edge && detail::edge_belongs_to_another(
                               walls, list.groups, first_of_body, group.second, centre))) {
        if constexpr (Visitor::commits) list.is_touching[c] = 0;
        continue;
      }
      if (overlap > setting.largest_overlap * list.reach[c]) {
        detail::note_overlap(overlap, group, true, trouble);
      }
      const double stiffness = hertz_stiffness(list.stiffness_factor[c], overlap);
      sum_of_stiffness += stiffness;
      touches[touch_count++] = {c, overlap, stiffness, to_motion<D>(view.direction)};
    }
    if (touch_count == 0) continue;
    contact_count += touch_count;
    detail::apply_group<D, Clipped, true>(group,
                                          touches,
                                          touch_count,
                                          sum_of_stiffness,
                                          setting,
                                          list,
                                          bodies,
                                          &surfaces[group.second],
                                          visit);
  }
  return contact_count;
}

}  // namespace graintruth::sim
