#include "calibrate/result/evaluation_json.h"

namespace graintruth::calibrate {

void add_evaluation(const Problem& problem, const Evaluation& evaluation, Json& json) {
  const auto shares = problem.calibrated->shares(evaluation.runs);
  if (shares.size() > 1) {
    for (const auto& [kind, value, weight] : shares) json["shares"][kind] = value;
  }
  Results results;
  for (const auto& observable : problem.observables->all()) {
    if (problem.calibrated->rule_of(observable->name()) != nullptr)
      observable->tell_evaluation(problem, evaluation, results);
  }
  for (const auto& [key, value] : results.json.items()) json[key] = value;
}

}  // namespace graintruth::calibrate
