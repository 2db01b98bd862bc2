// The contact law along a batch, as the machine's widest instructions run it, against the plain
// loop.
#include "sim/engine/contact_kernel.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <bit>
#include <cmath>
#include <random>

namespace graintruth::sim {
namespace {

double between(double low, double high, std::mt19937_64& random) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

void fill(std::mt19937_64& random, BatchScalars& column, int rows, double low, double high) {
  for (int k = 0; k < rows; ++k) column.set(k, between(low, high, random));
}
void fill(std::mt19937_64& random, BatchVectors<2>& column, int rows, double low, double high) {
  for (int k = 0; k < rows; ++k) {
    column.set(k, {between(low, high, random), between(low, high, random)});
  }
}
void fill(std::mt19937_64& random, BatchVectors<3>& column, int rows, double low, double high) {
  for (int k = 0; k < rows; ++k) {
    column.set(
        k, {between(low, high, random), between(low, high, random), between(low, high, random)});
  }
}

template <int D>
void measure_groups(ContactBatch<D>& batch) {
  batch.longest_group = 1;
  for (int k = 1, length = 1; k < batch.count; ++k) {
    length = batch.group.at(k) == batch.group.at(k - 1) ? length + 1 : 1;
    batch.longest_group = std::max(batch.longest_group, length);
  }
}

// Contacts of balls of some 1 cm; a quarter of them slide.
template <int D>
ContactBatch<D> random_batch(int rows, std::mt19937_64& random) {
  ContactBatch<D> batch{};
  batch.count = rows;
  for (int k = 0; k < rows; ++k) {
    batch.group.set(k, k > 0 && random() % 3 == 0 ? batch.group.at(k - 1) : k);
    batch.pair[k] = static_cast<int>(random() % 2);
    batch.was_touching[k] = random() % 5 == 0 ? kOpen : kTouching;
  }
  // Rows that fill up the last vector belong to no group
  for (int k = rows; k < whole_rows(rows); ++k) batch.group.set(k, -2.0);
  measure_groups(batch);
  fill(random, batch.first_sphere, rows, -0.001, 0.0);
  fill(random, batch.second_sphere, rows, 0.005, 0.01);
  fill(random, batch.radius, rows, 0.008, 0.012);
  for (auto* motion : {&batch.first, &batch.second}) {
    const double side = motion == &batch.first ? -1.0 : 1.0;
    fill(random, motion->position, rows, 0.01 * side - 0.005, 0.01 * side + 0.005);
    fill(random, motion->velocity, rows, -0.1, 0.1);
    fill(random, motion->velocity_now, rows, -0.1, 0.1);
    fill(random, motion->spin, rows, -3.0, 3.0);
    fill(random, motion->spin_now, rows, -3.0, 3.0);
  }
  batch.slip_time = between(4e-6, 9e-6, random);
  fill(random, batch.inverse_mass, rows, 50.0, 100.0);
  fill(random, batch.first_turn, rows, 1e6, 3e6);
  fill(random, batch.second_turn, rows, 1e6, 3e6);
  fill(random, batch.spring_before, rows, -1e-6, 1e-6);
  for (int k = 0; k < rows; ++k) {
    const auto apart = batch.second_sphere.at(k) - batch.first_sphere.at(k);
    const double reach = std::sqrt(dot(apart, apart)) + between(1e-9, 1e-5, random);
    batch.second_radius.set(k, reach - batch.radius.at(k));
  }
  return batch;
}

const PairTable kPairs{
    mix({3.5e9, 0.3}, {3.5e9, 0.3}, {.friction = 0.3, .restitution = 0.7}, Tension::clipped, 1.0),
    mix({3.5e9, 0.3},
        rigid_material(),
        {.friction = 0.1, .restitution = 0.5},
        Tension::clipped,
        1.0)};

std::uint64_t bits(double value) { return std::bit_cast<std::uint64_t>(value); }
bool same_bits(double a, double b) { return bits(a) == bits(b); }
bool same_bits(PlanarVector a, PlanarVector b) {
  return same_bits(a.x, b.x) && same_bits(a.z, b.z);
}
bool same_bits(SpatialVector a, SpatialVector b) {
  return same_bits(a.x, b.x) && same_bits(a.y, b.y) && same_bits(a.z, b.z);
}

template <int D>
void default_law_equals_the_same_law_chosen_at_run_time(int rows, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  ContactBatch<D> fast = random_batch<D>(rows, random);
  fast.is_of_one_pair = seed % 2 == 0;
  if (fast.is_of_one_pair) fast.pair.fill(static_cast<int>(seed % 4 / 2));
  find_geometry(kPairs, fast);
  sum_groups(fast);
  ContactBatch<D> plain = fast;
  apply_law(DefaultLaw{}, kPairs, fast);
  apply_law(ChosenLaw{}, kPairs, plain);
  for (int k = 0; k < rows; ++k) {
    RC_ASSERT(same_bits(fast.force.at(k), plain.force.at(k)));
    RC_ASSERT(same_bits(fast.moment.at(k), plain.moment.at(k)));
    RC_ASSERT(same_bits(fast.second_moment.at(k), plain.second_moment.at(k)));
    RC_ASSERT(same_bits(fast.spring.at(k), plain.spring.at(k)));
    RC_ASSERT(fast.slides.at(k) == plain.slides.at(k));
  }
}

RC_GTEST_PROP(ContactKernel, SameBitsOnEveryProcessor, ()) {
  const int rows = *rc::gen::inRange(1, kBatchRows);
  const auto seed = *rc::gen::arbitrary<std::uint64_t>();
  default_law_equals_the_same_law_chosen_at_run_time<2>(rows, seed);
  default_law_equals_the_same_law_chosen_at_run_time<3>(rows, seed);
}

// Against the plain loop, for batches of short groups and of long ones.
RC_GTEST_PROP(ContactKernel, GroupSumsAreThoseOfThePlainLoop, ()) {
  const int rows = *rc::gen::inRange(1, kBatchRows);
  const auto joined = *rc::gen::inRange<unsigned>(1, 20);  // in twentieths
  std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
  ContactBatch<3> batch = random_batch<3>(rows, random);
  for (int k = 1; k < rows; ++k) {
    batch.group.set(k, random() % 20 < joined ? batch.group.at(k - 1) : k);
  }
  measure_groups(batch);
  find_geometry(kPairs, batch);
  sum_groups(batch);
  std::vector<double> counts(rows);
  count_groups(rows, batch.group.value.data(), counts.data());
  for (int k = 0; k < rows; ++k) {
    double sum = 0.0, count = 0.0;
    for (int other = 0; other < rows; ++other) {
      if (batch.group.at(other) != batch.group.at(k)) continue;
      sum += batch.stiffness.at(other);
      count += 1.0;
    }
    RC_ASSERT(same_bits(batch.sum_of_stiffness.at(k), sum));
    RC_ASSERT(counts[k] == count);
  }
}

}  // namespace
}  // namespace graintruth::sim
