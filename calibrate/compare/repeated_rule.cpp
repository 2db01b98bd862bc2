#include "calibrate/compare/repeated_rule.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/compare/agreement.h"
#include "calibrate/compare/objective.h"

namespace graintruth::calibrate {

namespace {

constexpr std::size_t pooled_neighbours = 2;  // moments before and after whose variance is pooled

// Root mean square of what replicates say of their own error; 0 where they say nothing.
double measurement_error(std::span<const Channel* const> replicates, std::size_t i) {
  double squares = 0.0;
  int count = 0;
  for (const Channel* replicate : replicates) {
    if (replicate->errors.empty() || !std::isfinite(replicate->errors[i])) continue;
    squares += replicate->errors[i] * replicate->errors[i];
    ++count;
  }
  return count == 0 ? 0.0 : std::sqrt(squares / count);
}

// Mean variance over the moments around that of value `i`: of this value, or of all values of its
// kind, x of every particle, say.
enum class Pooled { moments, moments_of_kind };
double pooled_variance(const std::vector<Spread>& spreads,
                       const ChannelShape& shape,
                       std::size_t i,
                       Pooled pooled) {
  const std::size_t moments = spreads.size() / shape.series;
  const std::size_t moment = i / shape.series;
  const std::size_t step = pooled == Pooled::moments ? shape.series : shape.difference.size();
  const std::size_t first = moment < pooled_neighbours ? 0 : moment - pooled_neighbours;
  const std::size_t last = std::min(moment + pooled_neighbours, moments - 1);
  double sum = 0.0;
  int count = 0;
  for (std::size_t m = first; m <= last; ++m) {
    for (std::size_t place = i % shape.series % step; place < shape.series; place += step) {
      const double sd = spreads[m * shape.series + place].standard_deviation;
      if (!std::isfinite(sd)) continue;
      sum += sd * sd;
      ++count;
    }
  }
  return count == 0 ? 0.0 : sum / count;
}

// Student's 95 % interval of the mean of `count` values, t s / sqrt(n).
double half_width_of_mean(double standard_deviation, int count) {
  return critical_value(Critical::student_t, count) * standard_deviation / std::sqrt(count);
}

}  // namespace

// The channels of the completed runs.
struct RepeatedRule::Digest final : Runs {
  std::vector<std::size_t> condition;  // of every completed run
  std::vector<std::size_t> scene;      // the same
  std::vector<std::size_t> place;      // in the evaluation
  std::vector<Channel> channels;
  std::vector<WeightedMeans> means;                    // one a condition
  std::vector<std::vector<std::size_t>> of_condition;  // indices into the above
  bool is_mostly_failed = false;
};

RepeatedRule::RepeatedRule(std::size_t channel,
                           const ChannelShape& shape,
                           datasets::ObjectiveForm form,
                           const Layout& layout,
                           std::vector<Channel> replicates,
                           std::vector<double> lacking)
    : channel_(channel),
      shape_(shape),
      form_(form),
      layout_(layout),
      replicates_(std::move(replicates)),
      lacking_(std::move(lacking)) {
  for (const ComparedCondition& condition : layout_.conditions) {
    std::vector<const Channel*> own;
    for (const std::size_t r : condition.replicates) own.push_back(&replicates_[r]);
    Condition made;
    made.whole.spreads = spreads_of(own, shape_);
    for (const Spread& spread : made.whole.spreads) made.whole.mean.push_back(spread.mean);
    made.whole.half_widths = half_widths_of(own, 0);
    for (std::size_t r = 0; r < own.size(); ++r) {
      std::vector<const Channel*> others = own;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(r));
      Others rest;
      for (const Spread& spread : spreads_of(others, shape_)) rest.mean.push_back(spread.mean);
      rest.half_widths = others.size() < 2 ? made.whole.half_widths : half_widths_of(others, 1);
      // What two replicates know alone has no spread without one of them
      for (std::size_t i = 0; i < rest.half_widths.size(); ++i)
        if (!(rest.half_widths[i] > 0.0)) rest.half_widths[i] = made.whole.half_widths[i];
      made.without.push_back(std::move(rest));
    }
    targets_.push_back(std::move(made));
    std::vector<double> nothing_differs;
    append_residuals(targets_.back().whole.mean,
                     targets_.back().whole.half_widths,
                     targets_.back().whole.mean,
                     nothing_differs);
    count_ += nothing_differs.size();
  }
}

