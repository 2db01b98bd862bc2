// The same physics seen from elsewhere, for any angle and any order. Other views are cases of the
// verification.
#include "tests/sim/cases/invariance.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <utility>

namespace graintruth::sim::cases {
namespace {

RC_GTEST_PROP(Invariance, SceneTurnedInThePicture, ()) {
  const Apart apart = apart_turned(*rc::gen::inRange(-314, 314) / 100.0);
  RC_ASSERT(apart.place < kClosePlaces);
  RC_ASSERT(apart.angle < kCloseAngles);
}

RC_GTEST_PROP(Invariance, Renumbered, ()) {
  std::vector<int> order{0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  for (std::size_t i = order.size() - 1; i > 0; --i) {
    std::swap(order[i], order[*rc::gen::inRange<std::size_t>(0, i + 1)]);
  }
  RC_ASSERT(apart_renumbered(order).place < kClosePlaces);
}

}  // namespace
}  // namespace graintruth::sim::cases
