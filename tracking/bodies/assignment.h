// The cheapest one-to-one assignment, O(n^3): shortest augmenting paths with dual variables
// (Jonker and Volgenant 1987, Computing 38; OpenCV 4.6 has no such solver).
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace graintruth::tracking {

// cost(row, column); rows <= columns or the reverse, no NaN. Returns the column of each row, -1
// where a row gets none (more rows than columns, or every way to give it one costs `forbidden` or
// more).
std::vector<int> assign(const Eigen::MatrixXd& cost, double forbidden = 1.0e12);

}  // namespace graintruth::tracking
