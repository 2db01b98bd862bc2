// graintruth evaluate: one evaluation at given parameters, for programs that drive ours.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/session.h"
#include "calibrate/dem_simulator.h"
#include "calibrate/score.h"

namespace graintruth::app {

// The same seeds as in the search of calibrate: with the time step of its result.json an evaluation
// here is bit for bit one of the search.
int run_evaluate(const EvaluateCommand& command) {
  Session session("evaluate", command.common, command.experiment);
  const calibrate::ParameterSet parameters = calibrate::load_parameters(
      command.parameters, calibrate::bench_parameters(session.experiment()));
  session.track();
  const calibrate::Problem problem = session.problem();
  calibrate::Journal journal(session.folder().journal());
  const auto ensemble = session.ensemble(problem, journal);
  const double fraction =
      calibrate::load_time_step_fraction(command.parameters)
          .value_or(calibrate::largest_time_step_fraction(session.experiment()));
  const calibrate::Score score = calibrate::score(
      problem,
      *ensemble,
      "evaluation",
      {parameters, fraction},
      calibrate::make_seeds(command.common.seed, "search", command.runs),
      [&](int done, int total, bool) {
        session.progress().show("simulating", static_cast<double>(done) / total, "");
      });

  nlohmann::ordered_json json;
  for (const std::string_view name : calibrate::parameter_names)
    json["parameters"][std::string(name)] = value_of(parameters, name);
  json["objective"] = score.evaluation.objective;
  json["agreement_percent"] = score.thesis.percent;
  json["agreement_percent_student_t"] = score.student.percent;
  json["rms_position_m"] = score.rms_position;
  json["failed"] = score.evaluation.failed;
  json["simulations"] = score.evaluation.runs.size();
  if (command.common.json) {
    fmt::print("{}\n", json.dump(2));
    return 0;
  }
  for (const auto& [name, value] : json.items()) {
    if (value.is_object()) {
      for (const auto& [inner, number] : value.items())
        fmt::print("{:28} {}\n", inner, number.dump());
    } else {
      fmt::print("{:28} {}\n", name, value.dump());
    }
  }
  return 0;
}

}  // namespace graintruth::app
