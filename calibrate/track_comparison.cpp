#include "calibrate/track_comparison.h"

#include <algorithm>
#include <array>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <cmath>
#include <limits>
#include <optional>

#include "calibrate/agreement.h"
#include "calibrate/ensemble.h"
#include "calibrate/hypothesis_tests.h"

namespace graintruth::calibrate {

namespace {

using Generator = boost::random::mt19937_64;

// How often each of n things is drawn in n draws with replacement.
std::vector<int> draw_weights(std::size_t n, Generator& generator) {
  boost::random::uniform_int_distribution<std::size_t> which(0, n - 1);
  std::vector<int> weights(n, 0);
  for (std::size_t i = 0; i < n; ++i) ++weights[which(generator)];
  return weights;
}

bool spread_over_two(const std::vector<int>& weights) {
  return std::count_if(weights.begin(), weights.end(), [](int weight) { return weight > 0; }) > 1;
}

// Mean tracks over the completed runs of an evaluation, for many weightings of its seeds.
class RunMeans {
 public:
  explicit RunMeans(const Evaluation& evaluation)
      : tracks_(completed_tracks(evaluation.runs)), means_(tracks_) {
    for (const SimulatedRun& run : evaluation.runs)
      is_completed_.push_back(run.status == RunStatus::completed);
  }
  RunMeans(const RunMeans&) = delete;
  RunMeans& operator=(const RunMeans&) = delete;

  // Nothing where no run of those drawn completed.
  std::optional<datasets::Trajectories> mean(std::span<const int> weights) const {
    std::vector<int> of_completed;
    for (std::size_t i = 0; i < is_completed_.size(); ++i) {
      if (is_completed_[i]) of_completed.push_back(weights[i]);
    }
    if (std::none_of(of_completed.begin(), of_completed.end(), [](int w) { return w > 0; }))
      return std::nullopt;
    return means_.mean(of_completed);
  }

 private:
  std::vector<datasets::Trajectories> tracks_;
  WeightedMeans means_;  // of tracks_
  std::vector<bool> is_completed_;
};

}  // namespace

std::vector<datasets::Trajectories> completed_tracks(std::span<const SimulatedRun> runs) {
  std::vector<datasets::Trajectories> tracks;
  for (const SimulatedRun& run : runs) {
    if (run.status == RunStatus::completed) tracks.push_back(run.trajectories);
  }
  return tracks;
}

datasets::Trajectories mean_of_runs(std::span<const SimulatedRun> runs) {
  const std::vector<datasets::Trajectories> tracks = completed_tracks(runs);
  if (tracks.empty() || 2 * tracks.size() < runs.size()) return {};
  return mean_track(measure(tracks));
}

TrackComparison::TrackComparison(std::vector<datasets::Trajectories> replicates,
                                 datasets::ObjectiveForm form)
    : replicates_(std::move(replicates)) {
  target_.replicates = measure(replicates_);
  target_.mean = mean_track(target_.replicates);
  target_.widths = form == datasets::ObjectiveForm::smooth
                       ? smooth_half_widths(target_.replicates, replicates_)
                       : agreement_half_widths(target_.replicates);
}

double TrackComparison::objective(std::span<const SimulatedRun> runs) const {
  const datasets::Trajectories mean = mean_of_runs(runs);
  if (mean.poses.empty()) return objective_of_rest(target_.mean, target_.widths);
  return calibrate::objective(target_.mean, target_.widths, mean);
}

std::vector<double> TrackComparison::residuals(std::span<const SimulatedRun> runs) const {
  const datasets::Trajectories mean = mean_of_runs(runs);
  if (mean.poses.empty()) return {};
  return calibrate::residuals(target_.mean, target_.widths, mean);
}

std::size_t TrackComparison::residual_count() const {
  return calibrate::residuals(target_.mean, target_.widths, target_.mean).size();
}

double TrackComparison::loss(std::span<const double> residuals) const {
  return mean_loss(form(), residuals);
}

double TrackComparison::noise(std::span<const SimulatedRun> runs) const {
  const std::vector<datasets::Trajectories> tracks = completed_tracks(runs);
  const WeightedMeans means(tracks);
  std::vector<double> values;
  std::vector<int> weights(tracks.size(), 1);
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    weights[i] = 0;
    values.push_back(calibrate::objective(target_.mean, target_.widths, means.mean(weights)));
    weights[i] = 1;
  }
  return jackknife_error(values);
}

RunScore TrackComparison::score_run(const SimulatedRun& run, std::size_t) const {
  if (run.status != RunStatus::completed)
    return {objective_of_rest(target_.mean, target_.widths), 0.0};
  return {calibrate::objective(target_.mean, target_.widths, run.trajectories),
          agreement(target_.replicates, run.trajectories, Critical::student_t).percent};
}

