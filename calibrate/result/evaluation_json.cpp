#include "calibrate/result/evaluation_json.h"

#include "calibrate/result/result_json.h"
#include "datasets/verdict/verdict.h"

namespace graintruth::calibrate {

namespace {

// By the rules that judge a result: nothing is known of parameters, which are given.
void add_verdict(const Problem& problem,
                 const Evaluation& evaluation,
                 std::vector<datasets::Warning> warnings,
                 const Json& told,
                 Json& json) {
  Json facts = {{"kind", "validation"},
                {"channels", channels_json(problem, Scope::calibrated, evaluation.runs)}};
  if (const Json agreement = told.value("agreement", Json()); agreement.is_object())
    facts["agreement"] = agreement;
  if (evaluation.failed > 0) {
    const auto runs = static_cast<int>(evaluation.runs.size());
    facts["failed"] = evaluation.failed;
    facts["simulations"] = runs;
    warnings.push_back(words_on_failed(evaluation.failed, runs, ""));
  }
  datasets::add_warnings(warnings, facts);
  datasets::add_verdict(facts);
  json["verdict"] = facts["verdict"];
}

}  // namespace

void add_evaluation(const Problem& problem,
                    const Evaluation& evaluation,
                    std::span<const datasets::Warning> warnings,
                    Json& json) {
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
  for (const datasets::Warning& warning : warnings) json["warnings"].push_back(warning.text);
  add_verdict(problem, evaluation, {warnings.begin(), warnings.end()}, results.json, json);
}

}  // namespace graintruth::calibrate
