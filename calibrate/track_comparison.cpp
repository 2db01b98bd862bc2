#include "calibrate/track_comparison.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "calibrate/agreement.h"
#include "calibrate/hypothesis_tests.h"

namespace graintruth::calibrate {

namespace {

// 2 near - far
std::vector<double> mirrored(std::vector<double> near, std::span<const double> far) {
  for (std::size_t i = 0; i < near.size(); ++i) near[i] = 2.0 * near[i] - far[i];
  return near;
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
  const auto widths_of = [form](std::span<const datasets::Trajectories> tracks, int left_out) {
    return form == datasets::ObjectiveForm::smooth
               ? smooth_half_widths(measure(tracks), tracks, left_out)
               : agreement_half_widths(measure(tracks), left_out);
  };
  target_.replicates = measure(replicates_);
  target_.mean = mean_track(target_.replicates);
  target_.widths = widths_of(replicates_, 0);
  for (std::size_t r = 0; r < replicates_.size(); ++r) {
    std::vector<datasets::Trajectories> others = replicates_;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(r));
    without_.push_back(
        {mean_track(measure(others)), others.size() < 2 ? target_.widths : widths_of(others, 1)});
  }
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

std::unique_ptr<Comparison> TrackComparison::with_replicates(
    std::span<const SimulatedRun> runs) const {
  std::vector<datasets::Trajectories> tracks = completed_tracks(runs);
  if (tracks.size() < 2) return nullptr;
  return std::make_unique<TrackComparison>(std::move(tracks), form());
}

std::unique_ptr<Comparison> TrackComparison::with_form(datasets::ObjectiveForm form) const {
  return std::make_unique<TrackComparison>(replicates_, form);
}

// Excess of the second model and D of the text in the header, [L(z2) - L(z1)] + [L(2 z1 - z2) -
// L(z1)], z being residuals: H (p2 - p1)^2 on a parabola of curvature H.
double TrackComparison::second_difference(const HalfWidths& widths,
                                          const datasets::Trajectories& first,
                                          const datasets::Trajectories& second) const {
  const std::vector<double> near = calibrate::residuals(target_.mean, widths, first);
  const std::vector<double> far = calibrate::residuals(target_.mean, widths, second);
  return loss(far) + loss(mirrored(near, far)) - 2.0 * loss(near);
}

// D of the text in the header, L(2 z1 - z2) - L(z1), z being the residuals of the two models. What
// the seeds add to it is taken off by the jackknife's estimate of bias,
//   D - (n - 1)(mean of delete-one values - D),  Quenouille (1956).
double TrackComparison::distance(const Evaluation& first, const Evaluation& second) const {
  const RunMeans first_means(first), second_means(second);
  const auto without = [&](const std::vector<int>& weights) {
    const auto one = first_means.mean(weights), other = second_means.mean(weights);
    if (!one || !other) return 0.0;
    const std::vector<double> near = calibrate::residuals(target_.mean, target_.widths, *one);
    const std::vector<double> far = calibrate::residuals(target_.mean, target_.widths, *other);
    return loss(mirrored(near, far)) - loss(near);
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

// With d_r(h) what the difference changes by when replicate r leaves the mean that models are
// compared with, h being half widths, h_r those of the other replicates alone, and H(h) what
// second_difference() gives,
//   (n - 1)/n sum of d_r(h)^2  and  (n - 1)/n sum of (d_r(h_r) H(h)/H(h_r))^2:
// objectives grow with 1/h^2, and so does H.
ReplicateVariance TrackComparison::replicate_variance(const Evaluation& first,
                                                      const Evaluation& second) const {
  const datasets::Trajectories near = mean_of_runs(first.runs), far = mean_of_runs(second.runs);
  const auto objective_of = [](const datasets::Trajectories& measured,
                               const HalfWidths& widths,
                               const datasets::Trajectories& model) {
    return model.poses.empty() ? objective_of_rest(measured, widths)
                               : calibrate::objective(measured, widths, model);
  };
  const auto scale_of = [&](const HalfWidths& widths) {
    return near.poses.empty() || far.poses.empty() ? 0.0 : second_difference(widths, near, far);
  };
  const auto n = static_cast<double>(replicates_.size());
  const double scale = scale_of(target_.widths);
  ReplicateVariance variance;
  for (const auto& [others, widths_of_others] : without_) {
    const auto change_by = [&](const HalfWidths& widths) {
      return objective_of(target_.mean, widths, near) - objective_of(target_.mean, widths, far) -
             objective_of(others, widths, near) + objective_of(others, widths, far);
    };
    const double by_own = change_by(target_.widths);
    // Where the valley has no curvature there is nothing to scale by
    const double scale_of_others = scale_of(widths_of_others);
    const double by_others = scale > 0.0 && scale_of_others > 0.0
                                 ? change_by(widths_of_others) * scale / scale_of_others
                                 : by_own;
    variance.by_own_widths += (n - 1.0) / n * by_own * by_own;
    variance.by_widths_of_others += (n - 1.0) / n * by_others * by_others;
  }
  return variance;
}

double TrackComparison::half_width_of_difference(const Evaluation& first,
                                                 const Evaluation& second,
                                                 const PooledChance& chance,
                                                 const BootstrapOptions&) const {
  const auto n = static_cast<double>(replicates_.size());
  const auto m = static_cast<double>(first.runs.size());
  const double of_replicates =
      chance.cost_of_own_widths * replicate_variance(first, second).by_own_widths;
  const double of_seeds = std::pow(seed_deviation(first, second), 2);
  const double of_roughness =
      std::pow(chance.roughness * std::hypot(first.objective, second.objective), 2);
  const std::array<VarianceComponent, 3> components = {
      {{of_replicates, n - 1.0},
       {of_seeds, std::max(1.0, m - 1.0)},
       {of_roughness, std::numeric_limits<double>::infinity()}}};
  return half_width_95(components);
}

double TrackComparison::allowed_excess(const Evaluation& best,
                                       const Evaluation& evaluation,
                                       const PooledChance& chance,
                                       const BootstrapOptions& options) const {
  return std::max(
      0.0,
      half_width_of_difference(best, evaluation, chance, options) - distance(best, evaluation));
}

}  // namespace graintruth::calibrate
