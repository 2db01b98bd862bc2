#include "calibrate/observables/laws_rule.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/compare/objective.h"

namespace graintruth::calibrate {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

class LawsRule final : public Rule {
 public:
  LawsRule(Law law, const RuleParts& parts) : law_(law), layout_(*parts.layout) {
    // A bed at rest is as dense as it is
    const auto pooled = [&](std::string_view name, Relative relative, bool stays_at_rest) {
      auto of = parts.of(name);
      if (!of) return std::unique_ptr<PooledRule>();
      return std::make_unique<PooledRule>(
          of->channel,
          ChannelShape{.relative = relative},
          [stays_at_rest](const Channel& measured) {
            return stays_at_rest ? measured.values
                                 : std::vector<double>(measured.values.size(), 0.0);
          },
          layout_,
          std::move(of->replicates));
    };
    rate_ = pooled("discharge_rate", Relative::to_mean, false);
    density_ = pooled("flowing_density", Relative::to_mean, true);
    velocity_ = pooled("velocity_profile", Relative::to_largest, false);
    const Situation& any = parts.situations->front();
    diameter_ = any.particle.diameter;
    gravity_ = any.rig.gravity;
    for (const ComparedCondition& condition : layout_.conditions) {
      const Situation& own = (*parts.situations)[condition.replicates.front()];
      orifices_.push_back(own.rig.opening ? own.rig.opening->width() : 0.0);
      widths_.push_back(own.rig.bed ? own.rig.bed->right_x - own.rig.bed->left_x : 0.0);
      double height = 0.0;
      if (const auto profile = parts.of("velocity_profile")) {
        for (const std::size_t r : condition.replicates) {
          const auto& details = profile->replicates[r].details;
          if (const auto at = details.find("height_m"); at != details.end())
            height += at->second.front() / static_cast<double>(condition.replicates.size());
        }
      }
      heights_.push_back(height);
    }
    learn(parts);
  }

  bool is_learnt() const { return is_learnt_; }

  std::unique_ptr<Runs> digest(std::span<const SimulatedRun> runs) const override {
    auto digest = std::make_unique<Digest>();
    if (rate_) digest->rate = rate_->digest(runs);
    if (density_) digest->density = density_->digest(runs);
    if (velocity_) digest->velocity = velocity_->digest(runs);
    return digest;
  }
  bool is_known(const Runs&) const override { return true; }

  std::vector<double> residuals(const Runs& runs,
                                std::span<const int> weights,
                                const Otherwise& otherwise) const override {
    return residuals_of(simulated_flows(static_cast<const Digest&>(runs), weights, otherwise));
  }

  std::vector<std::size_t> kinds() const override {
    if (law_ == Law::beverloo) return {1, 1};
    return {static_cast<std::size_t>(
        std::count_if(filmed_.B.begin(), filmed_.B.end(), [](double B) { return B > 0.0; }))};
  }
  double loss(double z) const override { return pseudo_huber(z); }

  // One orifice tells no law.
  std::vector<double> residuals_of_run(const SimulatedRun&, std::size_t) const override {
    return {};
  }
  double percent_inside(const SimulatedRun&, std::size_t) const override { return nan; }
  // Of all conditions together, which is told with the first
  Band band(std::size_t condition) const override {
    if (law_ == Law::kinematic)
      return band_of({filmed_.B[condition]}, {relative_B_ * filmed_.B[condition]});
    if (condition > 0) return {};
    return band_of({filmed_.C, filmed_.k}, {uncertainty_.C, uncertainty_.k});
  }
  std::vector<double> simulated_mean(const Runs& runs, std::size_t condition) const override {
    const auto& digest = static_cast<const Digest&>(runs);
    const std::vector<MeanFlow> flows = simulated_flows(digest, {}, {});
    if (law_ == Law::kinematic) return {kinematic_length(flows[condition])};
    if (condition > 0) return {};
    const FlowLaws laws = fit_flow_laws(flows, diameter_, gravity_);
    return {laws.C, laws.k};
  }
  double percent_inside_of_mean(const Runs&) const override { return nan; }
  bool counts_failures() const override { return true; }
  bool pools_conditions() const override { return true; }
  int freedom() const override { return rate_ ? rate_->freedom() : velocity_->freedom(); }
  std::vector<std::size_t> deviating_replicates() const override {
    return rate_ ? rate_->deviating_replicates() : velocity_->deviating_replicates();
  }

 private:
  struct Digest final : Runs {
    std::unique_ptr<Runs> rate, density, velocity;
  };
  using Differences = std::optional<std::vector<std::vector<double>>>;

  static Band band_of(std::vector<double> values, const std::vector<double>& uncertainties) {
    constexpr double confidence_95 = 1.96;
    Band band{.mean = std::move(values)};
    for (std::size_t i = 0; i < band.mean.size(); ++i) {
      band.lower.push_back(band.mean[i] - confidence_95 * uncertainties[i]);
      band.upper.push_back(band.mean[i] + confidence_95 * uncertainties[i]);
    }
    return band;
  }

  std::vector<MeanFlow> simulated_flows(const Digest& digest,
                                        std::span<const int> weights,
                                        const Otherwise& otherwise) const {
    const auto of = [&](const std::unique_ptr<PooledRule>& rule, const std::unique_ptr<Runs>& own) {
      return rule ? std::optional(rule->mean_differences(*own, weights, otherwise)) : std::nullopt;
    };
    const auto rate = of(rate_, digest.rate), density = of(density_, digest.density),
               velocity = of(velocity_, digest.velocity);
    return mean_flows(&rate, &density, &velocity);
  }

