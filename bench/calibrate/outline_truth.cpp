// Heap and drum of the lab videos, simulated at the parameters with which another program computed
// their films, against the outlines of that program's grains: what differs is the simulator.
//   bench_calibration_outlines heap [SEEDS] [FIRST_SEED]
//   bench_calibration_outlines drum [SEEDS] [FIRST_SEED]
// Truth: ../shared/lab-videos/{heap,drum}/truth, profiles in parallel projection.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include "calibrate/observables/steady_surface.h"
#include "calibrate/problem.h"
#include "datasets/store/input_error.h"
#include "datasets/store/table.h"

using namespace graintruth;
namespace fs = std::filesystem;

namespace {

constexpr double degrees = 180.0 / 3.14159265358979323846;
constexpr double grain = 0.004;        // m
constexpr double step_fraction = 0.4;  // of the Rayleigh step

// What heap and drum have in common. The bench modulus is the softened one of the films.
constexpr const char* grains = R"(title = "Lab video"
[particle]
count = 1500
mass_g = 0.083106
radius_mm = 2
size = {distribution = "normal", standard_deviation = 0.01, classes = 7}
[material]
elastic_modulus_mpa = 6
poisson_ratio = 0.25
friction_particle_particle = 0.367
friction_particle_wall = 0.442
restitution = 0.74
rolling_friction_particle_particle = 0.147
rolling_friction_particle_wall = 0.147
)";

constexpr const char* heap = R"([rig]
kind = "lifted_cylinder"
tube_inner_diameter_mm = 50
tube_wall_mm = 1.5
tube_height_mm = 80
lift_speed_mm_per_s = 16
[measure]
observables = ["free_surface"]
)";

constexpr const char* drum = R"([rig]
kind = "rotating_drum"
drum_diameter_mm = 110
drum_depth_mm = 20
[measure]
frame_interval_s = 0.02
frames = 200
observables = ["drum_surface"]
)";

fs::path truth(const std::string& rig) {
  return fs::path(GRAINTRUTH_SOURCE_DIR) / "../shared/lab-videos" / rig / "truth";
}

// The column of a profile in which a silhouette stands, as an outline of one moment; 0 is no grain.
datasets::Outline profile_of(const fs::path& file, const char* column) {
  const datasets::Table table = datasets::read_csv(file);
  datasets::Outline outline;
  outline.time = {0.0};
  outline.column = table.numbers("x_m");
  for (const double z : table.numbers(column))
    outline.height.push_back(z == 0.0 ? std::nan("") : z);
  return outline;
}

struct Simulated {
  calibrate::Problem problem;
  std::size_t scene = 0;

  calibrate::EngineRun run(std::uint64_t seed) const {
    const calibrate::SimulationSpec spec =
        problem.spec_of(scene, datasets::bench_parameters(problem.experiment), step_fraction, seed);
    calibrate::EngineRun made = problem.engine->run(spec, {});
    fmt::print("# seed {}: {:.0f} s of one core, step {:.3g} s, {} moments to {:.2f} s {}\n",
               seed,
               made.seconds,
               made.time_step,
               made.recording.outlines.empty() ? 0 : made.recording.outlines.front().time.size(),
               made.recording.outlines.empty() ? 0.0 : made.recording.outlines.front().time.back(),
               made.message);
    std::fflush(stdout);
    return made;
  }
};

// With replicates whose tables stay empty.
Simulated simulated(const std::string& text, const std::string& settings) {
  const fs::path folder = fs::temp_directory_path() / "graintruth_outline_truth";
  fs::create_directories(folder);
  std::string all = text;
  for (const char* name : {"one.csv", "two.csv"}) {
    std::ofstream(folder / name) << "time_s,column_m,height_m\n";
    all += fmt::format("[[replicate]]\noutline = \"{}\"\n{}\n", name, settings);
  }
  std::ofstream(folder / "experiment.toml") << all;
  const datasets::Experiment experiment = datasets::load_experiment(folder / "experiment.toml");
  const std::vector<datasets::Recording> none(experiment.replicates.size());
  return {calibrate::plan_problem(experiment, none)};
}

struct Difference {
  double mean = 0.0, rms = 0.0;
  int columns = 0;
};

// b - a where both are known.
Difference difference(const std::vector<double>& a, const std::vector<double>& b) {
  Difference made;
  double squares = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::isnan(a[i]) || std::isnan(b[i])) continue;
    made.mean += b[i] - a[i];
    squares += (b[i] - a[i]) * (b[i] - a[i]);
    ++made.columns;
  }
  made.mean /= made.columns;
  made.rms = std::sqrt(squares / made.columns);
  return made;
}

calibrate::Situation situation_of(const calibrate::Problem& problem) {
  return {.particle = problem.experiment.particle,
          .rig = problem.experiment.replicates.front().rig,
          .measurement = problem.experiment.measurement};
}

