#include "calibrate/bin_comparison.h"

#include <algorithm>
#include <array>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <cmath>
#include <limits>

#include "calibrate/ensemble.h"
#include "calibrate/hypothesis_tests.h"
#include "calibrate/objective.h"

namespace graintruth::calibrate {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double particle_resolution = 1.0;  // remaining particles are counted whole

// Mean over those that are not NaN; NaN where none is.
class Mean {
 public:
  void add(double value) {
    if (std::isnan(value)) return;
    sum_ += value;
    ++count_;
  }
  double value() const { return count_ == 0 ? nan : sum_ / count_; }

 private:
  double sum_ = 0.0;
  int count_ = 0;
};

double mean_of(const BinComparison::Shares& shares) {
  Mean kinds;
  for (const BinComparison::Share& share : shares) kinds.add(share.value);
  return kinds.value();
}

// What a model in which nothing moves would give.
BinNumbers numbers_of_rest(const BinNumbers& filmed, int particles) {
  return {.rate = 0.0,
          .remaining = static_cast<double>(particles),
          .density = filmed.density,
          .velocity = std::vector<double>(filmed.velocity.size(), 0.0)};
}

}  // namespace

BinNumbers numbers_of(const BinMeasurement& measured, const BulkRig& rig) {
  BinNumbers numbers;
  const Discharge& discharge = measured.discharge;
  const auto left = static_cast<double>(discharge.times.size());
  const double duration = discharge.to - std::max(0.0, discharge.from);
  if (const auto steady = steady_rate(discharge, rig)) {
    numbers.rate = steady->rate;
  } else if (duration > 0.0) {
    numbers.rate = left * rig.particle_mass / duration;
  }
  numbers.remaining = discharge.particles - left;
  numbers.density = measured.flowing_density;
  const auto bins = profile_bins(rig);
  numbers.velocity.assign(bins, nan);
  for (const VelocitySample& sample : measured.profile.samples) {
    const double bin = std::floor((sample.x / rig.width + 0.5) * static_cast<double>(bins));
    numbers
        .velocity[static_cast<std::size_t>(std::clamp(bin, 0.0, static_cast<double>(bins - 1)))] =
        sample.velocity;
  }
  return numbers;
}

// Simulated minus filmed: rates and densities relative to the orifice's mean, velocities to its
// largest.
struct BinComparison::Differences {
  double rate = 0.0;
  double remaining = 0.0;
  double density = 0.0;          // 0 where either is not known
  std::vector<double> velocity;  // NaN where the film has none

  void add(const Differences& other, double factor) {
    rate += factor * other.rate;
    remaining += factor * other.remaining;
    density += factor * other.density;
    for (std::size_t i = 0; i < velocity.size(); ++i) {
      if (!std::isnan(other.velocity[i])) velocity[i] += factor * other.velocity[i];
    }
  }
};

