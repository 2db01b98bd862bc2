#include "calibrate/bin_score.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/beta.hpp>
#include <cmath>
#include <limits>

#include "calibrate/bin_simulator.h"
#include "calibrate/hypothesis_tests.h"

namespace graintruth::calibrate {

namespace {

// The completed runs of an evaluation, as fit_bins wants them.
std::vector<FilmedBin> bins_of(const BinComparison& films, std::span<const SimulatedRun> runs) {
  const std::size_t seeds = runs.size() / films.films().size();
  std::vector<FilmedBin> bins;
  for (std::size_t run = 0; run < runs.size(); ++run) {
    if (runs[run].status != RunStatus::completed) continue;
    const FilmedBin& film = films.films()[run / seeds];
    bins.push_back({film.name, film.rig, runs[run].bin});
  }
  return bins;
}

// The rates of all runs through one orifice that did not jam, kg/s; how often they jam is told
// apart.
std::vector<double> rates_of(const std::vector<FilmedBin>& bins, double orifice) {
  std::vector<double> rates;
  for (const FilmedBin& bin : bins) {
    if (bin.rig.orifice != orifice || find_arching(bin.measured.discharge, bin.rig).jammed)
      continue;
    rates.push_back(numbers_of(bin.measured, bin.rig).rate);
  }
  return rates;
}

// NaN where there is none: an orifice at which everything jammed has no rate.
double mean_of(const std::vector<double>& values) {
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : summarise(values).mean;
}

Probability jams_of(const std::vector<FilmedBin>& bins, double orifice) {
  int jams = 0, runs = 0;
  for (const FilmedBin& bin : bins) {
    // A discharge curve cannot tell.
    if (bin.rig.orifice != orifice || !bin.measured.of_tracks) continue;
    ++runs;
    jams += find_arching(bin.measured.discharge, bin.rig).jammed ? 1 : 0;
  }
  return probability_of(jams, runs);
}

// Stagnant heights, mean over the runs through one orifice that flowed steadily.
std::vector<double> mean_boundary(const std::vector<FilmedBin>& bins, double orifice) {
  std::vector<double> sum;
  double runs = 0.0;
  for (const FilmedBin& bin : bins) {
    const std::vector<double>& heights = bin.measured.stagnant_heights;
    if (bin.rig.orifice != orifice || heights.empty()) continue;
    sum.resize(heights.size(), 0.0);
    for (std::size_t column = 0; column < heights.size(); ++column) sum[column] += heights[column];
    ++runs;
  }
  for (double& height : sum) height /= runs;
  return sum;
}

// Mean, lowest and highest count of discharged particles.
struct Counts {
  double mean = 0.0, lowest = 0.0, highest = 0.0;
  int runs = 0;
};
Counts counts_at(const std::vector<FilmedBin>& bins, double orifice, double time) {
  Counts counts;
  for (const FilmedBin& bin : bins) {
    if (bin.rig.orifice != orifice) continue;
    const double count = discharged_by(bin.measured.discharge, time);
    counts.lowest = counts.runs == 0 ? count : std::min(counts.lowest, count);
    counts.highest = counts.runs == 0 ? count : std::max(counts.highest, count);
    counts.mean += count;
    ++counts.runs;
  }
  if (counts.runs > 0) counts.mean /= counts.runs;
  return counts;
}

// Standard deviation of one film's count at a share of the film's duration, pooled over orifices.
double scatter_of_counts(const BinComparison& films, double share) {
  double squares = 0.0;
  int freedom = 0;
  for (const OrificeMean& orifice : films.orifices()) {
    std::vector<double> counts;
    for (const std::size_t film : orifice.films) {
      const Discharge& discharge = films.films()[film].measured.discharge;
      counts.push_back(discharged_by(discharge, share * discharge.to));
    }
    if (counts.size() < 2) continue;
    const SampleSummary summary = summarise(counts);
    squares += std::pow(summary.standard_deviation, 2) * (summary.count - 1);
    freedom += summary.count - 1;
  }
  return freedom == 0 ? 0.0 : std::sqrt(squares / freedom);
}

class BinScorer {
 public:
  BinScorer(const BinProblem& problem,
            Ensemble& all,
            const EvaluationPoint& point,
            const BinScoreOptions& options,
            const std::function<SimulationProgress(double cost)>& progress)
      : problem_(problem), all_(all), point_(point), options_(options), progress_(progress) {}

