#include "calibrate/search/surrogate.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_01.hpp>
#include <cmath>
#include <openturns/ConstantBasisFactory.hxx>
#include <openturns/KrigingAlgorithm.hxx>
#include <openturns/Log.hxx>
#include <openturns/MaternModel.hxx>
#include <openturns/SobolSequence.hxx>

namespace graintruth::calibrate {

namespace {

OT::Sample sample_of(std::span<const UnitPoint> points) {
  OT::Sample sample(points.size(), points.front().size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t d = 0; d < points[i].size(); ++d) sample(i, d) = points[i][d];
  }
  return sample;
}

}  // namespace

double chebyshev_distance(const UnitPoint& a, const UnitPoint& b) {
  double distance = 0.0;
  for (std::size_t d = 0; d < a.size(); ++d) distance = std::max(distance, std::abs(a[d] - b[d]));
  return distance;
}

std::vector<UnitPoint> low_discrepancy_points(int count,
                                              std::size_t dimension,
                                              std::uint64_t seed) {
  boost::random::mt19937_64 generator(seed);
  boost::random::uniform_01<double> uniform;
  UnitPoint shift(dimension);
  for (double& offset : shift) offset = uniform(generator);
  const OT::Sample sequence =
      OT::SobolSequence(dimension).generate(static_cast<OT::UnsignedInteger>(count));
  std::vector<UnitPoint> points(static_cast<std::size_t>(count), UnitPoint(dimension));
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t d = 0; d < dimension; ++d) {
      const double moved = sequence(i, d) + shift[d];
      points[i][d] = moved - std::floor(moved);
    }
  }
  return points;
}

struct Surrogate::Fit {
  std::vector<UnitPoint> points;
  Eigen::VectorXd values;
  OT::CovarianceModel covariance;
  Eigen::MatrixXd inverse;   // of K = C(points, points) + noise^2
  Eigen::RowVectorXd trend;  // 1' K^-1 / (1' K^-1 1): weights of the constant trend
  double roughness = 0.0;
  std::function<double(const UnitPoint&)> known;  // see plus(); may be empty
};

namespace {

// One Gaussian process for an assumed roughness: lengths and amplitude by maximum likelihood.
struct Candidate {
  OT::CovarianceModel covariance;
  Eigen::MatrixXd inverse;
  Eigen::RowVectorXd trend;
  double log_likelihood = 0.0;
};

// K = C(inputs, inputs) + the errors' variances.
Eigen::MatrixXd covariance_of(const OT::CovarianceModel& covariance,
                              const OT::Sample& inputs,
                              const OT::Point& variance) {
  const OT::CovarianceMatrix discretised = covariance.discretize(inputs);
  const auto size = static_cast<Eigen::Index>(inputs.getSize());
  Eigen::MatrixXd k(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j < size; ++j) {
      const auto row = static_cast<OT::UnsignedInteger>(i);
      k(i, j) =
          discretised(row, static_cast<OT::UnsignedInteger>(j)) + (i == j ? variance[row] : 0.0);
    }
  }
  return k;
}

Candidate fit_candidate(const OT::Sample& inputs,
                        const Eigen::VectorXd& values,
                        const OT::Point& variance,
                        double amplitude) {
  const OT::UnsignedInteger n = inputs.getSize();
  const OT::UnsignedInteger dimension = inputs.getDimension();
  OT::Sample outputs(n, 1);
  for (OT::UnsignedInteger i = 0; i < n; ++i) outputs(i, 0) = values(static_cast<Eigen::Index>(i));
  const OT::MaternModel model(OT::Point(dimension, 0.5), OT::Point(1, amplitude), 2.5);
  OT::KrigingAlgorithm kriging(inputs, outputs, model, OT::ConstantBasisFactory(dimension).build());
  kriging.setNoise(variance);
  // Lengths from a twentieth of the range (below that a value tells nothing of its neighbours) to
  // ten times the range.
  kriging.setOptimizationBounds(
      OT::Interval(OT::Point(dimension, 0.05), OT::Point(dimension, 10.0)));
  kriging.run();

  Candidate candidate;
  candidate.covariance = kriging.getResult().getCovarianceModel();
  const Eigen::LDLT<Eigen::MatrixXd> factors =
      covariance_of(candidate.covariance, inputs, variance).ldlt();
  const auto size = static_cast<Eigen::Index>(n);
  candidate.inverse = factors.solve(Eigen::MatrixXd::Identity(size, size));
  candidate.trend = candidate.inverse.colwise().sum() / candidate.inverse.sum();
  // log p = -1/2 (r' K^-1 r + log |K|) + constant, r the values less their trend (Rasmussen and
  // Williams 2006, eq 2.30)
  const Eigen::VectorXd residual = values.array() - candidate.trend.dot(values);
  candidate.log_likelihood = -0.5 * (residual.dot(candidate.inverse * residual) +
                                     factors.vectorD().array().abs().log().sum());
  return candidate;
}

}  // namespace

