// What the micro rig can tell apart: calibrates one twin by the height of its heap alone, and by
// every particle's track with the friction of the wall known from a sliding test; prints what the
// calibration says of it.
//   bench_calibration_trade_offs
#include <fmt/format.h>

#include <thread>

#include "bench/calibrate/twins.h"
#include "calibrate/calibration.h"
#include "calibrate/dem_simulator.h"
#include "calibrate/score.h"

using namespace graintruth;

namespace {

constexpr std::uint64_t study_seed = 2000;
constexpr calibrate::ParameterSet truth = {0.15, 0.2, 0.8};

void calibrate_and_tell(const char* heading, const datasets::Experiment& experiment, int jobs) {
  const bench::Twin twin = bench::make_twin_at(truth, experiment, study_seed, -2);
  calibrate::Journal journal(":memory:");
  calibrate::Ensemble ensemble(
      {bench::scene_of(twin, experiment)}, journal, twin.problem.comparison, jobs);
  calibrate::CalibrationOptions options{.jobs = jobs};
  options.largest_time_step_fraction = calibrate::largest_time_step_fraction(experiment);
  const calibrate::CalibrationResult result = calibrate::calibrate(twin.problem, ensemble, options);
  // The truth's score with the seeds and step of the winner's
  const calibrate::Score at_truth = calibrate::score(
      twin.problem,
      ensemble,
      "truth",
      {truth, result.time_step.fraction},
      calibrate::make_seeds(options.seed, "confirmation", options.confirmation_seeds));
  fmt::print("{}: agreement {:.1f} %, at the truth {:.1f} %\n",
             heading,
             result.score.student.percent,
             at_truth.student.percent);
  for (const calibrate::CalibratedParameter& parameter : result.calibrated) {
    const auto& interval = parameter.interval;
    fmt::print("  {:28} {:.3f} (truth {:.3f}), {}{}\n",
               parameter.name,
               parameter.value,
               calibrate::value_of(truth, parameter.name),
               name_of(parameter.status),
               interval ? fmt::format(", {:.3f} to {:.3f}", interval->lower, interval->upper) : "");
  }
  for (const std::string& warning : result.warnings) fmt::print("  Note: {}\n", warning);
  std::fflush(stdout);
}

}  // namespace

int main() {
  const int jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  datasets::Experiment experiment = bench::softened_micro_rig();
  const std::vector<datasets::TunedParameter> all = experiment.tuned;
  experiment.material.restitution.value = truth.restitution;

  // 1. Both frictions from a ruler held to the heap at the end, and from one held to it all the
  // time
  const datasets::Measurement filmed = experiment.measurement;
  experiment.tuned = {all[0], all[1]};
  experiment.measurement = {.compared = datasets::Compared::heap_height,
                            .frame_interval = filmed.frame_interval * (filmed.frames - 1),
                            .frames = 2};
  calibrate_and_tell("height of the heap at the start and at the end", experiment, jobs);
  experiment.measurement = filmed;
  experiment.measurement.compared = datasets::Compared::heap_height;
  calibrate_and_tell("height of the heap in every frame", experiment, jobs);

  // 2. Both from all that the camera sees
  experiment.measurement = filmed;
  calibrate_and_tell("tracks of all particles", experiment, jobs);

  // 3. The wall's from a sliding test, the particles' from all that the camera sees
  experiment.tuned = {all[0]};
  experiment.material.friction_particle_wall.value = truth.friction_particle_wall;
  calibrate_and_tell("tracks of all particles, and a sliding test of the wall", experiment, jobs);
  return 0;
}
