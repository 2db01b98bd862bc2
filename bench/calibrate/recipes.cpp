// The default recipe beside NLopt's algorithms alone, on twins of the softened micro rig: how good
// the best of 60, 120 and 240 evaluations is.
//   bench_calibration_recipes [FIGURES.csv] [TWINS]
// All spend the same evaluations (6 simulations with common seeds) from the same time step; the
// best evaluation of each is judged by fresh seeds. Rows go to the file as they are measured; run
// again, it goes on where it stopped.
#include <fmt/format.h>

#include <map>
#include <mutex>
#include <nlopt.hpp>
#include <thread>

#include "bench/calibrate/twins.h"
#include "calibrate/flow/median.h"
#include "datasets/store/table.h"

using namespace graintruth;
using datasets::number_text;
namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t study_seed = 2000;
constexpr int default_twins = 12;
constexpr std::array<int, 3> budgets = {60, 120, 240};
const char* const default_recipe = "default";
const std::vector<std::pair<const char*, nlopt::algorithm>> algorithms = {
    {"LN_SBPLX", nlopt::LN_SBPLX},
    {"LN_BOBYQA", nlopt::LN_BOBYQA},
    {"GN_CRS2_LM", nlopt::GN_CRS2_LM},
    {"GN_DIRECT_L", nlopt::GN_DIRECT_L},
    {"G_MLSL_LDS", nlopt::G_MLSL_LDS}};
const std::vector<std::string> columns = {"twin",
                                          "recipe",
                                          "budget",
                                          "objective",
                                          "objective_at_truth",
                                          "agreement_percent",
                                          "agreement_at_truth_percent",
                                          "friction_particle_particle",
                                          "friction_particle_particle_truth"};

// One twin under study.
class Contest {
 public:
  Contest(const datasets::Experiment& experiment, int number)
      : experiment_(experiment),
        number_(number),
        twin_(bench::make_twin(experiment, study_seed, number)),
        journal_(":memory:"),
        executor_(calibrate::make_executor("threads", 1)),
        ensemble_(bench::ensemble_of(twin_.problem, journal_, *executor_)),
        space_(experiment.tuned, datasets::bench_parameters(experiment)) {
    options_.seed = static_cast<std::uint64_t>(number);
    options_.largest_time_step_fraction = twin_.problem.largest_time_step_fraction();
    fraction_ = options_.largest_time_step_fraction;
  }

  std::vector<std::vector<std::string>> run() {
    for (const int budget : budgets) follow_default(budget);
    for (const auto& [name, algorithm] : algorithms) follow(name, algorithm);
    return std::move(rows_);
  }

 private:
  void follow_default(int budget) {
    calibrate::CalibrationOptions options = options_;
    options.budget = budget;
    calibrate::Search search(experiment_, ensemble_, options, 0);
    search.run();
    fraction_ = search.time_step_fraction();
    judge(default_recipe, budget, calibrate::best_of(search.evaluations()).parameters);
  }

  // From the centre of the box, as far as the largest budget reaches.
  void follow(const char* name, nlopt::algorithm algorithm) {
    const auto dimension = static_cast<unsigned>(space_.dimension());
    const auto seeds = calibrate::make_seeds(options_.seed, "search", options_.search_seeds);
    double lowest = std::numeric_limits<double>::infinity();
    calibrate::ParameterSet best;
    int evaluations = 0;
    std::map<int, calibrate::ParameterSet> best_after;
    const nlopt::vfunc objective =
        [](const std::vector<double>& place, std::vector<double>&, void* data) {
          return (*static_cast<std::function<double(const std::vector<double>&)>*>(data))(place);
        };
    std::function<double(const std::vector<double>&)> evaluate =
        [&](const std::vector<double>& place) {
          const calibrate::ParameterSet at = space_.from_unit(place);
          const calibrate::EvaluationPoint point{at, fraction_};
          const double value = ensemble_.evaluate(name, {&point, 1}, seeds).front().objective;
          ++evaluations;
          if (value < lowest) {
            lowest = value;
            best = at;
          }
          best_after[evaluations] = best;
          return value;
        };
    nlopt::srand(options_.seed + 1);
    const auto prepared = [&](nlopt::algorithm which) {
      nlopt::opt optimiser(which, dimension);
      optimiser.set_lower_bounds(0.0);
      optimiser.set_upper_bounds(1.0);
      optimiser.set_initial_step(std::vector<double>(dimension, 0.2));
      optimiser.set_min_objective(objective, &evaluate);
      return optimiser;
    };
    nlopt::opt optimiser = prepared(algorithm);
    optimiser.set_maxeval(budgets.back());
    if (algorithm == nlopt::G_MLSL_LDS) {
      nlopt::opt local = prepared(nlopt::LN_SBPLX);
      local.set_xtol_abs(0.01);
      optimiser.set_local_optimizer(local);
    } else {
      optimiser.set_xtol_abs(1.0e-4);
    }
    std::vector<double> place(dimension, 0.5);
    try {
      double value = 0.0;
      optimiser.optimize(place, value);
    } catch (const nlopt::roundoff_limited&) {
      // It ends where it has come to.
    }
    // One that ends early has no better answer later
    for (const int budget : budgets)
      judge(name, budget, std::prev(best_after.upper_bound(budget))->second);
  }

