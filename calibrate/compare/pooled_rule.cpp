#include "calibrate/compare/pooled_rule.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/compare/hypothesis_tests.h"
#include "calibrate/compare/objective.h"

namespace graintruth::calibrate {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// Mean over those that are not NaN; NaN where none is.
class KnownMean {
 public:
  void add(double value, int weight = 1) {
    if (std::isnan(value) || weight == 0) return;
    sum_ += weight * value;
    count_ += weight;
  }
  double value() const { return count_ == 0 ? nan : sum_ / count_; }

 private:
  double sum_ = 0.0;
  int count_ = 0;
};

std::vector<double> values_of(const std::vector<KnownMean>& means) {
  std::vector<double> values;
  for (const KnownMean& mean : means) values.push_back(mean.value());
  return values;
}

}  // namespace

// Differences of every run.
struct PooledRule::Digest final : Runs {
  std::vector<std::vector<double>> differences;
};

PooledRule::PooledRule(std::size_t channel,
                       const ChannelShape& shape,
                       AtRest at_rest,
                       const Layout& layout,
                       std::vector<Channel> replicates)
    : channel_(channel),
      shape_(shape),
      at_rest_(std::move(at_rest)),
      layout_(layout),
      replicates_(std::move(replicates)),
      condition_of_(replicates_.size(), 0) {
  for (std::size_t c = 0; c < layout_.conditions.size(); ++c) {
    for (const std::size_t r : layout_.conditions[c].replicates) condition_of_[r] = c;
    means_.push_back(mean_of(layout_.conditions[c].replicates));
  }
  scatter_ = find_scatter(std::nullopt);
  for (std::size_t r = 0; r < replicates_.size(); ++r)
    scatter_without_.push_back(scatter_.freedom > 1 ? find_scatter(r).standard_deviation
                                                    : scatter_.standard_deviation);
  // As a model has them in which nothing moves
  const std::vector<SimulatedRun> failed(layout_.scenes, {.status = RunStatus::unstable});
  count_ = residuals(*digest(failed), {}, {}).size();
}

PooledRule::Mean PooledRule::mean_of(std::span<const std::size_t> replicates) const {
  std::vector<KnownMean> means(replicates_[replicates.front()].values.size());
  for (const std::size_t r : replicates) {
    for (std::size_t i = 0; i < means.size(); ++i) means[i].add(replicates_[r].values[i]);
  }
  Mean mean{.values = values_of(means)};
  for (const double value : mean.values) {
    if (!std::isnan(value)) mean.largest = std::max(mean.largest, std::abs(value));
  }
  return mean;
}

// Of a value from the mean of its condition, relative as the shape says; NaN where that is nothing.
double PooledRule::deviation(double value, double mean, const Mean& of) const {
  switch (shape_.relative) {
    case Relative::absolute:
      return value - mean;
    case Relative::to_mean:
      return mean > 0.0 ? value / mean - 1.0 : nan;
    case Relative::to_largest:
      return of.largest > 0.0 ? (value - mean) / of.largest : nan;
  }
  return nan;
}

// Replicates that agree by luck are not more exact than each of them says of itself: the mean
// square of what single values state.
PooledRule::Scatter PooledRule::find_scatter(std::optional<std::size_t> left_out) const {
  Scatter scatter;
  double squares = 0.0, within = 0.0;
  int stated = 0;
  for (const ComparedCondition& condition : layout_.conditions) {
    std::vector<std::size_t> own;
    for (const std::size_t r : condition.replicates) {
      if (r != left_out) own.push_back(r);
    }
    if (own.empty()) continue;
    const Mean mean = left_out ? mean_of(own) : means_[condition_of_[own.front()]];
    std::vector<int> known(mean.values.size(), 0);
    for (const std::size_t r : own) {
      const Channel& channel = replicates_[r];
      for (std::size_t i = 0; i < mean.values.size(); ++i) {
        known[i] += std::isnan(channel.values[i]) ? 0 : 1;
        const double apart = deviation(channel.values[i], mean.values[i], mean);
        if (!std::isnan(apart)) squares += std::pow(apart, 2);
        if (channel.errors.empty() || std::isnan(channel.errors[i])) continue;
        const double relative_to = shape_.relative == Relative::to_mean ? channel.values[i] : 1.0;
        within += std::pow(channel.errors[i] / relative_to, 2);
        ++stated;
      }
    }
    for (const int count : known) scatter.freedom += std::max(0, count - 1);
  }
  if (scatter.freedom == 0) return scatter;
  if (stated > 0) within /= stated;
  scatter.standard_deviation =
      std::max(std::sqrt(std::max(squares / scatter.freedom, within)), shape_.resolution);
  return scatter;
}

