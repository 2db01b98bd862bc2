// How often 95 % intervals hold the truth where outlines of heaps are compared, on heaps in closed
// form whose columns err together (tests/calibrate/toy_heap.h).
//   bench_calibration_outline_coverage [FIGURES.csv] [REPEATS] [REPLICATES]
#include <fmt/format.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <filesystem>
#include <map>
#include <mutex>
#include <thread>

#include "calibrate/calibration.h"
#include "calibrate/flow/median.h"
#include "datasets/store/table.h"
#include "tests/calibrate/toy_heap.h"

using namespace graintruth;
using namespace graintruth::calibrate;

namespace {

struct Count {
  int asked = 0, held = 0, open = 0;
  std::vector<double> widths;
};

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path figures = argc > 1 ? argv[1] : "outline_coverage.csv";
  const int repeats = argc > 2 ? std::stoi(argv[2]) : 200;
  const int replicates = argc > 3 ? std::stoi(argv[3]) : 3;
  const auto folder = std::filesystem::temp_directory_path() / "graintruth_outline_coverage";
  std::filesystem::create_directories(folder);
  const datasets::Experiment experiment = toy::heap_experiment(folder, replicates);
  const tests::ClosedEngine engine = toy::heap_engine(toy::Contacts::chaotic);
  std::map<std::string, Count> counts;
  std::mutex mutex;
  const int jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  parallel_for(repeats, jobs, [&](int repeat) {
    // 1. A truth anywhere but near the bounds, and the replicates that it gives
    const auto seed = static_cast<std::uint64_t>(repeat);
    boost::random::mt19937_64 generator(make_seeds(2000, "outline truths", repeat + 1).back());
    boost::random::uniform_real_distribution<double> share(0.2, 0.8);
    std::map<std::string, double> truth;
    for (const datasets::TunedParameter& tuned : experiment.tuned)
      truth[tuned.name] = tuned.lower + share(generator) * (tuned.upper - tuned.lower);
    Problem problem = toy::heap_problem(experiment,
                                        truth["friction_particle_particle"],
                                        truth["rolling_friction_particle_particle"],
                                        1000 + seed);
    // 2. Calibrated as outlines are
    problem.engine = &engine;
    Journal journal(":memory:");
    const auto executor = make_executor("threads", 1);
    const std::array experiments = {CalibratedExperiment{"heap", &problem}};
    CalibrationOptions options = default_options(experiments);
    options.seed = seed;
    const CalibrationResult result =
        calibrate::calibrate(experiment, experiments, journal, *executor, {}, options);
    // 3. Counted. What is not identified holds every truth
    const std::lock_guard lock(mutex);
    for (const CalibratedParameter& parameter : result.calibrated) {
      if (!truth.contains(parameter.name)) continue;
      Count& count = counts[parameter.name];
      const double range = parameter.upper_bound - parameter.lower_bound;
      const double expected = truth[parameter.name];
      const Interval interval =
          parameter.interval.value_or(Interval{parameter.lower_bound, parameter.upper_bound});
      ++count.asked;
      count.open += parameter.interval ? 0 : 1;
      count.held += interval.lower <= expected && expected <= interval.upper;
      count.widths.push_back((interval.upper - interval.lower) / range);
    }
  });
  datasets::Table table({"parameter", "intervals", "hold_the_truth", "not_identified", "width"});
  for (const auto& [name, count] : counts) {
    table.add({name,
               std::to_string(count.asked),
               std::to_string(count.held),
               std::to_string(count.open),
               datasets::number_text(median(count.widths))});
    fmt::print(
        "{:36} {} of {} intervals hold the truth ({} not identified); median width {:.2f} of the "
        "range\n",
        name,
        count.held,
        count.asked,
        count.open,
        median(count.widths));
  }
  datasets::write_csv(figures, table);
  return 0;
}
