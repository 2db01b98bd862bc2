#include "sim/engine/contact_rows.h"

#include <algorithm>

#include "sim/engine/processor_variants.h"
#include "sim/engine/transpose.h"

namespace graintruth::sim {
namespace {

std::array<Rows, 3> columns_of_spheres(BatchVectors<2>& centre, BatchScalars& radius) {
  return {centre.x.data(), centre.z.data(), radius.value.data()};
}
std::array<Rows, 4> columns_of_spheres(BatchVectors<3>& centre, BatchScalars& radius) {
  return {centre.x.data(), centre.y.data(), centre.z.data(), radius.value.data()};
}

// Squared distances of four pairs of spheres against the squared sums of their radii. A placed
// sphere is its centre and its radius: turning the sign of the first one's radius makes one
// subtraction give what is apart and the sum of the radii.
template <int D, bool is_periodic>
[[gnu::always_inline]] inline void touch(const Bodies<D>& bodies,
                                         const int* first,
                                         const int* second,
                                         int* touches) {
  const PlacedSphere<D>* spheres = bodies.spheres.data();
  const Quad sign = D == 2 ? Quad{1.0, 1.0, -1.0, 1.0} : Quad{1.0, 1.0, 1.0, -1.0};
  Quad apart[4];
#pragma GCC unroll 4
  for (int i = 0; i < 4; ++i) {
    Quad one, other;
    read_quad(spheres[first[i]], 0, one);
    read_quad(spheres[second[i]], 0, other);
    apart[i] = other - sign * one;
  }
  transpose(apart);
  if constexpr (is_periodic) {
    const auto length = to_eigen(bodies.cell.length),
               inverse = to_eigen(bodies.cell.inverse_length);
    for (int axis = 0; axis < D; ++axis) {
      const Quad whole = (inverse[axis] * apart[axis] + kMakesWhole) - kMakesWhole;
      apart[axis] = apart[axis] - length[axis] * whole;
    }
  }
  Quad squared = apart[0] * apart[0] + apart[1] * apart[1];
  if constexpr (D == 3) squared = squared + apart[2] * apart[2];
  const auto mask = squared < apart[D] * apart[D];
#pragma GCC unroll 4
  for (int i = 0; i < 4; ++i) touches[i] = static_cast<int>(mask[i] & 1);
}

template <int D, bool is_periodic>
[[gnu::always_inline]] inline void find_touching_among(const CandidateRange& range,
                                                       bool commits,
                                                       const Bodies<D>& bodies,
                                                       ContactList<D>& list,
                                                       ContactBatch<D>& batch) {
  const int count = range.end - range.begin;
  const int* first = list.first_sphere.data() + range.begin;
  const int* second = list.second.data() + range.begin;
  short* state = list.is_touching.data() + range.begin;
  std::array<int, kBatchRows> touches;
  int c = 0;
  for (; c + 4 <= count; c += 4) {
    touch<D, is_periodic>(bodies, first + c, second + c, touches.data() + c);
  }
  if (c < count) {
    // The last few, and the last of them again
    int last_first[4], last_second[4];
    for (int i = 0; i < 4; ++i) {
      last_first[i] = first[std::min(c + i, count - 1)];
      last_second[i] = second[std::min(c + i, count - 1)];
    }
    touch<D, is_periodic>(bodies, last_first, last_second, touches.data() + c);
  }
  // The row of one that does not touch is written over by the next: no branch, since nobody can
  // foretell the outcome
  int rows = 0;
  for (c = 0; c < count; ++c) {
    batch.candidate[rows] = range.begin + c;
    batch.was_touching[rows] = state[c];
    rows += touches[c];
    // The second body is anywhere in memory; it is asked for early
    __builtin_prefetch(&bodies.motion[bodies.body_of_sphere[second[c]]]);
  }
  batch.count = rows;
  if (!commits) return;
  for (c = 0; c < count; ++c) state[c] = static_cast<short>(touches[c]);
}

template <int D>
[[gnu::always_inline]] inline void find_touching_in(const CandidateRange& range,
                                                    bool commits,
                                                    const Bodies<D>& bodies,
                                                    ContactList<D>& list,
                                                    ContactBatch<D>& batch) {
  if (bodies.cell.is_periodic) {
    find_touching_among<D, true>(range, commits, bodies, list, batch);
  } else {
    find_touching_among<D, false>(range, commits, bodies, list, batch);
  }
}

// Copies of the last contact up to whole rows.
template <int D>
[[gnu::always_inline]] inline void fill_up(ContactBatch<D>& batch) {
  const int last = batch.count - 1;
  for (int k = batch.count; k < whole_rows(batch.count); ++k) {
    batch.candidate[k] = batch.candidate[last];
    batch.was_touching[k] = batch.was_touching[last];
  }
}

// Rows between the same two partners lie side by side; they are numbered, copies at the end apart.
// Without a branch: how long a group is nobody can foretell.
template <int D>
[[gnu::always_inline]] inline void number_groups(const int* first,
                                                 const int* second,
                                                 ContactBatch<D>& batch) {
  int group = 0, rows_of_group = 1;
  batch.group.set(0, 0.0);
  for (int k = 1; k < batch.count; ++k) {
    const int change = (first[k] ^ first[k - 1]) | (second[k] ^ second[k - 1]);
    const int is_same = change == 0 ? 1 : 0;
    group += 1 - is_same;
    rows_of_group = (rows_of_group & -is_same) + 1;
    batch.longest_group = std::max(batch.longest_group, rows_of_group);
    batch.group.set(k, group);
  }
  constexpr double kNoGroup = -2.0;
  for (int k = batch.count; k < whole_rows(batch.count); ++k) batch.group.set(k, kNoGroup);
}

[[gnu::always_inline]] inline bool are_equal(const int* numbers, int count) {
  int differences = 0;
  for (int k = 0; k < count; ++k) differences |= numbers[k] ^ numbers[0];
  return differences == 0;
}

// What does not depend on whether the partner is a body or a wall. `first_body` is there.
template <int D>
[[gnu::always_inline]] inline void gather_first(const ForceSetting& setting,
                                                const ContactList<D>& list,
                                                const Bodies<D>& bodies,
                                                ContactBatch<D>& batch) {
  const int rows = whole_rows(batch.count);
  const int *candidate = batch.candidate.data(), *sphere = list.first_sphere.data();
  const int* body = batch.first_body.data();
  batch.slip_time = setting.slip_time;
  for (int k = 0; k < rows; ++k) batch.spring_before.set(k, list.spring[candidate[k]]);
  for (int k = 0; k < rows; ++k) {
    const bool is_old = batch.was_touching[k] != kOpen;
    batch.spring_before.set(k, chosen(is_old, batch.spring_before.at(k), Motion<D>::no_tangent()));
  }
  const PlacedSphere<D>* spheres = bodies.spheres.data();
  const BodyMotion<D>* motion = bodies.motion.data();
  to_columns(
      rows,
      [=](int k) -> const PlacedSphere<D>& { return spheres[sphere[candidate[k]]]; },
      columns_of_spheres(batch.first_sphere, batch.radius));
  to_columns(
      rows,
      [=](int k) -> const BodyMotion<D>& { return motion[body[k]]; },
      columns_of(batch.first));
  if (!list.remembers()) return;
  for (int k = 0; k < batch.count; ++k) batch.remembered[k].memory = list.memory[candidate[k]];
}

// Masses and materials of the partners of each row.
template <int D>
[[gnu::always_inline]] inline void gather_kinds(const ForceSetting& setting,
                                                const Bodies<D>& bodies,
                                                ContactBatch<D>& batch) {
  const int rows = whole_rows(batch.count);
  batch.is_of_one_pair = bodies.are_alike;
  if (bodies.are_alike) {
    // Nothing has to be looked up
    const BodyKind<D>& kind = bodies.kind_of(0);
    const int pair = kind.material * (setting.material_count + 1);
    const double inverse_mass = kind.inverse_mass + kind.inverse_mass;
    std::fill_n(batch.pair.begin(), rows, pair);
    std::fill_n(batch.inverse_mass.value.begin(), rows, inverse_mass);
    std::fill_n(batch.first_turn.value.begin(), rows, kind.least_turn);
    std::fill_n(batch.second_turn.value.begin(), rows, kind.least_turn);
    return;
  }
  for (int k = 0; k < rows; ++k) {
    const BodyKind<D>& first = bodies.kind_of(batch.first_body[k]);
    const BodyKind<D>& second = bodies.kind_of(batch.second_body[k]);
    batch.pair[k] = first.material * setting.material_count + second.material;
    batch.inverse_mass.set(k, first.inverse_mass + second.inverse_mass);
    batch.first_turn.set(k, first.least_turn);
    batch.second_turn.set(k, second.least_turn);
  }
  batch.is_of_one_pair = are_equal(batch.pair.data(), rows);
}

template <int D>
[[gnu::always_inline]] inline void gather_pairs_in(const ForceSetting& setting,
                                                   const ContactList<D>& list,
                                                   const Bodies<D>& bodies,
                                                   ContactBatch<D>& batch) {
  fill_up(batch);
  const int rows = whole_rows(batch.count);
  const int *candidate = batch.candidate.data(), *sphere = list.second.data();
  const int *first = list.first_sphere.data(), *body_of = bodies.body_of_sphere.data();
  batch.second_goes = 1.0;
  for (int k = 0; k < rows; ++k) {
    batch.first_body[k] = body_of[first[candidate[k]]];
    batch.second_body[k] = body_of[sphere[candidate[k]]];
  }
  gather_kinds(setting, bodies, batch);
  batch.longest_group = 1;
  if (!bodies.are_single_spheres) {
    number_groups(batch.first_body.data(), batch.second_body.data(), batch);
  }
  gather_first(setting, list, bodies, batch);
  const PlacedSphere<D>* spheres = bodies.spheres.data();
  const BodyMotion<D>* motion = bodies.motion.data();
  const int* body = batch.second_body.data();
  to_columns(
      rows,
      [=](int k) -> const PlacedSphere<D>& { return spheres[sphere[candidate[k]]]; },
      columns_of_spheres(batch.second_sphere, batch.second_radius));
  to_columns(
      rows,
      [=](int k) -> const BodyMotion<D>& { return motion[body[k]]; },
      columns_of(batch.second));
  if (!bodies.cell.is_periodic) return;
  // The second partner where it is nearest to the first
  for (int k = 0; k < rows; ++k) {
    const auto sphere_now = batch.second_sphere.at(k);
    const auto shift = shift_to_nearest(bodies.cell, sphere_now - batch.first_sphere.at(k));
    batch.second_sphere.set(k, sphere_now + shift);
    batch.second.position.set(k, batch.second.position.at(k) + shift);
  }
}

template <int D>
[[gnu::always_inline]] inline void gather_walls_in(const ForceSetting& setting,
                                                   const ContactList<D>& list,
                                                   const Bodies<D>& bodies,
                                                   const WallSurfaces<D>& surfaces,
                                                   ContactBatch<D>& batch) {
  fill_up(batch);
  const int rows = whole_rows(batch.count);
  std::array<int, kBatchRows> wall_body;
  for (int k = 0; k < rows; ++k) {
    const int candidate = batch.candidate[k];
    const int body = bodies.body_of_sphere[list.first_sphere[candidate]];
    const int wall = list.second[candidate];
    batch.first_body[k] = body;
    batch.second_body[k] = wall;
    wall_body[k] = surfaces.bodies.of_wall[wall];
    const BodyKind<D>& kind = bodies.kind_of(body);
    batch.pair[k] = kind.material * setting.material_count + surfaces.material[wall];
    batch.inverse_mass.set(k, kind.inverse_mass);
    batch.first_turn.set(k, kind.least_turn);
    batch.second_turn.set(k, 0.0);
  }
  batch.is_of_one_pair = are_equal(batch.pair.data(), rows);
  batch.longest_group = 1;
  if (!bodies.are_single_spheres || !surfaces.bodies.are_all_alone) {
    number_groups(batch.first_body.data(), wall_body.data(), batch);
  }
  gather_first(setting, list, bodies, batch);
  for (int k = 0; k < batch.count; ++k) {
    const int before = batch.carries_on[k];
    if (before == batch.candidate[k]) continue;
    batch.spring_before.set(k, list.spring[before]);
    if (list.remembers()) batch.remembered[k].memory = list.memory[before];
  }
  for (int k = batch.count; k < rows; ++k) {
    batch.overlap.set(k, batch.overlap.at(batch.count - 1));
    batch.normal.set(k, batch.normal.at(batch.count - 1));
  }
  batch.second_goes = 0.0;
  const BodyMotion<D>* motion = surfaces.motion.data();
  const int* wall = batch.second_body.data();
  to_columns(
      rows,
      [=](int k) -> const BodyMotion<D>& { return motion[wall[k]]; },
      columns_of(batch.second));
}

template <int D>
[[gnu::always_inline]] inline void to_load_rows(BatchVectors<D>& force,
                                                BatchTangents<D>& moment,
                                                int rows,
                                                std::array<Load<D>, kBatchRows>& loads) {
  to_records(rows, columns_of(force, moment), [&loads](int k) -> Load<D>& { return loads[k]; });
}

// load + sign row
template <int D>
[[gnu::always_inline]] inline void add_row(double sign, const Load<D>& row, Load<D>& load) {
  Quad sum, more;
  read_quad(load, 0, sum);
  read_quad(row, 0, more);
  sum += sign * more;
  write_quad(sum, 0, load);
  if constexpr (D == 3) {
    Twin last, more_of_last;
    read_twin(load, 4, last);
    read_twin(row, 4, more_of_last);
    last += sign * more_of_last;
    write_twin(last, 4, load);
  }
}

template <int D>
[[gnu::always_inline]] inline void load_pairs_in(ContactBatch<D>& batch,
                                                 Bodies<D>& bodies,
                                                 SlabLoads<D>& slab) {
  const int rows = whole_rows(batch.count);
  to_load_rows<D>(batch.force, batch.moment, rows, batch.on_first);
  to_load_rows<D>(batch.force, batch.second_moment, rows, batch.on_second);
  Load<D>* loads = bodies.load.data();
  for (int k = 0; k < batch.count; ++k) {
    add_row(-1.0, batch.on_first[k], loads[batch.first_body[k]]);
    const int second = batch.second_body[k];
    if (second < slab.end) {
      add_row(1.0, batch.on_second[k], loads[second]);
    } else if (slab.puts_off) {
      slab.put_off(second, batch.on_second[k]);
    } else {
      add_row(1.0, batch.on_second[k], bodies.load_from_before[second]);
    }
  }
}

template <int D>
[[gnu::always_inline]] inline void load_first_in(ContactBatch<D>& batch, Bodies<D>& bodies) {
  to_load_rows<D>(batch.force, batch.moment, whole_rows(batch.count), batch.on_first);
  for (int k = 0; k < batch.count; ++k) {
    add_row(-1.0, batch.on_first[k], bodies.load[batch.first_body[k]]);
  }
}

}  // namespace

GRAINTRUTH_FOR_EACH_PROCESSOR void find_touching(const CandidateRange& range,
                                                 bool commits,
                                                 const Bodies<2>& bodies,
                                                 ContactList<2>& list,
                                                 ContactBatch<2>& batch) {
  find_touching_in(range, commits, bodies, list, batch);
}
GRAINTRUTH_FOR_EACH_PROCESSOR void gather_pairs(const ForceSetting& setting,
                                                const ContactList<2>& list,
                                                const Bodies<2>& bodies,
                                                ContactBatch<2>& batch) {
  gather_pairs_in(setting, list, bodies, batch);
}
GRAINTRUTH_FOR_EACH_PROCESSOR void gather_walls(const ForceSetting& setting,
                                                const ContactList<2>& list,
                                                const Bodies<2>& bodies,
                                                const WallSurfaces<2>& surfaces,
                                                ContactBatch<2>& batch) {
  gather_walls_in(setting, list, bodies, surfaces, batch);
}
GRAINTRUTH_FOR_EACH_PROCESSOR void load_pairs(ContactBatch<2>& batch,
                                              Bodies<2>& bodies,
                                              SlabLoads<2>& slab) {
  load_pairs_in(batch, bodies, slab);
}
GRAINTRUTH_FOR_EACH_PROCESSOR void load_first(ContactBatch<2>& batch, Bodies<2>& bodies) {
  load_first_in(batch, bodies);
}

GRAINTRUTH_FOR_EACH_PROCESSOR void find_touching(const CandidateRange& range,
                                                 bool commits,
                                                 const Bodies<3>& bodies,
                                                 ContactList<3>& list,
                                                 ContactBatch<3>& batch) {
  find_touching_in(range, commits, bodies, list, batch);
}
GRAINTRUTH_FOR_EACH_PROCESSOR void gather_pairs(const ForceSetting& setting,
                                                const ContactList<3>& list,
                                                const Bodies<3>& bodies,
                                                ContactBatch<3>& batch) {
  gather_pairs_in(setting, list, bodies, batch);
}
GRAINTRUTH_FOR_EACH_PROCESSOR void gather_walls(const ForceSetting& setting,
                                                const ContactList<3>& list,
                                                const Bodies<3>& bodies,
                                                const WallSurfaces<3>& surfaces,
                                                ContactBatch<3>& batch) {
  gather_walls_in(setting, list, bodies, surfaces, batch);
}
GRAINTRUTH_FOR_EACH_PROCESSOR void load_pairs(ContactBatch<3>& batch,
                                              Bodies<3>& bodies,
                                              SlabLoads<3>& slab) {
  load_pairs_in(batch, bodies, slab);
}
GRAINTRUTH_FOR_EACH_PROCESSOR void load_first(ContactBatch<3>& batch, Bodies<3>& bodies) {
  load_first_in(batch, bodies);
}

}  // namespace graintruth::sim
