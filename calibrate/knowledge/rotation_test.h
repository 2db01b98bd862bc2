// Whether one of several repeats is farther from the others than they are from each other, by a
// rotation test: exact for normal scatter whatever the correlation between the values is.
#pragma once

#include <Eigen/Core>

namespace graintruth::calibrate {

// Rows are independent draws of one normal law with mean zero, a column a value. Returns the chance
// that the first row is as long as it is or longer, given what all rows are together:
//   P(sum_k l_k q_k^2 >= |y_1|^2),   q uniform on the unit sphere,
// l_k the eigenvalues of Y Y^T, for the rows' law does not change when rows are rotated into each
// other (Langsrud 2005, Statistics and Computing 15). Columns are brought to one length first,
// which no rotation changes either. With one column it is the t-test. 1 where there is nothing to
// tell: fewer than two rows, or all of them zero.
double rotation_test(Eigen::MatrixXd rows);

}  // namespace graintruth::calibrate
