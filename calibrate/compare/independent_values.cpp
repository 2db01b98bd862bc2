#include "calibrate/compare/independent_values.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace graintruth::calibrate {

double independent_values(std::span<const Repeats> groups) {
  // 1. Deviations from the mean of each group: a repeat a row
  Eigen::Index count = 0, values = 0;
  for (const Repeats& group : groups) {
    if (group.size() < 2) continue;
    count += static_cast<Eigen::Index>(group.size());
    values = static_cast<Eigen::Index>(group.front().size());
  }
  Eigen::MatrixXd deviations(count, values);
  Eigen::Index next = 0;
  for (const Repeats& group : groups) {
    if (group.size() < 2) continue;
    auto rows = deviations.middleRows(next, static_cast<Eigen::Index>(group.size()));
    for (const std::vector<double>& one : group)
      deviations.row(next++) = Eigen::Map<const Eigen::RowVectorXd>(one.data(), values);
    rows.rowwise() -= rows.colwise().mean().eval();
  }
  // 2. In units of each value's own scatter
  for (auto column : deviations.colwise()) {
    column = column.unaryExpr([](double x) { return std::isfinite(x) ? x : 0.0; }).eval();
    if (const double size = column.norm(); size > 0.0) column /= size;
  }
  // 3. The traces, by the products of rows, which are few
  const Eigen::MatrixXd products = deviations * deviations.transpose();
  const double trace_of_square = products.squaredNorm();
  if (!(trace_of_square > 0.0)) return 1.0;
  return std::max(1.0, std::pow(products.trace(), 2) / trace_of_square);
}

}  // namespace graintruth::calibrate
