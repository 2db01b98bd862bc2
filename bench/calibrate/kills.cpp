// Nothing is lost: the bundled calibration is killed (SIGKILL) at twenty random moments, each time
// run again, and compared with one that nobody disturbed.
//   bench_calibration_kills [FIGURES.json] [RUN_DIR]
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_01.hpp>
#include <chrono>

#include "bench/calibrate/truth_check.h"

using namespace graintruth::bench;

namespace {

constexpr int kills = 20;

std::string calibrate_into(const fs::path& folder) {
  const fs::path experiment =
      fs::path(GRAINTRUTH_SOURCE_DIR) / "datasets" / "micro" / "experiment.toml";
  return fmt::format(
      "calibrate '{}' --out '{}' --quiet --json", experiment.string(), folder.string());
}

// result.json without what the clock put there.
Json timeless(const fs::path& folder) {
  Json result = read_json(folder / "result.json");
  result.erase("wall_time_s");
  for (Json& row : result["time_step"]["study"]) row.erase("cpu_seconds");
  return result;
}

int simulations_run(const fs::path& folder) {
  return read_json(folder / "run.json")["simulations_run"].get<int>();
}

}  // namespace

int main(int argc, char** argv) {
  const fs::path figures = argc > 1 ? argv[1] : "calibration_kills.json";
  const fs::path folder = argc > 2 ? argv[2] : "out/bench/kills";
  fs::remove_all(folder);
  const fs::path whole = folder / "whole", killed = folder / "killed";

  // 1. Undisturbed
  const auto start = std::chrono::steady_clock::now();
  run(calibrate_into(whole) + " > /dev/null");
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;

  // 2. Killed, again and again; the kills together span the time of about one run
  boost::random::mt19937_64 generator(2000);
  boost::random::uniform_01<double> uniform;
  for (int i = 0; i < kills; ++i) {
    const double moment = 2.0 * taken.count() / kills * uniform(generator);
    const std::string command = fmt::format("timeout -s KILL {:.3f} '{}' {} > /dev/null 2>&1",
                                            moment,
                                            GRAINTRUTH_PROGRAM,
                                            calibrate_into(killed));
    fmt::print("killed after {:.2f} s\n", moment);
    std::fflush(stdout);
    if (std::system(command.c_str()) == 0) fmt::print("  (it had ended before)\n");
  }
  run(calibrate_into(killed) + " > /dev/null");
  const int last = simulations_run(killed);

  // 3. The same end, and nothing left to do
  const bool same = timeless(killed) == timeless(whole);
  run(calibrate_into(killed) + " > /dev/null");
  const int again = simulations_run(killed);
  const int all = timeless(whole)["simulations"].get<int>();
  return report(
      {{"final result, apart from times", same ? 1.0 : 0.0, "the undisturbed run's", same},
       {"simulations of the last run",
        static_cast<double>(last),
        fmt::format("fewer than all {}: the others were read back", all),
        last < all},
       {"simulations of one run more", static_cast<double>(again), "0", again == 0}},
      figures);
}
