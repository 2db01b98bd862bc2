// What the micro rig can tell apart: calibrates one twin by the height of its heap alone, and by
// every particle's track with the friction of the wall known from a sliding test; prints what the
// calibration says of it.
//   bench_calibration_trade_offs
#include <fmt/format.h>

#include <thread>

#include "bench/calibrate/twins.h"
#include "calibrate/result/results.h"

using namespace graintruth;

namespace {

constexpr std::uint64_t study_seed = 2000;

void set_bench_value(datasets::Experiment& experiment, std::string_view parameter) {
  for (auto& [name, bench] : experiment.material.bench) {
    if (name == parameter) bench.value = bench::usual_truth().of(parameter);
  }
}

void calibrate_and_tell(const char* heading, const datasets::Experiment& experiment, int jobs) {
  const bench::Twin twin = bench::make_twin_at(bench::usual_truth(), experiment, study_seed, -2);
  calibrate::Journal journal(":memory:");
  const auto executor = calibrate::make_executor("threads", jobs);
  const calibrate::CalibratedExperiment one{experiment.name, &twin.problem};
  const calibrate::CalibrationOptions options = calibrate::default_options({&one, 1});
  const calibrate::CalibrationResult whole =
      calibrate::calibrate(experiment, {&one, 1}, journal, *executor, {}, options);
  const calibrate::ExperimentResult& result = whole.experiments.front();
  calibrate::Ensemble ensemble = bench::ensemble_of(twin.problem, journal, *executor);
  const calibrate::Evaluation at_truth =
      bench::judge({twin.truth, result.time_step.fraction}, options, ensemble);
  const calibrate::ChannelComparison& agreement = *twin.problem.calibrated;
  fmt::print("{}: agreement {:.1f} %, at the truth {:.1f} %\n",
             heading,
             agreement.percent_inside(result.confirmed.calibrated_runs),
             agreement.percent_inside(at_truth.runs));
  for (const calibrate::CalibratedParameter& parameter : result.calibrated) {
    const auto& interval = parameter.interval;
    fmt::print("  {:28} {:.3f} (truth {:.3f}), {}{}\n",
               parameter.name,
               parameter.value,
               twin.truth.of(parameter.name),
               name_of(parameter.status),
               interval ? fmt::format(", {:.3f} to {:.3f}", interval->lower, interval->upper) : "");
  }
  calibrate::Results told;
  for (const auto& observable : twin.problem.observables->all()) {
    if (twin.problem.all->rule_of(observable->name()) != nullptr)
      observable->conclude(twin.problem, result.confirmed, told);
  }
  told.warnings.insert(told.warnings.begin(), result.warnings.begin(), result.warnings.end());
  for (const datasets::Warning& warning : told.warnings) fmt::print("  Note: {}\n", warning.text);
  std::fflush(stdout);
}

}  // namespace

int main() {
  const int jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  datasets::Experiment experiment = bench::softened_micro_rig();
  const std::vector<datasets::TunedParameter> all = experiment.tuned;
  set_bench_value(experiment, "restitution");

  // 1. Both frictions from a ruler held to the heap at the end, and from one held to it all the
  // time
  const datasets::Measurement filmed = experiment.measurement;
  experiment.tuned = {all[0], all[1]};
  experiment.measurement = {.frame_interval = filmed.frame_interval * (filmed.frames - 1),
                            .frames = 2,
                            .observables = {{.name = "heap_height"}}};
  calibrate_and_tell("height of the heap at the start and at the end", experiment, jobs);
  experiment.measurement = filmed;
  experiment.measurement.observables = {{.name = "heap_height"}};
  calibrate_and_tell("height of the heap in every frame", experiment, jobs);

  // 2. Both from all that the camera sees
  experiment.measurement = filmed;
  calibrate_and_tell("tracks of all particles", experiment, jobs);

  // 3. The wall's from a sliding test, the particles' from all that the camera sees
  experiment.tuned = {all[0]};
  set_bench_value(experiment, "friction_particle_wall");
  calibrate_and_tell("tracks of all particles, and a sliding test of the wall", experiment, jobs);
  return 0;
}
