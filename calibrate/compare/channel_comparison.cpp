#include "calibrate/compare/channel_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "calibrate/compare/hypothesis_tests.h"

namespace graintruth::calibrate {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// 2 near - far
std::vector<double> mirrored(std::vector<double> near, std::span<const double> far) {
  for (std::size_t i = 0; i < near.size(); ++i) near[i] = 2.0 * near[i] - far[i];
  return near;
}

// Degrees of freedom from which on the seeds of a pair of evaluations tell enough of themselves: of
// as many seeds as a search takes where it can (CalibrationOptions::search_seeds).
constexpr double enough_freedom = 5.0;

// Of displacements of different evaluations by the same seed; 0 where there is one evaluation.
double mean_correlation(const std::vector<std::vector<std::vector<double>>>& displacements) {
  const auto product = [](const std::vector<double>& a, const std::vector<double>& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  };
  double sum = 0.0;
  int count = 0;
  for (std::size_t a = 0; a < displacements.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      double both = 0.0, first = 0.0, second = 0.0;
      for (std::size_t seed = 0; seed < displacements[a].size(); ++seed) {
        both += product(displacements[a][seed], displacements[b][seed]);
        first += product(displacements[a][seed], displacements[a][seed]);
        second += product(displacements[b][seed], displacements[b][seed]);
      }
      if (first > 0.0 && second > 0.0) sum += both / std::sqrt(first * second);
      ++count;
    }
  }
  return count == 0 ? 0.0 : sum / count;
}

// The weighted mean of what is known.
class KindMean {
 public:
  void add(double value, double weight) {
    if (std::isnan(value)) return;
    sum_ += weight * value;
    weights_ += weight;
  }
  double value() const { return weights_ == 0.0 ? nan : sum_ / weights_; }

 private:
  double sum_ = 0.0;
  double weights_ = 0.0;
};

}  // namespace

std::size_t Layout::condition_of_scene(std::size_t scene) const {
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    const auto& scenes_of_c = conditions[c].scenes;
    if (std::find(scenes_of_c.begin(), scenes_of_c.end(), scene) != scenes_of_c.end()) return c;
  }
  throw std::logic_error("no condition has the scene");
}

RuleParts ComparedExperiment::parts(datasets::ObjectiveForm form) const {
  return {.form = form,
          .layout = &layout,
          .situations = &situations,
          .of = [this](std::string_view name) -> std::optional<RuleParts::Of> {
            const auto place = observables->find(name);
            if (!place) return std::nullopt;
            RuleParts::Of of{*place, {}};
            for (const std::vector<Channel>& channels : measured) {
              if (!channels[*place].is_known()) return std::nullopt;
              of.replicates.push_back(channels[*place]);
            }
            return of;
          }};
}

// A way in which the replicates' mean might have been another: what it changes the objective by
// counts by its factor in the variance.
struct ChannelComparison::Weighted {
  Otherwise otherwise;
  double factor = 1.0;
  std::size_t stratum = 0;
  double freedom = 1.0;  // of the stratum
};

ChannelComparison::ChannelComparison(std::vector<ComparedExperiment> experiments,
                                     datasets::ObjectiveForm form)
    : experiments_(std::move(experiments)), form_(form) {
  for (const ComparedExperiment& experiment : experiments_) {
    Part part{.rules = make_rules(experiment, form), .first_scene = scenes_};
    if (part.rules.empty()) throw std::invalid_argument("nothing can be compared");
    scenes_ += experiment.layout.scenes;
    part.pools = true;
    for (const ComparedRule& compared : part.rules) {
      part.pools = part.pools && compared.rule->pools_conditions();
      part.freedom = std::max(part.freedom, compared.rule->freedom());
    }
    parts_.push_back(std::move(part));
  }
}

