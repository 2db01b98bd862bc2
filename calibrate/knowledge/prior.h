// What is known of the parameters besides the data, brought to the scale of the objective J. One
// mapping says how plausible an objective is: where it exceeds the lowest by what the data allow at
// 95 %, the log-likelihood has fallen by half of chi-squared(0.95, 1),
//   ln L = -1.92 (J - J_min) / allowed.
// A prior is a Gaussian of mean m and standard uncertainty u, independent for each parameter, so
// that prior times likelihood falls as the objective does with a penalty,
//   J + lambda sum ((p - m)/u)^2,   lambda = allowed / (2 * 1.92):
// 1.96 u from its mean the prior costs what the data allow at 95 %.
#pragma once

#include <string>
#include <vector>

#include "calibrate/compare/comparison.h"
#include "datasets/experiment/experiment.h"

namespace graintruth::calibrate {

// Log-likelihood of an objective, but for a constant. `allowed` as above, more than 0.
double log_likelihood(double objective, double allowed);

class Prior {
 public:
  Prior() = default;  // nothing is known
  explicit Prior(std::vector<datasets::TunedParameter> tuned);

  // Whether any parameter has one.
  bool is_stated() const;
  // Sets what the data allow at 95 %, and with it lambda. Until then the prior costs nothing.
  void weigh(double allowed) { allowed_ = allowed; }
  bool is_weighed() const { return is_stated() && allowed_ > 0.0; }
  double allowed() const { return allowed_; }

  // What it adds to the objective: lambda sum ((p - m)/u)^2.
  double penalty(const ParameterSet& parameters) const;
  // What the search minimises: the objective of the data and the penalty.
  double total(const Evaluation& evaluation) const {
    return evaluation.objective + penalty(evaluation.parameters);
  }
  // How far from its mean the prior of one parameter alone costs `excess`; infinite without one.
  double reach(const datasets::TunedParameter& parameter, double excess) const;

 private:
  std::vector<datasets::TunedParameter> tuned_;
  double allowed_ = 0.0;
};

}  // namespace graintruth::calibrate
