// How often 95 % intervals hold the truth on a model whose every result is known in closed form, by
// the number of replicates.
//   bench_calibration_coverage [FIGURES.csv] [REPEATS] [REPLICATES ...]
#include <fmt/format.h>

#include <boost/math/distributions/binomial.hpp>
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
  int held = 0, stated = 0, one_sided = 0, asked = 0;
  std::vector<double> widths, errors;
};

std::map<std::string, Count> count_intervals(int repeats, int replicates, int jobs) {
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
    const Problem problem = toy::problem(truth, replicates, 1000 + seed);
    // 2. Calibrated as films are
    const CalibrationResult result = toy::calibrated(
        toy::engine(truth.noise), problem, {.seed = seed, .largest_time_step_fraction = 0.05});
    // 3. Counted
    const std::lock_guard lock(mutex);
    for (const CalibratedParameter& parameter : result.calibrated) {
      if (parameter.name == "restitution") continue;
      const double expected = truth.parameters.of(parameter.name);
      Count& count = counts[parameter.name];
      ++count.asked;
      count.errors.push_back(std::abs(parameter.value - expected));
      if (!parameter.interval || is_unfinished(parameter)) continue;  // no end was found
      ++count.stated;
      count.held += parameter.interval->lower <= expected && expected <= parameter.interval->upper;
      count.one_sided +=
          parameter.lower_end != EndKind::found || parameter.upper_end != EndKind::found;
      count.widths.push_back(parameter.interval->upper - parameter.interval->lower);
    }
  });
  return counts;
}

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path figures = argc > 1 ? argv[1] : "calibration_coverage.csv";
  const int repeats = argc > 2 ? std::stoi(argv[2]) : 1000;
  std::vector<int> replicates;
  for (int i = 3; i < argc; ++i) replicates.push_back(std::stoi(argv[i]));
  if (replicates.empty()) replicates = {2, 3, 5, 10};
  const int jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  datasets::Table table({"replicates",
                         "parameter",
                         "asked",
                         "intervals",
                         "hold_the_truth",
                         "percent",
                         "percent_lower",
                         "percent_upper",
                         "one_sided",
                         "median_width",
                         "median_error"});
  for (const int count_of_replicates : replicates) {
    for (const auto& [name, count] : count_intervals(repeats, count_of_replicates, jobs)) {
      using Binomial = boost::math::binomial_distribution<>;
      const double percent = 100.0 * count.held / std::max(1, count.stated);
      const double lower = 100.0 * Binomial::find_lower_bound_on_p(count.stated, count.held, 0.025);
      const double upper = 100.0 * Binomial::find_upper_bound_on_p(count.stated, count.held, 0.025);
      table.add({std::to_string(count_of_replicates),
                 name,
                 std::to_string(count.asked),
                 std::to_string(count.stated),
                 std::to_string(count.held),
                 datasets::number_text(percent),
                 datasets::number_text(lower),
                 datasets::number_text(upper),
                 std::to_string(count.one_sided),
                 datasets::number_text(median(count.widths)),
                 datasets::number_text(median(count.errors))});
      fmt::print(
          "{:3} replicates  {:28} {} of {} intervals hold the truth ({:.1f} %, {:.1f} to {:.1f}); "
          "{} stated, {} one-sided; median width {:.4f}, error {:.4f}\n",
          count_of_replicates,
          name,
          count.held,
          count.stated,
          percent,
          lower,
          upper,
          count.stated,
          count.one_sided,
          median(count.widths),
          median(count.errors));
      std::fflush(stdout);
    }
  }
  datasets::write_csv(figures, table);
  return 0;
}
