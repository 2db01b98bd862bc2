// Known truth in, truth out within the stated interval: calibrates twins of the micro rig whose
// parameters are drawn over the full bounds, and counts how often the intervals hold them.
//   bench_calibration_twins [FIGURES.csv] [TWINS]
// One row a twin goes to the file as it ends; run again, it goes on where it stopped.
#include <fmt/format.h>

#include <algorithm>
#include <openturns/OT.hxx>
#include <thread>

#include "bench/calibrate/thread_seconds.h"
#include "bench/calibrate/twin_rows.h"
#include "bench/calibrate/twins.h"
#include "calibrate/flow/median.h"

using namespace graintruth;
using datasets::number_text;
namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t study_seed = 2000;
constexpr int default_twins = 60;
constexpr int rank_places = 10;
constexpr double slow_simulation = 0.2;  // s; what all else is compared with

// Whether the softened particles rank parameters as the true ones do: Spearman's correlation of the
// objective over a design.
double rank_correlation(const datasets::Experiment& soft, int jobs) {
  datasets::Experiment stiff = soft;
  stiff.material.elastic_modulus = datasets::load_experiment(soft.file).material.elastic_modulus;
  const bench::Twin twin = bench::make_twin_at(bench::usual_truth(), stiff, study_seed, -1);
  const calibrate::ParameterSpace space(soft.tuned, {});
  const auto seeds = calibrate::make_seeds(study_seed, "rank", 4);
  const auto executor = calibrate::make_executor("threads", jobs);
  OT::Sample objectives(rank_places, 2);
  for (unsigned column = 0; column < 2; ++column) {
    const calibrate::Problem problem =
        calibrate::make_problem(column == 0 ? soft : stiff, twin.recordings);
    std::vector<calibrate::EvaluationPoint> points;
    for (const calibrate::UnitPoint& place :
         calibrate::low_discrepancy_points(rank_places, space.dimension(), study_seed))
      points.push_back({space.from_unit(place), problem.largest_time_step_fraction()});
    calibrate::Journal journal(":memory:");
    const auto evaluations =
        bench::ensemble_of(problem, journal, *executor).evaluate("rank", points, seeds);
    for (std::size_t place = 0; place < evaluations.size(); ++place)
      objectives(place, column) = evaluations[place].objective;
  }
  return OT::CorrelationAnalysis(objectives.getMarginal(0), objectives.getMarginal(1))
      .computeSpearmanCorrelation()[0];
}

std::vector<std::string> columns(const datasets::Experiment& experiment) {
  std::vector<std::string> names = bench::parameter_columns(experiment);
  names.insert(names.begin(), "twin");
  for (const char* name : {"agreement_percent",
                           "agreement_at_truth_percent",
                           "evaluations",
                           "simulations",
                           "failed",
                           "simulation_s",
                           "all_s"})
    names.emplace_back(name);
  return names;
}

std::vector<std::string> calibrate_twin(const datasets::Experiment& experiment,
                                        int number,
                                        const fs::path& folder) {
  const bench::Twin twin = bench::make_twin(experiment, study_seed, number);
  const double started = bench::thread_seconds();
  calibrate::Journal journal(folder / fmt::format("twin-{}.db", number));
  const auto executor = calibrate::make_executor("threads", 1);
  const calibrate::CalibratedExperiment one{experiment.name, &twin.problem};
  calibrate::CalibrationOptions options = calibrate::default_options({&one, 1});
  options.seed = static_cast<std::uint64_t>(number);
  const calibrate::CalibrationResult whole =
      calibrate::calibrate(experiment, {&one, 1}, journal, *executor, {}, options);
  const calibrate::ExperimentResult& result = whole.experiments.front();
  calibrate::Ensemble ensemble = bench::ensemble_of(twin.problem, journal, *executor);
  const calibrate::Evaluation at_truth =
      bench::judge({twin.truth, result.time_step.fraction}, options, ensemble);
  double processor = 0.0;
  for (const calibrate::JournalRow& row : journal.rows()) processor += row.run.seconds;
  const double all = bench::thread_seconds() - started;

  std::vector<std::string> cells =
      bench::parameter_cells(experiment, twin.truth, result.calibrated);
  cells.insert(cells.begin(), std::to_string(number));
  const calibrate::ChannelComparison& agreement = *twin.problem.calibrated;
  cells.insert(cells.end(),
               {number_text(agreement.percent_inside(result.confirmed.calibrated_runs)),
                number_text(agreement.percent_inside(at_truth.runs)),
                std::to_string(result.evaluations.size()),
                std::to_string(result.simulations),
                std::to_string(result.failed),
                number_text(processor),
                number_text(all)});
  return cells;
}

