// Twins of heaps in closed form: truth in, truth out within the stated interval.
#include <gtest/gtest.h>

#include "calibrate/calibration.h"
#include "tests/calibrate/toy_heap.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

TEST(OutlineCalibration, ItsIntervalsHoldTheTruthAndEndWhereTheyCan) {
  constexpr int twins = 30;
  const tests::TemporaryFolder folder;
  const datasets::Experiment experiment = toy::heap_experiment(folder.path(), 5);
  const tests::ClosedEngine engine = toy::heap_engine(toy::Contacts::chaotic);
  int asked = 0, held = 0, ended = 0;
  for (int twin = 0; twin < twins; ++twin) {
    const double share = (twin + 0.5) / twins;
    const std::map<std::string, double> truth = {
        {"friction_particle_particle", 0.2 + 0.5 * share},
        {"rolling_friction_particle_particle", 0.24 - 0.18 * share}};
    Problem problem = toy::heap_problem(experiment,
                                        truth.at("friction_particle_particle"),
                                        truth.at("rolling_friction_particle_particle"),
                                        100 + static_cast<std::uint64_t>(twin));
    problem.engine = &engine;
    Journal journal(":memory:");
    const auto executor = make_executor("threads", 1);
    const std::array experiments = {CalibratedExperiment{"heap", &problem}};
    CalibrationOptions options = default_options(experiments);
    options.seed = static_cast<std::uint64_t>(twin);
    const CalibrationResult result =
        calibrate(experiment, experiments, journal, *executor, {}, options);
    for (const CalibratedParameter& parameter : result.calibrated) {
      const auto expected = truth.find(parameter.name);
      if (expected == truth.end()) continue;
      ++asked;
      // What is not identified may be anything
      held += !parameter.interval || (parameter.interval->lower <= expected->second &&
                                      expected->second <= parameter.interval->upper);
      if (parameter.name.starts_with("rolling")) ended += parameter.interval.has_value();
    }
  }
  // Of 60 intervals at 95 %, fewer than 51 hold the truth with probability 0.1 % (binomial)
  EXPECT_EQ(asked, 2 * twins);
  EXPECT_GE(held, 51) << held << " of " << asked;
  // Rolling friction shows in the slope, whatever sliding friction is: with two seeds that are
  // judged by themselves alone, hardly an interval ends
  EXPECT_GE(ended, twins / 3) << ended << " of " << twins;
}

}  // namespace
}  // namespace graintruth::calibrate