struct Profiles {
  std::vector<std::vector<double>> all;

  std::vector<double> mean() const {
    std::vector<double> made(all.front().size(), 0.0);
    for (const auto& one : all)
      for (std::size_t i = 0; i < made.size(); ++i)
        made[i] += one[i] / static_cast<double>(all.size());
    return made;
  }
};

void add_heap(const char* name,
              const calibrate::BedProfile& profile,
              const calibrate::Situation& situation,
              Profiles& profiles) {
  using calibrate::Side;
  const auto left = flank_of(profile, Side::left, situation);
  const auto right = flank_of(profile, Side::right, situation);
  fmt::print("{},{:.2f},{:.2f},{:.2f},{:.2f},{:.1f},{:.1f}\n",
             name,
             degrees * left->angle,
             degrees * right->angle,
             0.5 * degrees * (left->angle + right->angle),
             1e3 * profile.z[*apex_of(profile)],
             1e3 * foot_of(profile, Side::left, situation),
             1e3 * foot_of(profile, Side::right, situation));
  std::fflush(stdout);
  profiles.all.push_back(profile.z);
}

void compare_heap(int seeds, int first) {
  const Simulated simulation = simulated(std::string(grains) + heap, "");
  const calibrate::Situation situation = situation_of(simulation.problem);
  fmt::print("heap,left_deg,right_deg,mean_deg,height_mm,foot_left_mm,foot_right_mm\n");
  Profiles filmed, made;
  for (int replicate = 1; replicate <= 3; ++replicate) {
    const auto outline =
        profile_of(truth("heap") / fmt::format("heap_rep{}_profile.csv", replicate), "z_m");
    add_heap("truth", profile_at(outline, 0, situation), situation, filmed);
  }
  for (int seed = first; seed < first + seeds; ++seed) {
    const calibrate::EngineRun run = simulation.run(static_cast<std::uint64_t>(seed));
    if (run.recording.outlines.empty()) continue;
    add_heap("simulated", *profile_at_rest(run.recording, situation), situation, made);
  }
  const std::vector<double> mean = filmed.mean();
  for (const std::vector<double>& one : filmed.all)
    fmt::print("# a truth off the truths' mean: rms {:.3f} grain diameters\n",
               difference(mean, one).rms / grain);
  for (const std::vector<double>& one : made.all)
    fmt::print("# a simulation off the truths' mean: rms {:.3f} grain diameters\n",
               difference(mean, one).rms / grain);
  const Difference off = difference(mean, made.mean());
  fmt::print(
      "# mean simulated - mean truth: {:+.3f} on average, rms {:.3f} grain diameters, of {} "
      "columns\n",
      off.mean / grain,
      off.rms / grain,
      off.columns);
}

void compare_drum(int seeds, int first) {
  constexpr double middle = 0.045;  // m, of what is compared of the mean surface
  fmt::print("rpm,what,slope_deg,slope_error_deg,mean_off_grains,rms_off_grains\n");
  for (const auto& [rpm, file] : {std::pair(3, "drum03_rep1_profile.csv"),
                                  std::pair(8, "drum08_rep1_profile.csv"),
                                  std::pair(20, "drum20_rep1_profile.csv")}) {
    const Simulated simulation =
        simulated(std::string(grains) + "friction_particle_shell = 0.72\n" + drum,
                  fmt::format("turning_rpm = {}", rpm));
    const calibrate::Situation situation = situation_of(simulation.problem);
    calibrate::BedProfile seen =
        profile_at(profile_of(truth("drum") / file, "z_silhouette_mean_m"), 0, situation);
    for (std::size_t i = 0; i < seen.x.size(); ++i)
      if (std::abs(seen.x[i]) > middle) seen.z[i] = std::nan("");
    for (int seed = first; seed < first + seeds; ++seed) {
      const calibrate::EngineRun run = simulation.run(static_cast<std::uint64_t>(seed));
      if (run.recording.outlines.empty()) continue;
      const auto surface = steady_surface(run.recording.outlines.front(), situation);
      if (!surface) continue;
      const Difference off = difference(seen.z, surface->mean);
      fmt::print("{},simulated,{:.2f},{:.2f},{:+.3f},{:.3f}\n",
                 rpm,
                 degrees * surface->slope,
                 degrees * surface->slope_error,
                 off.mean / grain,
                 off.rms / grain);
      std::fflush(stdout);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::string rig = argc > 1 ? argv[1] : "heap";
  const int seeds = argc > 2 ? std::atoi(argv[2]) : 1;
  const int first = argc > 3 ? std::atoi(argv[3]) : 1;
  try {
    rig == "drum" ? compare_drum(seeds, first) : compare_heap(seeds, first);
  } catch (const datasets::InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
