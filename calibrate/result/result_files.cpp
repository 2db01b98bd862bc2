#include "calibrate/result/result_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "calibrate/compare/independent_values.h"
#include "calibrate/result/result_json.h"
#include "datasets/verdict/verdict.h"

namespace graintruth::calibrate {

namespace {

using datasets::number_text;
using datasets::Table;

Json numbers_json(const std::vector<double>& values) {
  Json json = Json::array();
  for (const double value : values) json.push_back(std::isfinite(value) ? Json(value) : Json());
  return json;
}

// A single number lies nowhere.
Json axis_json(const Observable& observable, std::size_t values, const Situation& situation) {
  if (values == 1) return {{"name", ""}, {"unit", ""}, {"values", Json::array()}};
  const ChannelWords words = observable.words();
  return {{"name", words.axis},
          {"unit", words.axis_unit},
          {"values", numbers_json(observable.axis(situation))}};
}

// Of one condition, replicates and completed simulations apart.
double independent_values_of(const Problem& problem,
                             const Condition& condition,
                             std::size_t place,
                             const std::vector<SimulatedRun>& simulated,
                             std::span<const std::size_t> scenes) {
  std::array<Repeats, 2> groups;
  for (const std::size_t replicate : condition.replicates)
    groups[0].push_back(problem.measured[replicate][place].values);
  const std::size_t seeds = simulated.size() / scenes.size();
  for (std::size_t run = 0; run < simulated.size(); ++run) {
    const auto& own = condition.scenes;
    if (std::find(own.begin(), own.end(), scenes[run / seeds]) == own.end()) continue;
    if (simulated[run].status == RunStatus::completed)
      groups[1].push_back(simulated[run].channels[place].values);
  }
  return independent_values(groups);
}

}  // namespace

Json channels_json(const Problem& problem,
                   Scope scope,
                   const std::vector<SimulatedRun>& simulated) {
  const std::vector<std::size_t> scenes =
      scope == Scope::everything ? problem.every_scene() : problem.calibrated_scenes;
  const ChannelComparison& comparison =
      scope == Scope::everything ? *problem.all : *problem.calibrated;
  Json channels = Json::array();
  for (std::size_t place = 0; place < problem.observables->all().size(); ++place) {
    const Observable& observable = *problem.observables->all()[place];
    const Rule* rule = comparison.rule_of(observable.name());
    if (rule == nullptr) continue;
    const auto runs = rule->digest(simulated);
    const ChannelWords words = observable.words();
    std::size_t place_in_comparison = 0;
    for (const Condition& condition : problem.conditions) {
      if (scope == Scope::calibrated && condition.held_out) continue;
      const std::size_t c = place_in_comparison++;
      const Rule::Band band = rule->band(c);
      if (band.mean.empty()) continue;
      channels.push_back(
          {{"observable", observable.name()},
           {"title", words.title},
           {"condition", condition.name},
           {"unit", words.unit},
           {"axis",
            axis_json(
                observable, band.mean.size(), problem.situations[condition.replicates.front()])},
           {"measured", numbers_json(band.mean)},
           {"lower", numbers_json(band.lower)},
           {"upper", numbers_json(band.upper)},
           {"simulated", numbers_json(rule->simulated_mean(*runs, c))},
           {"held_out", condition.held_out}});
      // Columns of an outline vary together
      if (observable.needs_outline() && band.mean.size() > 1)
        channels.back()["independent_values"] =
            independent_values_of(problem, condition, place, simulated, scenes);
    }
  }
  return channels;
}

namespace {

// What result.json says of fresh simulations, and the tables of every observable.
void add_confirmed(const Problem& problem, const Confirmed& confirmed, Results& results) {
  Json& json = results.json;
  json["objective"]["best"] = confirmed.objective;
  const auto shares = problem.calibrated->shares(confirmed.calibrated_runs);
  if (shares.size() > 1) {
    for (const auto& [kind, value, weight] : shares) json["objective"]["shares"][kind] = value;
  }
  const double modulus = problem.experiment.material.elastic_modulus;
  if (problem.simulated_modulus < modulus) {
    json["simulated_elastic_modulus_pa"] = problem.simulated_modulus;
    results.warnings.push_back(fmt::format(
        "Simulated with an elastic modulus of {:.3g} Pa instead of {:.3g} Pa. This is the lowest "
        "modulus at which the hardest expected impact overlaps by no more than 1 % of the particle "
        "diameter.",
        problem.simulated_modulus,
        modulus));
  }
  json["channels"] = channels_json(problem, Scope::everything, confirmed.runs.runs);
  for (const auto& observable : problem.observables->all()) {
    if (problem.all->rule_of(observable->name()) != nullptr)
      observable->conclude(problem, confirmed, results);
  }
}

void add_influence(const std::vector<InfluenceRow>& influence, Results& results) {
  if (influence.empty()) return;
  std::vector<std::string> names = {"left_out"};
  for (const auto& [name, value] : influence.front().best) names.push_back(name);
  names.emplace_back("objective");
  Table table(std::move(names));
  for (const InfluenceRow& row : influence) {
    std::vector<std::string> cells = {row.left_out};
    for (const auto& [name, value] : row.best) cells.push_back(number_text(value));
    cells.push_back(number_text(row.objective));
    table.add(std::move(cells));
  }
  results.tables["influence"] = std::move(table);
}

void append(std::vector<datasets::Warning>& all, const std::vector<datasets::Warning>& further) {
  all.insert(all.end(), further.begin(), further.end());
}

// One line of the experiments: what it adds to the sum, and by what it is judged.
Json experiment_json(const CalibratedExperiment& one, const ExperimentResult& result) {
  const datasets::Experiment& experiment = one.problem->experiment;
  Json compared = Json::array();
  for (const auto& [place, weight] : one.problem->observables->compared())
    compared.push_back(one.problem->observables->all()[place]->name());
  Results own;
  add_confirmed(*one.problem, result.confirmed, own);
  Json json = {{"name", one.name},
               {"title", experiment.title},
               {"compared", compared},
               {"replicates", experiment.replicates.size()},
               {"weight", one.weight},
               {"objective", result.confirmed.objective}};
  if (own.json.contains("agreement")) {
    for (const char* key :
         {"agreement_percent_student_t", "ceiling_percent_student_t", "agreement_percent"}) {
      const std::string name = std::string(key).starts_with("agreement_")
                                   ? std::string(key).substr(10)
                                   : std::string(key);
      json[key] = own.json["agreement"][name];
    }
  }
  if (own.json.contains("mean_signed_error")) {
    json["mean_signed_error"] = own.json["mean_signed_error"];
    int held_out = 0;
    for (const Condition& condition : one.problem->conditions) held_out += condition.held_out;
    json["orifices"] = one.problem->conditions.size();
    json["held_out_orifices"] = held_out;
  }
  // How this one agrees, whatever is known of the parameters, which all have in common
  own.json["kind"] = "calibration";
  datasets::add_verdict(own.json);
  json["verdict"] = own.json["verdict"];
  return json;
}

}  // namespace

EvaluationAgreement agreement_of(const ChannelComparison& comparison) {
  return [&comparison](const Evaluation& evaluation) {
    return comparison.percent_inside(evaluation.runs);
  };
}

std::vector<std::string> write_measured(const datasets::RunFolder& folder,
                                        const datasets::Experiment& experiment,
                                        std::span<const datasets::Recording> recordings) {
  const Observables observables(experiment);
  std::vector<Situation> situations;
  std::vector<std::vector<Channel>> channels;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    situations.push_back({.particle = experiment.particle,
                          .rig = experiment.replicates[r].rig,
                          .measurement = experiment.measurement});
    channels.push_back(observables.measure(recordings[r], situations.back()));
  }
  const MeasuredExperiment measured{experiment, observables, recordings, situations, channels};
  Results results;
  results.json["experiment"] = experiment.name;
  if (!experiment.note.empty()) results.json["note"] = experiment.note;
  for (std::size_t place = 0; place < observables.all().size(); ++place) {
    const bool is_known = std::all_of(
        channels.begin(), channels.end(), [&](const auto& one) { return one[place].is_known(); });
    if (is_known) observables.all()[place]->tell_measured(measured, results);
  }
  write_tables(folder, results);
  write_json(folder.measured(), results.json);
  return results.lines;
}

