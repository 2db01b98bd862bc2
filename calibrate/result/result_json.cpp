#include "calibrate/result/result_json.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "datasets/parameters/parameter.h"
#include "datasets/store/table.h"

namespace graintruth::calibrate {

namespace {

using datasets::number_text;
using datasets::Table;

// How an interval came about. `priors`: any parameter has one.
const char* method_of(const CalibratedParameter& parameter, bool priors) {
  if (!priors)
    return "values not worse than the best by more than other replicates and seeds could explain";
  if (parameter.prior && !parameter.shows_effect) return "the prior alone";
  return "values not worse than the best, the priors counted, by more than other replicates and "
         "seeds could explain";
}

Json parameter_json(const CalibratedParameter& parameter, bool priors) {
  Json json{{"value", parameter.value},
            {"unit", datasets::parameter_named(parameter.name).unit()},
            {"status", name_of(parameter.status)},
            {"interval_status", interval_status(parameter)}};
  if (parameter.interval) {
    json["lower"] = parameter.interval->lower;
    json["upper"] = parameter.interval->upper;
    json["lower_end"] = name_of(parameter.lower_end);
    json["upper_end"] = name_of(parameter.upper_end);
    json["confidence"] = 0.95;
    json["method"] = method_of(parameter, priors);
  }
  json["bench_value"] = parameter.bench;
  json["bench_standard_uncertainty"] = parameter.bench_uncertainty;
  if (const auto deviation =
          deviation_from(parameter, {parameter.bench, parameter.bench_uncertainty}))
    json["bench_deviation"] = *deviation;
  if (const auto& prior = parameter.prior)
    json["prior"] = {{"mean", prior->value}, {"standard_uncertainty", prior->standard_uncertainty}};
  if (const auto& data = parameter.data_alone; data && priors) {
    json["data_alone"] = {
        {"value", data->value}, {"lower", data->interval.lower}, {"upper", data->interval.upper}};
  }
  if (parameter.upper_bound > parameter.lower_bound) {
    json["bound_lower"] = parameter.lower_bound;
    json["bound_upper"] = parameter.upper_bound;
    json["objective_range"] = parameter.effect;
    json["objective_range_of_noise"] = parameter.effect_noise;
    json["sobol_total"] = parameter.sobol_total;
  }
  return json;
}

Json time_step_json(const TimeStepChoice& choice) {
  Json study = Json::array();
  for (const TimeStepRow& row : choice.rows) {
    Json entry;
    for (const auto& [name, value] : row.parameters) entry[name] = value;
    entry["fraction"] = row.fraction;
    entry["seconds"] = row.time_step;
    entry["objective"] = row.objective;
    entry["change"] = row.change ? Json(row.change->change) : Json(nullptr);
    entry["noise"] = row.change ? Json(row.change->noise.standard_error) : Json(nullptr);
    entry["half_width"] = row.change ? Json(row.change->noise.half_width) : Json(nullptr);
    entry["allowed"] = row.change ? Json(row.change->allowed) : Json(nullptr);
    entry["seeds"] = row.seeds;
    entry["cpu_seconds"] = row.seconds;
    study.push_back(std::move(entry));
  }
  return {{"fraction", choice.fraction},
          {"seconds", choice.time_step},
          {"discretisation_error", choice.discretisation_error},
          {"converged", choice.verdict == StepVerdict::resolved},
          {"verdict", name_of(choice.verdict)},
          {"rule", choice.joint ? "joint" : "gate"},
          {"study", study}};
}

}  // namespace

Json head_json(const datasets::Experiment& experiment, const char* kind) {
  Json json = {{"status", "done"},
               {"message", ""},
               {"verdict", nullptr},  // its place; written when everything else is there
               {"experiment", experiment.name},
               {"title", experiment.title},
               {"note", experiment.note},
               {"kind", kind}};
  if (!experiment.part_of.empty()) json["part_of"] = experiment.part_of;
  return json;
}

void write_tables(const datasets::RunFolder& folder, const Results& results) {
  for (const auto& [name, table] : results.tables) datasets::write_csv(folder.table(name), table);
}

void write_json(const std::filesystem::path& file, const Json& json) {
  datasets::write_whole(file, json.dump(2) + "\n");
}

void add_given_parameters(const datasets::Experiment& experiment,
                          const ParameterSet& parameters,
                          Json& json) {
  for (const auto& [name, value] : parameters) {
    json["parameters"][name] = {{"value", value},
                                {"unit", datasets::parameter_named(name).unit()},
                                {"status", "fixed"},
                                {"interval_status", "given"},
                                {"bench_value", datasets::bench_value(experiment, name).value}};
  }
}

namespace {

Json best_json(const BestByObjective& best) {
  const auto value_or_null = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
  };
  Json json = {{"form", datasets::name_of(best.form)},
               {"smooth", value_or_null(best.smooth)},
               {"requested", value_or_null(best.requested)}};
  for (const auto& [name, value] : best.parameters) json["parameters"][name] = value;
  return json;
}

}  // namespace

