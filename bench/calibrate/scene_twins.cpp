// Known truth in, truth out within the stated interval, for a rig that a scene file describes:
// calibrates twins of a box of clumps in three dimensions, from the tables that a balance and a
// load cell write, and counts how often frictions are identified and intervals hold the truth.
//   bench_calibration_scene_twins [FIGURES.csv] [TWINS] [BUDGET] [SEED] [JOBS]
// The experiment is bench/calibrate/scene_twins/experiment.toml. One row a twin goes to the file as
// it ends; run again with the same options, it goes on where it stopped.
#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <fstream>

#include "bench/calibrate/thread_seconds.h"
#include "bench/calibrate/twin_rows.h"
#include "calibrate/calibration.h"
#include "calibrate/flow/median.h"
#include "datasets/imports/curve_files.h"

using namespace graintruth;
using datasets::number_text;
namespace fs = std::filesystem;

namespace {

constexpr double balance_error = 2.0e-4;    // kg, of one reading; half a clump
constexpr double load_cell_error = 5.0e-3;  // N, of one reading; a hundredth of the shelf's load
// A smaller step than that of the calibration, so that the twins do not share its error
constexpr double twin_step = 0.5;  // of the largest
constexpr std::string_view friction = "friction_particle_";

struct Study {
  fs::path folder;
  int twins = 10;
  int budget = 60;  // evaluations a calibration
  std::uint64_t seed = 3000;
};

// The calibration as it is usually done, with fewer simulations of each place, so that ten twins
// take less than an hour.
calibrate::CalibrationOptions options_of(const Study& study,
                                         std::span<const calibrate::CalibratedExperiment> twin,
                                         int number) {
  calibrate::CalibrationOptions options = calibrate::default_options(twin);
  options.seed = static_cast<std::uint64_t>(number);
  options.budget = study.budget;
  options.search_seeds = 3;
  options.gate_seeds = 4;
  options.confirmation_seeds = 5;
  options.choice_candidates = 3;
  return options;
}

// The bundled experiment, in a folder of the twin's own, with its tables still empty.
datasets::Experiment experiment_in(const fs::path& folder) {
  const fs::path source = fs::path(GRAINTRUTH_SOURCE_DIR) / "bench" / "calibrate" / "scene_twins";
  constexpr int replicates = 5;
  fs::create_directories(folder);
  for (const char* name : {"box.toml", "experiment.toml"})
    fs::copy_file(source / name, folder / name, fs::copy_options::overwrite_existing);
  for (int replicate = 1; replicate <= replicates; ++replicate) {
    for (const char* instrument : {"balance", "force"})
      std::ofstream(folder / fmt::format("{}{}.csv", instrument, replicate));
  }
  datasets::Experiment experiment = datasets::load_experiment(folder / "experiment.toml");
  calibrate::complete_particle(experiment);
  return experiment;
}

// What an instrument writes of a quantity: every reading with an error of its own.
void write_readings(const fs::path& file,
                    const char* column,
                    double in_unit,
                    const std::vector<double>& time,
                    std::vector<double> value,
                    const std::function<double()>& error) {
  datasets::Table table({"time_s", column});
  for (std::size_t i = 0; i < time.size(); ++i)
    table.add({number_text(time[i]), number_text((value[i] + error()) * in_unit)});
  datasets::write_csv(file, table);
}

// The tables of all replicates, simulated at the truth with seeds that no calibration uses.
void record(const datasets::Experiment& experiment,
            const calibrate::ParameterSet& truth,
            const Study& study,
            int number) {
  const std::vector<datasets::Recording> none(experiment.replicates.size());
  const calibrate::Problem problem = calibrate::plan_problem(experiment, none);
  const auto seeds = calibrate::make_seeds(
      study.seed, fmt::format("twin {}", number), static_cast<int>(none.size()));
  for (std::size_t r = 0; r < seeds.size(); ++r) {
    const calibrate::EngineRun run = problem.engine->run(
        problem.spec_of(0, truth, twin_step * problem.largest_time_step_fraction(), seeds[r]), {});
    if (run.status != calibrate::RunStatus::completed)
      throw std::runtime_error(fmt::format("twin {}: {}", number, run.message));
    boost::random::mt19937_64 generator(seeds[r]);
    boost::random::normal_distribution<double> normal;
    const datasets::DischargeCurve& discharge = *run.recording.discharge;
    write_readings(
        experiment.replicates[r].discharge, "mass_g", 1.0e3, discharge.time, discharge.mass, [&] {
          return balance_error * normal(generator);
        });
    const datasets::Curve& force = run.recording.curves.begin()->second;
    write_readings(
        experiment.replicates[r].curves, "wall_force_n", 1.0, force.time, force.value, [&] {
          return load_cell_error * normal(generator);
        });
  }
}

// The tables as a user's are read.
std::vector<datasets::Recording> read_recordings(const datasets::Experiment& experiment) {
  const datasets::Particle& particle = experiment.particle;
  std::vector<datasets::Recording> recordings;
  for (const datasets::Replicate& replicate : experiment.replicates) {
    datasets::Recording& recording = recordings.emplace_back();
    recording.discharge = datasets::read_discharge_curve(
        replicate.discharge,
        {.full_mass = particle.count * particle.mass, .particle_mass = particle.mass});
    recording.curves = datasets::read_curves(replicate.curves, 0.0);
  }
  return recordings;
}

std::vector<std::string> columns(const datasets::Experiment& experiment) {
  std::vector<std::string> names = bench::parameter_columns(experiment);
  names.insert(names.begin(), "twin");
  for (const char* name : {"objective",
                           "objective_noise",
                           "time_step_fraction",
                           "evaluations",
                           "simulations",
                           "failed",
                           "simulation_s",
                           "all_s"})
    names.emplace_back(name);
  return names;
}

// Of a design that fills the box of the bounds evenly.
calibrate::ParameterSet truth_of(const datasets::Experiment& experiment,
                                 const Study& study,
                                 int number) {
  const calibrate::ParameterSpace space(experiment.tuned, datasets::bench_parameters(experiment));
  return space.from_unit(
      calibrate::low_discrepancy_points(number + 1, space.dimension(), study.seed).back());
}

std::vector<std::string> calibrate_twin(const Study& study, int number) {
  // 1. An experiment whose truth is known
  const fs::path folder = study.folder / fmt::format("twin-{}", number);
  const datasets::Experiment experiment = experiment_in(folder);
  const calibrate::ParameterSet truth = truth_of(experiment, study, number);
  record(experiment, truth, study, number);
  // 2. Calibrated as a user's is
  const double started = bench::thread_seconds();
  const calibrate::Problem problem =
      calibrate::make_problem(experiment, read_recordings(experiment));
  calibrate::Journal journal(folder / "journal.db");
  journal.belong_to(problem.parts);
  const auto executor = calibrate::make_executor("threads", 1);
  const calibrate::CalibratedExperiment one{experiment.name, &problem};
  const calibrate::CalibrationResult result = calibrate::calibrate(
      experiment, {&one, 1}, journal, *executor, {}, options_of(study, {&one, 1}, number));
  double processor = 0.0;
  for (const calibrate::JournalRow& row : journal.rows()) processor += row.run.seconds;
  // 3. What it says, beside the truth
  for (const datasets::Warning& warning : result.experiments.front().warnings)
    fmt::print("twin {}: {}\n", number, warning.text);
  std::vector<std::string> cells = bench::parameter_cells(experiment, truth, result.calibrated);
  cells.insert(cells.begin(), std::to_string(number));
  cells.insert(cells.end(),
               {number_text(result.objective),
                number_text(result.objective_noise),
                number_text(result.time_step.fraction),
                std::to_string(result.evaluations.size()),
                std::to_string(result.simulations),
                std::to_string(result.failed),
                number_text(processor),
                number_text(bench::thread_seconds() - started)});
  return cells;
}

// Whether the data bound a parameter on a side at least, as the program itself says.
bool is_identified(const bench::ToldParameter& told) {
  return told.status == "tuned" || told.status == "at_bound";
}

// The 95 % interval of a share of which `held` of `stated` were seen (Clopper and Pearson 1934).
calibrate::Interval share_interval(int held, int stated) {
  using Binomial = boost::math::binomial_distribution<>;
  constexpr double tail = 0.025;
  if (stated == 0) return {0.0, 1.0};
  return {held == 0 ? 0.0 : Binomial::find_lower_bound_on_p(stated, held, tail),
          held == stated ? 1.0 : Binomial::find_upper_bound_on_p(stated, held, tail)};
}

void print_share(std::string_view of, int held, int stated) {
  const auto [lower, upper] = share_interval(held, stated);
  fmt::print(
      "{:36} {:2} of {:2} stated intervals hold the truth; 95 % interval of the share {:.2f} "
      "to {:.2f}\n",
      of,
      held,
      stated,
      lower,
      upper);
}

void print_summary(const datasets::Experiment& experiment, const datasets::Table& table) {
  int all_held = 0, all_stated = 0;
  std::vector<char> any_friction(table.rows(), 0);
  for (const datasets::TunedParameter& tuned : experiment.tuned) {
    int held = 0, stated = 0, identified = 0, both_sides = 0;
    std::vector<double> widths;
    for (std::size_t row = 0; row < table.rows(); ++row) {
      const bench::ToldParameter told = bench::told_parameter(table, row, tuned.name);
      fmt::print("twin {} {:36} truth {:.3f} value {:.3f} interval {} {} {}\n",
                 table.text(row, "twin"),
                 tuned.name,
                 told.truth,
                 told.value,
                 told.has_interval
                     ? fmt::format("{:.3f} to {:.3f}", told.interval.lower, told.interval.upper)
                     : std::string("none"),
                 told.status,
                 !told.has_interval   ? ""
                 : told.holds_truth() ? "holds"
                                      : "DOES NOT HOLD");
      identified += is_identified(told);
      if (is_identified(told) && tuned.name.starts_with(friction)) any_friction[row] = 1;
      if (!told.has_interval) continue;
      ++stated;
      held += told.holds_truth();
      both_sides += told.interval.lower > tuned.lower && told.interval.upper < tuned.upper;
      widths.push_back(told.interval.upper - told.interval.lower);
    }
    all_held += held;
    all_stated += stated;
    print_share(tuned.name, held, stated);
    fmt::print(
        "{:36} identified in {} of {} twins, bounded on both sides in {}; median width {:.3f} of a "
        "range of {:.3f}\n",
        "",
        identified,
        table.rows(),
        both_sides,
        widths.empty() ? 0.0 : calibrate::median(widths),
        tuned.upper - tuned.lower);
  }
  print_share("all parameters", all_held, all_stated);
  double simulating = 0.0, all = 0.0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    simulating += table.number(row, "simulation_s");
    all += table.number(row, "all_s");
  }
  fmt::print(
      "a friction at least is identified in {} of {} twins; {:.0f} s of processor time, {:.0f} s "
      "of it simulating\n",
      std::count(any_friction.begin(), any_friction.end(), 1),
      table.rows(),
      all,
      simulating);
}

}  // namespace

int main(int argc, char** argv) {
  const fs::path figures = argc > 1 ? argv[1] : "calibration_scene_twins.csv";
  Study study{.folder = fs::path(figures).replace_extension("twins")};
  if (argc > 2) study.twins = std::stoi(argv[2]);
  if (argc > 3) study.budget = std::stoi(argv[3]);
  if (argc > 4) study.seed = std::stoull(argv[4]);
  const int jobs = argc > 5 ? std::stoi(argv[5]) : 1;

  const datasets::Experiment experiment = experiment_in(study.folder);
  bench::TwinRows rows(figures, columns(experiment), study.twins);
  calibrate::parallel_for(study.twins, jobs, [&](int number) {
    if (rows.has(number)) return;
    rows.keep(number, calibrate_twin(study, number));
    fmt::print("twin {} done\n", number);
    std::fflush(stdout);
  });
  print_summary(experiment, rows.table());
  return 0;
}
