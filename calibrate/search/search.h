// The search for parameters, whatever they are compared by: time step, design, an emulator's
// proposals, a local search, intervals, and the choice of the winner, in numbered steps.
#pragma once

#include <chrono>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibrate/ensemble.h"
#include "calibrate/knowledge/calibrated_parameter.h"
#include "calibrate/knowledge/identifiability.h"
#include "calibrate/knowledge/posterior.h"
#include "calibrate/search/best_by_objective.h"
#include "calibrate/search/optimiser.h"
#include "calibrate/search/self_test.h"
#include "calibrate/search/time_step_gate.h"
#include "datasets/verdict/warning.h"

namespace graintruth::calibrate {

struct CalibrationProgress {
  std::string_view stage;
  int evaluations = 0;  // of the search, done
  int budget = 0;
  double share = 0.0;  // of the whole calibration's expected cost that is done
  double best = 0.0;   // lowest objective so far; NaN before the first
  std::span<const Evaluation> finished = {};  // of the search, in order
};

struct CalibrationOptions {
  std::uint64_t seed = 1;
  int jobs = 1;
  int budget = 120;          // evaluations of the search: design, proposals, local search, profiles
  int search_seeds = 6;      // simulations an evaluation; a single run is as noisy as a replicate
  int gate_seeds = 8;        // simulations that a time step is tried with at first,
  int most_gate_seeds = 32;  // and at most
  int confirmation_seeds = 10;  // fresh runs whose mean is scored
  int choice_candidates = 6;  // evaluations among which fresh seeds choose, beside predicted places
  double largest_time_step_fraction = 0.3;
  double time_limit = 0.0;  // s of wall time after which the search ends with what it has; 0: none
  double allowed_failures = 0.3;  // share of simulations; above it the calibration gives up
  // Called with a sentence that the user should know before more is spent.
  std::function<void(const std::string&)> notice;
  // Called after every simulation.
  std::function<void(const CalibrationProgress&)> progress;
};

struct StageTime {
  std::string name;
  double seconds = 0.0;
};

// How well the surrogate knows the logarithm of the objective.
struct SurrogateQuality {
  double leave_one_out_error = 0.0;  // root mean square, of evaluations that it was not shown
  double value_spread = 0.0;         // standard deviation of all evaluations
  double roughness = 0.0;            // see Surrogate::roughness
};

// How well the emulator knows the compared numbers, in the form in which they enter it.
struct EmulatorQuality {
  double leave_one_out_error = 0.0;  // root mean square
  double value_spread = 0.0;         // standard deviation of all, each about its own mean
};

struct SearchResult {
  ParameterSet parameters;
  std::vector<CalibratedParameter> calibrated;
  TimeStepChoice time_step;
  double objective_noise = 0.0;         // of the confirmed parameters
  std::vector<Evaluation> evaluations;  // of the search, in order
  datasets::ObjectiveForm objective_form = datasets::ObjectiveForm::smooth;
  std::vector<BestByObjective> by_objective;  // what either form would have chosen of these
  std::string stop_reason;
  // Of those that show an effect, and of the posterior, on the surrogate: priors included
  std::vector<Profile> profiles;
  std::vector<PosteriorMarginal> posterior;
  double posterior_effective_size = 0.0;
  double prior_allowed_excess = 0.0;  // by which priors were weighed, see prior.h; 0 without any
  std::vector<TradeOff> trade_offs;   // of the data alone
  // Share of the measured values beyond everything that the design reached; NaN without a design.
  double out_of_reach = std::numeric_limits<double>::quiet_NaN();
  std::optional<SelfTest> self_test;          // none where the design's seeds are too few
  std::optional<SurrogateQuality> surrogate;  // none where nothing was tuned
  std::optional<EmulatorQuality> emulator;    // nor where hardly any simulation completed
  int simulations = 0;
  int failed = 0;
  int retried = 0;  // at half the time step
  std::vector<datasets::Warning> warnings;
  std::vector<StageTime> stages;
};

// What `text` tells of failed simulations, as a warning of the first line.
datasets::Warning words_on_failed(int failed, int simulations, std::string text);

// Simulations of one scene that the choice of the winner takes at most.
int choice_simulations(const CalibrationOptions& options);

// What a search costs at most, in simulations at the largest time step.
double expected_cost(std::size_t scenes, const CalibrationOptions& options);

// Thrown when more simulations fail than allowed; what() says what to try.
struct TooManyFailures : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// One search under way: the options, the growing result, and what every stage needs of both.
// Deterministic in the experiment, the options and the ensemble's simulators; resumes by being run
// again on the same journal.
class Search {
 public:
  // `later_simulations`: what the caller will simulate after the search, for the share of work
  // done that progress shows.
  Search(const datasets::Experiment& experiment,
         Ensemble& ensemble,
         const CalibrationOptions& options,
         int later_simulations);