  void judge(const char* recipe, int budget, const calibrate::ParameterSet& parameters) {
    const calibrate::Evaluation own = bench::judge({parameters, fraction_}, options_, ensemble_);
    const calibrate::Evaluation at_truth =
        bench::judge({twin_.truth, fraction_}, options_, ensemble_);
    const calibrate::ChannelComparison& agreement = *twin_.problem.calibrated;
    rows_.push_back({std::to_string(number_),
                     recipe,
                     std::to_string(budget),
                     number_text(own.objective),
                     number_text(at_truth.objective),
                     number_text(agreement.percent_inside(own.runs)),
                     number_text(agreement.percent_inside(at_truth.runs)),
                     number_text(parameters.of("friction_particle_particle")),
                     number_text(twin_.truth.of("friction_particle_particle"))});
  }

  const datasets::Experiment& experiment_;
  int number_;
  bench::Twin twin_;
  calibrate::Journal journal_;
  std::unique_ptr<calibrate::Executor> executor_;
  calibrate::Ensemble ensemble_;
  calibrate::ParameterSpace space_;
  calibrate::CalibrationOptions options_;
  double fraction_;
  std::vector<std::vector<std::string>> rows_;
};

void print_summary(const datasets::Table& table, int twins) {
  fmt::print(
      "medians over {} twins of: objective of fresh seeds in units of the truth's / percentage "
      "points of agreement below the truth's / error of the particles' friction\n\n| recipe |",
      twins);
  for (const int budget : budgets) fmt::print(" {} evaluations |", budget);
  fmt::print("\n|---|---|---|---|\n");
  std::vector<std::string> recipes = {default_recipe};
  for (const auto& [name, algorithm] : algorithms) recipes.emplace_back(name);
  for (const std::string& recipe : recipes) {
    fmt::print("| {} |", recipe);
    for (const int budget : budgets) {
      std::vector<double> ratios, points, errors;
      for (std::size_t row = 0; row < table.rows(); ++row) {
        if (table.text(row, "recipe") != recipe || table.integer(row, "budget") != budget) continue;
        ratios.push_back(table.number(row, "objective") / table.number(row, "objective_at_truth"));
        points.push_back(table.number(row, "agreement_at_truth_percent") -
                         table.number(row, "agreement_percent"));
        errors.push_back(std::abs(table.number(row, "friction_particle_particle") -
                                  table.number(row, "friction_particle_particle_truth")));
      }
      fmt::print(" {:.2f} / {:.1f} / {:.3f} |",
                 calibrate::median(ratios),
                 calibrate::median(points),
                 calibrate::median(errors));
    }
    fmt::print("\n");
  }
}

}  // namespace

int main(int argc, char** argv) {
  const fs::path figures = argc > 1 ? argv[1] : "calibration_recipes.csv";
  const int twins = argc > 2 ? std::stoi(argv[2]) : default_twins;
  const int jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const datasets::Experiment experiment = bench::softened_micro_rig();
  std::map<int, std::vector<std::vector<std::string>>> rows;
  if (fs::exists(figures)) {
    const datasets::Table kept = datasets::read_csv(figures);
    for (std::size_t row = 0; row < kept.rows(); ++row) {
      auto& cells = rows[kept.integer(row, "twin")].emplace_back();
      for (const std::string& name : columns) cells.push_back(kept.text(row, name));
    }
  }
  std::mutex mutex;
  const auto table = [&] {
    datasets::Table done(columns);
    for (const auto& [twin, of_twin] : rows) {
      for (const auto& row : of_twin) done.add(row);
    }
    return done;
  };
  calibrate::parallel_for(twins, jobs, [&](int number) {
    {
      const std::lock_guard lock(mutex);
      if (rows.contains(number)) return;
    }
    auto measured = Contest(experiment, number).run();
    const std::lock_guard lock(mutex);
    rows[number] = std::move(measured);
    datasets::write_csv(figures, table());
    fmt::print("twin {} done\n", number);
    std::fflush(stdout);
  });
  print_summary(table(), static_cast<int>(rows.size()));
  return 0;
}
