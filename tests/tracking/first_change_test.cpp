// When pictures begin to change, by how much they change.
#include "tracking/event/first_change.h"

#include <gtest/gtest.h>

#include <random>

namespace graintruth::tracking {
namespace {

// Changes of a film at rest; `start` of them, then motion that adds `more`.
std::vector<double> changes(std::size_t start, double more, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, 0.05);
  std::vector<double> all;
  for (std::size_t k = 0; k < 100; ++k)
    all.push_back(1.0 + noise(random) + (k < start ? 0.0 : more));
  return all;
}

TEST(FirstChange, IsTheFirstPictureThatDiffers) {
  for (const std::size_t start : {6, 10, 60}) {
    const auto found = find_first_change(changes(start, 3.0, 7));
    ASSERT_TRUE(found) << start;
    // changes[k] leads into picture k + 1
    EXPECT_EQ(found->picture, static_cast<int>(start) + 1);
    EXPECT_GT(found->certainty, 10.0);
  }
}

TEST(FirstChange, IsNotFoundAtRestNorInSteadyMotion) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    EXPECT_FALSE(find_first_change(changes(100, 0.0, seed))) << seed;
    EXPECT_FALSE(find_first_change(changes(0, 3.0, seed))) << seed;
  }
  EXPECT_FALSE(find_first_change({}));
  EXPECT_FALSE(find_first_change({0.0, 0.0}));
}

// A codec stores every twelfth picture anew; a lamp flickers once.
TEST(FirstChange, IsNoLonePicture) {
  std::vector<double> all = changes(65, 3.0, 3);
  for (std::size_t k = 11; k < all.size(); k += 12) all[k] += 4.0;
  all[30] += 10.0;
  const auto found = find_first_change(all);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->picture, 66);
}

// After six pictures a codec stores what it left out at first.
TEST(FirstChange, IsNotWhatACodecMakesUpFor) {
  std::vector<double> all = changes(40, 0.0, 9);
  for (std::size_t k = 6; k < all.size(); ++k) all[k] += 1.0;
  for (std::size_t k = 40; k < all.size(); ++k) all[k] += 2.0 * static_cast<double>(k - 38);
  const auto found = find_first_change(all);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->picture, 42, 2);
}

}  // namespace
}  // namespace graintruth::tracking
