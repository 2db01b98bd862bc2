#include "calibrate/compare/hypothesis_tests.h"

#include <algorithm>
#include <array>
#include <boost/math/distributions/students_t.hpp>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

namespace graintruth::calibrate {

namespace {

TTest test_of(double difference, double standard_error, double freedom) {
  TTest test;
  test.difference = difference;
  test.standard_error = standard_error;
  test.freedom = freedom;
  test.t = difference / standard_error;
  const boost::math::students_t distribution(freedom);
  test.p = 2.0 * boost::math::cdf(boost::math::complement(distribution, std::abs(test.t)));
  const double reach = boost::math::quantile(distribution, 0.975) * standard_error;
  test.lower = difference - reach;
  test.upper = difference + reach;
  return test;
}

}  // namespace

SampleSummary summarise(std::span<const double> values) {
  SampleSummary summary;
  summary.count = static_cast<int>(values.size());
  for (double value : values) summary.mean += value / summary.count;
  double square = 0.0;
  for (double value : values) square += (value - summary.mean) * (value - summary.mean);
  summary.standard_deviation = std::sqrt(square / (summary.count - 1));
  return summary;
}

double student_t_quantile(double probability, double freedom) {
  return boost::math::quantile(boost::math::students_t(freedom), probability);
}

double satterthwaite_freedom(std::span<const VarianceComponent> components) {
  double sum = 0.0, of_estimates = 0.0;
  for (const auto& [variance, freedom] : components) {
    sum += variance;
    of_estimates += variance * variance / freedom;
  }
  return of_estimates > 0.0 ? sum * sum / of_estimates : std::numeric_limits<double>::infinity();
}

double half_width_95(std::span<const VarianceComponent> components) {
  double sum = 0.0;
  for (const VarianceComponent& component : components) sum += component.variance;
  if (!(sum > 0.0)) return 0.0;
  double half_width = student_t_quantile(0.975, satterthwaite_freedom(components)) * std::sqrt(sum);
  for (const auto& [variance, freedom] : components) {
    if (variance > 0.0)
      half_width = std::max(half_width, student_t_quantile(0.975, freedom) * std::sqrt(variance));
  }
  return half_width;
}

// Variances of the means, s^2 / n, of n - 1 degrees of freedom
TTest welch_test(const SampleSummary& first, const SampleSummary& second) {
  const auto of_mean = [](const SampleSummary& sample) {
    return VarianceComponent{std::pow(sample.standard_deviation, 2) / sample.count,
                             sample.count - 1.0};
  };
  const std::array<VarianceComponent, 2> means = {of_mean(first), of_mean(second)};
  return test_of(first.mean - second.mean,
                 std::sqrt(means[0].variance + means[1].variance),
                 satterthwaite_freedom(means));
}

TTest pooled_test(const SampleSummary& first, const SampleSummary& second) {
  const double freedom = first.count + second.count - 2.0;
  const double variance = ((first.count - 1) * std::pow(first.standard_deviation, 2) +
                           (second.count - 1) * std::pow(second.standard_deviation, 2)) /
                          freedom;
  return test_of(first.mean - second.mean,
                 std::sqrt(variance * (1.0 / first.count + 1.0 / second.count)),
                 freedom);
}

TTest paired_test(std::span<const double> first, std::span<const double> second) {
  assert(first.size() == second.size());
  std::vector<double> differences(first.size());
  std::transform(
      first.begin(), first.end(), second.begin(), differences.begin(), std::minus<double>());
  const SampleSummary summary = summarise(differences);
  return test_of(
      summary.mean, summary.standard_deviation / std::sqrt(summary.count), summary.count - 1.0);
}

EquivalenceTest equivalence_test(const TTest& test, double margin) {
  const boost::math::students_t distribution(test.freedom);
  const double above =
      boost::math::cdf(distribution, (test.difference - margin) / test.standard_error);
  const double below = boost::math::cdf(
      boost::math::complement(distribution, (test.difference + margin) / test.standard_error));
  const double p = std::max(above, below);
  return {margin, p, p < 0.05};
}

}  // namespace graintruth::calibrate
