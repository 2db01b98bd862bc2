// Forces of all touching contacts, group by group: body pair after body pair, then body and wall.
// Contacts are gathered into batches, the law runs over each batch, and its forces go to the bodies
// in the order of the groups, so that the same bits come out however the batches fall.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "sim/engine/contact_kernel.h"
#include "sim/engine/contact_rows.h"
#include "sim/engine/contacts.h"
#include "sim/engine/wall_surfaces.h"

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

namespace detail {

template <int D>
inline void note_overlap(const ContactBatch<D>& batch, int k, bool wall, OverlapTrouble& trouble) {
  const double overlap = batch.overlap.at(k);
  if (trouble.found && !(overlap > trouble.overlap)) return;
  trouble = {true, batch.first_body[k], batch.second_body[k], wall, overlap};
}

// The rows of the touches of the candidates of a range.
template <int D>
void take_touches(const CandidateRange& range,
                  bool commits,
                  ContactList<D>& list,
                  ContactBatch<D>& batch) {
  batch.count = 0;
  if (commits) {
    std::fill(list.is_touching.begin() + range.begin, list.is_touching.begin() + range.end, kOpen);
  }
  const auto is_before = [](const WallTouch<D>& touch, int candidate) {
    return touch.candidate < candidate;
  };
  const auto& touches = batch.wall_touches;
  for (auto touch = std::lower_bound(touches.begin(), touches.end(), range.begin, is_before);
       touch != touches.end() && touch->candidate < range.end;
       ++touch) {
    if (commits) list.is_touching[touch->candidate] = kTouching;
    const int k = batch.count++;
    batch.candidate[k] = touch->candidate;
    batch.carries_on[k] = touch->carries_on;
    batch.was_touching[k] = touch->was_touching;
    batch.overlap.set(k, touch->overlap);
    batch.normal.set(k, touch->normal);
  }
}

// Candidates of the group of which the range is a part.
template <int D>
CandidateRange whole_group(const CandidateRange& part,
                           const std::vector<int>& body_of_second,
                           const Bodies<D>& bodies,
                           const ContactList<D>& list) {
  const auto& body = bodies.body_of_sphere;
  const auto is_of_group = [&](int c) {
    return body[list.first_sphere[c]] == body[list.first_sphere[part.begin]] &&
           body_of_second[list.second[c]] == body_of_second[list.second[part.begin]];
  };
  CandidateRange whole = part;
  while (whole.begin > 0 && is_of_group(whole.begin - 1)) --whole.begin;
  while (whole.end < list.count() && is_of_group(whole.end)) ++whole.end;
  return whole;
}

// Visits the rows of a group that is spread over several batches. `gather` fills a batch without
// committing anything.
template <int D, class Gather, class Visit>
void visit_spread_group(const CandidateRange& group,
                        const Gather& gather,
                        ContactBatch<D>& batch,
                        const Visit& visit) {
  double number = 0.0;
  for (int begin = group.begin; begin < group.end; begin += kBatchRows - 1) {
    gather(CandidateRange{begin, std::min(begin + kBatchRows - 1, group.end), true});
    for (int k = 0; k < batch.count; ++k) visit(k);
    number += batch.count;
  }
  batch.contact_count.value.fill(number);
}

// Rows of groups all of which are in the batch. Their number is asked for by one law alone.
template <int D, class Law>
void count_whole_groups(const Law& law, ContactBatch<D>& batch) {
  if (law.sharing != DampingSharing::inv_n) return;
  if (batch.longest_group == 1) {
    batch.contact_count.value.fill(1.0);
    return;
  }
  count_groups(batch.count, batch.group.value.data(), batch.contact_count.value.data());
}

template <int D>
WallPush<D> wall_push(const ContactBatch<D>& batch, int k) {
  return {batch.normal.at(k), batch.stiffness.at(k)};
}

// Each of them shares the damping with the others as far as they push along its line:
//   K_i = sum_j k_j |n_i . n_j|
// On one plane that is the sum of all, in a corner of right angles each is alone, and of two equal
// ones at any angle it is k (1 + |cos|), the stiffness along the line between them.
template <int D>
double stiffness_along(typename Motion<D>::Vector normal, const std::vector<WallPush<D>>& group) {
  double sum = 0.0;
  for (const WallPush<D>& push : group) sum += push.stiffness * std::abs(dot(push.normal, normal));
  return sum;
}
template <int D>
void sum_wall_groups(ContactBatch<D>& batch) {
  std::copy_n(batch.stiffness.value.begin(), batch.count, batch.sum_of_stiffness.value.begin());
  if (batch.longest_group == 1) return;
  std::vector<WallPush<D>>& group = batch.wall_pushes;
  for (int begin = 0, end = 0; begin < batch.count; begin = end) {
    group.clear();
    for (; end < batch.count && batch.group.at(end) == batch.group.at(begin); ++end) {
      group.push_back(wall_push(batch, end));
    }
    for (int k = begin; k < end && end - begin > 1; ++k) {
      batch.sum_of_stiffness.set(k, stiffness_along<D>(batch.normal.at(k), group));
    }
  }
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
      double stiffness = 0.0;
      detail::visit_spread_group(
          detail::whole_group(range, bodies.body_of_sphere, bodies, list), look, batch, [&](int k) {
            stiffness += batch.stiffness.at(k);
          });
      batch.sum_of_stiffness.value.fill(stiffness);
    }
    gather(range, Observer::commits);
    if (batch.count == 0) continue;
    if (!range.is_part) {
      sum_groups(batch);
      detail::count_whole_groups(law, batch);
    }
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
    detail::take_touches(range, commits, list, batch);
    if (batch.count == 0) return;
    gather_walls(setting, list, bodies, surfaces, batch);
    find_wall_stiffness(*setting.pairs, batch);
    detail::use_linear_stiffness(law, batch);
  };
  find_wall_touches(walls, surfaces.bodies, bodies, list, batch.wall_touches);
  for (const CandidateRange& range : list.ranges) {
    std::vector<WallPush<D>> of_group;
    if (range.is_part) {
      const auto look = [&](const CandidateRange& part) { gather(part, false); };
      detail::visit_spread_group(detail::whole_group(range, surfaces.bodies.of_wall, bodies, list),
                                 look,
                                 batch,
                                 [&](int k) { of_group.push_back(detail::wall_push(batch, k)); });
    }
    gather(range, Observer::commits);
    if (batch.count == 0) continue;
    if (range.is_part) {
      for (int k = 0; k < batch.count; ++k) {
        batch.sum_of_stiffness.set(k, detail::stiffness_along<D>(batch.normal.at(k), of_group));
      }
    } else {
      detail::sum_wall_groups(batch);
      detail::count_whole_groups(law, batch);
    }
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