std::vector<ChannelComparison::ComparedRule> ChannelComparison::make_rules(
    const ComparedExperiment& experiment, datasets::ObjectiveForm form) const {
  const RuleParts parts = experiment.parts(form);
  const Observables& observables = *experiment.observables;
  std::vector<ComparedRule> rules;
  for (const auto& [place, weight] : form == datasets::ObjectiveForm::smooth
                                         ? observables.compared()
                                         : observables.compared_by_request()) {
    const Observable& observable = *observables.all()[place];
    auto rule = observable.rule(parts);
    if (rule && rule->kinds().front() > 0) {
      rules.push_back({observable.name(), std::move(rule), weight});
    } else if (form == datasets::ObjectiveForm::requested && rules.empty()) {
      return {};  // what it judges by before all else is not told
    }
  }
  return rules;
}

const Rule* ChannelComparison::rule_of(std::string_view observable, std::size_t experiment) const {
  for (const ComparedRule& compared : parts_[experiment].rules) {
    if (compared.name == observable) return compared.rule.get();
  }
  return nullptr;
}

std::shared_ptr<const ChannelComparison> ChannelComparison::alone(std::size_t i) const {
  std::vector<ComparedExperiment> one = {experiments_[i]};
  one.front().weight = 1.0;
  return std::make_shared<ChannelComparison>(std::move(one), form_);
}

std::unique_ptr<ChannelComparison> ChannelComparison::without_replicate(
    std::size_t experiment, std::size_t replicate) const {
  constexpr std::size_t enough = 3;  // what is left still has a spread
  std::vector<ComparedExperiment> rest = experiments_;
  for (ComparedCondition& condition : rest[experiment].layout.conditions) {
    const auto at = std::find(condition.replicates.begin(), condition.replicates.end(), replicate);
    if (at == condition.replicates.end()) continue;
    if (condition.replicates.size() < enough || condition.is_paired) return nullptr;
    condition.replicates.erase(at);
    return std::make_unique<ChannelComparison>(std::move(rest), form_);
  }
  return nullptr;
}

// Runs are in order of scenes, those of a scene in order of seeds.
std::span<const SimulatedRun> ChannelComparison::runs_of(std::span<const SimulatedRun> runs,
                                                         std::size_t i) const {
  const std::size_t seeds = runs.size() / scenes_;
  return runs.subspan(parts_[i].first_scene * seeds, experiments_[i].layout.scenes * seeds);
}

Evaluation ChannelComparison::part_of(const Evaluation& evaluation, std::size_t i) const {
  const std::span<const SimulatedRun> runs = runs_of(evaluation.runs, i);
  Evaluation part{.stage = evaluation.stage,
                  .parameters = evaluation.parameters,
                  .time_step_fraction = evaluation.time_step_fraction,
                  .runs = {runs.begin(), runs.end()},
                  .objective = objective_of(i, digest(i, runs), {}, {})};
  count_runs(part);
  return part;
}

ChannelComparison::Digests ChannelComparison::digest(std::size_t i,
                                                     std::span<const SimulatedRun> runs) const {
  Digests digests;
  for (const ComparedRule& compared : parts_[i].rules)
    digests.push_back(compared.rule->digest(runs));
  return digests;
}

bool ChannelComparison::is_known(std::size_t i, const Digests& runs) const {
  for (std::size_t r = 0; r < runs.size(); ++r) {
    if (!parts_[i].rules[r].rule->is_known(*runs[r])) return false;
  }
  return true;
}

std::vector<double> ChannelComparison::residuals_of(std::size_t i,
                                                    const Digests& runs,
                                                    std::span<const int> weights,
                                                    const Otherwise& otherwise) const {
  std::vector<double> all;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const std::vector<double> own =
        parts_[i].rules[r].rule->residuals(*runs[r], weights, otherwise);
    if (all.empty()) {
      all = own;
    } else {
      all.insert(all.end(), own.begin(), own.end());
    }
  }
  return all;
}

double ChannelComparison::loss_of_part(std::size_t i, std::span<const double> residuals) const {
  KindMean kinds;
  std::size_t next = 0;
  for (const ComparedRule& compared : parts_[i].rules) {
    for (const std::size_t count : compared.rule->kinds()) {
      double sum = 0.0;
      for (std::size_t k = 0; k < count; ++k) sum += compared.rule->loss(residuals[next++]);
      kinds.add(sum / static_cast<double>(count), compared.weight);
    }
  }
  return kinds.value();
}

