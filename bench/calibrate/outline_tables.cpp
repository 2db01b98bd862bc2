// Outlines of beds that our own simulator makes at stated parameters, as tables that an experiment
// file can name: the bundled heap was made so (datasets/heap/README.md).
//   make_outline_tables EXPERIMENT.toml TRUTH.toml FIRST_SEED
// TRUTH.toml: a table `name = value` of parameters. Replicate n of the file is simulated with the
// seed FIRST_SEED + n - 1, seen as the file says, and written where the file expects its table,
// with an error of 0.01 grain lengths (one standard deviation) on every height. Of a heap or a
// column that collapses the last moment is written, of a drum all of them.
#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>

#include "calibrate/problem.h"
#include "datasets/parameters/parameter.h"
#include "datasets/store/input_error.h"

using namespace graintruth;
namespace fs = std::filesystem;

namespace {

constexpr double error_of_height = 0.01;  // grain lengths

// Tables that are not there yet, so that the file can be read.
void make_room(const fs::path& file) {
  const toml::table text = toml::parse_file(file.string());
  for (const toml::node& replicate : *text["replicate"].as_array()) {
    const fs::path table =
        file.parent_path() / replicate.as_table()->at("outline").value<std::string>().value();
    if (!fs::exists(table)) std::ofstream(table) << "time_s,column_m,height_m\n";
  }
}

datasets::Outline last_moment(const datasets::Outline& outline) {
  datasets::Outline last = outline;
  last.time = {outline.time.back()};
  const auto first = outline.height.end() - static_cast<std::ptrdiff_t>(outline.column.size());
  last.height.assign(first, outline.height.end());
  return last;
}

void blur(double error, std::uint64_t seed, datasets::Outline& outline) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, error);
  outline.sigma.assign(outline.height.size(), error);
  // Micrometres and microseconds are enough
  for (double& height : outline.height) height = std::round((height + normal(random)) * 1e6) / 1e6;
  for (double& time : outline.time) time = std::round(time * 1e6) / 1e6;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    fmt::print(stderr, "make_outline_tables EXPERIMENT.toml TRUTH.toml FIRST_SEED\n");
    return 2;
  }
  try {
    const fs::path file = argv[1];
    make_room(file);
    const datasets::Experiment experiment = datasets::load_experiment(file);
    calibrate::ParameterSet truth = datasets::bench_parameters(experiment);
    for (const auto& [name, value] : datasets::read_parameter_table(argv[2]))
      truth.set(name, value);
    const std::vector<datasets::Recording> none(experiment.replicates.size());
    const calibrate::Problem problem = calibrate::plan_problem(experiment, none);
    // Half the largest that a calibration tries
    const double step = 0.5 * problem.largest_time_step_fraction();
    const auto first_seed = static_cast<std::uint64_t>(std::atoi(argv[3]));
    for (std::size_t r = 0; r < experiment.replicates.size(); ++r) {
      std::size_t scene = 0;
      for (std::size_t s = 0; s < problem.scenes.size(); ++s) {
        const auto& own = problem.conditions[problem.scenes[s].condition].replicates;
        if (std::find(own.begin(), own.end(), r) != own.end()) scene = s;
      }
      const calibrate::EngineRun made =
          problem.engine->run(problem.spec_of(scene, truth, step, first_seed + r), {});
      if (made.recording.outlines.empty()) {
        fmt::print(stderr, "{}\n", made.message);
        return 1;
      }
      std::vector<datasets::Outline> outlines = made.recording.outlines;
      for (datasets::Outline& outline : outlines) {
        if (!experiment.rig.seen_outline->drum) outline = last_moment(outline);
        blur(error_of_height * experiment.particle.diameter, first_seed + r, outline);
      }
      datasets::write_outlines(experiment.replicates[r].outline, outlines);
      fmt::print("{}: seed {}, {:.1f} s of one core\n",
                 experiment.replicates[r].outline.string(),
                 first_seed + r,
                 made.seconds);
      std::fflush(stdout);
    }
  } catch (const datasets::InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