// With the text of objective.h. Of `left_out` more replicates the mean knows, the variance does
// not. Two replicates of a value lie close together by chance so often that their own distance, as
// a weight, would let a few such values decide; and without one of them nothing tells what that
// costs.
std::vector<double> RepeatedRule::half_widths_of(std::span<const Channel* const> replicates,
                                                 int left_out) const {
  const std::vector<Spread> spreads = spreads_of(replicates, shape_);
  std::vector<double> half_widths(spreads.size(), 0.0);
  for (std::size_t i = 0; i < spreads.size(); ++i) {
    const Spread& spread = spreads[i];
    if (spread.count < 2) continue;
    if (form_ == datasets::ObjectiveForm::requested) {
      half_widths[i] = half_width_of_mean(spread.standard_deviation, spread.count + left_out);
      continue;
    }
    const double own = spread.standard_deviation * spread.standard_deviation;
    const double variance =
        spread.count + left_out == 2
            ? pooled_variance(spreads, shape_, i, Pooled::moments_of_kind)
            : 0.5 * (own + pooled_variance(spreads, shape_, i, Pooled::moments));
    const double floor = std::max(measurement_error(replicates, i), shape_.least_error_of(i));
    half_widths[i] =
        std::max(half_width_of_mean(std::sqrt(variance), spread.count + left_out), floor);
  }
  return half_widths;
}

std::unique_ptr<Rule::Runs> RepeatedRule::digest(std::span<const SimulatedRun> runs) const {
  auto digest = std::make_unique<Digest>();
  const std::size_t seeds = layout_.seeds_of(runs.size());
  digest->of_condition.resize(layout_.conditions.size());
  for (std::size_t run = 0; run < runs.size(); ++run) {
    if (runs[run].status != RunStatus::completed) continue;
    const std::size_t condition = layout_.condition_of_scene(run / seeds);
    digest->of_condition[condition].push_back(digest->channels.size());
    digest->condition.push_back(condition);
    digest->scene.push_back(run / seeds);
    digest->place.push_back(run);
    digest->channels.push_back(runs[run].channels[channel_]);
  }
  for (const std::vector<std::size_t>& own : digest->of_condition) {
    std::vector<const Channel*> channels;
    for (const std::size_t i : own) channels.push_back(&digest->channels[i]);
    digest->means.emplace_back(std::move(channels), shape_);
  }
  digest->is_mostly_failed = digest->channels.empty() || 2 * digest->channels.size() < runs.size();
  return digest;
}

bool RepeatedRule::is_known(const Runs& runs) const {
  return !static_cast<const Digest&>(runs).is_mostly_failed;
}

void RepeatedRule::append_residuals(const std::vector<double>& measured,
                                    const std::vector<double>& half_widths,
                                    const std::vector<double>& simulated,
                                    std::vector<double>& all) const {
  for (std::size_t i = 0; i < measured.size(); ++i) {
    if (!(half_widths[i] > 0.0)) continue;
    double value = simulated.empty() ? std::numeric_limits<double>::quiet_NaN() : simulated[i];
    if (!std::isfinite(value)) value = lacking_.empty() ? measured[i % shape_.series] : lacking_[i];
    const double z = difference(shape_.difference_of(i), value, measured[i]) / half_widths[i];
    // Nothing is known to differ; there are as many numbers whatever a simulation does
    all.push_back(std::isfinite(z) ? z : 0.0);
  }
}