// Gneiting and Raftery (2007), eq 43: width + 2/alpha times what the truth lies outside by.
double interval_score(double lower, double upper, double truth) {
  constexpr double alpha = 0.05;
  return upper - lower +
         2.0 / alpha * (std::max(0.0, lower - truth) + std::max(0.0, truth - upper));
}

void print_parameter(const datasets::Table& table, std::string_view name) {
  int held = 0, without = 0;
  std::vector<double> widths, scores, errors;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const bench::ToldParameter told = bench::told_parameter(table, row, name);
    errors.push_back(std::abs(told.value - told.truth));
    if (!told.has_interval) {
      ++without;
      continue;
    }
    const auto& [lower, upper] = told.interval;
    held += told.holds_truth();
    widths.push_back(upper - lower);
    scores.push_back(interval_score(lower, upper, told.truth));
  }
  fmt::print(
      "{:28} {:3} of {} inside their interval ({} without one); median width {:.3f}, interval "
      "score {:.3f}, |error| {:.3f}\n",
      name,
      held,
      table.rows(),
      without,
      calibrate::median(widths),
      calibrate::median(scores),
      calibrate::median(errors));
}

void print_summary(const datasets::Experiment& experiment, const datasets::Table& table) {
  for (const datasets::TunedParameter& tuned : experiment.tuned) print_parameter(table, tuned.name);
  int near = 0, most = 0;
  std::vector<double> all, simulation, overhead;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    near += table.number(row, "agreement_percent") >=
            table.number(row, "agreement_at_truth_percent") - 5.0;
    most = std::max(most, table.integer(row, "evaluations"));
    all.push_back(table.number(row, "all_s"));
    simulation.push_back(table.number(row, "simulation_s"));
    overhead.push_back(100.0 * (all.back() - simulation.back()) /
                       (slow_simulation * table.number(row, "simulations")));
  }
  fmt::print("agreement at least the truth's less 5 points: {} of {}\n", near, table.rows());
  fmt::print(
      "evaluations at most {}; a calibration takes {:.1f} s of processor time, {:.1f} s of it "
      "simulating; all else is {:.1f} % of simulations that would take {} s each (medians)\n",
      most,
      calibrate::median(all),
      calibrate::median(simulation),
      calibrate::median(overhead),
      slow_simulation);
}

}  // namespace

int main(int argc, char** argv) {
  const fs::path figures = argc > 1 ? argv[1] : "calibration_twins.csv";
  const int twins = argc > 2 ? std::stoi(argv[2]) : default_twins;
  const int jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const datasets::Experiment experiment = bench::softened_micro_rig();
  fs::path folder = figures;
  folder.replace_extension("journals");
  fs::create_directories(folder);

  fmt::print(
      "modulus softened to {:.3g} Pa; rank correlation of the objective with the true "
      "modulus over {} places: {:.3f}\n",
      bench::softened_modulus,
      rank_places,
      rank_correlation(experiment, jobs));
  std::fflush(stdout);

  bench::TwinRows rows(figures, columns(experiment), twins);
  calibrate::parallel_for(twins, jobs, [&](int number) {
    if (rows.has(number)) return;
    rows.keep(number, calibrate_twin(experiment, number, folder));
    fmt::print("twin {} done\n", number);
    std::fflush(stdout);
  });
  print_summary(experiment, rows.table());
  return 0;
}
