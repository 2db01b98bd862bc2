// Two experiments with one truth: found together, and better than by either.
#include <gtest/gtest.h>

#include <limits>

#include "tests/calibrate/toy_experiment.h"

namespace graintruth::calibrate {
namespace {

constexpr double noise = 0.001;  // m
const ParameterSet truth = toy::parameters(0.22, 0.35, 0.7);
const toy::ClosedEngine engine = toy::engine(noise);

struct Both {
  Both(std::uint64_t first_seed, std::uint64_t second_seed)
      : first(toy::problem({truth, noise}, 5, first_seed)),
        second(toy::problem({truth, noise}, 5, second_seed)) {
    first.engine = second.engine = &engine;
  }
  std::vector<CalibratedExperiment> experiments() const {
    return {{"first", &first}, {"second", &second}};
  }
  Problem first, second;
};

CalibrationOptions quick() {
  return {.budget = 60, .search_seeds = 5, .largest_time_step_fraction = 0.05};
}

CalibrationResult calibrated(std::span<const CalibratedExperiment> experiments,
                             Journal& journal,
                             const CalibrationOptions& options,
                             int jobs = 1) {
  const auto executor = make_executor("threads", jobs);
  journal.belong_to(parts_of(experiments));
  return calibrate(
      experiments.front().problem->experiment, experiments, journal, *executor, {}, options);
}

CalibrationResult calibrated(std::span<const CalibratedExperiment> experiments) {
  Journal journal(":memory:");
  return calibrated(experiments, journal, quick());
}

double width_of(const SearchResult& result, std::string_view name) {
  for (const CalibratedParameter& parameter : result.calibrated) {
    if (parameter.name == name && parameter.interval)
      return parameter.interval->upper - parameter.interval->lower;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

// Of 16 intervals that hold the truth 95 times in a hundred 12 or fewer do so seven times in a
// thousand (binomial). Two experiments that know as much each make intervals narrower by sqrt(2).
TEST(CalibrationOfSeveral, ItsIntervalsAreNarrowerAndStillHoldTheTruth) {
  constexpr int repeats = 8, asked = 2 * repeats, least = 13;
  std::atomic<int> held = 0;
  std::vector<double> ratios(repeats);
  parallel_for(repeats, 2, [&](int i) {
    const auto seed = static_cast<std::uint64_t>(i);
    const Both both(11 + seed, 91 + seed);
    const auto experiments = both.experiments();
    const CalibrationResult result = calibrated(experiments);
    const CalibrationResult of_one = calibrated(std::span(experiments).first(1));
    for (const CalibratedParameter& parameter : result.calibrated) {
      const double expected = truth.of(parameter.name);
      if (parameter.interval && parameter.interval->lower <= expected &&
          expected <= parameter.interval->upper)
        ++held;
    }
    ratios[static_cast<std::size_t>(i)] =
        width_of(result, "friction_particle_wall") / width_of(of_one, "friction_particle_wall");
  });
  EXPECT_GE(held, least) << "of " << asked;
  double ratio = 0.0;
  for (const double one : ratios) ratio += one / repeats;
  EXPECT_LT(ratio, 0.9);
}

TEST(CalibrationOfSeveral, TellsEveryExperimentWhatItMeansForIt) {
  const Both both(11, 91);
  const CalibrationResult result = calibrated(both.experiments());
  ASSERT_EQ(result.experiments.size(), 2U);
  double sum = 0.0;
  for (std::size_t i = 0; i < 2; ++i) {
    const ExperimentResult& one = result.experiments[i];
    sum += one.confirmed.objective;
    EXPECT_EQ(one.parameters, result.parameters);
    EXPECT_GT(both.experiments()[i].problem->all->percent_inside(one.confirmed.runs.runs), 60.0);
    ASSERT_EQ(one.evaluations.size(), result.evaluations.size());
    EXPECT_NE(one.warnings.front().text.find("found together with"), std::string::npos);
  }
  EXPECT_DOUBLE_EQ(result.objective, sum);
  for (std::size_t e = 0; e < result.evaluations.size(); ++e)
    EXPECT_NEAR(result.experiments[0].evaluations[e].objective +
                    result.experiments[1].evaluations[e].objective,
                result.evaluations[e].objective,
                1e-12);
  EXPECT_GT(result.simulated, 0);
  EXPECT_LE(result.simulated, result.simulations);  // the choice asks for some twice
}

// A second run on the same journal simulates nothing and ends at the same.
TEST(CalibrationOfSeveral, ResumesAndDoesNotDependOnThreads) {
  const Both both(11, 91);
  CalibrationOptions options = quick();
  options.budget = 20;
  // Few seeds an evaluation: each is used several times, and every time it is another run
  options.search_seeds = 2;
  Journal journal(":memory:");
  const auto experiments = both.experiments();
  const CalibrationResult first = calibrated(experiments, journal, options);
  const auto& runs = first.evaluations.front().runs;
  EXPECT_EQ(runs.size(), 2U * 2U * 3U);
  const CalibrationResult again = calibrated(experiments, journal, options, 3);
  EXPECT_EQ(again.simulated, 0);
  EXPECT_EQ(again.objective, first.objective);
  EXPECT_EQ(again.parameters, first.parameters);
  for (std::size_t a = 0; a < runs.size() / 2; ++a) {
    for (std::size_t b = a + 1; b < runs.size() / 2; ++b)
      EXPECT_NE(runs[a].channels[0].values[15], runs[b].channels[0].values[15]) << a << ' ' << b;
  }
}

}  // namespace
}  // namespace graintruth::calibrate
