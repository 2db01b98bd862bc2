#include "sim/engine/contact_kernel.h"

#include <algorithm>

#include "sim/engine/processor_variants.h"

namespace graintruth::sim {
namespace {

// The materials of a row. Those of a batch of one pair are read once.
struct OnePair {
  PairMaterial pair;
  OnePair(const PairTable& pairs, const int* index) : pair(pairs[index[0]]) {}
  const PairMaterial& at(int) const { return pair; }
};
struct AnyPair {
  const PairMaterial* pairs;
  const int* index;
  AnyPair(const PairTable& table, const int* of_row) : pairs(table.data()), index(of_row) {}
  const PairMaterial& at(int k) const { return pairs[index[k]]; }
};

// overlap = R1 + R2 - distance, normal from first to second (thesis 1.30-1.33)
// R* = R1 R2/(R1 + R2) (thesis 1.4); it and the normal share one division
template <int D, class Pairs>
[[gnu::always_inline]] inline void find_geometry_of(const Pairs& materials,
                                                    ContactBatch<D>& batch) {
  const int rows = whole_rows(batch.count);
#pragma GCC ivdep
  for (int k = 0; k < rows; ++k) {
    const auto apart = batch.second_sphere.at(k) - batch.first_sphere.at(k);
    const double first = batch.radius.at(k), second = batch.second_radius.at(k);
    const double reach = first + second;
    const double distance = std::sqrt(dot(apart, apart));
    const double overlap = reach - distance;
    const double inverse = 1.0 / (reach * distance);
    const double reduced_radius = first * second * (inverse * distance);
    batch.normal.set(k, (inverse * reach) * apart);
    batch.overlap.set(k, overlap);
    batch.reduced_radius.set(k, reduced_radius);
    batch.stiffness.set(k, hertz_stiffness(materials.at(k), reduced_radius, overlap));
  }
}

// Every row adds up the rows of its group, in their order, so that all of them get the same bits.
// Small groups: by looking as many rows to either side as the longest has others, without a branch.
constexpr int kSmallGroup = 8;

// Copies with room on either side, so that looking aside needs no care at the ends.
struct SurroundedRows {
  std::array<double, kBatchRows + 2 * kSmallGroup> number;
  SurroundedRows(const double* rows, int count, double around) {
    std::fill_n(number.begin(), kSmallGroup, around);
    std::copy_n(rows, count, number.begin() + kSmallGroup);
    std::fill_n(number.begin() + kSmallGroup + count, kSmallGroup, around);
  }
  const double* aside(int rows) const { return number.data() + kSmallGroup + rows; }
};

[[gnu::always_inline]] inline void sum_small_groups(
    int longest_group, int rows, const double* group, const double* stiffness, double* sum) {
  const SurroundedRows groups(group, rows, -1.0), numbers(stiffness, rows, 0.0);
  std::fill_n(sum, rows, 0.0);
  for (int aside = 1 - longest_group; aside < longest_group; ++aside) {
    const double *other = groups.aside(aside), *number = numbers.aside(aside);
#pragma GCC ivdep
    for (int k = 0; k < rows; ++k) sum[k] += other[k] == group[k] ? number[k] : 0.0;
  }
}

inline void sum_large_groups(int count, const double* group, const double* stiffness, double* sum) {
  for (int begin = 0; begin < count;) {
    double total = 0.0;
    int end = begin;
    for (; end < count && group[end] == group[begin]; ++end) total += stiffness[end];
    std::fill(sum + begin, sum + end, total);
    begin = end;
  }
}

template <int D>
[[gnu::always_inline]] inline void sum_groups_of(ContactBatch<D>& batch) {
  const double* group = batch.group.value.data();
  const double* stiffness = batch.stiffness.value.data();
  double* sum = batch.sum_of_stiffness.value.data();
  const int rows = whole_rows(batch.count);
  if (batch.longest_group == 1) {
    std::copy_n(stiffness, rows, sum);
  } else if (batch.longest_group <= kSmallGroup) {
    sum_small_groups(batch.longest_group, rows, group, stiffness, sum);
  } else {
    sum_large_groups(rows, group, stiffness, sum);
  }
}

// The force that presses, before the dashpot. Under a law with a memory, of which `remembered` is
// carried on, it may depend on the past; so may the tangential spring.
template <int D>
double remembered_force(const ChosenLaw& law,
                        const PairMaterial& pair,
                        const ContactBatch<D>& batch,
                        int k,
                        double approach,
                        typename Motion<D>::Tangent& spring,
                        RememberedContact<D>& remembered) {
  const double stiffness = batch.stiffness.at(k);
  ContactMemory<D>& memory = remembered.memory;
  if (batch.was_touching[k] == kOpen) memory = {};
  double force = elastic_force(law, stiffness, batch.overlap.at(k));
  if (law.normal_spring == NormalSpring::incremental) {
    const double hertz = hertz_force(stiffness, batch.overlap.at(k));
    const double factor = stiffness_factor_of(pair, batch.reduced_radius.at(k));
    force = incremental_force(memory.elastic_force, approach, factor, hertz);
    memory.elastic_force = force;
  }
  if (law.tangential_spring == TangentialSpring::mindlin_scaled) {
    const double now = tangential_stiffness_of(law, pair, stiffness);
    if (now > memory.stiffness) spring = (memory.stiffness / now) * spring;
    memory.stiffness = now;
  }
  remembered.elastic_force = force;
  return force;
}

template <int D, class Law, class Pairs>
[[gnu::always_inline]] inline void apply_law_to(const Law& law,
                                                const Pairs& materials,
                                                ContactBatch<D>& batch) {
  // Copies of the last contact would carry its memory on once more
  const bool remembers = !std::is_same_v<Law, DefaultLaw>;
  const int rows = remembers ? batch.count : whole_rows(batch.count);
#pragma GCC ivdep
  for (int k = 0; k < rows; ++k) {
    const PairMaterial& pair = materials.at(k);
    const auto normal = batch.normal.at(k);
    const double overlap = batch.overlap.at(k);
    const double stiffness = batch.stiffness.at(k);

    // 1. Relative motion of the two surfaces at the contact point, x1 + lever: that of the second
    //    body where the first one's centre is, and the difference of the spins
    //      u(lever) = u(0) + (w_2 - w_1) x lever,   u(0) = v_2 + w_2 x (x_1 - x_2) - v_1
    //    Half a step back it stretches the springs, now it drives the dashpots.
    const auto lever = lever_of(batch, k);
    const auto offset = batch.first.position.at(k) - batch.second.position.at(k);
    const auto spin = batch.second.spin.at(k), spin_now = batch.second.spin_now.at(k);
    const auto relative_spin = spin - batch.first.spin.at(k);
    const auto relative_spin_now = spin_now - batch.first.spin_now.at(k);
    const auto moved = batch.second.velocity.at(k) + spin_velocity(spin, offset) -
                       batch.first.velocity.at(k) + spin_velocity(relative_spin, lever);
    const auto moving = batch.second.velocity_now.at(k) + spin_velocity(spin_now, offset) -
                        batch.first.velocity_now.at(k) + spin_velocity(relative_spin_now, lever);
    SurfaceMotion<D> motion;
    motion.normal_speed = dot(moving, normal);
    motion.tangential = tangential_part(moving, normal, motion.normal_speed);
    motion.slip = batch.slip_time.at(k) * tangential_part(moved, normal, dot(moved, normal));

    // 2. Contact law
    const double dashpot = dashpot_per_stiffness(law,
                                                 pair.normal_damping,
                                                 batch.inverse_mass.at(k),
                                                 batch.sum_of_stiffness.at(k),
                                                 stiffness,
                                                 batch.contact_count.at(k));
    auto spring = batch.spring.at(k);
    double elastic;
    if constexpr (std::is_same_v<Law, DefaultLaw>) {
      elastic = elastic_force(law, stiffness, overlap);
    } else {
      const double approach = -batch.slip_time.at(k) * dot(moved, normal);
      elastic = remembered_force(law, pair, batch, k, approach, spring, batch.remembered[k]);
    }
    const ContactForce<D> force = contact_force<D>(law,
                                                   pair,
                                                   motion,
                                                   normal,
                                                   elastic,
                                                   stiffness,
                                                   dashpot,
                                                   batch.was_touching[k] == kSliding,
                                                   spring);
    batch.spring.set(k, spring);
    batch.normal_force.set(k, force.normal);
    batch.tangential_force.set(k, force.tangential);
    batch.slides.set(k, force.slides ? 1.0 : 0.0);
    batch.normal_speed.set(k, motion.normal_speed);
    batch.tangential_speed.set(k, motion.tangential);

    // 3. On the second body; the first gets the opposite
    const auto on_second = force.normal * normal + as_vector(force.tangential, normal);
    batch.force.set(k, on_second);
    const auto about_first = moment(lever, on_second);
    batch.moment.set(k, about_first);
    // About the second centre: that about the first and (x_1 - x_2) x force
    batch.second_moment.set(k, about_first + moment(offset, on_second));

    // 4. Against rolling: the same moment on both, the other way round
    if constexpr (!std::is_same_v<Law, DefaultLaw>) {
      if (!law.has_rolling_friction) continue;
      RememberedContact<D>& remembered = batch.remembered[k];
      remembered.rolling = rolling_resistance<D>(pair,
                                                 batch.slip_time.at(k) * relative_spin,
                                                 relative_spin_now,
                                                 normal,
                                                 batch.reduced_radius.at(k),
                                                 stiffness,
                                                 1.0 / batch.inverse_mass.at(k),
                                                 std::max(force.normal, 0.0),
                                                 remembered.memory.rolled);
      batch.moment.set(k, batch.moment.at(k) + remembered.rolling.moment);
      batch.second_moment.set(k, batch.second_moment.at(k) + remembered.rolling.moment);
    }
  }
}

// One loop for batches of one pair of materials, one for any.
template <int D>
[[gnu::always_inline]] inline void find_geometry_in(const PairTable& pairs,
                                                    ContactBatch<D>& batch) {
  if (batch.is_of_one_pair) {
    find_geometry_of(OnePair(pairs, batch.pair.data()), batch);
  } else {
    find_geometry_of(AnyPair(pairs, batch.pair.data()), batch);
  }
}
template <int D>
[[gnu::always_inline]] inline void apply_law_in(const DefaultLaw& law,
                                                const PairTable& pairs,
                                                ContactBatch<D>& batch) {
  if (batch.is_of_one_pair) {
    apply_law_to(law, OnePair(pairs, batch.pair.data()), batch);
  } else {
    apply_law_to(law, AnyPair(pairs, batch.pair.data()), batch);
  }
}

template <int D, class Pairs>
[[gnu::always_inline]] inline void find_wall_stiffness_of(const Pairs& materials,
                                                          ContactBatch<D>& batch) {
  const int rows = whole_rows(batch.count);
#pragma GCC ivdep
  for (int k = 0; k < rows; ++k) {
    // R* = R1 at a flat wall
    const double radius = batch.radius.at(k);
    batch.reduced_radius.set(k, radius);
    batch.stiffness.set(k, hertz_stiffness(materials.at(k), radius, batch.overlap.at(k)));
  }
}

template <int D>
[[gnu::always_inline]] inline void find_wall_stiffness_in(const PairTable& pairs,
                                                          ContactBatch<D>& batch) {
  if (batch.is_of_one_pair) {
    find_wall_stiffness_of(OnePair(pairs, batch.pair.data()), batch);
  } else {
    find_wall_stiffness_of(AnyPair(pairs, batch.pair.data()), batch);
  }
}

template <int D>
[[gnu::always_inline]] inline bool may_be_deeper_in(double share, const ContactBatch<D>& batch) {
  const int rows = whole_rows(batch.count);
  int suspects = 0;
  for (int k = 0; k < rows; ++k) {
    suspects += batch.overlap.at(k) > share * batch.reduced_radius.at(k) ? 1 : 0;
  }
  return suspects > 0;
}

}  // namespace

GRAINTRUTH_FOR_EACH_PROCESSOR bool may_be_deeper(double share, const ContactBatch<2>& batch) {
  return may_be_deeper_in(share, batch);
}
GRAINTRUTH_FOR_EACH_PROCESSOR bool may_be_deeper(double share, const ContactBatch<3>& batch) {
  return may_be_deeper_in(share, batch);
}

GRAINTRUTH_FOR_EACH_PROCESSOR void find_geometry(const PairTable& pairs, ContactBatch<2>& batch) {
  find_geometry_in(pairs, batch);
}
GRAINTRUTH_FOR_EACH_PROCESSOR void find_geometry(const PairTable& pairs, ContactBatch<3>& batch) {
  find_geometry_in(pairs, batch);
}

GRAINTRUTH_FOR_EACH_PROCESSOR void find_wall_stiffness(const PairTable& pairs,
                                                       ContactBatch<2>& batch) {
  find_wall_stiffness_in(pairs, batch);
}
GRAINTRUTH_FOR_EACH_PROCESSOR void find_wall_stiffness(const PairTable& pairs,
                                                       ContactBatch<3>& batch) {
  find_wall_stiffness_in(pairs, batch);
}

GRAINTRUTH_FOR_EACH_PROCESSOR void sum_groups(ContactBatch<2>& batch) { sum_groups_of(batch); }
GRAINTRUTH_FOR_EACH_PROCESSOR void sum_groups(ContactBatch<3>& batch) { sum_groups_of(batch); }

void count_groups(int rows, const double* group, double* count) {
  for (int begin = 0; begin < rows;) {
    int end = begin;
    while (end < rows && group[end] == group[begin]) ++end;
    std::fill(count + begin, count + end, end - begin);
    begin = end;
  }
}

GRAINTRUTH_FOR_EACH_PROCESSOR void apply_law(const DefaultLaw& law,
                                             const PairTable& pairs,
                                             ContactBatch<2>& batch) {
  apply_law_in(law, pairs, batch);
}
GRAINTRUTH_FOR_EACH_PROCESSOR void apply_law(const DefaultLaw& law,
                                             const PairTable& pairs,
                                             ContactBatch<3>& batch) {
  apply_law_in(law, pairs, batch);
}
void apply_law(const ChosenLaw& law, const PairTable& pairs, ContactBatch<2>& batch) {
  apply_law_to(law, AnyPair(pairs, batch.pair.data()), batch);
}
void apply_law(const ChosenLaw& law, const PairTable& pairs, ContactBatch<3>& batch) {
  apply_law_to(law, AnyPair(pairs, batch.pair.data()), batch);
}

}  // namespace graintruth::sim