  BinScore score() {
    confirm();
    halve_step();
    vary_input();
    for (const OrificeMean& orifice : problem_.all->orifices()) compare(orifice);
    conclude();
    return std::move(result_);
  }

 private:
  // Fresh runs of every film at these parameters: nothing was chosen by them.
  void confirm() {
    const auto seeds = make_seeds(options_.seed, "confirmation", options_.runs);
    result_.evaluation = all_.evaluate("confirmation", {&point_, 1}, seeds, progress_(1.0)).front();
    result_.calibrated_runs = calibrated_runs();
    result_.shares = problem_.calibrated->shares(result_.calibrated_runs);
    simulated_ = bins_of(*problem_.all, result_.evaluation.runs);
  }

  // Of the films that are calibrated on.
  std::vector<SimulatedRun> calibrated_runs() const {
    const std::vector<SimulatedRun>& runs = result_.evaluation.runs;
    const auto seeds = static_cast<std::ptrdiff_t>(runs.size() / problem_.starts.size());
    std::vector<SimulatedRun> chosen;
    for (const std::size_t film : problem_.calibrated_films) {
      const auto first = runs.begin() + static_cast<std::ptrdiff_t>(film) * seeds;
      chosen.insert(chosen.end(), first, first + seeds);
    }
    return chosen;
  }

  // The same seeds at half the step.
  void halve_step() {
    const auto seeds = make_seeds(options_.seed, "confirmation", 1);
    EvaluationPoint point = point_;
    point.time_step_fraction *= 0.5;
    result_.others = all_.evaluate("time_step", {&point, 1}, seeds, progress_(2.0));
    halved_ = bins_of(*problem_.all, result_.others.front().runs);
  }

  // What parameters that the films cannot tell from these would predict.
  void vary_input() {
    const auto seeds = make_seeds(options_.seed, "prediction", 1);
    std::vector<EvaluationPoint> points;
    for (const ParameterSet& parameters : options_.alternatives)
      points.push_back({parameters, point_.time_step_fraction});
    const auto evaluations = all_.evaluate("prediction", points, seeds, progress_(1.0));
    for (const Evaluation& evaluation : evaluations) {
      inputs_.push_back(bins_of(*problem_.all, evaluation.runs));
      result_.others.push_back(evaluation);
    }
  }

  void compare(const OrificeMean& orifice) {
    OrificeComparison row{.orifice = orifice.orifice};
    row.held_out = problem_.starts[orifice.films.front()].held_out;
    const std::vector<FilmedBin>& films = problem_.all->films();
    const std::vector<double> filmed_rates = rates_of(films, row.orifice);
    row.filmed = mean_of(filmed_rates);
    row.film_error = problem_.all->scatter().relative_rate * row.filmed /
                     std::sqrt(static_cast<double>(filmed_rates.size()));
    const std::vector<double> rates = rates_of(simulated_, row.orifice);
    row.simulated = mean_of(rates);
    if (rates.size() > 1)
      row.run_error =
          summarise(rates).standard_deviation / std::sqrt(static_cast<double>(rates.size()));
    row.numerical_error = numerical_error() * row.simulated;
    // The scatter of single runs is in it too, which makes it rather too large than too small.
    std::vector<double> means;
    for (const std::vector<FilmedBin>& input : inputs_) {
      const std::vector<double> of_input = rates_of(input, row.orifice);
      if (!of_input.empty()) means.push_back(mean_of(of_input));
    }
    if (means.size() > 1) row.input_error = summarise(means).standard_deviation;
    row.filmed_stagnant = mean_boundary(films, row.orifice);
    row.simulated_stagnant = mean_boundary(simulated_, row.orifice);
    row.stagnant_overlap = datasets::stagnant_overlap(row.filmed_stagnant, row.simulated_stagnant);
    row.filmed_jams = jams_of(films, row.orifice);
    row.simulated_jams = jams_of(simulated_, row.orifice);
    result_.curves.push_back(curve_of(films, row));
    result_.orifices.push_back(row);
  }

  // Mean relative change of the rates of all orifices from the step to its half.
  double numerical_error() const {
    double change = 0.0;
    int orifices = 0;
    for (const OrificeMean& orifice : problem_.all->orifices()) {
      const double whole = mean_of(rates_of(simulated_, orifice.orifice));
      const double half = mean_of(rates_of(halved_, orifice.orifice));
      if (!(whole > 0.0 && half > 0.0)) continue;
      change += half / whole - 1.0;
      ++orifices;
    }
    return orifices == 0 ? 0.0 : std::abs(change) / orifices;
  }

