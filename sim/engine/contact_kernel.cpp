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

// What the last step was for a contact.
struct StepOfContact {
  double slip_time;      // s; how long it has slipped
  double half;           // s; half the step, none for a contact that is new
  double dashpot_share;  // of a step that its dashpots act
};

// A contact that is new began within the last step, as long ago as the surfaces took to come so
// deep: t = min(step, overlap / speed of approach). So long has it slipped.
// Its dashpots must make up, with one push at the end of that time, for what they do from then
// until half a step on. Theirs go as c ~ d^(1/4) ~ t^(1/4), so with x = t/step their share is
//   [4/5 (x + 1/2)^(5/4) - (x + 1/2)^(-3/4)/100] / x^(1/4)
// the first term the integral, the second what the midpoint rule of the later steps leaves out:
// together -zeta(-1/4, 1 + x) (Hurwitz) to 1e-3 (Euler and Maclaurin). A constant dashpot has x +
// 1/2. The elastic force, t^(3/2), needs none of this.
inline StepOfContact first_step(bool is_linear, double step, double approach, double overlap) {
  if (step == 0.0) return {0.0, 0.0, 1.0};
  const double share = overlap / std::max(step * approach, overlap), later = share + 0.5;
  const double dashpot_share =
      is_linear ? later : std::sqrt(std::sqrt(later / share)) * (0.8 * later - 0.01 / later);
  return {share * step, 0.0, dashpot_share};
}

// Mean of a stiffness that goes with the root of the overlap, while that grows evenly.
inline double mean_of_roots(double from, double to) {
  return 2.0 / 3.0 * (from * from + from * to + to * to) / (from + to);
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
                        typename Motion<D>::Tangent& slip,
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
    if (now > memory.stiffness) {
      spring = (memory.stiffness / now) * spring;
      slip = (mean_of_roots(memory.stiffness, now) / now) * slip;
    }
    memory.stiffness = now;
  }
  remembered.elastic_force = force;
  return force;
}

inline double squared(double x) { return x * x; }

// What a push at the contact point moves, the turning of the bodies included, 1/kg: across the
// contact plane 1/m + |l x n|^2/I of both, along it 1/m + (l.n)^2/I, l the lever and I the largest
// principal moment: exact in the layer and for balls. Several contacts between two bodies mostly
// hold their turning about each other: across it is 1/m* for them.
struct FeltMass {
  double inverse_across, inverse_along;
};
template <int D>
[[gnu::always_inline]] inline FeltMass felt_mass(const ContactBatch<D>& batch,
                                                 int k,
                                                 typename Motion<D>::Vector lever,
                                                 typename Motion<D>::Vector offset) {
  const auto normal = batch.normal.at(k), second_lever = lever + offset;
  const double first_turn = batch.first_turn.at(k), second_turn = batch.second_turn.at(k);
  const double inverse_mass = batch.inverse_mass.at(k);
  const double reach = squared(dot(lever, normal));
  const double second_reach = squared(dot(second_lever, normal));
  const double along = inverse_mass + first_turn * reach + second_turn * second_reach;
  const double across = inverse_mass + first_turn * (dot(lever, lever) - reach) +
                        second_turn * (dot(second_lever, second_lever) - second_reach);
  const bool is_alone = batch.sum_of_stiffness.at(k) == batch.stiffness.at(k);
  return {is_alone ? across : inverse_mass, along};
}

inline double at_most_one(double x) { return x < 1.0 ? x : 1.0; }

// How the surfaces of a contact move, and what follows from that alone.
template <int D>
struct RowMotion {
  SurfaceMotion<D> surfaces;
  HalfStep<D> half_step;
  double viscosity;             // N s/m; of the normal dashpot
  double tangential_stiffness;  // N/m
  double slip_time;             // s
  double dashpot_share;         // of a step that the dashpots act
  double moved_apart;           // m/s; half a step back
};