BinComparison::BinComparison(std::vector<FilmedBin> films) : films_(std::move(films)) {
  // 1. Films by orifice, and their means
  for (std::size_t i = 0; i < films_.size(); ++i) {
    numbers_.push_back(numbers_of(films_[i].measured, films_[i].rig));
    const double orifice = films_[i].rig.orifice;
    auto at = std::find_if(orifices_.begin(), orifices_.end(), [&](const OrificeMean& mean) {
      return mean.orifice == orifice;
    });
    if (at == orifices_.end()) at = orifices_.insert(at, OrificeMean{.orifice = orifice});
    at->films.push_back(i);
  }
  std::sort(orifices_.begin(), orifices_.end(), [](const OrificeMean& a, const OrificeMean& b) {
    return a.orifice < b.orifice;
  });
  for (OrificeMean& orifice : orifices_) {
    Mean rate, remaining, density;
    std::vector<Mean> velocity(numbers_[orifice.films.front()].velocity.size());
    for (const std::size_t film : orifice.films) {
      rate.add(numbers_[film].rate);
      remaining.add(numbers_[film].remaining);
      density.add(numbers_[film].density > 0.0 ? numbers_[film].density : nan);
      for (std::size_t bin = 0; bin < velocity.size(); ++bin)
        velocity[bin].add(numbers_[film].velocity[bin]);
    }
    orifice.mean = {.rate = rate.value(),
                    .remaining = remaining.value(),
                    .density = std::isnan(density.value()) ? 0.0 : density.value(),
                    .velocity = {}};
    for (const Mean& bin : velocity) {
      orifice.mean.velocity.push_back(bin.value());
      if (!std::isnan(bin.value()))
        orifice.largest_velocity = std::max(orifice.largest_velocity, std::abs(bin.value()));
    }
  }

  // 2. Scatter about them, pooled
  double rate = 0.0, remaining = 0.0, velocity = 0.0;
  int velocity_freedom = 0;
  double within = 0.0;  // mean square of what single films say of their own rate
  for (const OrificeMean& orifice : orifices_) {
    scatter_.freedom += static_cast<int>(orifice.films.size()) - 1;
    for (const std::size_t film : orifice.films) {
      const BinNumbers& numbers = numbers_[film];
      if (orifice.mean.rate > 0.0) rate += std::pow(numbers.rate / orifice.mean.rate - 1.0, 2);
      remaining += std::pow(numbers.remaining - orifice.mean.remaining, 2);
      const auto steady = steady_rate(films_[film].measured.discharge, films_[film].rig);
      if (steady)
        within +=
            std::pow(steady->standard_error / steady->rate, 2) / static_cast<double>(films_.size());
      for (std::size_t bin = 0; bin < numbers.velocity.size(); ++bin) {
        if (std::isnan(numbers.velocity[bin]) || orifice.largest_velocity == 0.0) continue;
        velocity += std::pow(
            (numbers.velocity[bin] - orifice.mean.velocity[bin]) / orifice.largest_velocity, 2);
      }
    }
    for (std::size_t bin = 0; bin < orifice.mean.velocity.size(); ++bin) {
      int seen = 0;
      for (const std::size_t film : orifice.films)
        seen += std::isnan(numbers_[film].velocity[bin]) ? 0 : 1;
      velocity_freedom += std::max(0, seen - 1);
    }
  }
  if (scatter_.freedom > 0) {
    // Films that agree by luck are not more exact than each of them is.
    scatter_.relative_rate = std::sqrt(std::max(rate / scatter_.freedom, within));
    scatter_.remaining = std::max(std::sqrt(remaining / scatter_.freedom), particle_resolution);
  }
  if (velocity_freedom > 0) scatter_.relative_velocity = std::sqrt(velocity / velocity_freedom);
  learn_kinds();
}

std::vector<BinComparison::Differences> BinComparison::differences(
    std::span<const SimulatedRun> runs) const {
  std::vector<const OrificeMean*> orifice_of(films_.size());
  for (const OrificeMean& orifice : orifices_) {
    for (const std::size_t film : orifice.films) orifice_of[film] = &orifice;
  }
  const std::size_t seeds = runs.size() / films_.size();
  std::vector<Differences> all;
  for (std::size_t run = 0; run < runs.size(); ++run) {
    const std::size_t film = run / seeds;
    const OrificeMean& orifice = *orifice_of[film];
    const BinNumbers& filmed = numbers_[film];
    const BinNumbers simulated =
        runs[run].status == RunStatus::completed
            ? numbers_of(runs[run].bin, films_[film].rig)
            : numbers_of_rest(filmed, films_[film].measured.discharge.particles);
    Differences difference;
    if (orifice.mean.rate > 0.0)
      difference.rate = (simulated.rate - filmed.rate) / orifice.mean.rate;
    difference.remaining = simulated.remaining - filmed.remaining;
    if (simulated.density > 0.0 && filmed.density > 0.0)
      difference.density = (simulated.density - filmed.density) / orifice.mean.density;
    for (std::size_t bin = 0; bin < filmed.velocity.size(); ++bin) {
      // Where nothing passes in the simulation nothing moves.
      const double passing = std::isnan(simulated.velocity[bin]) ? 0.0 : simulated.velocity[bin];
      difference.velocity.push_back(orifice.largest_velocity > 0.0
                                        ? (passing - filmed.velocity[bin]) /
                                              orifice.largest_velocity
                                        : nan);
    }
    all.push_back(std::move(difference));
  }
  return all;
}

// Over all films of an orifice and their seeds, without the run `left_out` (all: any other number).
BinComparison::Differences BinComparison::mean_difference(const std::vector<Differences>& of_runs,
                                                          const OrificeMean& orifice,
                                                          std::size_t seeds,
                                                          std::size_t left_out) const {
  Mean rate, remaining, density;
  std::vector<Mean> velocity(orifice.mean.velocity.size());
  for (const std::size_t film : orifice.films) {
    for (std::size_t seed = 0; seed < seeds; ++seed) {
      const std::size_t run = film * seeds + seed;
      if (run == left_out) continue;
      rate.add(of_runs[run].rate);
      remaining.add(of_runs[run].remaining);
      density.add(of_runs[run].density);
      for (std::size_t bin = 0; bin < velocity.size(); ++bin)
        velocity[bin].add(of_runs[run].velocity[bin]);
    }
  }
  Differences mean{rate.value(), remaining.value(), density.value(), {}};
  for (const Mean& bin : velocity) mean.velocity.push_back(bin.value());
  return mean;
}

