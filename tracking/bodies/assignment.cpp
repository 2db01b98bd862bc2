#include "tracking/bodies/assignment.h"

#include <limits>

namespace graintruth::tracking {

namespace {

// rows <= columns. u, v are the dual variables; each row in turn is added by the cheapest
// alternating path.
std::vector<int> assign_wide(const Eigen::MatrixXd& cost) {
  const int rows = static_cast<int>(cost.rows()), columns = static_cast<int>(cost.cols());
  const auto at = [](auto& list, int i) -> auto& { return list[static_cast<std::size_t>(i)]; };
  std::vector<double> u(static_cast<std::size_t>(rows) + 1),
      v(static_cast<std::size_t>(columns) + 1);
  std::vector<int> row_of(static_cast<std::size_t>(columns) + 1,
                          0);  // 1-based, 0 = free; column 0 is the start
  for (int row = 1; row <= rows; ++row) {
    std::vector<double> shortest(static_cast<std::size_t>(columns) + 1,
                                 std::numeric_limits<double>::infinity());
    std::vector<int> before(static_cast<std::size_t>(columns) + 1, 0);
    std::vector<char> done(static_cast<std::size_t>(columns) + 1, 0);
    at(row_of, 0) = row;
    int column = 0;
    do {
      at(done, column) = 1;
      const int from = at(row_of, column);
      double step = std::numeric_limits<double>::infinity();
      int next = 0;
      for (int j = 1; j <= columns; ++j) {
        if (at(done, j)) continue;
        const double reduced = cost(from - 1, j - 1) - at(u, from) - at(v, j);
        if (reduced < at(shortest, j)) {
          at(shortest, j) = reduced;
          at(before, j) = column;
        }
        if (at(shortest, j) < step) {
          step = at(shortest, j);
          next = j;
        }
      }
      for (int j = 0; j <= columns; ++j) {
        if (at(done, j)) {
          at(u, at(row_of, j)) += step;
          at(v, j) -= step;
        } else {
          at(shortest, j) -= step;
        }
      }
      column = next;
    } while (at(row_of, column) != 0);
    while (column != 0) {
      at(row_of, column) = at(row_of, at(before, column));
      column = at(before, column);
    }
  }
  std::vector<int> result(static_cast<std::size_t>(rows), -1);
  for (int j = 1; j <= columns; ++j)
    if (at(row_of, j) != 0) at(result, at(row_of, j) - 1) = j - 1;
  return result;
}

}  // namespace

std::vector<int> assign(const Eigen::MatrixXd& cost, double forbidden) {
  const auto rows = static_cast<std::size_t>(cost.rows());
  std::vector<int> result(rows, -1);
  if (cost.rows() == 0 || cost.cols() == 0) return result;
  // Infinite costs would poison the dual variables.
  const Eigen::MatrixXd bounded = cost.cwiseMin(forbidden);
  if (bounded.rows() <= bounded.cols()) {
    result = assign_wide(bounded);
  } else {
    const std::vector<int> row_of = assign_wide(bounded.transpose());
    for (std::size_t column = 0; column < row_of.size(); ++column)
      result[static_cast<std::size_t>(row_of[column])] = static_cast<int>(column);
  }
  for (std::size_t row = 0; row < rows; ++row) {
    if (result[row] >= 0 && bounded(static_cast<Eigen::Index>(row), result[row]) >= forbidden)
      result[row] = -1;
  }
  return result;
}

}  // namespace graintruth::tracking