std::vector<std::vector<double>> TrackComparison::draw_objectives(
    std::span<const Evaluation> evaluations, const BootstrapOptions& options) const {
  const WeightedMeans replicate_means(replicates_);
  const std::vector<RunMeans> run_means(evaluations.begin(), evaluations.end());
  const std::vector<std::uint64_t> seeds = make_seeds(options.seed, "bootstrap", options.draws);
  std::vector<std::vector<double>> drawn(static_cast<std::size_t>(options.draws));
  parallel_for(options.draws, options.jobs, [&](int draw) {
    Generator generator(seeds[static_cast<std::size_t>(draw)]);
    // A draw of one replicate only has no spread left in it; it is drawn again.
    std::vector<int> replicate_weights;
    do {
      replicate_weights = draw_weights(replicates_.size(), generator);
    } while (!spread_over_two(replicate_weights));
    const datasets::Trajectories measured = replicate_means.mean(replicate_weights);
    // The same draw for all evaluations: they share their replicates and their seeds
    const std::vector<int> run_weights = draw_weights(evaluations.front().runs.size(), generator);
    for (const RunMeans& runs : run_means) {
      const auto mean = runs.mean(run_weights);
      drawn[static_cast<std::size_t>(draw)].push_back(
          mean ? calibrate::objective(measured, target_.widths, *mean)
               : objective_of_rest(measured, target_.widths));
    }
  });
  return drawn;
}

std::unique_ptr<Comparison> TrackComparison::with_replicates(
    std::span<const SimulatedRun> runs) const {
  std::vector<datasets::Trajectories> tracks = completed_tracks(runs);
  if (tracks.size() < 2) return nullptr;
  return std::make_unique<TrackComparison>(std::move(tracks), form());
}

std::unique_ptr<Comparison> TrackComparison::with_form(datasets::ObjectiveForm form) const {
  return std::make_unique<TrackComparison>(replicates_, form);
}

// D of the text in the header: the objective of one model's mean as if the other's were measured.
// What the seeds add to it is taken off by the jackknife's estimate of bias,
//   D - (n - 1)(mean of delete-one values - D),  Quenouille (1956).
double TrackComparison::distance(const Evaluation& first, const Evaluation& second) const {
  const RunMeans first_means(first), second_means(second);
  const auto without = [&](const std::vector<int>& weights) {
    const auto from = first_means.mean(weights), to = second_means.mean(weights);
    return from && to ? calibrate::objective(*from, target_.widths, *to) : 0.0;
  };
  const std::size_t n = first.runs.size();
  std::vector<int> weights(n, 1);
  const double whole = without(weights);
  double deleted = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    weights[i] = 0;
    deleted += without(weights) / static_cast<double>(n);
    weights[i] = 1;
  }
  return std::max(0.0, whole - static_cast<double>(n - 1) * (deleted - whole));
}

// Standard deviation of the difference of two objectives that comes from the seeds, which they
// share.
double TrackComparison::seed_deviation(const Evaluation& first, const Evaluation& second) const {
  const RunMeans first_means(first), second_means(second);
  const auto objective_of = [&](const RunMeans& means, const std::vector<int>& weights) {
    const auto mean = means.mean(weights);
    return mean ? calibrate::objective(target_.mean, target_.widths, *mean)
                : objective_of_rest(target_.mean, target_.widths);
  };
  std::vector<int> weights(first.runs.size(), 1);
  std::vector<double> values;
  for (int& weight : weights) {
    weight = 0;
    values.push_back(objective_of(first_means, weights) - objective_of(second_means, weights));
    weight = 1;
  }
  return jackknife_error(values);
}

double TrackComparison::half_width_of_difference(const Evaluation& first,
                                                 const Evaluation& second,
                                                 double roughness,
                                                 const BootstrapOptions& options) const {
  const auto n = static_cast<double>(replicates_.size());
  const auto m = static_cast<double>(first.runs.size());
  const double all = std::pow(difference_deviation(*this, first, second, options), 2);
  const double of_seeds = std::pow(seed_deviation(first, second), 2);
  // m seeds drawn from m vary too little likewise
  const double of_replicates = std::max(0.0, all - (m - 1.0) / m * of_seeds);
  const double of_roughness =
      std::pow(roughness * std::hypot(first.objective, second.objective), 2);
  const std::array<VarianceComponent, 3> components = {
      {{n / (n - 1.0) * of_replicates, n - 1.0},
       {of_seeds, std::max(1.0, m - 1.0)},
       {of_roughness, std::numeric_limits<double>::infinity()}}};
  return half_width_95(components);
}

double TrackComparison::allowed_excess(const Evaluation& best,
                                       const Evaluation& evaluation,
                                       double roughness,
                                       const BootstrapOptions& options) const {
  return std::max(
      0.0,
      half_width_of_difference(best, evaluation, roughness, options) - distance(evaluation, best));
}

}  // namespace graintruth::calibrate
