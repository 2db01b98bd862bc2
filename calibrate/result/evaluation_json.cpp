#include "calibrate/result/evaluation_json.h"

#include <array>

#include "calibrate/result/result_json.h"
#include "datasets/verdict/verdict.h"

namespace graintruth::calibrate {

namespace {

// By the rules that judge a result: nothing is known of parameters, which are given.
void add_verdict(const Problem& problem,
                 const Evaluation& evaluation,
                 const Json& told,
                 Json& json) {
  Json facts = {{"kind", "validation"},
                {"channels", channels_json(problem, Scope::calibrated, evaluation.runs)}};
  if (const Json agreement = told.value("agreement", Json()); agreement.is_object())
    facts["agreement"] = agreement;
  if (evaluation.failed > 0) {
    const auto runs = static_cast<int>(evaluation.runs.size());
    datasets::add_warnings(std::array{words_on_failed(evaluation.failed, runs)}, facts);
  }
  datasets::add_verdict(facts);
  json["verdict"] = facts["verdict"];
}

}  // namespace

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
  for (const auto& [key, value] : results.json.items())
    if (key != "agreement") json[key] = value;  // which the verdict sums up
  add_verdict(problem, evaluation, results.json, json);
}

}  // namespace graintruth::calibrate
