#include "calibrate/compare/agreement.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

namespace graintruth::calibrate {

namespace {

using StudentT = boost::math::students_t_distribution<double>;

struct Tally {
  int passed = 0;
  int made = 0;
};

// Of one body at one moment, whose first value is `first`.
Tally test_body(std::span<const Spread> spreads,
                const ChannelShape& shape,
                const std::vector<double>& simulated,
                std::size_t first,
                Critical critical) {
  Tally tally;
  for (std::size_t i = first; i < first + shape.difference.size(); ++i) {
    const Spread& spread = spreads[i];
    if (spread.count < 2) continue;
    ++tally.made;
    // |x - mean| <= c s / sqrt(n), eq 4.2
    const double half_width = critical_value(critical, spread.count) * spread.standard_deviation /
                              std::sqrt(spread.count);
    const double value =
        simulated.empty() ? std::numeric_limits<double>::quiet_NaN() : simulated[i];
    if (std::abs(difference(shape.difference_of(i), value, spread.mean)) <= half_width)
      ++tally.passed;
  }
  return tally;
}

double percent_of(int points, int possible) {
  return possible == 0 ? 0.0 : 100.0 * points / possible;
}

}  // namespace

double critical_value(Critical critical, int replicates) {
  if (critical == Critical::thesis_196) return 1.96;
  return boost::math::quantile(StudentT(replicates - 1), 0.975);
}

ParticleAgreement score_ranks(int particle, const std::array<int, 4>& frames_of_rank) {
  ParticleAgreement scored{.particle = particle, .frames_of_rank = frames_of_rank};
  for (int rank = 0; rank < 4; ++rank) {
    scored.points += rank * frames_of_rank[static_cast<std::size_t>(rank)];
    scored.possible += 3 * frames_of_rank[static_cast<std::size_t>(rank)];
  }
  scored.percent = percent_of(scored.points, scored.possible);
  return scored;
}

Agreement agreement(std::span<const Spread> replicates,
                    const ChannelShape& shape,
                    const std::vector<double>& simulated,
                    Critical critical,
                    std::size_t first_moment) {
  Agreement result;
  const std::size_t quantities = shape.difference.size();
  const std::size_t bodies = shape.series / quantities;
  const std::size_t moments = replicates.size() / shape.series;
  result.ranks.assign(moments * bodies, -1);
  Tally total;
  for (std::size_t body = 0; body < bodies; ++body) {
    std::array<int, 4> frames_of_rank = {};
    int possible = 0;
    for (std::size_t moment = first_moment; moment < moments; ++moment) {
      const std::size_t first = moment * shape.series + body * quantities;
      const Tally tally = test_body(replicates, shape, simulated, first, critical);
      if (tally.made == 0) continue;
      total.passed += tally.passed;
      possible += tally.made;
      result.ranks[moment * bodies + body] = tally.passed;
      ++frames_of_rank[static_cast<std::size_t>(tally.passed)];
    }
    ParticleAgreement scored = score_ranks(static_cast<int>(body) + 1, frames_of_rank);
    scored.possible = possible;
    scored.percent = percent_of(scored.points, possible);
    result.per_particle.push_back(scored);
    total.made += possible;
  }
  result.percent = percent_of(total.passed, total.made);
  return result;
}

double percent_of_tests_passed(std::span<const Spread> replicates,
                               const ChannelShape& shape,
                               const std::vector<double>& simulated,
                               Critical critical) {
  return agreement(replicates, shape, simulated, critical).percent;
}

double ceiling_percent(int replicates, int runs, Critical critical) {
  const double spread = runs == 0 ? 1.0 : std::sqrt(1.0 + static_cast<double>(replicates) / runs);
  const double t = critical_value(critical, replicates) / spread;
  return 100.0 *
         (1.0 - 2.0 * boost::math::cdf(boost::math::complement(StudentT(replicates - 1), t)));
}

double leave_one_out_percent(std::span<const Channel* const> replicates,
                             const ChannelShape& shape,
                             Critical critical) {
  if (replicates.size() < 3) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0.0;
  for (std::size_t left_out = 0; left_out < replicates.size(); ++left_out) {
    std::vector<const Channel*> others(replicates.begin(), replicates.end());
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(left_out));
    sum +=
        agreement(spreads_of(others, shape), shape, replicates[left_out]->values, critical).percent;
  }
  return sum / static_cast<double>(replicates.size());
}

}  // namespace graintruth::calibrate
