// Forces of all touching contacts, group by group: body pair after body pair, then body and wall.
// Contacts are gathered into batches, the law runs over each batch, and its forces go to the bodies
// in the order of the groups, so that the same bits come out however the batches fall.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "sim/contact_kernel.h"
#include "sim/contacts.h"

namespace graintruth::sim {

// What the force loop needs besides bodies and contacts.
struct ForceSetting {
  const PairTable* pairs;
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

// What an observer of the loop sees of a batch after the law.
template <int D>
struct BatchView {
  const ContactBatch<D>& batch;
  const ContactList<D>& list;
  const PairTable& pairs;
  ChosenLaw law;
  bool with_walls;
};

inline ChosenLaw as_chosen(const DefaultLaw&) { return {}; }
inline ChosenLaw as_chosen(const ChosenLaw& law) { return law; }

// Observers of the loop. `commits`: springs are carried on and forces are summed.
struct StepOnly {
  static constexpr bool commits = true;
  template <int D>
  void operator()(const BatchView<D>&) const {}
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

// Sum of the contacts of a slab on a wall.
template <int D>
struct WallLoad {
  Vec<D> force = Vec<D>::Zero();                           // N
  typename Motion<D>::Spin torque = Motion<D>::no_spin();  // N m, about the origin
};

// What a contact does to a body of a later slab.
template <int D>
struct DeferredLoad {
  int body;
  Load<D> load;
};

// The sums over the groups of one slab that are not those of its own bodies.
template <int D>
struct SlabLoads {
  int end = 0;  // its bodies are those before
  std::vector<DeferredLoad<D>> deferred;
  std::vector<WallLoad<D>> walls;
  OverlapTrouble trouble;
  int contact_count = 0;
};

namespace detail {

inline void note_overlap(double overlap,
                         const ContactGroup& group,
                         bool wall,
                         OverlapTrouble& trouble) {
  if (trouble.found && !(overlap > trouble.overlap)) return;
  trouble = {true, group.first, group.second, wall, overlap};
}

// How the surface of the second partner moves relative to the first body, per contact.
template <int D>
inline void gather_motion(int k,
                          const BodyMotion<D>& first,
                          typename Motion<D>::Vector moved,
                          typename Motion<D>::Vector moving,
                          typename Motion<D>::Tangent spin,
                          typename Motion<D>::Tangent spin_now,
                          ContactBatch<D>& batch) {
  batch.moved.at_centre.set(k, moved - plain(first.velocity));
  batch.moving.at_centre.set(k, moving - plain(first.velocity_now));
  batch.moved.spin.set(k, spin - plain(first.spin));
  batch.moving.spin.set(k, spin_now - plain(first.spin_now));
}

// Columns that do not depend on whether the partner is a body or a wall.
template <int D>
inline void gather_contact(int k,
                           const ForceSetting& setting,
                           const ContactList<D>& list,
                           const ContactGroup& group,
                           const Bodies<D>& bodies,
                           ContactBatch<D>& batch) {
  const int c = batch.candidate[k];
  const int sphere = list.first_sphere[c];
  const bool is_old = batch.was_touching[k] != 0;
  batch.pair[k] = group.pair;
  batch.reduced_mass.set(k, group.reduced_mass);
  batch.reach.set(k, list.reach[c]);
  batch.stiffness_factor.set(k, list.stiffness_factor[c]);
  batch.radius.set(k, bodies.sphere_radius[sphere]);
  batch.arm.set(k,
                plain(bodies.sphere_position[sphere]) - plain(bodies.motion[group.first].position));
  // A contact that is new has, on average, existed for half of the step
  batch.slip_time.set(k, is_old ? setting.slip_time : 0.5 * setting.slip_time);
  batch.spring.set(k, chosen(is_old, list.spring[c], Motion<D>::no_tangent()));
  if (list.remembers()) batch.remembered[k].memory = list.memory[c];
}

// Which candidates of the range touch: the row of one that does not is written over by the next.
// Without a branch, since nobody can foretell the outcome.
template <int D, bool Commits>
void gather_touching_pairs(const CandidateRange& range,
                           ContactList<D>& list,
                           const Bodies<D>& bodies,
                           ContactBatch<D>& batch) {
  const auto* centres = bodies.sphere_position.data();
  int rows = 0;
  for (int c = range.begin; c < range.end; ++c) {
    const auto apart = plain(centres[list.second_sphere[c]]) - plain(centres[list.first_sphere[c]]);
    const double squared = dot(apart, apart);
    const int touches = squared < list.reach[c] * list.reach[c] ? 1 : 0;
    // The second body is anywhere in memory; it is asked for early
    __builtin_prefetch(&bodies.motion[list.groups[list.group_of[c]].second]);
    batch.candidate[rows] = c;
    batch.was_touching[rows] = list.is_touching[c];
    batch.apart.set(rows, apart);
    batch.distance_squared.set(rows, squared);
    if constexpr (Commits) list.is_touching[c] = touches;
    rows += touches;
  }
  batch.count = rows;
}

template <int D, bool Commits>
void gather_pairs(const ForceSetting& setting,
                  const CandidateRange& range,
                  ContactList<D>& list,
                  const Bodies<D>& bodies,
                  ContactBatch<D>& batch) {
  gather_touching_pairs<D, Commits>(range, list, bodies, batch);
  for (int k = 0; k < batch.count; ++k) {
    const int g = list.group_of[batch.candidate[k]];
    const ContactGroup& group = list.groups[g];
    const BodyMotion<D>& first = bodies.motion[group.first];
    const BodyMotion<D>& second = bodies.motion[group.second];
    // The second body's motion where the first one's centre is
    const auto offset = plain(first.position) - plain(second.position);
    const auto spin = plain(second.spin), spin_now = plain(second.spin_now);
    batch.group[k] = g;
    batch.offset.set(k, offset);
    gather_motion<D>(k,
                     first,
                     plain(second.velocity) + spin_velocity(spin, offset),
                     plain(second.velocity_now) + spin_velocity(spin_now, offset),
                     spin,
                     spin_now,
                     batch);
    gather_contact(k, setting, list, group, bodies, batch);
  }
  find_geometry(batch);
}

// Whether the rim of a wall at which a sphere touches is part of another wall that has the contact.
// That wall is among the candidates of the same body, whose groups lie side by side.
inline bool edge_belongs_to_another(const std::vector<Wall>& walls,
                                    const std::vector<ContactGroup>& groups,
                                    int group,
                                    const Vec3& centre) {
  const int body = groups[group].first, wall = groups[group].second;
  int first = group;
  while (first > 0 && groups[first - 1].first == body) --first;
  for (std::size_t g = first; g < groups.size() && groups[g].first == body; ++g) {
    const int other = groups[g].second;
    if (other != wall && edge_belongs_to(walls[other], other < wall, walls[wall], centre)) {
      return true;
    }
  }
  return false;
}

// The same for spheres at walls, which are where `walls` says.
template <int D, bool Commits>
void gather_walls(const ForceSetting& setting,
                  const CandidateRange& range,
                  const std::vector<Wall>& walls,
                  const std::vector<WallSurface<D>>& surfaces,
                  ContactList<D>& list,
                  const Bodies<D>& bodies,
                  ContactBatch<D>& batch) {
  batch.count = 0;
  for (int c = range.begin; c < range.end; ++c) {
    const int g = list.group_of[c];
    const ContactGroup& group = list.groups[g];
    const Vec3 centre =
        to_space(to_eigen(bodies.sphere_position[list.first_sphere[c]]), bodies.layer);
    const WallView view = look_at(walls[group.second], centre);
    const double overlap = list.reach[c] - view.distance;
    const bool touches =
        overlap > 0.0 && !(view.is_edge && edge_belongs_to_another(walls, list.groups, g, centre));
    const int was_touching = list.is_touching[c];
    if constexpr (Commits) list.is_touching[c] = touches ? 1 : 0;
    if (!touches) continue;
    const int k = batch.count++;
    const WallSurface<D>& surface = surfaces[group.second];
    batch.candidate[k] = c;
    batch.was_touching[k] = was_touching;
    batch.group[k] = g;
    batch.overlap.set(k, overlap);
    batch.normal.set(k, plain(to_motion<D>(view.direction)));
    batch.stiffness.set(k, hertz_stiffness(list.stiffness_factor[c], overlap));
    const auto spin = plain(surface.spin), spin_now = plain(surface.spin_now);
    const auto first_centre = plain(bodies.motion[group.first].position);
    gather_motion<D>(k,
                     bodies.motion[group.first],
                     plain(surface.velocity) + spin_velocity(spin, first_centre),
                     plain(surface.velocity_now) + spin_velocity(spin_now, first_centre),
                     spin,
                     spin_now,
                     batch);
    gather_contact(k, setting, list, group, bodies, batch);
  }
}

// Sums over a group that is spread over several batches. `gather` fills a batch without committing
// anything.
template <int D, class Gather>
void sum_spread_group(const ContactGroup& group, const Gather& gather, ContactBatch<D>& batch) {
  double stiffness = 0.0, number = 0.0;
  for (int begin = group.begin; begin < group.end; begin += kBatchRows - 1) {
    gather(CandidateRange{begin, std::min(begin + kBatchRows - 1, group.end), true});
    for (int k = 0; k < batch.count; ++k) stiffness += batch.stiffness.at(k);
    number += batch.count;
  }
  batch.sum_of_stiffness.value.fill(stiffness);
  batch.contact_count.value.fill(number);
}

// Sums over groups of which all rows are in the batch. Their number is asked for by one law alone.
template <int D, class Law>
void sum_whole_groups(const Law& law, ContactBatch<D>& batch) {
  sum_groups(batch);
  if (law.sharing != DampingSharing::inv_n) return;
  count_groups(batch.count, batch.group.data(), batch.contact_count.value.data());
}

// Looks for overlaps that are too deep. R* <= smaller radius <= 2 R*, and reach >= 2 smaller
// radius: most contacts are cleared by a cheap bound on overlap / radius.
template <int D>
void look_for_deep_overlap(const ForceSetting& setting,
                           const ContactList<D>& list,
                           const Bodies<D>& bodies,
                           const ContactBatch<D>& batch,
                           bool with_walls,
                           OverlapTrouble& trouble) {
  int suspects = 0;
  for (int k = 0; k < batch.count; ++k) {
    suspects += batch.overlap.at(k) > 0.5 * setting.largest_overlap * batch.reach.at(k) ? 1 : 0;
  }
  if (suspects == 0) return;
  for (int k = 0; k < batch.count; ++k) {
    double smaller = batch.radius.at(k);
    if (!with_walls) {
      const int sphere = list.second_sphere[batch.candidate[k]];
      smaller = std::min(smaller, bodies.sphere_radius[sphere]);
    }
    if (batch.overlap.at(k) > setting.largest_overlap * smaller) {
      note_overlap(batch.overlap.at(k), list.groups[batch.group[k]], with_walls, trouble);
    }
  }
}

template <int D, class Law>
void keep_springs_of(const Law& law, const ContactBatch<D>& batch, ContactList<D>& list) {
  for (int k = 0; k < batch.count; ++k) list.spring[batch.candidate[k]] = batch.spring.at(k);
  if (list.remembers()) {
    for (int k = 0; k < batch.count; ++k) {
      list.memory[batch.candidate[k]] = batch.remembered[k].memory;
    }
  }
  if (!law.has_static_friction) return;
  for (int k = 0; k < batch.count; ++k) {
    if (batch.slides.at(k) != 0.0) list.is_touching[batch.candidate[k]] = kSliding;
  }
}

// A linear spring is as stiff at any overlap.
template <int D, class Law>
void use_linear_stiffness(const Law& law, ContactBatch<D>& batch) {
  if (law.normal_spring != NormalSpring::linear) return;
  std::fill_n(batch.stiffness.value.begin(), batch.count, law.linear_stiffness);
}

// Action and reaction.
template <int D>
void load_bodies(const ContactBatch<D>& batch,
                 const ContactList<D>& list,
                 Bodies<D>& bodies,
                 SlabLoads<D>& slab) {
  Load<D>* loads = bodies.load.data();
  for (int k = 0; k < batch.count; ++k) {
    const ContactGroup& group = list.groups[batch.group[k]];
    Load<D>& first = loads[group.first];
    const auto force = batch.force.at(k);
    first.force = first.force - force;
    first.torque = first.torque - batch.moment.at(k);
    if (group.second >= slab.end) {
      slab.deferred.push_back({group.second, {force, batch.second_moment.at(k)}});
      continue;
    }
    Load<D>& second = loads[group.second];
    second.force = second.force + force;
    second.torque = second.torque + batch.second_moment.at(k);
  }
}

template <int D>
void load_walls(const ContactBatch<D>& batch,
                const ContactList<D>& list,
                Bodies<D>& bodies,
                const std::vector<WallSurface<D>>& surfaces,
                SlabLoads<D>& slab) {
  for (int k = 0; k < batch.count; ++k) {
    const ContactGroup& group = list.groups[batch.group[k]];
    Load<D>& first = bodies.load[group.first];
    first.force = first.force - batch.force.at(k);
    first.torque = first.torque - batch.moment.at(k);
    WallLoad<D>& wall = slab.walls[group.second];
    const auto force = batch.force.at(k);
    wall.force += to_eigen(force);
    if (surfaces[group.second].turns) {
      const auto first_centre = plain(bodies.motion[group.first].position);
      wall.torque += to_eigen(batch.moment.at(k) + moment(first_centre, force));
    }
  }
}

}  // namespace detail

// Adds the force of every touching pair of bodies of the ranges to both. Linear in candidates;
// allocates nothing once the slab has seen its largest load.
template <int D, class Law, class Observer>
void add_pair_forces(const Law& law,
                     const ForceSetting& setting,
                     std::span<const CandidateRange> ranges,
                     ContactList<D>& list,
                     Bodies<D>& bodies,
                     ContactBatch<D>& batch,
                     SlabLoads<D>& slab,
                     Observer& observe) {
  for (const CandidateRange& range : ranges) {
    if (range.is_part) {
      const auto look = [&](const CandidateRange& part) {
        detail::gather_pairs<D, false>(setting, part, list, bodies, batch);
        detail::use_linear_stiffness(law, batch);
      };
      detail::sum_spread_group(list.groups[list.group_of[range.begin]], look, batch);
    }
    detail::gather_pairs<D, Observer::commits>(setting, range, list, bodies, batch);
    detail::use_linear_stiffness(law, batch);
    if (!range.is_part) detail::sum_whole_groups(law, batch);
    detail::look_for_deep_overlap(setting, list, bodies, batch, false, slab.trouble);
    apply_law(law, *setting.pairs, batch);
    observe(BatchView<D>{batch, list, *setting.pairs, as_chosen(law), false});
    if constexpr (Observer::commits) {
      detail::keep_springs_of(law, batch, list);
      detail::load_bodies(batch, list, bodies, slab);
    }
    slab.contact_count += batch.count;
  }
}

// The same for every sphere that touches a wall. `walls` are where they are now.
template <int D, class Law, class Observer>
void add_wall_forces(const Law& law,
                     const ForceSetting& setting,
                     std::span<const CandidateRange> ranges,
                     const std::vector<Wall>& walls,
                     const std::vector<WallSurface<D>>& surfaces,
                     ContactList<D>& list,
                     Bodies<D>& bodies,
                     ContactBatch<D>& batch,
                     SlabLoads<D>& slab,
                     Observer& observe) {
  for (const CandidateRange& range : ranges) {
    if (range.is_part) {
      const auto look = [&](const CandidateRange& part) {
        detail::gather_walls<D, false>(setting, part, walls, surfaces, list, bodies, batch);
        detail::use_linear_stiffness(law, batch);
      };
      detail::sum_spread_group(list.groups[list.group_of[range.begin]], look, batch);
    }
    detail::gather_walls<D, Observer::commits>(
        setting, range, walls, surfaces, list, bodies, batch);
    detail::use_linear_stiffness(law, batch);
    if (!range.is_part) detail::sum_whole_groups(law, batch);
    detail::look_for_deep_overlap(setting, list, bodies, batch, true, slab.trouble);
    apply_law(law, *setting.pairs, batch);
    observe(BatchView<D>{batch, list, *setting.pairs, as_chosen(law), true});
    if constexpr (Observer::commits) {
      detail::keep_springs_of(law, batch, list);
      detail::load_walls(batch, list, bodies, surfaces, slab);
    }
    slab.contact_count += batch.count;
  }
}

}  // namespace graintruth::sim
