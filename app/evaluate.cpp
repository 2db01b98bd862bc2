// graintruth evaluate: one evaluation at given parameters, for programs that drive ours.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/session.h"
#include "calibrate/bin_calibration.h"
#include "calibrate/bin_simulator.h"
#include "calibrate/dem_simulator.h"
#include "calibrate/score.h"

namespace graintruth::app {

namespace {

using Json = nlohmann::ordered_json;

Json head_of(const calibrate::ParameterSet& parameters, const calibrate::Evaluation& evaluation) {
  Json json;
  for (const std::string_view name : calibrate::parameter_names)
    json["parameters"][std::string(name)] = value_of(parameters, name);
  json["objective"] = evaluation.objective;
  json["failed"] = evaluation.failed;
  json["simulations"] = evaluation.runs.size();
  return json;
}

// The seeds of an evaluation of the search: with the time step of its result.json an evaluation
// here is bit for bit one of the search.
std::vector<std::uint64_t> seeds_of(const EvaluateCommand& command,
                                    const calibrate::CalibrationOptions& search) {
  return calibrate::make_seeds(
      command.common.seed, "search", command.runs > 0 ? command.runs : search.search_seeds);
}

// Films of particles that stay in the picture.
Json evaluate_tracks(const EvaluateCommand& command,
                     const calibrate::ParameterSet& parameters,
                     Session& session) {
  const calibrate::Problem problem = session.problem();
  calibrate::Journal journal(session.folder().journal());
  const auto ensemble = session.ensemble(problem, journal);
  const double fraction =
      calibrate::load_time_step_fraction(command.parameters)
          .value_or(calibrate::largest_time_step_fraction(session.experiment()));
  const calibrate::Score score = calibrate::score(problem,
                                                  *ensemble,
                                                  "evaluation",
                                                  {parameters, fraction},
                                                  seeds_of(command, {}),
                                                  session.simulation_progress());
  Json json = head_of(parameters, score.evaluation);
  json["agreement_percent"] = score.thesis.percent;
  json["agreement_percent_student_t"] = score.student.percent;
  json["rms_position_m"] = score.rms_position;
  return json;
}

// Films of particles that run out of a bin: those that are calibrated on.
Json evaluate_flow(const EvaluateCommand& command,
                   const calibrate::ParameterSet& parameters,
                   Session& session) {
  const calibrate::BinProblem problem = session.bin_problem();
  calibrate::Journal journal(session.folder().journal());
  const auto ensemble = session.ensemble_of_calibrated(problem, journal);
  const calibrate::EvaluationPoint point = {
      parameters,
      calibrate::load_time_step_fraction(command.parameters)
          .value_or(calibrate::largest_time_step_fraction(problem))};
  const std::vector<std::uint64_t> seeds = seeds_of(command, calibrate::bin_options());
  const calibrate::Evaluation evaluation =
      ensemble->evaluate("evaluation", {&point, 1}, seeds, session.simulation_progress()).front();
  const calibrate::BinComparison& films = *problem.calibrated;
  Json json = head_of(parameters, evaluation);
  for (const auto& [kind, value] : films.shares(evaluation.runs))
    json["shares"][std::string(kind)] = value;
  for (const calibrate::OrificeMean& orifice : films.orifices()) {
    json["orifices"].push_back(
        {{"orifice_m", orifice.orifice},
         {"filmed_kg_per_s", orifice.mean.rate},
         {"simulated_kg_per_s", films.simulated_rate(orifice, evaluation.runs)}});
  }
  return json;
}

void print_lines(const Json& json, const std::string& before) {
  for (const auto& [name, value] : json.items()) {
    if (value.is_structured()) {
      print_lines(value, value.is_array() ? name + " " : before);
    } else {
      fmt::print("{:28} {}\n", before + name, value.dump());
    }
  }
}

}  // namespace

int run_evaluate(const EvaluateCommand& command) {
  Session session("evaluate", command.common, command.experiment);
  const calibrate::ParameterSet parameters = calibrate::load_parameters(
      command.parameters, calibrate::bench_parameters(session.experiment()));
  session.track();
  const Json json = session.experiment().rig.bin ? evaluate_flow(command, parameters, session)
                                                 : evaluate_tracks(command, parameters, session);
  if (command.common.json) {
    fmt::print("{}\n", json.dump(2));
  } else {
    print_lines(json, "");
  }
  return 0;
}

}  // namespace graintruth::app
