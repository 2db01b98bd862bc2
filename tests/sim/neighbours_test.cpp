#include "sim/engine/neighbours.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "sim/simulation.h"
#include "tests/sim/scenes.h"

namespace graintruth::sim {
namespace {

template <int D>
void expect_all_pairs() {
  const int count = *rc::gen::inRange(0, 80);
  const double spread = *rc::gen::elementOf(std::vector<double>{1.0, 5.0, 100.0});
  std::vector<Vec<D>> centres;
  std::vector<double> radii;
  for (int i = 0; i < count; ++i) {
    Vec<D> centre;
    for (int axis = 0; axis < D; ++axis)
      centre[axis] = spread * *rc::gen::inRange(-1000, 1000) / 1000.0;
    centres.push_back(centre);
    radii.push_back(*rc::gen::inRange(1, 100) / 100.0);
  }
  std::vector<IndexPair> plain;
  for (int i = 0; i < count; ++i) {
    for (int j = i + 1; j < count; ++j) {
      const double reach = radii[i] + radii[j] + 0.1;
      if ((centres[j] - centres[i]).squaredNorm() < reach * reach) plain.push_back({i, j});
    }
  }
  CellList<D> cells;
  std::vector<IndexPair> found;
  find_near_pairs<D>(centres, radii, 0.1, cells, found);
  RC_ASSERT(found == plain);
}

RC_GTEST_PROP(Neighbours, CellListFindsAllPairsInTheLayer, ()) { expect_all_pairs<2>(); }
RC_GTEST_PROP(Neighbours, CellListFindsAllPairsInSpace, ()) { expect_all_pairs<3>(); }

// As the nearest of all images tells, wherever in the cells around the bodies are; with axes that
// do not repeat among those that do, and periods of few cells and of many.
template <int D>
void expect_all_pairs_of_images() {
  Period period;
  std::vector<int> axes = D == 2 ? std::vector<int>{0, 2} : std::vector<int>{0, 1, 2};
  for (const int axis : axes) {
    if (!*rc::gen::arbitrary<bool>()) continue;
    period.low[axis] = *rc::gen::inRange(-500, 500) / 100.0;
    period.length[axis] = *rc::gen::elementOf(std::vector<double>{4.0, 7.0, 40.0});
  }
  const int count = *rc::gen::inRange(0, 60);
  std::vector<Vec<D>> centres;
  std::vector<double> radii;
  for (int i = 0; i < count; ++i) {
    Vec<D> centre;
    for (int axis = 0; axis < D; ++axis) centre[axis] = *rc::gen::inRange(-1000, 1000) / 50.0;
    centres.push_back(centre);
    radii.push_back(*rc::gen::inRange(1, 90) / 100.0);
  }
  const auto distance = [&](const Vec<D>& from, const Vec<D>& to) {
    double squared = 0.0;
    for (int axis = 0; axis < D; ++axis) {
      double apart = std::abs(to[axis] - from[axis]);
      const double length = period.length[axes[axis]];
      if (length > 0.0) apart = std::abs(std::remainder(apart, length));
      squared += apart * apart;
    }
    return std::sqrt(squared);
  };
  std::vector<IndexPair> plain;
  for (int i = 0; i < count; ++i) {
    for (int j = i + 1; j < count; ++j) {
      const double gap = distance(centres[i], centres[j]) - radii[i] - radii[j] - 0.1;
      RC_PRE(std::abs(gap) > 1e-9);  // else rounding decides
      if (gap < 0.0) plain.push_back({i, j});
    }
  }
  CellList<D> cells;
  std::vector<IndexPair> found;
  find_near_pairs<D>(centres, radii, 0.1, cells, found, periodic_cell<D>(period));
  RC_ASSERT(found == plain);
}

RC_GTEST_PROP(Neighbours, ImagesInTheLayerAreFound, ()) { expect_all_pairs_of_images<2>(); }
RC_GTEST_PROP(Neighbours, ImagesInSpaceAreFound, ()) { expect_all_pairs_of_images<3>(); }

// With a skin as wide as the rig every pair is a candidate at every step: the plain method.
TEST(Neighbours, SkinDoesNotChangeOneBitOfARun) {
  Scene scene = scenes::micro_rig();
  relax_overlaps(scene);
  std::uint64_t hash[3];
  int i = 0;
  for (const double skin : {0.0005, 0.004, 10.0}) {
    Simulation simulation(scene, {.skin = skin});
    ASSERT_EQ(simulation.run_until(0.5).status, RunStatus::completed);
    hash[i++] = simulation.state_hash();
  }
  EXPECT_EQ(hash[0], hash[1]);
  EXPECT_EQ(hash[0], hash[2]);
}

}  // namespace
}  // namespace graintruth::sim