  // The means of the replicates, or with these differences those of their simulations.
  std::vector<MeanFlow> mean_flows(const Differences* rate,
                                   const Differences* density,
                                   const Differences* velocity) const {
    std::vector<MeanFlow> flows;
    for (std::size_t c = 0; c < layout_.conditions.size(); ++c) {
      const auto replicates = static_cast<double>(layout_.conditions[c].replicates.size());
      MeanFlow flow{.orifice = orifices_[c], .height = heights_[c]};
      if (rate_) {
        flow.rate = rate_->means()[c].values.front();
        flow.standard_uncertainty =
            rate_->scatter().standard_deviation * flow.rate / std::sqrt(replicates);
        if (rate) flow.rate *= 1.0 + (**rate)[c].front();
      }
      if (density_) {
        const double mean = density_->means()[c].values.front();
        flow.density = std::isnan(mean) ? 0.0 : mean;
        if (density) flow.density *= 1.0 + (**density)[c].front();
      }
      if (velocity_) {
        const PooledRule::Mean& mean = velocity_->means()[c];
        const auto bins = static_cast<double>(mean.values.size());
        for (std::size_t bin = 0; bin < mean.values.size(); ++bin) {
          double value = mean.values[bin];
          if (velocity) value += mean.largest * (**velocity)[c][bin];
          if (std::isnan(value)) continue;
          flow.profile.push_back({.x = ((static_cast<double>(bin) + 0.5) / bins - 0.5) * widths_[c],
                                  .velocity = value});
        }
      }
      flows.push_back(std::move(flow));
    }
    return flows;
  }

  void learn(const RuleParts& parts) {
    if (law_ == Law::beverloo) {
      if (!rate_ || !density_ || layout_.conditions.size() < 2 ||
          !(rate_->scatter().standard_deviation > 0.0))
        return;
      const std::vector<MeanFlow> flows = mean_flows(nullptr, nullptr, nullptr);
      for (const MeanFlow& flow : flows) {
        if (!(flow.rate > 0.0 && flow.density > 0.0)) return;
      }
      filmed_ = fit_flow_laws(flows, diameter_, gravity_);
      uncertainty_ = beverloo_uncertainty(flows, diameter_, gravity_);
      is_learnt_ = uncertainty_.C > 0.0 && uncertainty_.k > 0.0;
      return;
    }
    if (!velocity_) return;
    for (const MeanFlow& flow : mean_flows(nullptr, nullptr, nullptr))
      filmed_.B.push_back(kinematic_length(flow));
    // B of every replicate by itself, about that of its condition
    const auto profile = parts.of("velocity_profile");
    double squares = 0.0;
    int freedom = 0;
    for (std::size_t c = 0; c < layout_.conditions.size(); ++c) {
      int fitted = 0;
      for (const std::size_t r : layout_.conditions[c].replicates) {
        const double B = kinematic_length({.orifice = orifices_[c],
                                           .height = height_of(profile->replicates[r]),
                                           .profile = samples_of(profile->replicates[r])});
        if (std::isnan(B) || !(filmed_.B[c] > 0.0)) continue;
        squares += std::pow(B / filmed_.B[c] - 1.0, 2);
        ++fitted;
      }
      freedom += std::max(0, fitted - 1);
    }
    if (freedom > 0) relative_B_ = std::sqrt(squares / freedom);
    is_learnt_ = relative_B_ > 0.0 && kinds().front() > 0;
  }

  static double height_of(const Channel& profile) {
    const auto at = profile.details.find("height_m");
    return at == profile.details.end() ? 0.0 : at->second.front();
  }
  static std::vector<VelocitySample> samples_of(const Channel& profile) {
    std::vector<VelocitySample> samples;
    const auto at = profile.details.find("samples");
    if (at == profile.details.end()) return samples;
    for (std::size_t i = 0; i + 2 < at->second.size(); i += 3)
      samples.push_back({at->second[i], at->second[i + 1], at->second[i + 2]});
    // Where fewer than three grains passed nobody knows one; then all count alike
    const bool are_known = std::all_of(samples.begin(), samples.end(), [](const auto& sample) {
      return sample.standard_uncertainty > 0.0;
    });
    if (!are_known)
      for (VelocitySample& sample : samples) sample.standard_uncertainty = 0.0;
    return samples;
  }

  // Simulated means scatter as filmed ones do.
  std::vector<double> residuals_of(const std::vector<MeanFlow>& flows) const {
    const double both = std::sqrt(2.0);
    if (law_ == Law::beverloo) {
      const FlowLaws simulated = fit_flow_laws(flows, diameter_, gravity_);
      return {(simulated.C - filmed_.C) / (both * uncertainty_.C),
              (simulated.k - filmed_.k) / (both * uncertainty_.k)};
    }
    std::vector<double> all;
    for (std::size_t c = 0; c < flows.size(); ++c) {
      if (!(filmed_.B[c] > 0.0)) continue;
      const auto replicates = static_cast<double>(layout_.conditions[c].replicates.size());
      all.push_back((kinematic_length(flows[c]) / filmed_.B[c] - 1.0) /
                    (both * relative_B_ / std::sqrt(replicates)));
    }
    return all;
  }

  Law law_;
  Layout layout_;
  std::unique_ptr<PooledRule> rate_, density_, velocity_;
  double diameter_ = 0.0, gravity_ = 0.0;
  std::vector<double> orifices_, widths_, heights_;  // of the conditions
  FlowLaws filmed_;
  BeverlooUncertainty uncertainty_;  // of C and k of one mean
  double relative_B_ = 0.0;          // standard deviation of one replicate
  bool is_learnt_ = false;
};

}  // namespace

std::unique_ptr<Rule> make_laws_rule(Law law, const RuleParts& parts) {
  auto rule = std::make_unique<LawsRule>(law, parts);
  if (!rule->is_learnt()) return nullptr;
  return rule;
}

}  // namespace graintruth::calibrate
