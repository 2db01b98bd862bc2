#include "tests/calibrate/toy_heap.h"

#include <fmt/format.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>

namespace graintruth::calibrate::toy {

namespace {

constexpr double grain = 0.004;                                  // m, over which it is rough
constexpr double volume = 400 * 33.5e-9 / 0.6;                   // m3
constexpr double of_slope = 0.05, of_flank = 0.05;               // relative scatter
constexpr double of_top = 0.5 * grain, of_grains = 0.3 * grain;  // m, scatter

}  // namespace

datasets::Outline heap(double sliding_friction,
                       double rolling_friction,
                       const std::vector<double>& columns,
                       std::uint64_t seed,
                       bool is_rough) {
  boost::random::mt19937_64 generator(seed);
  boost::random::normal_distribution<double> normal;
  const double slope =
      (0.2 + 0.3 * sliding_friction / (sliding_friction + 0.3) + 0.8 * rolling_friction) *
      (1.0 + of_slope * normal(generator));
  const double lean = of_flank * normal(generator), middle = of_top * normal(generator);
  const double height = std::cbrt(3.0 * volume * slope * slope / std::numbers::pi);
  const double rounding = grain * (3.0 - 2.5 * sliding_friction);
  datasets::Outline outline{.column = columns, .time = {1.0}, .height = {}, .sigma = {}, .eye = {}};
  const double kept = std::exp(-(columns[1] - columns[0]) / grain);
  double rough = normal(generator);
  for (const double x : columns) {
    rough = kept * rough + std::sqrt(1.0 - kept * kept) * normal(generator);
    const double aside = x - middle;
    const double flank = slope * (1.0 + (aside > 0.0 ? lean : -lean));
    const double z = height + flank * rounding - flank * std::hypot(aside, rounding) +
                     (is_rough ? of_grains * rough : 0.0);
    outline.height.push_back(z > 0.5 * grain ? z : std::nan(""));
  }
  return outline;
}

datasets::Experiment heap_experiment(const std::filesystem::path& folder, int replicates) {
  std::ifstream file(GRAINTRUTH_SOURCE_DIR "/app/new/lifted_cylinder/experiment.toml");
  std::string text(std::istreambuf_iterator<char>(file), {});
  text.erase(text.find("[[replicate]]"));
  const std::string both = R"(["free_surface", "angle_of_repose"])";
  text.replace(text.find(both), both.size(), R"(["free_surface"])");
  for (int i = 0; i < replicates; ++i) {
    const std::string name = fmt::format("heap{}.csv", i);
    std::ofstream(folder / name) << "time_s,column_m,height_m\n";
    text += fmt::format("[[replicate]]\noutline = \"{}\"\n", name);
  }
  std::ofstream(folder / "experiment.toml") << text;
  return datasets::load_experiment(folder / "experiment.toml");
}

Problem heap_problem(const datasets::Experiment& experiment,
                     double sliding_friction,
                     double rolling_friction,
                     std::uint64_t seed) {
  const std::vector<double> columns =
      datasets::outline_columns(*experiment.rig.seen_outline, experiment.particle.diameter);
  std::vector<datasets::Recording> recordings;
  for (const std::uint64_t one :
       make_seeds(seed, "toy heaps", static_cast<int>(experiment.replicates.size())))
    recordings.push_back({.outlines = {heap(sliding_friction, rolling_friction, columns, one)}});
  return make_problem(experiment, recordings);
}

tests::ClosedEngine heap_engine(Contacts contacts) {
  return tests::ClosedEngine([contacts](const SimulationSpec& spec) {
    const double sliding = spec.parameters.of("friction_particle_particle");
    const double rolling = spec.parameters.of("rolling_friction_particle_particle");
    std::uint64_t seed = spec.seed;
    if (contacts == Contacts::chaotic)
      seed ^= std::hash<double>{}(sliding + std::numbers::pi * rolling);
    EngineRun run{.time_step = 1e-5 * spec.time_step_fraction};
    run.recording.outlines = {heap(sliding, rolling, spec.record.outlines.front().columns, seed)};
    return run;
  });
}

}  // namespace graintruth::calibrate::toy
