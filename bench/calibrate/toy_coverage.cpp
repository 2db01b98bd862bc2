// How often 95 % intervals hold the truth on a model whose every result is known in closed form.
//   bench_calibration_coverage [FIGURES.csv] [REPEATS]
#include <fmt/format.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <map>
#include <mutex>
#include <thread>

#include "calibrate/calibration.h"
#include "calibrate/flow/median.h"
#include "datasets/store/table.h"
#include "tests/calibrate/toy_experiment.h"

using namespace graintruth;
using namespace graintruth::calibrate;

namespace {

struct Count {
  int held = 0, asked = 0;
  std::vector<double> widths;
};

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path figures = argc > 1 ? argv[1] : "calibration_coverage.csv";
  const int repeats = argc > 2 ? std::stoi(argv[2]) : 1000;
  const int jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  std::map<std::string, Count> counts;
  std::mutex mutex;
  parallel_for(repeats, jobs, [&](int repeat) {
    // 1. A truth anywhere but near the bounds, and the replicates that it gives
    const auto seed = static_cast<std::uint64_t>(repeat);
    boost::random::mt19937_64 generator(make_seeds(2000, "toy truths", repeat + 1).back());
    boost::random::uniform_real_distribution<double> friction(0.1, 0.5);
    toy::Truth truth{.noise = 0.001};
    for (const char* name : {"friction_particle_particle", "friction_particle_wall"})
      truth.parameters.set(name, friction(generator));
    const Problem problem = toy::problem(truth, 5, 1000 + seed);
    // 2. Calibrated as films are
    const CalibrationResult result = toy::calibrated(
        toy::engine(truth.noise), problem, {.seed = seed, .largest_time_step_fraction = 0.05});
    // 3. Counted
    const std::lock_guard lock(mutex);
    for (const CalibratedParameter& parameter : result.calibrated) {
      if (parameter.name == "restitution") continue;
      Count& count = counts[parameter.name];
      ++count.asked;
      if (!parameter.interval || is_unfinished(parameter)) continue;  // no end was found
      const double expected = truth.parameters.of(parameter.name);
      count.held += parameter.interval->lower <= expected && expected <= parameter.interval->upper;
      count.widths.push_back(parameter.interval->upper - parameter.interval->lower);
    }
  });
  datasets::Table table({"parameter", "intervals", "hold_the_truth", "median_width"});
  for (const auto& [name, count] : counts) {
    table.add({name,
               std::to_string(count.asked),
               std::to_string(count.held),
               datasets::number_text(median(count.widths))});
    fmt::print("{:28} {} of {} intervals hold the truth ({:.1f} %); median width {:.4f}\n",
               name,
               count.held,
               count.asked,
               100.0 * count.held / count.asked,
               median(count.widths));
  }
  datasets::write_csv(figures, table);
  return 0;
}