  // Filmed counts at 100 moments, with the band of a further film: mean +- t s sqrt(1 + 1/n).
  std::vector<BinCurvePoint> curve_of(const std::vector<FilmedBin>& films, OrificeComparison& row) {
    constexpr int moments = 100;
    const BinComparison& all = *problem_.all;
    double duration = 0.0;
    for (const FilmedBin& film : films) {
      if (film.rig.orifice == row.orifice)
        duration = std::max(duration, film.measured.discharge.to);
    }
    const double t =
        all.scatter().freedom > 0 ? student_t_quantile(0.975, all.scatter().freedom) : 0.0;
    std::vector<BinCurvePoint> curve;
    int inside = 0;
    for (int i = 0; i <= moments; ++i) {
      const double share = static_cast<double>(i) / moments;
      BinCurvePoint point{.time = share * duration};
      const Counts filmed = counts_at(films, row.orifice, point.time);
      const Counts simulated = counts_at(simulated_, row.orifice, point.time);
      // No particle is counted in part.
      const double reach =
          std::max(1.0, t * scatter_of_counts(all, share) * std::sqrt(1.0 + 1.0 / filmed.runs));
      point.filmed = filmed.mean;
      point.lower = std::max(0.0, filmed.mean - reach);
      point.upper =
          std::min(filmed.mean + reach, static_cast<double>(problem_.experiment.particle.count));
      point.simulated = simulated.mean;
      point.simulated_lower = simulated.lowest;
      point.simulated_upper = simulated.highest;
      inside += point.lower <= point.simulated && point.simulated <= point.upper ? 1 : 0;
      curve.push_back(point);
    }
    row.curve_inside = static_cast<double>(inside) / (moments + 1);
    return curve;
  }

  void conclude() {
    result_.filmed = fit_bins(problem_.all->films(), problem_.experiment.rig.gravity);
    result_.simulated = fit_bins(simulated_, problem_.experiment.rig.gravity);
    result_.simulated_modulus = simulated_modulus(problem_.starts.front());
    int calibrated = 0;
    for (const OrificeComparison& row : result_.orifices) {
      if (row.held_out || !(row.filmed > 0.0) || std::isnan(row.error())) continue;
      result_.mean_signed_error += row.error() / row.filmed;
      ++calibrated;
    }
    result_.mean_signed_error /= std::max(1, calibrated);
    if (result_.simulated_modulus < problem_.experiment.material.elastic_modulus) {
      result_.warnings.push_back(fmt::format(
          "Simulated with an elastic modulus of {:.3g} Pa instead of {:.3g} Pa: the softest at "
          "which the hardest expected impact overlaps by 1 % of the particle diameter.",
          result_.simulated_modulus,
          problem_.experiment.material.elastic_modulus));
    }
  }

  const BinProblem& problem_;
  Ensemble& all_;
  EvaluationPoint point_;
  const BinScoreOptions& options_;
  const std::function<SimulationProgress(double cost)>& progress_;
  BinScore result_;
  std::vector<FilmedBin> simulated_, halved_;
  std::vector<std::vector<FilmedBin>> inputs_;
};

}  // namespace

Probability probability_of(int happened, int runs) {
  Probability probability{.happened = happened, .runs = runs, .lower = 0.0, .upper = 1.0};
  if (runs == 0) return probability;
  const boost::math::beta_distribution<double> posterior(happened + 0.5, runs - happened + 0.5);
  if (happened > 0) probability.lower = boost::math::quantile(posterior, 0.025);
  if (happened < runs) probability.upper = boost::math::quantile(posterior, 0.975);
  return probability;
}

double OrificeComparison::validation_uncertainty() const {
  return std::sqrt(film_error * film_error + run_error * run_error + input_error * input_error +
                   numerical_error * numerical_error);
}

int simulations_of_score(const BinProblem& problem, int runs, int alternatives) {
  return static_cast<int>(problem.starts.size()) * (runs + 1 + alternatives);
}

BinScore score_bin(const BinProblem& problem,
                   Ensemble& all,
                   const EvaluationPoint& point,
                   const BinScoreOptions& options,
                   const std::function<SimulationProgress(double cost)>& progress) {
  return BinScorer(problem, all, point, options, progress).score();
}

}  // namespace graintruth::calibrate
