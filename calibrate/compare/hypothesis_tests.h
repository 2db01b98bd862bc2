// Comparing two means: Student's t in its three forms, and the test of equivalence. That a t-test
// finds no difference is no evidence that there is none; the interval of the difference, and
// equivalence within a stated margin, are.
#pragma once

#include <span>

namespace graintruth::calibrate {

// Mean and standard deviation (n - 1) of a sample, or as printed in somebody's table.
struct SampleSummary {
  double mean = 0.0;
  double standard_deviation = 0.0;
  int count = 0;
};
SampleSummary summarise(std::span<const double> values);

// Quantile of Student's t with `freedom` degrees of freedom (need not be whole).
double student_t_quantile(double probability, double freedom);

// One source of an error: its variance, and of how many degrees of freedom that is an estimate
// (infinity where it is known).
struct VarianceComponent {
  double variance = 0.0;
  double freedom = 1.0;
};

// Degrees of freedom of the sum of independent errors' variances,
//   nu = (sum v_i)^2 / sum (v_i^2 / nu_i),
// Welch (1947) and Satterthwaite (1946); at least one variance is more than 0.
double satterthwaite_freedom(std::span<const VarianceComponent> components);

// Half width of the 95 % interval of the sum of independent errors,
//   max( t(0.975; nu) sqrt(sum v_i),  t(0.975; nu_i) sqrt(v_i) of each ):
// a sum is known no better than its parts. Satterthwaite's nu alone forgets that where a variance
// of one or two degrees of freedom happens to come out small, as it often does.
double half_width_95(std::span<const VarianceComponent> components);

struct TTest {
  double difference = 0.0;      // of the means, first minus second
  double standard_error = 0.0;  // of the difference
  double t = 0.0;
  double freedom = 0.0;
  double p = 0.0;                   // two-sided
  double lower = 0.0, upper = 0.0;  // 95 % interval of the difference
};

// Welch 1947: unequal variances, freedom after Satterthwaite. The default for two samples.
TTest welch_test(const SampleSummary& first, const SampleSummary& second);
// Student 1908: equal variances.
TTest pooled_test(const SampleSummary& first, const SampleSummary& second);
// Of pairs; both must have the same length.
TTest paired_test(std::span<const double> first, std::span<const double> second);

// Two one-sided tests (Schuirmann 1987): `p` is the chance of seeing means so close if they
// differed by the margin or more; below 0.05 they are equivalent within the margin.
struct EquivalenceTest {
  double margin = 0.0;
  double p = 0.0;
  bool equivalent = false;
};
EquivalenceTest equivalence_test(const TTest& test, double margin);

}  // namespace graintruth::calibrate