// Under Pressure::of_now as if the contact had begun before the step.
template <Pressure of, int D, class Law>
[[gnu::always_inline]] inline RowMotion<D> motion_of_row(const Law& law,
                                                         const PairMaterial& pair,
                                                         ContactBatch<D>& batch,
                                                         int k) {
  const auto normal = batch.normal.at(k);
  const double stiffness = batch.stiffness.at(k);

  // Relative motion of the two surfaces at the contact point, x1 + lever
  const auto lever = lever_of(batch, k);
  batch.lever.set(k, lever);
  const auto offset = batch.first.position.at(k) - batch.second.position.at(k);
  const auto moving = predicted_motion(batch, k, lever);
  // Half a step back it stretches the springs, now it drives the dashpots. The place of the contact
  // on the second body was another then, and the overlap
  const auto first = batch.first.velocity.at(k), second = batch.second.velocity.at(k);
  const auto spin = batch.second.spin.at(k), relative_spin = spin - batch.first.spin.at(k);
  const auto parting = first - batch.second_goes * second;
  const auto carried = second - first + spin_velocity(relative_spin, lever);
  StepOfContact step{batch.slip_time, 0.5 * batch.slip_time, 1.0};
  if constexpr (of == Pressure::of_step) {
    if (batch.was_touching[k] == kOpen) {
      const double approach = -dot(carried + spin_velocity(spin, offset), normal);
      step = first_step(
          law.normal_spring == NormalSpring::linear, step.slip_time, approach, batch.overlap.at(k));
    }
  }
  const double slip_time = step.slip_time, back = 0.5 * slip_time;
  const auto moved_now = carried + spin_velocity(spin, offset - back * parting);
  const double moved_apart = dot(moved_now, normal);
  const auto moved = moved_now - 0.5 * back * moved_apart * spin_velocity(relative_spin, normal);
  const auto moved_along = tangential_part(moved, normal, moved_apart);

  // The velocity of now is predicted with the force of the last step. Since then the springs of
  // the group have gained K u dt, u of half a step back, and the dashpots c times twice what is
  // predicted beyond u: half a step of that over the mass is lacking. Leapfrog swings too fast by
  // w^2 dt^2/24, w^2 = K_t over that mass: the spring is softer by twice that
  const double sum = batch.sum_of_stiffness.at(k);
  const double dashpot = step.dashpot_share * dashpot_per_stiffness(law,
                                                                    pair.normal_damping,
                                                                    batch.inverse_mass.at(k),
                                                                    sum,
                                                                    stiffness,
                                                                    batch.contact_count.at(k));
  const FeltMass felt = felt_mass(batch, k, lever, offset);
  const double half_square = 0.5 * slip_time * slip_time, dashpot_step = slip_time * dashpot;
  const double across = felt.inverse_across * sum, along = felt.inverse_along * sum;  // 1/s2
  const double slowed = at_most_one(half_square * force_gain(law, across));
  const double damped = at_most_one(dashpot_step * across);
  const double slowed_along =
      at_most_one(half_square * (felt.inverse_along * tangential_stiffness_of(law, pair, sum)));
  const double damped_along = at_most_one(dashpot_step * pair.tangential_damping * along);
  const auto gained = moving - moved;
  const double apart_gained = dot(gained, normal);
  const auto along_gained = tangential_part(gained, normal, apart_gained);
  const double normal_speed = (1.0 - slowed) * moved_apart + (1.0 - damped) * apart_gained;
  const double viscosity = dashpot * stiffness;

  // A contact that is new has no half step before now
  const double is_old = step.half > 0.0 ? 1.0 : 0.0;
  RowMotion<D> motion;
  motion.surfaces.normal_speed = normal_speed;
  motion.surfaces.tangential =
      (1.0 - slowed_along) * moved_along + (1.0 - damped_along) * along_gained;
  motion.surfaces.slip = slip_time * moved_along;
  motion.half_step.duration = step.half;
  motion.half_step.normal_force =
      -(force_gain(law, stiffness) * step.half * normal_speed + is_old * viscosity * apart_gained);
  motion.half_step.velocity = is_old * along_gained;
  motion.viscosity = viscosity;
  motion.tangential_stiffness =
      tangential_stiffness_of(law, pair, stiffness) * (1.0 - (1.0 / 6.0) * slowed_along);
  motion.slip_time = slip_time;
  motion.dashpot_share = step.dashpot_share;
  motion.moved_apart = moved_apart;
  return motion;
}

// The law to one row that moves so. The answer is whether the contact ends within the step, 1 or 0.
template <Pressure of, int D, class Law>
[[gnu::always_inline]] inline double apply_law_to_row(
    const Law& law, const PairMaterial& pair, RowMotion<D> motion, ContactBatch<D>& batch, int k) {
  const auto normal = batch.normal.at(k);
  const double overlap = batch.overlap.at(k), stiffness = batch.stiffness.at(k);
  auto spring = batch.spring_before.at(k);
  double elastic;
  if constexpr (std::is_same_v<Law, DefaultLaw>) {
    elastic = elastic_force(law, stiffness, overlap);
  } else {
    const double approach = -motion.slip_time * motion.moved_apart;
    elastic = remembered_force(
        law, pair, batch, k, approach, spring, motion.surfaces.slip, batch.remembered[k]);
  }
  const ContactForce<D> force = contact_force<of, D>(law,
                                                     pair,
                                                     motion.surfaces,
                                                     motion.half_step,
                                                     normal,
                                                     overlap,
                                                     elastic,
                                                     motion.viscosity,
                                                     motion.tangential_stiffness,
                                                     batch.was_touching[k] == kSliding,
                                                     spring);
  batch.spring.set(k, spring);
  batch.normal_force.set(k, force.normal);
  batch.tangential_force.set(k, force.tangential);
  batch.slides.set(k, force.slides ? 1.0 : 0.0);

  // On the second body; the first gets the opposite
  const auto on_second = force.normal * normal + as_vector(force.tangential, normal);
  batch.force.set(k, on_second);
  const auto about_first = moment(batch.lever.at(k), on_second);
  batch.moment.set(k, about_first);
  // About the second centre: that about the first and (x_1 - x_2) x force
  const auto offset = batch.first.position.at(k) - batch.second.position.at(k);
  batch.second_moment.set(k, about_first + moment(offset, on_second));

  // Against rolling: the same moment on both, the other way round
  if constexpr (!std::is_same_v<Law, DefaultLaw>) {
    if (law.has_rolling_friction) {
      RememberedContact<D>& remembered = batch.remembered[k];
      const auto spin = batch.second.spin.at(k) - batch.first.spin.at(k);
      const auto spin_now = batch.second.spin_now.at(k) - batch.first.spin_now.at(k);
      remembered.rolling = rolling_resistance<D>(
          pair,
          motion.slip_time * spin,
          spin_now,
          normal,
          batch.reduced_radius.at(k),
          stiffness,
          1.0 / batch.inverse_mass.at(k),
          std::max(force.normal, 0.0),
          motion.dashpot_share * std::sqrt(stiffness / batch.sum_of_stiffness.at(k)),
          remembered.memory.rolled);
      batch.moment.set(k, batch.moment.at(k) + remembered.rolling.moment);
      batch.second_moment.set(k, batch.second_moment.at(k) + remembered.rolling.moment);
    }
  }
  return force.ends;
}

