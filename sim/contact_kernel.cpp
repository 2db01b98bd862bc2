#include "sim/contact_kernel.h"

#include <algorithm>

#include "sim/processor_variants.h"

namespace graintruth::sim {
namespace {

// overlap = R1 + R2 - distance, normal from first to second (thesis 1.30-1.33)
template <int D>
[[gnu::always_inline]] inline void find_geometry_of(ContactBatch<D>& batch) {
  const int count = batch.count;
#pragma GCC ivdep
  for (int k = 0; k < count; ++k) {
    const double distance = std::sqrt(batch.distance_squared.at(k));
    const double overlap = batch.reach.at(k) - distance;
    batch.normal.set(k, (1.0 / distance) * batch.apart.at(k));
    batch.overlap.set(k, overlap);
    batch.stiffness.set(k, hertz_stiffness(batch.stiffness_factor.at(k), overlap));
  }
}

// Every row adds up the rows of its group, in their order, so that all of them get the same bits.
// Small groups: by looking as many rows to either side as the longest has others, without a branch.
constexpr int kSmallGroup = 8;

// Length of the longest run of rows of one group, as far as it is small: one look along all rows
// for each length.
[[gnu::always_inline]] inline int longest_of_small_groups(int count, const int* group) {
  for (int length = 1; length <= kSmallGroup; ++length) {
    int longer = 0;
    for (int k = length; k < count; ++k) longer += group[k] == group[k - length] ? 1 : 0;
    if (longer == 0) return length;
  }
  return kSmallGroup + 1;
}

[[gnu::always_inline]] inline void sum_small_groups(
    int longest_group, int count, const int* group, const double* stiffness, double* sum) {
  std::fill_n(sum, count, 0.0);
  for (int aside = 1 - longest_group; aside < longest_group; ++aside) {
    const int begin = aside < 0 ? -aside : 0;
    const int end = aside > 0 ? count - aside : count;
#pragma GCC ivdep
    for (int k = begin; k < end; ++k) {
      sum[k] += group[k + aside] == group[k] ? stiffness[k + aside] : 0.0;
    }
  }
}

inline void sum_large_groups(int count, const int* group, const double* stiffness, double* sum) {
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
  const int* group = batch.group.data();
  const double* stiffness = batch.stiffness.value.data();
  double* sum = batch.sum_of_stiffness.value.data();
  const int longest = longest_of_small_groups(batch.count, group);
  if (longest <= kSmallGroup) {
    sum_small_groups(longest, batch.count, group, stiffness, sum);
  } else {
    sum_large_groups(batch.count, group, stiffness, sum);
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
    force = incremental_force(memory.elastic_force, approach, batch.stiffness_factor.at(k), hertz);
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

// R* from the stiffness factor 2 E* sqrt(R*).
inline double reduced_radius_of(const PairMaterial& pair, double stiffness_factor) {
  const double root = stiffness_factor / (2.0 * pair.normal_modulus);
  return root * root;
}

template <int D, class Law>
[[gnu::always_inline]] inline void apply_law_to(const Law& law,
                                                const PairTable& pairs,
                                                ContactBatch<D>& batch) {
  const int count = batch.count;
  const PairMaterial* materials = pairs.data();
#pragma GCC ivdep
  for (int k = 0; k < count; ++k) {
    const PairMaterial& pair = materials[batch.pair[k]];
    const auto normal = batch.normal.at(k);
    const double overlap = batch.overlap.at(k);
    const double stiffness = batch.stiffness.at(k);

    // 1. Relative motion of the two surfaces at the contact point, x1 + (R1 - overlap/2) n
    const auto lever = batch.arm.at(k) + (batch.radius.at(k) - 0.5 * overlap) * normal;
    const auto moved = batch.moved.at_centre.at(k) + spin_velocity(batch.moved.spin.at(k), lever);
    const auto moving =
        batch.moving.at_centre.at(k) + spin_velocity(batch.moving.spin.at(k), lever);
    SurfaceMotion<D> motion;
    motion.normal_speed = dot(moving, normal);
    motion.tangential = tangential_part(moving, normal, motion.normal_speed);
    motion.slip = batch.slip_time.at(k) * tangential_part(moved, normal, dot(moved, normal));

    // 2. Contact law
    const double dashpot = dashpot_per_stiffness(law,
                                                 pair.normal_damping,
                                                 batch.reduced_mass.at(k),
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
    batch.second_moment.set(k, about_first + moment(batch.offset.at(k), on_second));

    // 4. Against rolling: the same moment on both, the other way round
    if constexpr (!std::is_same_v<Law, DefaultLaw>) {
      if (!law.has_rolling_friction) continue;
      RememberedContact<D>& remembered = batch.remembered[k];
      remembered.rolling =
          rolling_resistance<D>(pair,
                                batch.slip_time.at(k) * batch.moved.spin.at(k),
                                batch.moving.spin.at(k),
                                normal,
                                reduced_radius_of(pair, batch.stiffness_factor.at(k)),
                                stiffness,
                                batch.reduced_mass.at(k),
                                std::max(force.normal, 0.0),
                                remembered.memory.rolled);
      batch.moment.set(k, batch.moment.at(k) + remembered.rolling.moment);
      batch.second_moment.set(k, batch.second_moment.at(k) + remembered.rolling.moment);
    }
  }
}

}  // namespace

GRAINTRUTH_FOR_EACH_PROCESSOR void find_geometry(ContactBatch<2>& batch) {
  find_geometry_of(batch);
}
GRAINTRUTH_FOR_EACH_PROCESSOR void find_geometry(ContactBatch<3>& batch) {
  find_geometry_of(batch);
}

GRAINTRUTH_FOR_EACH_PROCESSOR void sum_groups(ContactBatch<2>& batch) { sum_groups_of(batch); }
GRAINTRUTH_FOR_EACH_PROCESSOR void sum_groups(ContactBatch<3>& batch) { sum_groups_of(batch); }

void count_groups(int rows, const int* group, double* count) {
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
  apply_law_to(law, pairs, batch);
}
GRAINTRUTH_FOR_EACH_PROCESSOR void apply_law(const DefaultLaw& law,
                                             const PairTable& pairs,
                                             ContactBatch<3>& batch) {
  apply_law_to(law, pairs, batch);
}
void apply_law(const ChosenLaw& law, const PairTable& pairs, ContactBatch<2>& batch) {
  apply_law_to(law, pairs, batch);
}
void apply_law(const ChosenLaw& law, const PairTable& pairs, ContactBatch<3>& batch) {
  apply_law_to(law, pairs, batch);
}

}  // namespace graintruth::sim