// Simulated minus measured.
std::vector<double> PooledRule::difference_of(const Channel& simulated,
                                              const std::vector<double>& measured,
                                              const Mean& mean) const {
  std::vector<double> all;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    double value = simulated.values[i];
    switch (shape_.relative) {
      case Relative::absolute:
        all.push_back(value - measured[i]);
        break;
      case Relative::to_mean:
        // Where either is not known nothing differs
        all.push_back(mean.values[i] > 0.0 && !std::isnan(value) && !std::isnan(measured[i])
                          ? (value - measured[i]) / mean.values[i]
                          : 0.0);
        break;
      case Relative::to_largest:
        // Where nothing passes in the simulation nothing moves
        if (std::isnan(value)) value = 0.0;
        all.push_back(mean.largest > 0.0 ? (value - measured[i]) / mean.largest : nan);
        break;
    }
  }
  return all;
}

std::vector<double> PooledRule::differences_of(const SimulatedRun& run, std::size_t scene) const {
  const std::size_t c = layout_.condition_of_scene(scene);
  const ComparedCondition& condition = layout_.conditions[c];
  const auto place = std::find(condition.scenes.begin(), condition.scenes.end(), scene);
  const std::size_t replicate =
      condition.replicates[condition.is_paired
                               ? static_cast<std::size_t>(place - condition.scenes.begin())
                               : 0];
  const Channel& of_replicate = replicates_[replicate];
  const std::vector<double>& measured =
      condition.is_paired ? of_replicate.values : means_[c].values;
  if (run.status == RunStatus::completed)
    return difference_of(run.channels[channel_], measured, means_[c]);
  return difference_of({.values = at_rest_(of_replicate)}, measured, means_[c]);
}

std::unique_ptr<Rule::Runs> PooledRule::digest(std::span<const SimulatedRun> runs) const {
  auto digest = std::make_unique<Digest>();
  const std::size_t seeds = layout_.seeds_of(runs.size());
  for (std::size_t run = 0; run < runs.size(); ++run)
    digest->differences.push_back(differences_of(runs[run], run / seeds));
  return digest;
}

// What a replicate deviates from its own condition, with its simulations where they are paired,
// as widely scattered as single ones are: sqrt(n / (n - 1)) of what is seen about a mean.
std::vector<double> PooledRule::deviation_of(const Digest& digest,
                                             std::size_t replicate,
                                             std::span<const int> weights,
                                             bool of_replicates_alone) const {
  const std::size_t c = condition_of_[replicate];
  const ComparedCondition& condition = layout_.conditions[c];
  const auto n = static_cast<double>(condition.replicates.size());
  const double widened = std::sqrt(n / (n - 1.0));
  std::vector<double> all(means_[c].values.size());
  if (!condition.is_paired || of_replicates_alone) {
    // A replicate above the mean makes the simulation too low
    for (std::size_t i = 0; i < all.size(); ++i)
      all[i] =
          -widened * deviation(replicates_[replicate].values[i], means_[c].values[i], means_[c]);
    return all;
  }
  const std::size_t seeds = layout_.seeds_of(digest.differences.size());
  std::vector<KnownMean> own(all.size()), whole(all.size());
  for (std::size_t k = 0; k < condition.scenes.size(); ++k) {
    for (std::size_t seed = 0; seed < seeds; ++seed) {
      const std::size_t run = condition.scenes[k] * seeds + seed;
      const int weight = weights.empty() ? 1 : weights[run];
      for (std::size_t i = 0; i < all.size(); ++i) {
        whole[i].add(digest.differences[run][i], weight);
        if (condition.replicates[k] == replicate) own[i].add(digest.differences[run][i], weight);
      }
    }
  }
  for (std::size_t i = 0; i < all.size(); ++i)
    all[i] = widened * (own[i].value() - whole[i].value());
  return all;
}

std::vector<std::vector<double>> PooledRule::mean_differences(const Runs& runs,
                                                              std::span<const int> weights,
                                                              const Otherwise& otherwise) const {
  const auto& digest = static_cast<const Digest&>(runs);
  const std::size_t seeds = layout_.seeds_of(digest.differences.size());
  std::vector<std::vector<double>> all;
  for (std::size_t c = 0; c < layout_.conditions.size(); ++c) {
    const ComparedCondition& condition = layout_.conditions[c];
    const bool is_without = otherwise.mean == Otherwise::Mean::without && otherwise.condition == c;
    const bool is_paired = condition.is_paired && !otherwise.of_replicates_alone;
    std::vector<KnownMean> means(means_[c].values.size());
    for (std::size_t k = 0; k < condition.scenes.size(); ++k) {
      if (is_without && is_paired && condition.replicates[k] == otherwise.replicate) continue;
      for (std::size_t seed = 0; seed < seeds; ++seed) {
        const std::size_t run = condition.scenes[k] * seeds + seed;
        for (std::size_t i = 0; i < means.size(); ++i)
          means[i].add(digest.differences[run][i], weights.empty() ? 1 : weights[run]);
      }
    }
    all.push_back(values_of(means));
    if (is_without && !is_paired) {
      // The mean moves away from the one that is left out, by a share of what it deviates
      const auto n = static_cast<double>(condition.replicates.size());
      for (std::size_t i = 0; i < means.size(); ++i) {
        const double apart =
            deviation(replicates_[otherwise.replicate].values[i], means_[c].values[i], means_[c]);
        if (!std::isnan(apart)) all.back()[i] += apart / (n - 1.0);
      }
    }
    if (otherwise.mean == Otherwise::Mean::moved && otherwise.condition == c) {
      const std::vector<double> apart =
          deviation_of(digest, otherwise.replicate, weights, otherwise.of_replicates_alone);
      for (std::size_t i = 0; i < std::min(apart.size(), means.size()); ++i) {
        if (!std::isnan(apart[i])) all.back()[i] += otherwise.share * apart[i];
      }
    }
  }
  return all;
}

