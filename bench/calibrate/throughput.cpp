// Whether two cores are busy: simulations a second of one ensemble with two threads, against two
// processes with one thread each, taken in turns; and what a calibration costs beside its
// simulations.
//   bench_calibration_throughput [ROUNDS]
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>

#include "bench/calibrate/twins.h"
#include "calibrate/flow/median.h"
#include "tests/calibrate/toy_experiment.h"

using namespace graintruth;

namespace {

constexpr int simulations = 32;          // of a measurement
constexpr double slow_simulation = 0.2;  // s; what all else is compared with

double seconds_of(const std::function<void()>& task) {
  const auto start = std::chrono::steady_clock::now();
  task();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// So many simulations at the twin's truth, none of them read back, on `jobs` threads.
void simulate(const bench::Twin& twin, int count, int jobs, std::uint64_t seed) {
  calibrate::Journal journal(":memory:");
  const auto executor = calibrate::make_executor("threads", jobs);
  const calibrate::EvaluationPoint point{twin.truth, twin.problem.largest_time_step_fraction()};
  bench::ensemble_of(twin.problem, journal, *executor)
      .evaluate("throughput", {&point, 1}, calibrate::make_seeds(seed, "throughput", count));
}

void in_two_processes(const std::function<void(int)>& task) {
  for (int child = 0; child < 2; ++child) {
    if (::fork() == 0) {
      task(child);
      ::_exit(0);
    }
  }
  while (::wait(nullptr) > 0) {
  }
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::stoi(argv[1]) : 9;
  const bench::Twin twin =
      bench::make_twin_at(bench::usual_truth(), bench::softened_micro_rig(), 2000, -1);

  // 1. Two threads against two processes, as many simulations each
  std::vector<double> ratios;
  for (int round = 0; round < rounds; ++round) {
    const auto seed = static_cast<std::uint64_t>(round);
    const double threads = seconds_of([&] { simulate(twin, simulations, 2, seed); });
    const double processes = seconds_of([&] {
      in_two_processes([&](int child) {
        simulate(twin, simulations / 2, 1, 2 * seed + static_cast<std::uint64_t>(child));
      });
    });
    ratios.push_back(processes / threads);
  }
  fmt::print("two threads reach {:.2f} of the throughput of two processes (median of {} rounds)\n",
             calibrate::median(ratios),
             rounds);

  // 2. A calibration whose simulations cost next to nothing
  const calibrate::Problem problem = calibrate::toy::problem({.noise = 0.001}, 5, 1);
  int simulated = 0;
  const double all = seconds_of([&] {
    simulated = calibrate::toy::calibrated(
                    calibrate::toy::engine(0.001), problem, {.largest_time_step_fraction = 0.05})
                    .simulations;
  });
  fmt::print(
      "all but simulation takes {:.1f} s of a calibration of {} simulations: {:.1f} % if each took "
      "{} s on one core\n",
      all,
      simulated,
      100.0 * all / (slow_simulation * simulated),
      slow_simulation);
  return 0;
}
