// graintruth evaluate: one evaluation at given parameters, for programs that drive ours.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "app/run/session.h"
#include "calibrate/calibration.h"
#include "calibrate/result/evaluation_json.h"
#include "calibrate/result/failures.h"

namespace graintruth::app {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const calibrate::Problem& problem,
             const calibrate::Evaluation& evaluation,
             std::span<const datasets::Warning> doubts) {
  Json json;
  for (const auto& [name, value] : evaluation.parameters) json["parameters"][name] = value;
  json["objective"] = evaluation.objective;
  json["failed"] = evaluation.failed;
  json["simulations"] = evaluation.runs.size();
  calibrate::add_evaluation(problem, evaluation, doubts, json);
  return json;
}

using Lines = std::vector<std::pair<std::string, std::string>>;

void add_lines(const Json& json, const std::string& before, Lines& lines) {
  for (const auto& [name, value] : json.items()) {
    if (name == "verdict") continue;  // the last line tells it
    if (value.is_structured()) {
      add_lines(value, value.is_array() ? name + " " : before, lines);
    } else {
      lines.emplace_back(before + name, value.dump());
    }
  }
}

void print(const Lines& lines) {
  std::size_t longest = 0;
  for (const auto& [name, value] : lines) longest = std::max(longest, name.size());
  for (const auto& [name, value] : lines) fmt::print("{:{}} {}\n", name, longest, value);
}

}  // namespace

int run_evaluate(const EvaluateCommand& command) {
  Session session("evaluate", command.common, command.experiment);
  const calibrate::ParameterSet parameters = calibrate::load_parameters(
      command.parameters, datasets::bench_parameters(session.experiment()));
  const std::optional<double> fraction = calibrate::load_time_step_fraction(command.parameters);
  session.track();
  const calibrate::Problem problem = session.problem();
  calibrate::Journal journal(session.folder().journal());
  const auto ensemble = session.ensemble_of_calibrated(problem, journal);
  const calibrate::EvaluationPoint point = {
      parameters, fraction ? *fraction : problem.largest_time_step_fraction()};
  // The seeds of an evaluation of the search: with the time step of its result.json an evaluation
  // here is bit for bit one of the search.
  const std::array one = {calibrate::CalibratedExperiment{session.experiment().name, &problem}};
  const auto seeds = calibrate::make_seeds(
      command.common.seed,
      "search",
      command.runs > 0 ? command.runs : calibrate::default_options(one).search_seeds);
  const calibrate::Evaluation evaluation =
      ensemble->evaluate("evaluation", {&point, 1}, seeds, session.simulation_progress()).front();
  const std::vector<datasets::Warning>& doubts = session.films().doubts;
  const Json json = json_of(problem, evaluation, doubts);
  for (const datasets::Warning& doubt : doubts) session.progress().say("Warning: " + doubt.text);
  if (command.common.json) {
    fmt::print("{}\n", json.dump(2));
  } else {
    Lines lines;
    add_lines(json, "", lines);
    print(lines);
    fmt::print("Verdict: {}\n", json["verdict"]["sentence"].get<std::string>());
  }
  // Whoever drives us must not take what is left of a few runs for what the parameters do
  const calibrate::Failures failures =
      calibrate::failures_of(problem, problem.calibrated_scenes, evaluation);
  if (failures.are_too_many) {
    throw calibrate::TooManyFailures(
        failures.sentence +
        "; look at walls and starting places in the pictures of 'graintruth "
        "check', and at the parameters");
  }
  if (!failures.sentence.empty()) fmt::print(stderr, "Note: {}.\n", failures.sentence);
  return 0;
}

}  // namespace graintruth::app