double ChannelComparison::objective_of(std::size_t i,
                                       const Digests& runs,
                                       std::span<const int> weights,
                                       const Otherwise& otherwise) const {
  return loss_of_part(i, residuals_of(i, runs, weights, otherwise));
}

std::vector<ChannelComparison::Share> ChannelComparison::shares(std::span<const SimulatedRun> runs,
                                                                std::size_t experiment) const {
  const std::vector<double> residuals = residuals_of(experiment, digest(experiment, runs), {}, {});
  std::vector<Share> shares;
  std::size_t next = 0;
  for (const ComparedRule& compared : parts_[experiment].rules) {
    const std::vector<std::size_t> kinds = compared.rule->kinds();
    for (std::size_t k = 0; k < kinds.size(); ++k) {
      double sum = 0.0;
      for (std::size_t n = 0; n < kinds[k]; ++n) sum += compared.rule->loss(residuals[next++]);
      shares.push_back(
          {kinds.size() == 1 ? compared.name : fmt::format("{}_{}", compared.name, k + 1),
           sum / static_cast<double>(kinds[k]),
           compared.weight});
    }
  }
  return shares;
}

double ChannelComparison::percent_inside(std::span<const SimulatedRun> runs,
                                         std::size_t experiment) const {
  const std::span<const SimulatedRun> own = runs_of(runs, experiment);
  for (const ComparedRule& compared : parts_[experiment].rules) {
    const double percent = compared.rule->percent_inside_of_mean(*compared.rule->digest(own));
    if (!std::isnan(percent)) return percent;
  }
  return nan;
}

double ChannelComparison::objective(std::span<const SimulatedRun> runs) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < experiments_.size(); ++i)
    sum += experiments_[i].weight * objective_of(i, digest(i, runs_of(runs, i)), {}, {});
  return sum;
}

std::size_t ChannelComparison::residual_count() const {
  std::size_t count = 0;
  for (const Part& part : parts_) {
    for (const ComparedRule& compared : part.rules) {
      const std::vector<std::size_t> kinds = compared.rule->kinds();
      count += std::accumulate(kinds.begin(), kinds.end(), std::size_t{0});
    }
  }
  return count;
}

