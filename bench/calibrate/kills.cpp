// Nothing is lost: calibrations are killed (SIGKILL) at random moments, each time run again, and
// compared with one that nobody disturbed.
//   bench_calibration_kills [FIGURES.json] [RUN_DIR]         the bundled films, twenty kills
//   bench_calibration_kills FIGURES.json RUN_DIR KILLS       short runs on tracks, as many kills
#include <sys/wait.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_01.hpp>
#include <chrono>
#include <sstream>

#include "bench/calibrate/truth_check.h"

using namespace graintruth::bench;

namespace {

constexpr int usual_kills = 20;
constexpr int replicates = 5;  // of the bundled films

struct Study {
  fs::path experiment;
  std::string options;  // of calibrate, beyond those of every run
  int kills = usual_kills;
  double latest_kill = 0.0;  // of the time of an undisturbed run
};

fs::path bundled() { return fs::path(GRAINTRUTH_SOURCE_DIR) / "datasets" / "micro"; }

std::string with(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) {
    fmt::print(stderr, "datasets/micro/experiment.toml has no '{}'\n", from);
    std::exit(1);
  }
  return text.replace(at, from.size(), to);
}

// The bundled experiment on tracks, with soft particles and few frames: it ends within seconds.
fs::path short_experiment(const fs::path& folder) {
  run(fmt::format("track '{}' --out '{}' --quiet > /dev/null",
                  (bundled() / "experiment.toml").string(),
                  (folder / "tracked").string()));
  std::ifstream stream(bundled() / "experiment.toml");
  std::ostringstream content;
  content << stream.rdbuf();
  std::string text = content.str();
  for (int n = 1; n <= replicates; ++n) {
    text = with(text,
                fmt::format("video = \"rep{}.mp4\"", n),
                fmt::format("tracks = \"tracked/tracks/rep{}.csv\"", n));
  }
  text = with(text, "elastic_modulus_gpa = 6.89", "elastic_modulus_mpa = 50");
  text = with(text, "frames = 25", "frames = 7");
  const fs::path file = folder / "experiment.toml";
  std::ofstream(file) << text;
  return file;
}

std::string calibrate_into(const Study& study, const fs::path& folder) {
  return fmt::format("calibrate '{}' --out '{}' --quiet --json{}",
                     study.experiment.string(),
                     folder.string(),
                     study.options);
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

// Whether the record of simulations can be read from its first row to its last.
bool has_sound_journal(const fs::path& folder) {
  if (!fs::exists(folder / "journal.db")) return true;  // not come so far
  const std::string command =
      fmt::format("'{}' journal list '{}' > /dev/null 2>&1", GRAINTRUTH_PROGRAM, folder.string());
  return std::system(command.c_str()) == 0;
}

int unfinished_files(const fs::path& folder) {
  int count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    count += entry.path().filename().string().find(".unfinished") != std::string::npos;
  return count;
}

}  // namespace

int main(int argc, char** argv) {
  const fs::path figures = argc > 1 ? argv[1] : "calibration_kills.json";
  const fs::path folder = fs::absolute(argc > 2 ? argv[2] : "out/bench/kills");
  fs::remove_all(folder);
  fs::create_directories(folder);
  Study study{.experiment = bundled() / "experiment.toml", .latest_kill = 2.0 / usual_kills};
  if (argc > 3) {
    study = {.experiment = short_experiment(folder),
             .options = " --budget 20",
             .kills = std::atoi(argv[3]),
             .latest_kill = 0.6};
  }
  const fs::path whole = folder / "whole", killed = folder / "killed";

  // 1. Undisturbed
  const auto start = std::chrono::steady_clock::now();
  run(calibrate_into(study, whole) + " > /dev/null");
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  const Json expected = timeless(whole);

  // 2. Killed, again and again, and run on each time; whoever comes to the end begins anew
  boost::random::mt19937_64 generator(2000);
  boost::random::uniform_01<double> uniform;
  int kills = 0, ends = 0, equal = 0, damaged = 0, left_over = 0;
  const auto compare = [&] {
    ++ends;
    equal += timeless(killed) == expected;
    left_over += unfinished_files(killed);
  };
  while (kills < study.kills) {
    const double moment = study.latest_kill * taken.count() * uniform(generator);
    const std::string command = fmt::format("timeout -s KILL {:.3f} '{}' {} > /dev/null 2>&1",
                                            moment,
                                            GRAINTRUTH_PROGRAM,
                                            calibrate_into(study, killed));
    const int status = std::system(command.c_str());
    constexpr int was_killed = 137;  // says timeout
    if (status != 0 && !(WIFEXITED(status) && WEXITSTATUS(status) == was_killed)) {
      fmt::print(stderr, "a run that was not killed failed\n");
      return 1;
    }
    if (status == 0) {
      compare();
      fs::remove_all(killed);
      continue;
    }
    ++kills;
    damaged += has_sound_journal(killed) ? 0 : 1;
    fmt::print("kill {} after {:.2f} s\n", kills, moment);
    std::fflush(stdout);
  }
  run(calibrate_into(study, killed) + " > /dev/null");
  compare();
  const int last = simulations_run(killed);

  // 3. Nothing left to do
  run(calibrate_into(study, killed) + " > /dev/null");
  const int again = simulations_run(killed);
  const bool same = timeless(killed) == expected;
  // A short one may have been killed before its first simulation
  const bool is_short = argc > 3;
  const int all = expected["simulations"].get<int>();
  return report(
      {{"kills", static_cast<double>(kills), "as many as asked for", kills == study.kills},
       {"runs that came to their end", static_cast<double>(ends), "at least 1", ends > 0},
       {"of these with equal results", static_cast<double>(equal), "all", equal == ends},
       {"journals that a kill damaged", static_cast<double>(damaged), "0", damaged == 0},
       {"files left half written", static_cast<double>(left_over), "0", left_over == 0},
       {"simulations of the last run",
        static_cast<double>(last),
        fmt::format(
            "{} all {}: the others were read back", is_short ? "at most" : "fewer than", all),
        is_short ? last <= all : last < all},
       {"simulations of one run more",
        static_cast<double>(again),
        "0, and the same result",
        again == 0 && same}},
      figures);
}
