#include "calibrate/hypothesis_tests.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cassert>
#include <cmath>
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

// nu = (v1 + v2)^2 / (v1^2 / (n1 - 1) + v2^2 / (n2 - 1)),  v = s^2 / n
TTest welch_test(const SampleSummary& first, const SampleSummary& second) {
  const double one = first.standard_deviation * first.standard_deviation / first.count;
  const double two = second.standard_deviation * second.standard_deviation / second.count;
  const double freedom =
      (one + two) * (one + two) / (one * one / (first.count - 1) + two * two / (second.count - 1));
  return test_of(first.mean - second.mean, std::sqrt(one + two), freedom);
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