std::vector<double> ChannelComparison::residuals(std::span<const SimulatedRun> runs) const {
  std::vector<double> all;
  for (std::size_t i = 0; i < experiments_.size(); ++i) {
    const Digests digests = digest(i, runs_of(runs, i));
    if (!is_known(i, digests)) return {};
    const std::vector<double> part = residuals_of(i, digests, {}, {});
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

double ChannelComparison::loss(std::span<const double> residuals) const {
  double sum = 0.0;
  std::size_t first = 0;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    std::size_t count = 0;
    for (const ComparedRule& compared : parts_[i].rules) {
      for (const std::size_t kind : compared.rule->kinds()) count += kind;
    }
    sum += experiments_[i].weight * loss_of_part(i, residuals.subspan(first, count));
    first += count;
  }
  return sum;
}

std::vector<std::vector<std::size_t>> ChannelComparison::strata_of(std::size_t i,
                                                                   std::size_t runs) const {
  const Layout& layout = experiments_[i].layout;
  const std::size_t seeds = layout.seeds_of(runs);
  std::vector<std::vector<std::size_t>> strata;
  for (const ComparedCondition& condition : layout.conditions) {
    std::vector<std::size_t>& stratum = strata.emplace_back();
    for (const std::size_t scene : condition.scenes) {
      for (std::size_t seed = 0; seed < seeds; ++seed) stratum.push_back(scene * seeds + seed);
    }
  }
  return strata;
}

double ChannelComparison::noise(std::span<const SimulatedRun> runs) const {
  double deviation = 0.0;
  for (std::size_t i = 0; i < experiments_.size(); ++i) {
    const std::span<const SimulatedRun> own = runs_of(runs, i);
    const Digests digests = digest(i, own);
    const bool counts_failures =
        std::any_of(parts_[i].rules.begin(), parts_[i].rules.end(), [](const auto& compared) {
          return compared.rule->counts_failures();
        });
    double variance = 0.0;
    std::vector<int> weights(own.size(), 1);
    for (const std::vector<std::size_t>& stratum : strata_of(i, own.size())) {
      if (stratum.size() < 2) continue;  // without its only run nothing is left to compare
      std::vector<double> values;
      for (const std::size_t run : stratum) {
        if (own[run].status != RunStatus::completed && !counts_failures) continue;
        weights[run] = 0;
        values.push_back(objective_of(i, digests, weights, {}));
        weights[run] = 1;
      }
      if (values.size() < 2) continue;
      const double error = jackknife_error(values);
      variance += error * error;
    }
    deviation = std::hypot(deviation, experiments_[i].weight * std::sqrt(variance));
  }
  return deviation;
}

RunScore ChannelComparison::score_run(const SimulatedRun& run, std::size_t scene) const {
  std::size_t i = 0;
  while (i + 1 < parts_.size() && scene >= parts_[i + 1].first_scene) ++i;
  const std::size_t own_scene = scene - parts_[i].first_scene;
  KindMean kinds;
  RunScore score{.agreement_percent = nan};
  for (const ComparedRule& compared : parts_[i].rules) {
    const std::vector<double> residuals = compared.rule->residuals_of_run(run, own_scene);
    double sum = 0.0;
    for (const double z : residuals) sum += compared.rule->loss(z);
    kinds.add(residuals.empty() ? nan : sum / static_cast<double>(residuals.size()),
              compared.weight);
    const double percent = compared.rule->percent_inside(run, own_scene);
    if (std::isnan(score.agreement_percent)) score.agreement_percent = percent;
  }
  score.objective = kinds.value();
  if (!std::isnan(score.objective) || form_ == datasets::ObjectiveForm::smooth) return score;
  // One condition tells no law: a single run is told by the smooth form
  return ChannelComparison({experiments_[i]}).score_run(run, own_scene);
}

std::string ChannelComparison::misfit(const SimulatedRun& run, std::size_t scene) const {
  if (run.status != RunStatus::completed) return {};
  std::size_t i = 0;
  while (i + 1 < parts_.size() && scene >= parts_[i + 1].first_scene) ++i;
  const ComparedExperiment& experiment = experiments_[i];
  const auto& observables = experiment.observables->all();
  if (run.channels.size() != observables.size()) {
    return fmt::format("it has results of {} observables, but {} are measured",
                       run.channels.size(),
                       observables.size());
  }
  const Layout& layout = experiment.layout;
  const std::size_t replicate =
      layout.conditions[layout.condition_of_scene(scene - parts_[i].first_scene)]
          .replicates.front();
  for (const auto& [place, weight] : experiment.observables->compared()) {
    const std::size_t known = run.channels[place].values.size();
    const std::size_t wanted = experiment.measured[replicate][place].values.size();
    // Who cannot tell has none
    if (known == wanted || known == 0 || wanted == 0) continue;
    return fmt::format(
        "it has {} values of {}, but {} are compared", known, observables[place]->name(), wanted);
  }
  return {};
}

// Excess of the second model and D of the text in the header, [L(z2) - L(z1)] + [L(2 z1 - z2) -
// L(z1)], z being residuals: H (p2 - p1)^2 on a parabola of curvature H.
double ChannelComparison::second_difference(std::size_t i,
                                            const Digests& near,
                                            const Digests& far,
                                            std::optional<std::size_t> widths_without) const {
  const Otherwise otherwise{.widths_without = widths_without};
  const std::vector<double> first = residuals_of(i, near, {}, otherwise);
  const std::vector<double> second = residuals_of(i, far, {}, otherwise);
  return loss_of_part(i, second) + loss_of_part(i, mirrored(first, second)) -
         2.0 * loss_of_part(i, first);
}

// Leaving replicates out one by one, (n - 1)/n sum d^2 in each condition; or, where scatter is
// pooled, moving the mean of each condition by a share 1/n of what any replicate deviates: with nu
// degrees of freedom in all, n/nu sum d^2, which is the same for one condition.
std::vector<ChannelComparison::Weighted> ChannelComparison::ways_of(std::size_t i) const {
  const Layout& layout = experiments_[i].layout;
  std::vector<Weighted> ways;
  if (parts_[i].pools) {
    const std::vector<std::size_t> replicates =
        parts_[i].rules.front().rule->deviating_replicates();
    // As widely scattered as single replicates are: sum of n/(n - 1) e^2 over all estimates
    // variance as many times
    const auto count = static_cast<double>(replicates.size());
    for (std::size_t c = 0; c < layout.conditions.size(); ++c) {
      const auto n = static_cast<double>(layout.conditions[c].replicates.size());
      for (const std::size_t replicate : replicates) {
        ways.push_back({{.mean = Otherwise::Mean::moved,
                         .condition = c,
                         .replicate = replicate,
                         .share = 1.0 / n},
                        n / count,
                        0,
                        static_cast<double>(std::max(1, parts_[i].freedom))});
      }
    }
    return ways;
  }
  std::size_t stratum = 0;
  for (std::size_t c = 0; c < layout.conditions.size(); ++c) {
    const auto n = static_cast<double>(layout.conditions[c].replicates.size());
    if (n < 2.0) continue;
    for (const std::size_t replicate : layout.conditions[c].replicates) {
      ways.push_back({{.mean = Otherwise::Mean::without, .condition = c, .replicate = replicate},
                      (n - 1.0) / n,
                      stratum,
                      n - 1.0});
    }
    ++stratum;
  }
  return ways;
}

// With d_r(h) what the difference changes by when the mean is that without replicate r, h being
// half widths, h_r those of the other replicates alone, and H(h) what second_difference() gives,
//   sum of f d_r(h)^2  and  sum of f (d_r(h_r) H(h)/H(h_r))^2,  f being the factors of ways_of():
// objectives grow with 1/h^2, and so does H.
std::vector<ChannelComparison::StratumVariance> ChannelComparison::replicate_variances(
    std::size_t i, const Evaluation& first, const Evaluation& second) const {
  const Digests near = digest(i, runs_of(first.runs, i)), far = digest(i, runs_of(second.runs, i));
  const bool both_known = is_known(i, near) && is_known(i, far);
  const auto scale_of = [&](std::optional<std::size_t> widths_without) {
    return both_known ? second_difference(i, near, far, widths_without) : 0.0;
  };
  const double scale = scale_of(std::nullopt);
  std::map<std::size_t, double> scale_without;
  std::vector<StratumVariance> strata;
  for (const auto& [otherwise, factor, stratum, freedom] : ways_of(i)) {
    const auto change_by = [&, &changed = otherwise](std::optional<std::size_t> widths_without) {
      const Otherwise as_it_is{.widths_without = widths_without};
      Otherwise other = changed;
      other.widths_without = widths_without;
      return objective_of(i, near, {}, as_it_is) - objective_of(i, far, {}, as_it_is) -
             objective_of(i, near, {}, other) + objective_of(i, far, {}, other);
    };
    const double by_own = change_by(std::nullopt);
    const auto [known, is_new] = scale_without.try_emplace(otherwise.replicate, 0.0);
    if (is_new) known->second = scale_of(otherwise.replicate);
    // Where the valley has no curvature there is nothing to scale by
    const double by_others = scale > 0.0 && known->second > 0.0
                                 ? change_by(otherwise.replicate) * scale / known->second
                                 : by_own;
    if (strata.size() <= stratum) strata.resize(stratum + 1);
    strata[stratum].freedom = freedom;
    strata[stratum].variance.by_own_widths += factor * by_own * by_own;
    strata[stratum].variance.by_widths_of_others += factor * by_others * by_others;
  }
  return strata;
}

ReplicateVariance ChannelComparison::replicate_variance(const Evaluation& first,
                                                        const Evaluation& second) const {
  ReplicateVariance sum;
  for (std::size_t i = 0; i < experiments_.size(); ++i) {
    const double weight = experiments_[i].weight;
    for (const auto& [variance, freedom] : replicate_variances(i, first, second)) {
      sum.by_own_widths += weight * weight * variance.by_own_widths;
      sum.by_widths_of_others += weight * weight * variance.by_widths_of_others;
    }
  }
  return sum;
}

// A mean of n runs without one of them lies off the mean of all by sqrt(n - 1) times less than that
// lies off what more runs would give. Where seeds do the same at all parameters, more evaluations
// tell no more of them: with their mean correlation r, E evaluations are worth E/(1 + (E - 1) r^2).
std::vector<SeedScatter> ChannelComparison::seed_scatter(
    std::span<const Evaluation> evaluations) const {
  std::vector<SeedScatter> all;
  for (std::size_t i = 0; i < experiments_.size(); ++i) {
    for (std::size_t c = 0; c < experiments_[i].layout.conditions.size(); ++c) {
      SeedScatter& scatter = all.emplace_back();
      if (experiments_[i].layout.conditions[c].is_paired) continue;
      std::size_t n = 0;
      for (const Evaluation& evaluation : evaluations) {
        if (evaluation.failed > 0) continue;
        const std::span<const SimulatedRun> runs = runs_of(evaluation.runs, i);
        const std::vector<std::size_t> stratum = strata_of(i, runs.size())[c];
        n = stratum.size();
        if (n < 2) break;
        const Digests digests = digest(i, runs);
        const std::vector<double> whole = residuals_of(i, digests, {}, {});
        std::vector<std::vector<double>>& own = scatter.displacements.emplace_back();
        std::vector<int> weights(runs.size(), 1);
        for (const std::size_t run : stratum) {
          weights[run] = 0;
          std::vector<double> moved = residuals_of(i, digests, weights, {});
          weights[run] = 1;
          for (std::size_t k = 0; k < moved.size(); ++k)
            moved[k] = std::sqrt(static_cast<double>(n) - 1.0) * (moved[k] - whole[k]);
          own.push_back(std::move(moved));
        }
      }
      const auto count = static_cast<double>(scatter.displacements.size());
      if (count < 1.0) continue;
      const double alike = std::max(0.0, mean_correlation(scatter.displacements));
      scatter.freedom =
          (static_cast<double>(n) - 1.0) * count / (1.0 + (count - 1.0) * alike * alike);
    }
  }
  return all;
}

const SeedScatter* ChannelComparison::scatter_of(std::size_t i,
                                                 std::size_t condition,
                                                 const PooledChance& chance) const {
  if (chance.seeds.empty()) return nullptr;
  std::size_t place = condition;
  for (std::size_t before = 0; before < i; ++before)
    place += experiments_[before].layout.conditions.size();
  return &chance.seeds[place];
}

// Variance of L(z1 + a) - L(z2 + b), a and b being displacements of two evaluations by the same
// seed: what seeds do to both alike drops out. Near the best, where the loss has no slope, its
// curvature makes most of it.
double ChannelComparison::pooled_seed_variance(std::size_t i,
                                               const Digests& first,
                                               const Digests& second,
                                               const SeedScatter& scatter) const {
  const auto moved = [&](const Digests& digests) {
    const std::vector<double> whole = residuals_of(i, digests, {}, {});
    std::vector<std::vector<double>> all;
    for (const auto& of_evaluation : scatter.displacements) {
      std::vector<double>& own = all.emplace_back();
      for (const std::vector<double>& displacement : of_evaluation) {
        std::vector<double> z = whole;
        for (std::size_t k = 0; k < z.size(); ++k) z[k] += displacement[k];
        own.push_back(loss_of_part(i, z));
      }
    }
    return all;
  };
  const auto near = moved(first), far = moved(second);
  double sum = 0.0, squares = 0.0;
  int count = 0;
  for (std::size_t a = 0; a < near.size(); ++a) {
    for (std::size_t b = 0; b < far.size(); ++b) {
      if (a == b && near.size() > 1) continue;
      for (std::size_t seed = 0; seed < near[a].size(); ++seed) {
        const double apart = near[a][seed] - far[b][seed];
        sum += apart;
        squares += apart * apart;
        ++count;
      }
    }
  }
  return count == 0 ? 0.0 : squares / count - std::pow(sum / count, 2);
}

std::vector<VarianceComponent> ChannelComparison::seed_variances(std::size_t i,
                                                                 const Digests& first,
                                                                 const Digests& second,
                                                                 std::size_t runs,
                                                                 const PooledChance& chance) const {
  std::vector<VarianceComponent> components;
  std::vector<int> weights(runs, 1);
  const auto strata = strata_of(i, runs);
  for (std::size_t c = 0; c < strata.size(); ++c) {
    if (experiments_[i].layout.conditions[c].is_paired) continue;
    const double own_freedom = std::max(1.0, static_cast<double>(strata[c].size()) - 1.0);
    const SeedScatter* scatter = scatter_of(i, c, chance);
    if (scatter != nullptr && own_freedom < enough_freedom && scatter->freedom > own_freedom) {
      components.push_back(
          {std::pow(experiments_[i].weight, 2) * pooled_seed_variance(i, first, second, *scatter),
           scatter->freedom});
      continue;
    }
    std::vector<double> values;
    for (const std::size_t run : strata[c]) {
      weights[run] = 0;
      values.push_back(objective_of(i, first, weights, {}) - objective_of(i, second, weights, {}));
      weights[run] = 1;
    }
    const double error = experiments_[i].weight * jackknife_error(values);
    components.push_back({error * error, own_freedom});
  }
  return components;
}

// D of the text in the header, L(2 z1 - z2) - L(z1), z being the residuals of the two models. What
// the seeds add to it is taken off by the jackknife's estimate of bias,
//   D - (n - 1)(mean of delete-one values - D),  Quenouille (1956),
// condition by condition. Where means are moved instead, half the second difference of D to either
// side is what one deviation adds.
double ChannelComparison::distance(std::size_t i,
                                   const Digests& first,
                                   const Digests& second,
                                   std::size_t runs) const {
  const auto at = [&](std::span<const int> weights, const Otherwise& otherwise) {
    const std::vector<double> near = residuals_of(i, first, weights, otherwise);
    const std::vector<double> far = residuals_of(i, second, weights, otherwise);
    return loss_of_part(i, mirrored(near, far)) - loss_of_part(i, near);
  };
  std::vector<int> weights(runs, 1);
  const double whole = at(weights, {});
  double bias = 0.0;
  const Layout& layout = experiments_[i].layout;
  const auto strata = strata_of(i, runs);
  for (std::size_t c = 0; c < strata.size(); ++c) {
    if (layout.conditions[c].is_paired) continue;
    const std::size_t n = strata[c].size();
    double deleted = 0.0;
    for (const std::size_t run : strata[c]) {
      weights[run] = 0;
      deleted += at(weights, {}) / static_cast<double>(n);
      weights[run] = 1;
    }
    bias += static_cast<double>(n - 1) * (deleted - whole);
  }
  for (const auto& [otherwise, factor, stratum, freedom] : ways_of(i)) {
    if (!layout.conditions[otherwise.condition].is_paired) continue;
    if (otherwise.mean == Otherwise::Mean::moved) {
      Otherwise back = otherwise;
      back.share = -otherwise.share;
      bias += factor * 0.5 * (at(weights, otherwise) + at(weights, back) - 2.0 * whole);
    } else {
      bias += factor * (at(weights, otherwise) - whole);
    }
  }
  return std::max(0.0, whole - bias);
}

double ChannelComparison::half_width_of_difference(const Evaluation& first,
                                                   const Evaluation& second,
                                                   const PooledChance& chance) const {
  std::vector<VarianceComponent> components;
  for (std::size_t i = 0; i < experiments_.size(); ++i) {
    const double weight = experiments_[i].weight;
    const auto one = runs_of(first.runs, i), other = runs_of(second.runs, i);
    for (const auto& [variance, freedom] : replicate_variances(i, first, second)) {
      components.push_back(
          {chance.cost_of_own_widths * (weight * weight * variance.by_own_widths), freedom});
    }
    for (const VarianceComponent& component :
         seed_variances(i, digest(i, one), digest(i, other), one.size(), chance))
      components.push_back(component);
  }
  components.push_back(
      {std::pow(chance.roughness * std::hypot(first.objective, second.objective), 2),
       std::numeric_limits<double>::infinity()});
  return half_width_95(components);
}

double ChannelComparison::half_width_by_replicates(const Evaluation& evaluation) const {
  std::vector<VarianceComponent> components;
  for (std::size_t i = 0; i < experiments_.size(); ++i) {
    const Digests runs = digest(i, runs_of(evaluation.runs, i));
    const double as_it_is = objective_of(i, runs, {}, {});
    std::vector<VarianceComponent> strata;
    for (const auto& [otherwise, factor, stratum, freedom] : ways_of(i)) {
      Otherwise other = otherwise;
      other.of_replicates_alone = true;
      const double change = experiments_[i].weight * (objective_of(i, runs, {}, other) - as_it_is);
      if (strata.size() <= stratum) strata.resize(stratum + 1);
      strata[stratum].freedom = freedom;
      strata[stratum].variance += factor * change * change;
    }
    components.insert(components.end(), strata.begin(), strata.end());
  }
  return half_width_95(components);
}

// By the jackknife, a run of both at a time. What a condition's only run scatters nobody knows.
SeedNoise ChannelComparison::noise_of_difference(const Evaluation& first,
                                                 const Evaluation& second) const {
  std::vector<VarianceComponent> components;
  for (std::size_t i = 0; i < experiments_.size(); ++i) {
    const auto one = runs_of(first.runs, i), other = runs_of(second.runs, i);
    const Digests near = digest(i, one), far = digest(i, other);
    std::vector<int> weights(one.size(), 1);
    for (const std::vector<std::size_t>& stratum : strata_of(i, one.size())) {
      if (stratum.size() < 2) return {};
      std::vector<double> values;
      for (const std::size_t run : stratum) {
        weights[run] = 0;
        values.push_back(objective_of(i, near, weights, {}) - objective_of(i, far, weights, {}));
        weights[run] = 1;
      }
      const double error = experiments_[i].weight * jackknife_error(values);
      components.push_back({error * error, static_cast<double>(stratum.size()) - 1.0});
    }
  }
  double variance = 0.0;
  for (const VarianceComponent& component : components) variance += component.variance;
  return {std::sqrt(variance), half_width_95(components)};
}

double ChannelComparison::allowed_excess(const Evaluation& best,
                                         const Evaluation& evaluation,
                                         const PooledChance& chance) const {
  double apart = 0.0;
  for (std::size_t i = 0; i < experiments_.size(); ++i) {
    const auto near = runs_of(best.runs, i), far = runs_of(evaluation.runs, i);
    apart += experiments_[i].weight * distance(i, digest(i, near), digest(i, far), near.size());
  }
  return std::max(0.0, half_width_of_difference(best, evaluation, chance) - apart);
}

std::unique_ptr<Comparison> ChannelComparison::with_replicates(
    std::span<const SimulatedRun> runs) const {
  std::vector<ComparedExperiment> simulated = experiments_;
  for (std::size_t i = 0; i < experiments_.size(); ++i) {
    const std::span<const SimulatedRun> own = runs_of(runs, i);
    ComparedExperiment& experiment = simulated[i];
    const std::size_t seeds = experiment.layout.seeds_of(own.size());
    std::vector<Situation> situations;
    experiment.measured.clear();
    for (ComparedCondition& condition : experiment.layout.conditions) {
      // An evaluation has one simulation of every paired replicate, and none to spare
      if (condition.is_paired) return nullptr;
      const Situation situation = experiment.situations[condition.replicates.front()];
      condition.replicates.clear();
      for (const std::size_t scene : condition.scenes) {
        for (std::size_t seed = 0; seed < seeds; ++seed) {
          const SimulatedRun& run = own[scene * seeds + seed];
          if (run.status != RunStatus::completed) continue;
          condition.replicates.push_back(experiment.measured.size());
          experiment.measured.push_back(run.channels);
          situations.push_back(situation);
        }
      }
      if (condition.replicates.size() < 2) return nullptr;
    }
    experiment.situations = std::move(situations);
  }
  // An experiment has seeds of its own in no part of the runs
  if (experiments_.size() > 1) return nullptr;
  return std::make_unique<ChannelComparison>(std::move(simulated), form_);
}

std::unique_ptr<Comparison> ChannelComparison::with_form(datasets::ObjectiveForm form) const {
  try {
    return std::make_unique<ChannelComparison>(experiments_, form);
  } catch (const std::invalid_argument&) {
    return nullptr;
  }
}

}  // namespace graintruth::calibrate
