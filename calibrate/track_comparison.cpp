#include "calibrate/track_comparison.h"

#include <algorithm>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <cmath>

#include "calibrate/agreement.h"
#include "calibrate/ensemble.h"

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

double objective_of(const Target& target,
                    std::span<const datasets::Trajectories> tracks,
                    std::span<const int> weights) {
  return calibrate::objective(
      target.replicates, target.widths, mean_track(measure(tracks, weights)));
}

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

TrackComparison::TrackComparison(std::vector<datasets::Trajectories> replicates)
    : replicates_(std::move(replicates)) {
  target_.replicates = measure(replicates_);
  target_.widths = smooth_half_widths(target_.replicates, replicates_);
}

double TrackComparison::objective(std::span<const SimulatedRun> runs) const {
  const datasets::Trajectories mean = mean_of_runs(runs);
  if (mean.poses.empty()) return objective_of_rest(target_.replicates, target_.widths);
  return calibrate::objective(target_.replicates, target_.widths, mean);
}

double TrackComparison::noise(std::span<const SimulatedRun> runs) const {
  const std::vector<datasets::Trajectories> tracks = completed_tracks(runs);
  std::vector<double> values;
  std::vector<int> weights(tracks.size(), 1);
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    weights[i] = 0;
    values.push_back(objective_of(target_, tracks, weights));
    weights[i] = 1;
  }
  return jackknife_error(values);
}

RunScore TrackComparison::score_run(const SimulatedRun& run, std::size_t) const {
  if (run.status != RunStatus::completed)
    return {objective_of_rest(target_.replicates, target_.widths), 0.0};
  return {calibrate::objective(target_.replicates, target_.widths, run.trajectories),
          agreement(target_.replicates, run.trajectories, Critical::student_t).percent};
}

std::vector<std::vector<double>> TrackComparison::draw_objectives(
    std::span<const Evaluation> evaluations, const BootstrapOptions& options) const {
  std::vector<std::vector<datasets::Trajectories>> tracks;
  for (const Evaluation& evaluation : evaluations)
    tracks.push_back(completed_tracks(evaluation.runs));
  const std::vector<std::uint64_t> seeds = make_seeds(options.seed, "bootstrap", options.draws);
  std::vector<std::vector<double>> drawn(static_cast<std::size_t>(options.draws));
  parallel_for(options.draws, options.jobs, [&](int draw) {
    Generator generator(seeds[static_cast<std::size_t>(draw)]);
    // A draw of one replicate only has no spread left in it; it is drawn again.
    std::vector<int> replicate_weights;
    do {
      replicate_weights = draw_weights(replicates_.size(), generator);
    } while (!spread_over_two(replicate_weights));
    const Target drawn_target{measure(replicates_, replicate_weights), target_.widths};
    for (const auto& runs : tracks) {
      const double value =
          runs.empty() ? objective_of_rest(drawn_target.replicates, target_.widths)
                       : objective_of(drawn_target, runs, draw_weights(runs.size(), generator));
      drawn[static_cast<std::size_t>(draw)].push_back(value);
    }
  });
  return drawn;
}

double TrackComparison::significance() const {
  const auto n = static_cast<double>(replicates_.size());
  return critical_value(Critical::student_t, static_cast<int>(replicates_.size())) *
         std::sqrt(n / (n - 1.0));
}

}  // namespace graintruth::calibrate