std::vector<BinComparison::Differences> BinComparison::mean_differences(
    std::span<const SimulatedRun> runs) const {
  const std::vector<Differences> of_runs = differences(runs);
  std::vector<Differences> of_orifices;
  for (const OrificeMean& orifice : orifices_)
    of_orifices.push_back(
        mean_difference(of_runs, orifice, runs.size() / films_.size(), runs.size()));
  return of_orifices;
}

std::vector<BinComparison::Residual> BinComparison::residuals_of(
    const std::vector<Differences>& of_orifices) const {
  if (laws_) return law_residuals(of_orifices);
  std::vector<Residual> all;
  // Which are NaN depends on the films alone.
  const auto add = [&](std::string_view kind, double difference, double scatter) {
    if (const double z = difference / scatter; !std::isnan(z)) all.push_back({kind, z});
  };
  for (std::size_t i = 0; i < orifices_.size(); ++i) {
    const Differences& difference = of_orifices[i];
    const double share = std::sqrt(2.0 / static_cast<double>(orifices_[i].films.size()));
    add("flow_rate", difference.rate, scatter_.relative_rate * share);
    add("remaining", difference.remaining, scatter_.remaining * share);
    if (!(scatter_.relative_velocity > 0.0)) continue;
    for (const double velocity : difference.velocity)
      add("velocity_profile", velocity, scatter_.relative_velocity * share);
  }
  return all;
}

std::vector<MeanFlow> BinComparison::mean_flows(const std::vector<Differences>* of_orifices) const {
  std::vector<MeanFlow> flows;
  for (std::size_t i = 0; i < orifices_.size(); ++i) {
    const OrificeMean& orifice = orifices_[i];
    const auto films = static_cast<double>(orifice.films.size());
    MeanFlow flow{
        .orifice = orifice.orifice,
        .rate = orifice.mean.rate,
        .standard_uncertainty = scatter_.relative_rate * orifice.mean.rate / std::sqrt(films),
        .density = orifice.mean.density};
    for (const std::size_t film : orifice.films)
      flow.height += films_[film].measured.profile.height / films;
    if (of_orifices) {
      flow.rate *= 1.0 + (*of_orifices)[i].rate;
      flow.density *= 1.0 + (*of_orifices)[i].density;
    }
    const auto bins = static_cast<double>(orifice.mean.velocity.size());
    const double width = films_[orifice.films.front()].rig.width;
    for (std::size_t bin = 0; bin < orifice.mean.velocity.size(); ++bin) {
      double velocity = orifice.mean.velocity[bin];
      if (of_orifices) velocity += orifice.largest_velocity * (*of_orifices)[i].velocity[bin];
      if (std::isnan(velocity)) continue;
      flow.profile.push_back(
          {.x = ((static_cast<double>(bin) + 0.5) / bins - 0.5) * width, .velocity = velocity});
    }
    flows.push_back(std::move(flow));
  }
  return flows;
}

bool BinComparison::tells_laws() const {
  return orifices_.size() >= 2 && scatter_.relative_rate > 0.0 &&
         std::all_of(orifices_.begin(), orifices_.end(), [](const OrificeMean& orifice) {
           return orifice.mean.rate > 0.0 && orifice.mean.density > 0.0;
         });
}

std::optional<BinComparison::Laws> BinComparison::learn_laws() const {
  const double diameter = films_.front().rig.particle_diameter;
  const double gravity = films_.front().rig.gravity;
  const std::vector<MeanFlow> flows = mean_flows(nullptr);
  Laws laws{fit_flow_laws(flows, diameter, gravity),
            beverloo_uncertainty(flows, diameter, gravity)};
  if (!(laws.uncertainty.C > 0.0 && laws.uncertainty.k > 0.0)) return std::nullopt;
  // B of every film by itself, about that of its orifice
  double squares = 0.0;
  int freedom = 0;
  for (std::size_t i = 0; i < orifices_.size(); ++i) {
    int fitted = 0;
    for (const std::size_t film : orifices_[i].films) {
      const MeanFlow alone{.orifice = orifices_[i].orifice,
                           .height = films_[film].measured.profile.height,
                           .profile = films_[film].measured.profile.samples};
      const double B = kinematic_length(alone);
      if (std::isnan(B) || !(laws.filmed.B[i] > 0.0)) continue;
      squares += std::pow(B / laws.filmed.B[i] - 1.0, 2);
      ++fitted;
    }
    freedom += std::max(0, fitted - 1);
  }
  if (freedom > 0) laws.relative_B = std::sqrt(squares / freedom);
  return laws;
}

