// The contact law along a batch, as the machine's widest instructions run it, against the plain
// loop.
#include "sim/contact_kernel.h"

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

// Contacts of balls of some 1 cm; a quarter of them slide.
template <int D>
ContactBatch<D> random_batch(int rows, std::mt19937_64& random) {
  ContactBatch<D> batch{};
  batch.count = rows;
  for (int k = 0; k < rows; ++k) {
    batch.group[k] = k > 0 && random() % 3 == 0 ? batch.group[k - 1] : k;
    batch.pair[k] = static_cast<int>(random() % 2);
  }
  fill(random, batch.apart, rows, 0.005, 0.012);
  fill(random, batch.stiffness_factor, rows, 1e8, 3e8);
  fill(random, batch.offset, rows, -0.03, 0.03);
  fill(random, batch.arm, rows, -0.01, 0.01);
  fill(random, batch.radius, rows, 0.008, 0.012);
  for (auto* motion : {&batch.moved, &batch.moving}) {
    fill(random, motion->at_centre, rows, -0.1, 0.1);
    fill(random, motion->spin, rows, -3.0, 3.0);
  }
  fill(random, batch.slip_time, rows, 4e-6, 9e-6);
  fill(random, batch.reduced_mass, rows, 0.01, 0.02);
  fill(random, batch.spring, rows, -1e-6, 1e-6);
  for (int k = 0; k < rows; ++k) {
    const auto apart = batch.apart.at(k);
    batch.distance_squared.set(k, dot(apart, apart));
    batch.reach.set(k, std::sqrt(dot(apart, apart)) + between(1e-9, 1e-5, random));
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
  find_geometry(fast);
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
    batch.group[k] = random() % 20 < joined ? batch.group[k - 1] : k;
  }
  find_geometry(batch);
  sum_groups(batch);
  std::vector<double> counts(rows);
  count_groups(rows, batch.group.data(), counts.data());
  for (int k = 0; k < rows; ++k) {
    double sum = 0.0, count = 0.0;
    for (int other = 0; other < rows; ++other) {
      if (batch.group[other] != batch.group[k]) continue;
      sum += batch.stiffness.at(other);
      count += 1.0;
    }
    RC_ASSERT(same_bits(batch.sum_of_stiffness.at(k), sum));
    RC_ASSERT(counts[k] == count);
  }
}

}  // namespace
}  // namespace graintruth::sim
