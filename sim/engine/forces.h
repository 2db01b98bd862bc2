// Forces of all touching contacts, group by group: body pair after body pair, then body and wall.
// Contacts are gathered into batches, the law runs over each batch, and its forces go to the bodies
// in the order of the groups, so that the same bits come out however the batches fall.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "sim/engine/contact_kernel.h"
#include "sim/engine/contact_rows.h"
#include "sim/engine/contacts.h"

namespace graintruth::sim {

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

// The surfaces of the walls.
template <int D>
struct WallSurfaces {
  // Of the point at the origin, as if the wall were a body there: at p its velocity is
  // velocity + spin x p
  std::vector<BodyMotion<D>> motion;
  std::vector<int> material;
  std::vector<char> turns;        // else the spins are zero and the torque is not summed
  std::vector<WallLoad<D>> load;  // of the last step

  void resize(std::size_t count) {
    motion.resize(count, BodyMotion<D>{});
    material.resize(count);
    turns.resize(count, 0);
    load.resize(count);
  }
};

namespace detail {

template <int D>
inline void note_overlap(const ContactBatch<D>& batch, int k, bool wall, OverlapTrouble& trouble) {
  const double overlap = batch.overlap.at(k);
  if (trouble.found && !(overlap > trouble.overlap)) return;
  trouble = {true, batch.first_body[k], batch.second_body[k], wall, overlap};
}

// Whether the rim of a wall at which a sphere touches is part of another wall that has the contact.
// That wall is among the candidates of the same body, which lie side by side.
template <int D>
bool edge_belongs_to_another(const std::vector<Wall>& walls,
                             const Bodies<D>& bodies,
                             const ContactList<D>& list,
                             int candidate,
                             const Vec3& centre) {
  const auto body_of = [&](int c) { return bodies.body_of_sphere[list.first_sphere[c]]; };
  const int body = body_of(candidate), wall = list.second[candidate];
  int first = candidate;
  while (first > 0 && body_of(first - 1) == body) --first;
  int last_seen = wall;
  for (int c = first; c < list.count() && body_of(c) == body; ++c) {
    const int other = list.second[c];
    if (other == wall || other == last_seen) continue;
    last_seen = other;
    if (edge_belongs_to(walls[other], other < wall, walls[wall], centre)) return true;
  }
  return false;
}

// The rows of spheres that touch walls, which are where `walls` says: overlap and normal.
template <int D>
void find_touching_walls(const CandidateRange& range,
                         bool commits,
                         const std::vector<Wall>& walls,
                         const Bodies<D>& bodies,
                         ContactList<D>& list,
                         ContactBatch<D>& batch) {
  batch.count = 0;
  for (int c = range.begin; c < range.end; ++c) {
    const PlacedSphere<D>& sphere = bodies.spheres[list.first_sphere[c]];
    const Vec3 centre = to_space(to_eigen(sphere.centre), bodies.layer);
    const WallView view = look_at(walls[list.second[c]], centre);
    const double overlap = sphere.radius - view.distance;
    const bool touches =
        overlap > 0.0 && !(view.is_edge && edge_belongs_to_another(walls, bodies, list, c, centre));
    const int was_touching = list.is_touching[c];
    if (commits) list.is_touching[c] = touches ? kTouching : kOpen;
    if (!touches) continue;
    const int k = batch.count++;
    batch.candidate[k] = c;
    batch.was_touching[k] = was_touching;
    batch.overlap.set(k, overlap);
    batch.normal.set(k, plain(to_motion<D>(view.direction)));
  }
}

// Candidates of the group of which the range is a part.
template <int D>
CandidateRange whole_group(const CandidateRange& part,
                           bool with_walls,
                           const Bodies<D>& bodies,
                           const ContactList<D>& list) {
  const auto& body = bodies.body_of_sphere;
  const auto is_of_group = [&](int c) {
    const int second = list.second[c], of_part = list.second[part.begin];
    return body[list.first_sphere[c]] == body[list.first_sphere[part.begin]] &&
           (with_walls ? second == of_part : body[second] == body[of_part]);
  };
  CandidateRange whole = part;
  while (whole.begin > 0 && is_of_group(whole.begin - 1)) --whole.begin;
  while (whole.end < list.count() && is_of_group(whole.end)) ++whole.end;
  return whole;
}

// Sums over a group that is spread over several batches. `gather` fills a batch without committing
// anything.
template <int D, class Gather>
void sum_spread_group(const CandidateRange& group, const Gather& gather, ContactBatch<D>& batch) {
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
  if (batch.longest_group == 1) {
    batch.contact_count.value.fill(1.0);
    return;
  }
  count_groups(batch.count, batch.group.value.data(), batch.contact_count.value.data());
}

// Looks for overlaps that are too deep, as shares of the smaller radius.
template <int D>
void look_for_deep_overlap(const ForceSetting& setting,
                           const ContactBatch<D>& batch,
                           bool with_walls,
                           OverlapTrouble& trouble) {
  if (!may_be_deeper(setting.largest_overlap, batch)) return;
  for (int k = 0; k < batch.count; ++k) {
    double smaller = batch.radius.at(k);
    if (!with_walls) smaller = std::min(smaller, batch.second_radius.at(k));
    if (batch.overlap.at(k) > setting.largest_overlap * smaller) {
      note_overlap(batch, k, with_walls, trouble);
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
  batch.stiffness.value.fill(law.linear_stiffness);
}

template <int D>
void load_walls(ContactBatch<D>& batch,
                const WallSurfaces<D>& surfaces,
                Bodies<D>& bodies,
                SlabLoads<D>& slab) {
  load_first(batch, bodies);
  for (int k = 0; k < batch.count; ++k) {
    WallLoad<D>& wall = slab.walls[batch.second_body[k]];
    wall.force += to_eigen(batch.force.at(k));
    if (surfaces.turns[batch.second_body[k]] != 0) {
      wall.torque += to_eigen(batch.second_moment.at(k));
    }
  }
}

}  // namespace detail

// Adds the force of every touching pair of bodies of the list to both. Linear in candidates;
// allocates nothing once the slab has seen its largest load.
template <int D, class Law, class Observer>
void add_pair_forces(const Law& law,
                     const ForceSetting& setting,
                     ContactList<D>& list,
                     Bodies<D>& bodies,
                     ContactBatch<D>& batch,
                     SlabLoads<D>& slab,
                     Observer& observe) {
  const auto gather = [&](const CandidateRange& range, bool commits) {
    find_touching(range, commits, bodies, list, batch);
    if (batch.count == 0) return;
    gather_pairs(setting, list, bodies, batch);
    find_geometry(*setting.pairs, batch);
    detail::use_linear_stiffness(law, batch);
  };
  for (const CandidateRange& range : list.ranges) {
    if (range.is_part) {
      const auto look = [&](const CandidateRange& part) { gather(part, false); };
      detail::sum_spread_group(detail::whole_group(range, false, bodies, list), look, batch);
    }
    gather(range, Observer::commits);
    if (batch.count == 0) continue;
    if (!range.is_part) detail::sum_whole_groups(law, batch);
    detail::look_for_deep_overlap(setting, batch, false, slab.trouble);
    apply_law(law, *setting.pairs, batch);
    observe(BatchView<D>{batch, list, *setting.pairs, as_chosen(law), false});
    if constexpr (Observer::commits) {
      detail::keep_springs_of(law, batch, list);
      load_pairs(batch, bodies, slab);
    }
    slab.contact_count += batch.count;
  }
}

// The same for every sphere that touches a wall. `walls` are where they are now.
template <int D, class Law, class Observer>
void add_wall_forces(const Law& law,
                     const ForceSetting& setting,
                     const std::vector<Wall>& walls,
                     const WallSurfaces<D>& surfaces,
                     ContactList<D>& list,
                     Bodies<D>& bodies,
                     ContactBatch<D>& batch,
                     SlabLoads<D>& slab,
                     Observer& observe) {
  const auto gather = [&](const CandidateRange& range, bool commits) {
    detail::find_touching_walls(range, commits, walls, bodies, list, batch);
    if (batch.count == 0) return;
    gather_walls(setting, list, bodies, surfaces.motion, surfaces.material, batch);
    find_wall_stiffness(*setting.pairs, batch);
    detail::use_linear_stiffness(law, batch);
  };
  for (const CandidateRange& range : list.ranges) {
    if (range.is_part) {
      const auto look = [&](const CandidateRange& part) { gather(part, false); };
      detail::sum_spread_group(detail::whole_group(range, true, bodies, list), look, batch);
    }
    gather(range, Observer::commits);
    if (batch.count == 0) continue;
    if (!range.is_part) detail::sum_whole_groups(law, batch);
    detail::look_for_deep_overlap(setting, batch, true, slab.trouble);
    apply_law(law, *setting.pairs, batch);
    observe(BatchView<D>{batch, list, *setting.pairs, as_chosen(law), true});
    if constexpr (Observer::commits) {
      detail::keep_springs_of(law, batch, list);
      detail::load_walls(batch, surfaces, bodies, slab);
    }
    slab.contact_count += batch.count;
  }
}

}  // namespace graintruth::sim