// Of C, of k, and of the B of each orifice whose films tell one. Simulated means scatter as filmed
// ones do.
std::vector<BinComparison::Residual> BinComparison::law_residuals(
    const std::vector<Differences>& of_orifices) const {
  const FlowLaws simulated = fit_flow_laws(
      mean_flows(&of_orifices), films_.front().rig.particle_diameter, films_.front().rig.gravity);
  const FlowLaws& filmed = laws_->filmed;
  const double both = std::sqrt(2.0);
  std::vector<Residual> all = {
      {"beverloo_C", (simulated.C - filmed.C) / (both * laws_->uncertainty.C)},
      {"beverloo_k", (simulated.k - filmed.k) / (both * laws_->uncertainty.k)}};
  for (std::size_t i = 0; i < orifices_.size(); ++i) {
    if (!(filmed.B[i] > 0.0) || !(laws_->relative_B > 0.0)) continue;
    const auto films = static_cast<double>(orifices_[i].films.size());
    all.push_back(
        {"kinematic_B",
         (simulated.B[i] / filmed.B[i] - 1.0) / (both * laws_->relative_B / std::sqrt(films))});
  }
  return all;
}

// Kinds in the order in which they come first.
BinComparison::Shares BinComparison::shares_of(const std::vector<Residual>& residuals) {
  std::vector<std::pair<std::string_view, Mean>> means;
  for (const Residual& residual : residuals) {
    auto at = std::find_if(
        means.begin(), means.end(), [&](const auto& mean) { return mean.first == residual.kind; });
    if (at == means.end()) at = means.insert(means.end(), {residual.kind, Mean{}});
    at->second.add(pseudo_huber(residual.z));
  }
  Shares shares;
  for (const auto& [kind, mean] : means) shares.push_back({kind, mean.value()});
  return shares;
}

double BinComparison::objective_of(const std::vector<Differences>& of_orifices) const {
  return mean_of(shares_of(residuals_of(of_orifices)));
}

// As a model has them in which nothing moves.
void BinComparison::learn_kinds() {
  const std::vector<SimulatedRun> at_rest(films_.size(), {.status = RunStatus::unstable});
  kinds_.clear();
  for (const Residual& residual : residuals_of(mean_differences(at_rest)))
    kinds_.push_back(residual.kind);
}

double BinComparison::loss(std::span<const double> residuals) const {
  std::vector<Residual> all;
  for (std::size_t i = 0; i < residuals.size(); ++i) all.push_back({kinds_.at(i), residuals[i]});
  return mean_of(shares_of(all));
}

BinComparison::Shares BinComparison::shares(std::span<const SimulatedRun> runs) const {
  return shares_of(residuals_of(mean_differences(runs)));
}

double BinComparison::simulated_rate(const OrificeMean& orifice,
                                     std::span<const SimulatedRun> runs) const {
  const Differences mean =
      mean_difference(differences(runs), orifice, runs.size() / films_.size(), runs.size());
  return orifice.mean.rate * (1.0 + mean.rate);
}

std::vector<double> BinComparison::residuals(std::span<const SimulatedRun> runs) const {
  std::vector<double> all;
  for (const Residual& residual : residuals_of(mean_differences(runs))) all.push_back(residual.z);
  return all;
}

double BinComparison::objective(std::span<const SimulatedRun> runs) const {
  return objective_of(mean_differences(runs));
}

// Delete-one jackknife with orifices as strata:
//   var = sum over orifices of (n - 1)/n sum (v_i - mean v)^2
double BinComparison::noise(std::span<const SimulatedRun> runs) const {
  const std::size_t seeds = runs.size() / films_.size();
  const std::vector<Differences> of_runs = differences(runs);
  std::vector<Differences> of_orifices;
  for (const OrificeMean& orifice : orifices_)
    of_orifices.push_back(mean_difference(of_runs, orifice, seeds, runs.size()));
  double variance = 0.0;
  for (std::size_t i = 0; i < orifices_.size(); ++i) {
    const OrificeMean& orifice = orifices_[i];
    if (orifice.films.size() * seeds < 2) continue;
    std::vector<double> values;
    std::vector<Differences> without = of_orifices;
    for (const std::size_t film : orifice.films) {
      for (std::size_t seed = 0; seed < seeds; ++seed) {
        without[i] = mean_difference(of_runs, orifice, seeds, film * seeds + seed);
        values.push_back(objective_of(without));
      }
    }
    variance += std::pow(jackknife_error(values), 2);
  }
  return std::sqrt(variance);
}