std::vector<std::string> write_calibration(const datasets::RunFolder& folder,
                                           const Problem& problem,
                                           const CalibrationOptions& options,
                                           ExperimentResult& result,
                                           double wall_time) {
  write_evaluations(
      folder.table("evaluations"), result.evaluations, agreement_of(*problem.calibrated));
  write_parameters(folder, result);
  write_profiles(folder, result);
  Results results{.json = head_json(problem.experiment, "calibration")};
  add_search(result, options, results.json);
  if (const auto check = half_step_of(problem, result.confirmed)) {
    results.json["time_step"]["at_half"] = {{"objective_change", check->objective.change},
                                            {"noise", check->objective.noise.standard_error},
                                            {"half_width", check->objective.noise.half_width},
                                            {"allowed", check->objective.allowed},
                                            {"verdict", name_of(check->objective.verdict())},
                                            {"agreement_change_points", check->agreement_change}};
  }
  add_confirmed(problem, result.confirmed, results);
  add_influence(result.influence, results);
  append(result.warnings, results.warnings);
  datasets::add_warnings(result.warnings, results.json);
  results.json["wall_time_s"] = wall_time;
  datasets::add_verdict(results.json);
  write_tables(folder, results);
  write_json(folder.result(), results.json);
  return results.lines;
}

