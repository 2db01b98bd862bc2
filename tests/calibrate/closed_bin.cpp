#include "tests/calibrate/closed_bin.h"

#include <fmt/format.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cmath>

#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate::closed_bin {

namespace {

constexpr double particle_mass = 0.332e-3;  // kg
constexpr double duration = 8.0;            // s
constexpr double interval = 0.01;           // s

datasets::DischargeCurve run_of(const ParameterSet& parameters,
                                double orifice,
                                double noise,
                                std::uint64_t seed) {
  boost::random::mt19937_64 generator(seed);
  boost::random::normal_distribution<double> normal(0.0, noise);
  const double rate = 0.1 * std::pow((orifice - 0.012) / 0.088, 1.5) *
                      (1.0 - parameters.of("friction_particle_particle")) *
                      (1.0 + normal(generator));
  const double staying =
      5.0 + 40.0 * parameters.of("friction_particle_wall") + 50.0 * normal(generator);
  const double leaving = (particles - std::lround(staying)) * particle_mass;
  datasets::DischargeCurve curve;
  for (int sample = 0; sample * interval <= duration; ++sample) {
    curve.time.push_back(sample * interval);
    curve.mass.push_back(std::min(rate * curve.time.back(), leaving));
  }
  return curve;
}

double orifice_of(const SimulationSpec& spec) {
  for (const datasets::SceneWall& wall : spec.scene.walls) {
    if (wall.name == "stopper") return wall.points[1].x() - wall.points[0].x();
  }
  return 0.0;
}

}  // namespace

datasets::Experiment experiment() {
  const tests::TemporaryFolder folder;
  std::string text = fmt::format(R"(title = "A closed bin"
[particle]
count = {}
mass_kg = {}
plate = {{semi_major_mm = 6.9, semi_minor_mm = 5.3, thickness_mm = 2.3}}
[material]
elastic_modulus_gpa = 1
poisson_ratio = 0.3
friction_particle_particle = 0.5
friction_particle_wall = 0.4
restitution = 0.8
[rig]
kind = "flat_bin_orifice"
bin_width_mm = 150
bin_height_mm = 210
front_back_gap_mm = 2.6
[tune]
friction_particle_particle = {{lower = 0.0, upper = 0.7}}
friction_particle_wall = {{lower = 0.0, upper = 0.7}}
restitution = {{lower = 0.3, upper = 0.95}}
)",
                                 particles,
                                 particle_mass);
  folder.write("curve.csv", "time_s,mass_kg\n0,0\n1,0\n");
  for (std::size_t i = 0; i < 3 * orifices.size(); ++i)
    text += fmt::format(
        "[[replicate]]\nname = \"film{}\"\ndischarge = \"curve.csv\"\norifice_width_m = {}\n",
        i,
        orifices[i / 3]);
  return datasets::load_experiment(folder.write("bin.toml", text));
}

std::vector<datasets::Recording> recordings(const ParameterSet& truth,
                                            double noise,
                                            std::uint64_t seed) {
  std::vector<datasets::Recording> made;
  for (const std::uint64_t own : make_seeds(seed, "films", 3 * orifices.size()))
    made.push_back({.discharge = run_of(truth, orifices[made.size() / 3], noise, own)});
  return made;
}

Problem problem(const ParameterSet& truth, double noise, std::uint64_t seed) {
  return make_problem(experiment(), recordings(truth, noise, seed));
}

tests::ClosedEngine engine(double noise) {
  return tests::ClosedEngine([noise](const SimulationSpec& spec) {
    EngineRun run{.time_step = 1e-5};
    const auto bed = static_cast<std::uint64_t>(spec.scene.fill.number);
    run.recording.discharge =
        run_of(spec.parameters, orifice_of(spec), noise, spec.seed + 1000 * bed);
    return run;
  });
}

Evaluation evaluated(const Problem& problem,
                     const Engine& engine,
                     const ParameterSet& parameters,
                     std::uint64_t first_seed,
                     int seeds) {
  Evaluation evaluation{.parameters = parameters};
  for (const std::size_t scene : problem.calibrated_scenes) {
    const std::size_t replicate = problem.scenes[scene].replicate;
    for (int seed = 0; seed < seeds; ++seed) {
      const EngineRun run = engine.run(
          problem.spec_of(scene, parameters, 0.05, first_seed + static_cast<std::uint64_t>(seed)),
          {});
      evaluation.runs.push_back(
          {.channels = problem.observables->measure(
               run.recording, problem.situations[replicate], &problem.measured[replicate])});
    }
  }
  evaluation.objective = problem.calibrated->objective(evaluation.runs);
  return evaluation;
}

CalibrationResult calibrated(const Engine& engine, Problem problem, std::uint64_t seed) {
  problem.engine = &engine;
  Journal journal(":memory:");
  const auto executor = make_executor("threads", 2);
  const std::array experiments = {CalibratedExperiment{"bin", &problem}};
  CalibrationOptions options = default_options(experiments);
  options.seed = seed;
  return calibrate(problem.experiment, experiments, journal, *executor, {}, options);
}

}  // namespace graintruth::calibrate::closed_bin