RunScore BinComparison::score_run(const SimulatedRun& run, std::size_t scene) const {
  const BinComparison alone = [&] {
    BinComparison one({films_[scene]});
    one.scatter_ = scatter_;
    return one;
  }();
  return {alone.objective({&run, 1}), nan};
}

std::vector<std::vector<double>> BinComparison::draw_objectives(
    std::span<const Evaluation> evaluations, const BootstrapOptions& options) const {
  // 1. Mean differences of every evaluation, and residuals about them, as widely scattered as
  // single pairs of film and simulation are: sqrt(n / (n - 1)) of what is seen about a mean
  struct Seen {
    std::vector<Differences> means, residuals;
  };
  std::vector<Seen> seen;
  for (const Evaluation& evaluation : evaluations) {
    const std::size_t seeds = evaluation.runs.size() / films_.size();
    const std::vector<Differences> of_runs = differences(evaluation.runs);
    Seen one;
    for (const OrificeMean& orifice : orifices_) {
      one.means.push_back(mean_difference(of_runs, orifice, seeds, of_runs.size()));
      const auto n = static_cast<double>(orifice.films.size());
      if (n < 2.0) continue;
      for (const std::size_t film : orifice.films) {
        // All seeds of a film stand and fall with it.
        const OrificeMean only{.orifice = orifice.orifice, .films = {film}, .mean = orifice.mean};
        Differences residual = mean_difference(of_runs, only, seeds, of_runs.size());
        residual.add(one.means.back(), -1.0);
        Differences wide{.velocity = std::vector<double>(residual.velocity.size(), 0.0)};
        wide.add(residual, std::sqrt(n / (n - 1.0)));
        one.residuals.push_back(std::move(wide));
      }
    }
    seen.push_back(std::move(one));
  }

  // 2. The same draw for all evaluations: they share their films
  const std::vector<std::uint64_t> seeds = make_seeds(options.seed, "bootstrap", options.draws);
  std::vector<std::vector<double>> drawn(static_cast<std::size_t>(options.draws));
  parallel_for(options.draws, options.jobs, [&](int draw) {
    boost::random::mt19937_64 generator(seeds[static_cast<std::size_t>(draw)]);
    boost::random::uniform_int_distribution<std::size_t> which(0,
                                                               seen.front().residuals.size() - 1);
    std::vector<std::vector<std::size_t>> chosen;
    for (const OrificeMean& orifice : orifices_) {
      chosen.emplace_back();
      for (std::size_t i = 0; i < orifice.films.size(); ++i)
        chosen.back().push_back(which(generator));
    }
    for (const Seen& one : seen) {
      std::vector<Differences> of_orifices = one.means;
      for (std::size_t i = 0; i < orifices_.size(); ++i) {
        for (const std::size_t residual : chosen[i])
          of_orifices[i].add(one.residuals[residual], 1.0 / static_cast<double>(chosen[i].size()));
      }
      drawn[static_cast<std::size_t>(draw)].push_back(objective_of(of_orifices));
    }
  });
  return drawn;
}

std::unique_ptr<Comparison> BinComparison::with_replicates(std::span<const SimulatedRun>) const {
  return nullptr;
}

std::unique_ptr<Comparison> BinComparison::with_form(datasets::ObjectiveForm form) const {
  auto other = std::make_unique<BinComparison>(*this);
  other->laws_.reset();
  if (form == datasets::ObjectiveForm::requested) {
    if (tells_laws()) other->laws_ = learn_laws();
    if (!other->laws_) return nullptr;
  }
  other->learn_kinds();
  return other;
}

double BinComparison::half_width_of_difference(const Evaluation& first,
                                               const Evaluation& second,
                                               const PooledChance& chance,
                                               const BootstrapOptions& options) const {
  const std::array<Evaluation, 2> both = {first, second};
  return student_t_quantile(0.975, scatter_.freedom) *
         std::hypot(difference_deviation(draw_objectives(both, options)),
                    chance.roughness * std::hypot(first.objective, second.objective));
}

// Films and seeds are drawn as pairs and cannot be told apart: the whole deviation is allowed,
// which is more than 95 % asks for.
double BinComparison::allowed_excess(const Evaluation& best,
                                     const Evaluation& evaluation,
                                     const PooledChance& chance,
                                     const BootstrapOptions& options) const {
  return half_width_of_difference(best, evaluation, chance, options);
}

}  // namespace graintruth::calibrate