  // All stages up to the choice of the parameters.
  void run();
  // A further stage of the caller's, with its time.
  void timed(const char* name, const std::function<void()>& stage);
  SimulationProgress reporter(double weight = 1.0);
  // Counts what a batch cost. Throws TooManyFailures.
  void count(std::span<const Evaluation> evaluations);
  // Puts values and intervals together, and says in words what must be said of them.
  SearchResult finish();

  const ParameterSet& parameters() const { return result_.parameters; }
  double time_step_fraction() const { return result_.time_step.fraction; }
  const std::vector<Evaluation>& evaluations() const { return result_.evaluations; }
  // The best evaluation of the search, and up to `count` - 1 that cannot be told apart from it, as
  // far from one another as there are.
  std::vector<Evaluation> compatible_evaluations(std::size_t count) const;

 private:
  static std::string first_complaint(std::span<const Evaluation> evaluations);
  std::vector<Evaluation> search(const char* stage, const std::vector<ParameterSet>& places);
  std::vector<Evaluation> search(const char* stage, const std::vector<EvaluationPoint>& points);
  const Evaluation& best() const;
  int share_of_budget(double share) const;
  int kept_for_intervals() const;
  bool is_time_up() const;
  void say_that_time_was_up();
  int budget_left() const;
  std::string words_on_limit() const;
  void choose_step();
  void explore();
  const Emulator& learn_emulator();
  double lowest_predicted() const;
  void follow_emulator(double share, int kept, int crowd = std::numeric_limits<int>::max());
  CalibratedParameter& calibrated(std::string_view name);
  void test_itself();
  void check_reach();
  void warn_early(datasets::Warning warning);
  OptimiserOptions local_search(double step, int budget) const;
  void polish(int kept);
  void polish_with_time_step();
  // Of the evaluations so far, the lowest first; each farther than `distance` from those before it.
  std::vector<UnitPoint> lowest_places(std::size_t count, double distance) const;
  void find_effects();
  void find_uncertainty();
  std::vector<Profile> find_profiles();
  double allowed_by_data() const;
  void bring_in_prior();
  void learn_landscape();
  void choose();
  const Profile* profile_of(const CalibratedParameter& parameter) const;
  std::optional<double> held_value(const CalibratedParameter& parameter) const;
  void give_interval(CalibratedParameter& parameter);
  void say_what_is_open(const CalibratedParameter& parameter);

  const datasets::Experiment& experiment_;
  Ensemble& ensemble_;
  CalibrationOptions options_;
  int later_simulations_;
  std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  std::vector<std::uint64_t> search_seeds_;
  ParameterSpace space_;
  Prior prior_;  // costs nothing until the data alone have been heard
  int budget_;   // evaluations that may be spent by now
  std::optional<Emulator> emulator_;
  std::optional<Surrogate> surrogate_;  // of all evaluations and the prior, once the search is over
  UnitPoint surrogate_minimum_;
  UnitPoint posterior_mean_;  // empty where nothing can be told apart
  std::string stage_;
  double cost_ = 0.0;
  SearchResult result_;
};

}  // namespace graintruth::calibrate