template <int D, class Law>
[[gnu::always_inline]] inline void apply_law_of_step_to(const Law& law,
                                                        const PairMaterial& pair,
                                                        ContactBatch<D>& batch,
                                                        int k) {
  constexpr Pressure of = Pressure::of_step;
  const RowMotion<D> motion = motion_of_row<of>(law, pair, batch, k);
  batch.normal_speed.set(k, motion.surfaces.normal_speed);
  batch.tangential_speed.set(k, motion.surfaces.tangential);
  apply_law_to_row<of>(law, pair, motion, batch, k);
}

// Not inlined, or the loop over the few that need it would run along all of them.
template <int D>
[[gnu::noinline]] void apply_law_of_step(const DefaultLaw& law,
                                         const PairMaterial& pair,
                                         ContactBatch<D>& batch,
                                         int k) {
  apply_law_of_step_to(law, pair, batch, k);
}

// Two loops, since the processor begins the next rows before it is done with these, but sees only
// so far ahead. Contacts that begin or end within the step are few: the loops take them for others,
// and they are done once more by themselves.
template <int D, class Pairs>
[[gnu::always_inline]] inline void apply_law_to(const DefaultLaw& law,
                                                const Pairs& materials,
                                                ContactBatch<D>& batch) {
  constexpr Pressure of = Pressure::of_now;
  const int rows = whole_rows(batch.count);
#pragma GCC ivdep
  for (int k = 0; k < rows; ++k) {
    const RowMotion<D> motion = motion_of_row<of>(law, materials.at(k), batch, k);
    batch.normal_speed.set(k, motion.surfaces.normal_speed);
    batch.tangential_speed.set(k, motion.surfaces.tangential);
    batch.slip.set(k, motion.surfaces.slip);
    batch.pressure_gained.set(k, motion.half_step.normal_force);
    batch.speed_gained.set(k, motion.half_step.velocity);
    batch.viscosity.set(k, motion.viscosity);
    batch.tangential_stiffness.set(k, motion.tangential_stiffness);
  }
  const double half = 0.5 * batch.slip_time;
#pragma GCC ivdep
  for (int k = 0; k < rows; ++k) {
    RowMotion<D> motion;
    motion.surfaces = {batch.normal_speed.at(k), batch.tangential_speed.at(k), batch.slip.at(k)};
    motion.half_step = {half, batch.pressure_gained.at(k), batch.speed_gained.at(k)};
    motion.viscosity = batch.viscosity.at(k);
    motion.tangential_stiffness = batch.tangential_stiffness.at(k);
    batch.ends.set(k, apply_law_to_row<of>(law, materials.at(k), motion, batch, k));
  }
  int begin_or_end = 0;
  for (int k = 0; k < rows; ++k) begin_or_end += batch.was_touching[k] == kOpen ? 1 : 0;
  for (int k = 0; k < rows; ++k) begin_or_end += batch.ends.at(k) != 0.0 ? 1 : 0;
  if (begin_or_end == 0) return;
  for (int k = 0; k < batch.count; ++k) {
    if (batch.was_touching[k] != kOpen && batch.ends.at(k) == 0.0) continue;
    apply_law_of_step(law, materials.at(k), batch, k);
  }
}
template <int D>
void apply_law_to(const ChosenLaw& law, const AnyPair& materials, ContactBatch<D>& batch) {
  for (int k = 0; k < batch.count; ++k) apply_law_of_step_to(law, materials.at(k), batch, k);
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
