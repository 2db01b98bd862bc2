#include "tracking/bodies/assignment.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <numeric>

namespace graintruth::tracking {
namespace {

double total(const Eigen::MatrixXd& cost, const std::vector<int>& columns) {
  double sum = 0.0;
  for (std::size_t row = 0; row < columns.size(); ++row)
    if (columns[row] >= 0) sum += cost(static_cast<Eigen::Index>(row), columns[row]);
  return sum;
}

// Tries every permutation of the columns.
double least_total(const Eigen::MatrixXd& cost) {
  std::vector<int> order(static_cast<std::size_t>(cost.cols()));
  std::iota(order.begin(), order.end(), 0);
  double least = 1.0e300;
  do {
    double sum = 0.0;
    for (Eigen::Index row = 0; row < cost.rows(); ++row)
      sum += cost(row, order[static_cast<std::size_t>(row)]);
    least = std::min(least, sum);
  } while (std::next_permutation(order.begin(), order.end()));
  return least;
}

RC_GTEST_PROP(Assignment, CostsAsLittleAsTheBestPermutation, ()) {
  const int rows = *rc::gen::inRange(1, 6);
  const int columns = *rc::gen::inRange(rows, 7);
  Eigen::MatrixXd cost(rows, columns);
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) cost(i, j) = *rc::gen::inRange(-1000, 1000);
  const std::vector<int> chosen = assign(cost);
  std::vector<int> used = chosen;
  std::sort(used.begin(), used.end());
  RC_ASSERT(std::adjacent_find(used.begin(), used.end()) == used.end());
  RC_ASSERT(used.front() >= 0);
  RC_ASSERT(total(cost, chosen) == least_total(cost));
}

TEST(Assignment, LeavesRowsOverWhenColumnsRunOut) {
  Eigen::MatrixXd cost(3, 2);
  cost << 5, 9, 1, 8, 9, 1;
  EXPECT_EQ(assign(cost), (std::vector<int>{-1, 0, 1}));
}

TEST(Assignment, NeverUsesForbiddenPairs) {
  Eigen::MatrixXd cost(2, 2);
  cost << 1, 1.0e9, 2, 1.0e9;
  EXPECT_EQ(assign(cost, 1.0e9), (std::vector<int>{0, -1}));
}

}  // namespace
}  // namespace graintruth::tracking