std::vector<double> RepeatedRule::residuals(const Runs& runs,
                                            std::span<const int> weights,
                                            const Otherwise& otherwise) const {
  const auto& digest = static_cast<const Digest&>(runs);
  std::vector<double> all;
  all.reserve(count_);
  std::vector<int> own;
  for (std::size_t c = 0; c < targets_.size(); ++c) {
    const ComparedCondition& condition = layout_.conditions[c];
    const auto place_of = [&](std::size_t replicate) {
      return static_cast<std::size_t>(
          std::find(condition.replicates.begin(), condition.replicates.end(), replicate) -
          condition.replicates.begin());
    };
    // 1. The measured mean and its half widths
    const bool is_without = otherwise.mean == Otherwise::Mean::without && otherwise.condition == c;
    const std::size_t left_out = is_without ? place_of(otherwise.replicate) : 0;
    const std::vector<double>& measured =
        is_without ? targets_[c].without[left_out].mean : targets_[c].whole.mean;
    const std::size_t widths_of = otherwise.widths_without ? place_of(*otherwise.widths_without)
                                                           : condition.replicates.size();
    const std::vector<double>& half_widths = widths_of < condition.replicates.size()
                                                 ? targets_[c].without[widths_of].half_widths
                                                 : targets_[c].whole.half_widths;
    // 2. The simulated mean
    own.clear();
    bool any = false;
    for (const std::size_t i : digest.of_condition[c]) {
      int weight = weights.empty() ? 1 : weights[digest.place[i]];
      if (is_without && condition.is_paired && !otherwise.of_replicates_alone &&
          digest.scene[i] == condition.scenes[left_out])
        weight = 0;
      own.push_back(weight);
      any |= weight > 0;
    }
    const bool is_at_rest = !any || (weights.empty() && digest.is_mostly_failed);
    append_residuals(
        measured, half_widths, is_at_rest ? std::vector<double>{} : digest.means[c].mean(own), all);
  }
  return all;
}

std::vector<double> RepeatedRule::residuals_of_run(const SimulatedRun& run,
                                                   std::size_t scene) const {
  const Target& target = targets_[layout_.condition_of_scene(scene)].whole;
  std::vector<double> all;
  append_residuals(
      target.mean,
      target.half_widths,
      run.status == RunStatus::completed ? run.channels[channel_].values : std::vector<double>{},
      all);
  return all;
}

double RepeatedRule::percent_inside(const SimulatedRun& run, std::size_t scene) const {
  if (run.status != RunStatus::completed) return 0.0;
  const Target& target = targets_[layout_.condition_of_scene(scene)].whole;
  return percent_of_tests_passed(
      target.spreads, shape_, run.channels[channel_].values, Critical::student_t);
}

std::vector<const Channel*> RepeatedRule::replicates_of(std::size_t condition) const {
  std::vector<const Channel*> own;
  for (const std::size_t r : layout_.conditions[condition].replicates)
    own.push_back(&replicates_[r]);
  return own;
}

// Student's interval, without the floor of the half widths.
Rule::Band RepeatedRule::band(std::size_t condition) const {
  Band band;
  for (const Spread& spread : targets_[condition].whole.spreads) {
    const double half = spread.count < 2
                            ? std::numeric_limits<double>::quiet_NaN()
                            : half_width_of_mean(spread.standard_deviation, spread.count);
    band.mean.push_back(spread.mean);
    band.lower.push_back(spread.mean - half);
    band.upper.push_back(spread.mean + half);
  }
  return band;
}

std::vector<double> RepeatedRule::simulated_mean(const Runs& runs, std::size_t condition) const {
  const auto& digest = static_cast<const Digest&>(runs);
  if (digest.is_mostly_failed || digest.means[condition].repeats() == 0) return {};
  return digest.means[condition].mean();
}

double RepeatedRule::percent_inside_of_mean(const Runs& runs) const {
  double percent = 0.0;
  for (std::size_t c = 0; c < targets_.size(); ++c) {
    const std::vector<double> mean = simulated_mean(runs, c);
    if (mean.empty()) continue;
    percent +=
        percent_of_tests_passed(targets_[c].whole.spreads, shape_, mean, Critical::student_t) /
        static_cast<double>(targets_.size());
  }
  return percent;
}

}  // namespace graintruth::calibrate