std::vector<double> PooledRule::residuals(const Runs& runs,
                                          std::span<const int> weights,
                                          const Otherwise& otherwise) const {
  const double scatter = otherwise.widths_without ? scatter_without_[*otherwise.widths_without]
                                                  : scatter_.standard_deviation;
  std::vector<double> all;
  if (!(scatter > 0.0)) return all;
  const auto differences = mean_differences(runs, weights, otherwise);
  for (std::size_t c = 0; c < layout_.conditions.size(); ++c) {
    const double share =
        std::sqrt(2.0 / static_cast<double>(layout_.conditions[c].replicates.size()));
    for (const double difference : differences[c]) {
      // Which are NaN depends on the replicates alone
      if (const double z = difference / (scatter * share); !std::isnan(z)) all.push_back(z);
    }
  }
  return all;
}

double PooledRule::loss(double z) const { return pseudo_huber(z); }

// With the scatter of all, and relative to its own replicate where it has one.
std::vector<double> PooledRule::residuals_of_run(const SimulatedRun& run, std::size_t scene) const {
  std::vector<double> all;
  if (!(scatter_.standard_deviation > 0.0)) return all;
  const std::size_t c = layout_.condition_of_scene(scene);
  const ComparedCondition& condition = layout_.conditions[c];
  std::vector<std::size_t> own = condition.replicates;
  if (condition.is_paired) {
    const auto place = std::find(condition.scenes.begin(), condition.scenes.end(), scene);
    own = {condition.replicates[static_cast<std::size_t>(place - condition.scenes.begin())]};
  }
  const Mean mean = mean_of(own);
  const Channel simulated = run.status == RunStatus::completed
                                ? run.channels[channel_]
                                : Channel{.values = at_rest_(replicates_[own.front()])};
  const double share = std::sqrt(2.0 / static_cast<double>(own.size()));
  for (const double difference : difference_of(simulated, mean.values, mean)) {
    const double z = difference / (scatter_.standard_deviation * share);
    if (!std::isnan(z)) all.push_back(z);
  }
  return all;
}

double PooledRule::percent_inside(const SimulatedRun&, std::size_t) const { return nan; }

double PooledRule::percent_inside_of_mean(const Runs&) const { return nan; }

Rule::Band PooledRule::band(std::size_t condition) const {
  const Mean& mean = means_[condition];
  const auto n = static_cast<double>(layout_.conditions[condition].replicates.size());
  const double half = scatter_.freedom > 0 ? student_t_quantile(0.975, scatter_.freedom) *
                                                 scatter_.standard_deviation / std::sqrt(n)
                                           : nan;
  Band band{.mean = mean.values};
  for (const double value : mean.values) {
    const double scale = shape_.relative == Relative::to_mean      ? value
                         : shape_.relative == Relative::to_largest ? mean.largest
                                                                   : 1.0;
    band.lower.push_back(value - half * scale);
    band.upper.push_back(value + half * scale);
  }
  return band;
}

std::vector<double> PooledRule::simulated_mean(const Runs& runs, std::size_t condition) const {
  const std::vector<double> differences = mean_differences(runs, {}, {})[condition];
  const Mean& mean = means_[condition];
  std::vector<double> values;
  for (std::size_t i = 0; i < mean.values.size(); ++i) {
    const double scale = shape_.relative == Relative::to_mean      ? mean.values[i]
                         : shape_.relative == Relative::to_largest ? mean.largest
                                                                   : 1.0;
    values.push_back(mean.values[i] + scale * differences[i]);
  }
  return values;
}

std::vector<std::size_t> PooledRule::deviating_replicates() const {
  std::vector<std::size_t> all;
  for (const ComparedCondition& condition : layout_.conditions) {
    if (condition.replicates.size() < 2) continue;
    all.insert(all.end(), condition.replicates.begin(), condition.replicates.end());
  }
  return all;
}

}  // namespace graintruth::calibrate