void add_search(const SearchResult& result, const CalibrationOptions& options, Json& json) {
  const bool priors =
      std::any_of(result.calibrated.begin(), result.calibrated.end(), [](const auto& parameter) {
        return parameter.prior.has_value();
      });
  for (const CalibratedParameter& parameter : result.calibrated)
    json["parameters"][parameter.name] = parameter_json(parameter, priors);
  json["time_step"] = time_step_json(result.time_step);
  json["objective"] = {{"best", nullptr},
                       {"noise", result.objective_noise},
                       {"search_seeds", options.search_seeds},
                       {"stop_reason", result.stop_reason},
                       {"form", datasets::name_of(result.objective_form)}};
  for (const BestByObjective& best : result.by_objective)
    json["objective"]["by_form"].push_back(best_json(best));
  if (priors) json["objective"]["allowed_excess"] = result.prior_allowed_excess;
  if (const auto& quality = result.surrogate) {
    json["surrogate"] = {{"leave_one_out_error", quality->leave_one_out_error},
                         {"value_spread", quality->value_spread},
                         {"roughness", quality->roughness}};
  }
  if (const auto& quality = result.emulator) {
    json["emulator"] = {{"leave_one_out_error", quality->leave_one_out_error},
                        {"value_spread", quality->value_spread}};
  }
  json["posterior"] = {{"effective_size", result.posterior_effective_size}};
  for (const PosteriorMarginal& one : result.posterior) {
    json["posterior"][one.name] = {{"mean", one.mean},
                                   {"standard_deviation", one.standard_deviation},
                                   {"lower", one.credible.lower},
                                   {"upper", one.credible.upper}};
  }
  if (const auto& test = result.self_test)
    json["self_test"] = {{"truths", test->truths}, {"found", test->found}};
  json["out_of_reach_share"] = result.out_of_reach;
  json["trade_offs"] = Json::array();
  for (const TradeOff& trade_off : result.trade_offs) {
    json["trade_offs"].push_back({{"first", trade_off.first},
                                  {"second", trade_off.second},
                                  {"direction", {trade_off.first_share, trade_off.second_share}},
                                  {"half_length", trade_off.half_length},
                                  {"correlation", trade_off.correlation}});
  }
  json["evaluations"] = result.evaluations.size();
  json["simulations"] = result.simulations;
  json["failed"] = result.failed;
  json["retried"] = result.retried;
  datasets::add_warnings(result.warnings, json);
}

void write_evaluations(const std::filesystem::path& file,
                       std::span<const Evaluation> evaluations,
                       const EvaluationAgreement& agreement_percent) {
  std::vector<std::string> names = {"evaluation", "stage"};
  if (!evaluations.empty()) {
    for (const auto& [name, value] : evaluations.front().parameters) names.push_back(name);
  }
  for (const char* name : {"objective", "best", "agreement_percent", "failed", "seconds"})
    names.emplace_back(name);
  Table table(std::move(names));
  double best = std::numeric_limits<double>::infinity();
  int number = 0;
  for (const Evaluation& evaluation : evaluations) {
    best = std::min(best, evaluation.objective);
    const double percent = agreement_percent ? agreement_percent(evaluation) : std::nan("");
    std::vector<std::string> cells = {std::to_string(++number), evaluation.stage};
    for (const auto& [name, value] : evaluation.parameters) cells.push_back(number_text(value));
    cells.push_back(number_text(evaluation.objective));
    cells.push_back(number_text(best));
    cells.push_back(number_text(percent));
    cells.push_back(std::to_string(evaluation.failed));
    cells.push_back(number_text(evaluation.seconds));
    table.add(std::move(cells));
  }
  datasets::write_csv(file, table);
}

void write_parameters(const datasets::RunFolder& folder, const SearchResult& result) {
  Table table({"parameter",
               "value",
               "lower",
               "upper",
               "unit",
               "status",
               "interval_status",
               "lower_end",
               "upper_end",
               "bench_value"});
  for (const CalibratedParameter& parameter : result.calibrated) {
    const auto& interval = parameter.interval;
    const auto of_end = [&](double value) { return interval ? number_text(value) : ""; };
    const auto kind_of = [&](EndKind end) { return std::string(interval ? name_of(end) : ""); };
    table.add({parameter.name,
               number_text(parameter.value),
               of_end(interval ? interval->lower : 0.0),
               of_end(interval ? interval->upper : 0.0),
               datasets::parameter_named(parameter.name).unit(),
               std::string(name_of(parameter.status)),
               std::string(interval_status(parameter)),
               kind_of(parameter.lower_end),
               kind_of(parameter.upper_end),
               number_text(parameter.bench)});
  }
  datasets::write_csv(folder.table("parameters"), table);
}

void write_profiles(const datasets::RunFolder& folder, const SearchResult& result) {
  Table table({"parameter", "value", "objective", "excess", "allowed_excess", "compatible"});
  for (const Profile& profile : result.profiles) {
    for (const ProfilePoint& point : profile.points) {
      table.add({profile.name,
                 number_text(point.value),
                 number_text(point.objective),
                 number_text(point.excess.objective),
                 number_text(point.excess.allowed),
                 point.excess.is_compatible() ? "1" : "0"});
    }
  }
  datasets::write_csv(folder.table("profile"), table);
}

}  // namespace graintruth::calibrate
