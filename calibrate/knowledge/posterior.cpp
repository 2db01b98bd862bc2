#include "calibrate/knowledge/posterior.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_01.hpp>
#include <cmath>

#include "calibrate/knowledge/prior.h"

namespace graintruth::calibrate {

namespace {

constexpr int burn_in = 3000;
constexpr int draw_count = 4000;
constexpr int steps_per_draw = 2;
constexpr double first_step = 0.02;  // of each range

using Generator = boost::random::mt19937_64;

// Mean and covariance of the chain so far.
class Moments {
 public:
  explicit Moments(Eigen::Index dimension)
      : mean_(Eigen::VectorXd::Zero(dimension)),
        squares_(Eigen::MatrixXd::Zero(dimension, dimension)) {}
  void add(const Eigen::VectorXd& value) {
    ++count_;
    const Eigen::VectorXd before = value - mean_;
    mean_ += before / count_;
    squares_ += before * (value - mean_).transpose();
  }
  Eigen::MatrixXd covariance() const { return squares_ / std::max(1, count_ - 1); }

 private:
  int count_ = 0;
  Eigen::VectorXd mean_;
  Eigen::MatrixXd squares_;
};

}  // namespace

double effective_sample_size(const std::vector<double>& chain) {
  const std::size_t n = chain.size();
  double mean = 0.0;
  for (const double value : chain) mean += value / static_cast<double>(n);
  const auto covariance = [&](std::size_t lag) {
    double sum = 0.0;
    for (std::size_t i = 0; i + lag < n; ++i) sum += (chain[i] - mean) * (chain[i + lag] - mean);
    return sum / static_cast<double>(n);
  };
  const double variance = covariance(0);
  if (!(variance > 0.0)) return 1.0;
  double time = -1.0;
  for (std::size_t lag = 0; lag + 1 < n / 2; lag += 2) {
    const double pair = (covariance(lag) + covariance(lag + 1)) / variance;
    if (pair <= 0.0) break;
    time += 2.0 * pair;
  }
  return static_cast<double>(n) / std::max(1.0, time);
}

Posterior draw_posterior(const Surrogate& surrogate,
                         const UnitPoint& start,
                         double allowed,
                         std::uint64_t seed) {
  Generator generator(seed);
  boost::random::normal_distribution<double> normal;
  boost::random::uniform_01<double> uniform;
  const auto dimension = static_cast<Eigen::Index>(start.size());
  const auto log_density = [&](const UnitPoint& point) {
    const double objective = std::exp(surrogate.predict({&point, 1}).front().mean);
    return log_likelihood(objective, allowed);
  };

  Posterior posterior;
  UnitPoint here = start;
  double density = log_density(here);
  Moments moments(dimension);
  Eigen::MatrixXd step = first_step * Eigen::MatrixXd::Identity(dimension, dimension);
  for (int i = 0; i < burn_in + draw_count * steps_per_draw; ++i) {
    Eigen::VectorXd random(dimension);
    for (double& value : random) value = normal(generator);
    const Eigen::VectorXd move = step * random;
    UnitPoint there = here;
    bool is_inside = true;
    for (std::size_t d = 0; d < there.size(); ++d) {
      there[d] += move(static_cast<Eigen::Index>(d));
      is_inside = is_inside && there[d] >= 0.0 && there[d] <= 1.0;
    }
    if (is_inside) {
      const double proposed = log_density(there);
      if (std::log(uniform(generator)) < proposed - density) {
        here = std::move(there);
        density = proposed;
      }
    }
    if (i < burn_in) {
      moments.add(Eigen::Map<const Eigen::VectorXd>(here.data(), dimension));
      // 2.38^2 / d of the covariance is the best proposal for a Gaussian (Gelman et al. 1996)
      constexpr int learning_interval = 250;
      if ((i + 1) % learning_interval == 0) {
        const Eigen::MatrixXd learnt =
            5.66 / static_cast<double>(dimension) * moments.covariance() +
            1.0e-8 * Eigen::MatrixXd::Identity(dimension, dimension);
        step = learnt.llt().matrixL();
      }
    } else if ((i - burn_in) % steps_per_draw == 0) {
      posterior.draws.push_back(here);
    }
  }

  posterior.effective_size = static_cast<double>(posterior.draws.size());
  for (std::size_t d = 0; d < start.size(); ++d) {
    std::vector<double> chain;
    for (const UnitPoint& draw : posterior.draws) chain.push_back(draw[d]);
    posterior.effective_size = std::min(posterior.effective_size, effective_sample_size(chain));
  }
  return posterior;
}

PosteriorMarginal marginal_of(const Posterior& posterior,
                              const ParameterSpace& space,
                              std::size_t dimension) {
  PosteriorMarginal marginal{.name = space.tuned()[dimension].name};
  std::vector<double> values;
  for (const UnitPoint& draw : posterior.draws)
    values.push_back(value_of(space.from_unit(draw), marginal.name));
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(values.size());
  double squares = 0.0;
  for (const double value : values) marginal.mean += value / n;
  for (const double value : values) squares += (value - marginal.mean) * (value - marginal.mean);
  marginal.standard_deviation = std::sqrt(squares / (n - 1.0));
  const std::size_t tail = values.size() / 40;
  marginal.credible = {values[tail], values[values.size() - 1 - tail]};
  return marginal;
}

UnitPoint mean_of(const Posterior& posterior) {
  UnitPoint mean(posterior.draws.front().size(), 0.0);
  for (const UnitPoint& draw : posterior.draws) {
    for (std::size_t d = 0; d < mean.size(); ++d)
      mean[d] += draw[d] / static_cast<double>(posterior.draws.size());
  }
  return mean;
}

}  // namespace graintruth::calibrate