void write_calibration_of_several(const datasets::RunFolder& folder,
                                  const datasets::Experiment& common,
                                  std::span<const CalibratedExperiment> experiments,
                                  const CalibrationOptions& options,
                                  const CalibrationResult& result,
                                  double wall_time) {
  write_evaluations(folder.table("evaluations"), result.evaluations, {});
  write_parameters(folder, result);
  write_profiles(folder, result);
  Json json = head_json(common, "calibration");
  add_search(result, options, json);
  json["objective"]["best"] = result.objective;
  for (std::size_t i = 0; i < experiments.size(); ++i)
    json["experiments"].push_back(experiment_json(experiments[i], result.experiments[i]));
  json["wall_time_s"] = wall_time;
  datasets::add_verdict(json);
  write_json(folder.result(), json);
}

void write_validation(const datasets::RunFolder& folder,
                      const Problem& problem,
                      const Confirmed& confirmed,
                      double wall_time,
                      Validation& validation) {
  Results results{.json = head_json(problem.experiment, "validation")};
  Json& json = results.json;
  add_given_parameters(problem.experiment, confirmed.point.parameters, json);
  json["time_step"] = {{"fraction", confirmed.point.time_step_fraction},
                       {"seconds", confirmed.runs.runs.front().time_step},
                       {"discretisation_error", nullptr}};
  add_confirmed(problem, confirmed, results);
  json["objective"]["noise"] = confirmed.noise;
  json["evaluations"] = 1;
  json["simulations"] = confirmed.runs.runs.size();
  json["failed"] = confirmed.runs.failed;
  json["wall_time_s"] = wall_time;
  results.warnings.insert(
      results.warnings.begin(), validation.warnings.begin(), validation.warnings.end());
  datasets::add_warnings(results.warnings, json);
  datasets::add_verdict(json);
  write_tables(folder, results);
  write_json(folder.result(), json);
  validation.lines = results.lines;
  validation.agreement_percent = json.contains("agreement")
                                     ? json["agreement"]["percent_student_t"].get<double>()
                                     : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace graintruth::calibrate