Surrogate::Surrogate(std::vector<UnitPoint> points,
                     std::span<const double> values,
                     std::span<const double> noise)
    : fit_(std::make_unique<Fit>()) {
  fit_->points = std::move(points);
  fit_->values =
      Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  OT::Log::Show(OT::Log::NONE);  // its remarks on bounds would land in the user's terminal
  const OT::Sample inputs = sample_of(fit_->points);
  const double spread = std::max(value_spread(), 1.0e-6);
  // Between neighbouring parameters the objective jumps by more than its seeds tell, because
  // particles take another turn. That roughness is one more independent error of each value; its
  // size is the likeliest of a few.
  constexpr std::array<double, 6> roughness = {
      0.0, 0.03, 0.06, 0.12, 0.25, 0.5};      // of the values' spread
  constexpr double worth_a_roughness = 1.92;  // chi-squared(0.95, 1) / 2: else there is none
  bool is_first = true;
  double best = 0.0;
  for (const double share : roughness) {
    OT::Point variance(noise.size());
    for (std::size_t i = 0; i < noise.size(); ++i)
      variance[i] = noise[i] * noise[i] + std::pow(share * spread, 2);
    Candidate candidate = fit_candidate(inputs, fit_->values, variance, spread);
    const double likelihood = candidate.log_likelihood - (share > 0.0 ? worth_a_roughness : 0.0);
    if (!is_first && !(likelihood > best)) continue;
    is_first = false;
    best = likelihood;
    fit_->covariance = candidate.covariance;
    fit_->inverse = std::move(candidate.inverse);
    fit_->trend = std::move(candidate.trend);
    fit_->roughness = share * spread;
  }
}

Surrogate::Surrogate(std::unique_ptr<Fit> fit) : fit_(std::move(fit)) {}
Surrogate::~Surrogate() = default;
Surrogate::Surrogate(Surrogate&&) noexcept = default;

std::vector<Surrogate::Prediction> Surrogate::predict_own(std::span<const UnitPoint> places) const {
  const auto n = static_cast<Eigen::Index>(fit_->points.size());
  const auto m = static_cast<Eigen::Index>(places.size());
  const OT::Matrix cross =
      fit_->covariance.computeCrossCovariance(sample_of(places), sample_of(fit_->points));
  Eigen::MatrixXd c(m, n);
  for (Eigen::Index i = 0; i < m; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      c(i, j) = cross(static_cast<OT::UnsignedInteger>(i), static_cast<OT::UnsignedInteger>(j));
    }
  }
  // mean = mu + c K^-1 (y - mu),  variance = C(0) - c K^-1 c' + (1 - c K^-1 1)^2 / (1' K^-1 1)
  // (ordinary Kriging; Rasmussen and Williams 2006, eqs 2.25-2.26 and 2.42)
  const double mu = fit_->trend.dot(fit_->values);
  const Eigen::MatrixXd gain = c * fit_->inverse;
  const Eigen::VectorXd mean = (gain * (fit_->values.array() - mu).matrix()).array() + mu;
  const OT::Point origin(fit_->points.front().size(), 0.0);
  const double prior = fit_->covariance.computeAsScalar(origin, origin);
  std::vector<Prediction> predictions(places.size());
  for (Eigen::Index i = 0; i < m; ++i) {
    const double rest = 1.0 - gain.row(i).sum();
    const double variance = prior - gain.row(i).dot(c.row(i)) + rest * rest / fit_->inverse.sum();
    predictions[static_cast<std::size_t>(i)] = {mean(i), std::sqrt(std::max(0.0, variance))};
  }
  return predictions;
}

std::vector<Surrogate::Prediction> Surrogate::predict(std::span<const UnitPoint> places) const {
  std::vector<Prediction> predictions = predict_own(places);
  if (!fit_->known) return predictions;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double own = std::exp(predictions[i].mean);
    const double both = own + fit_->known(places[i]);
    predictions[i] = {std::log(both), predictions[i].standard_deviation * own / both};
  }
  return predictions;
}

Surrogate Surrogate::plus(std::function<double(const UnitPoint&)> known) const {
  auto fit = std::make_unique<Fit>(*fit_);
  fit->known = std::move(known);
  return Surrogate(std::move(fit));
}

double Surrogate::roughness() const { return fit_->roughness; }

double Surrogate::leave_one_out_error() const {
  // e_i = [K^-1 (y - mu)]_i / [K^-1]_ii, Dubrule (1983), with the trend held.
  const double mean = fit_->trend.dot(fit_->values);
  const Eigen::VectorXd residual =
      (fit_->inverse * (fit_->values.array() - mean).matrix()).array() /
      fit_->inverse.diagonal().array();
  return std::sqrt(residual.squaredNorm() / static_cast<double>(residual.size()));
}

double Surrogate::value_spread() const {
  const Eigen::ArrayXd centred = fit_->values.array() - fit_->values.mean();
  return std::sqrt(centred.square().sum() /
                   std::max<double>(1.0, static_cast<double>(centred.size() - 1)));
}

}  // namespace graintruth::calibrate
