#include "calibrate/agreement.h"

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

Tally test_pose(const std::array<Spread, 3>& spreads,
                const datasets::Pose& simulated,
                Critical critical) {
  Tally tally;
  for (const Quantity quantity : quantities) {
    const Spread& spread = spreads[static_cast<std::size_t>(quantity)];
    const double value = value_of(simulated, quantity);
    if (spread.count < 2) continue;
    ++tally.made;
    // |x - mean| <= c s / sqrt(n), eq 4.2
    const double half_width = critical_value(critical, spread.count) * spread.standard_deviation /
                              std::sqrt(spread.count);
    if (std::abs(difference(quantity, value, spread.mean)) <= half_width) ++tally.passed;
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

std::vector<Quantity> compared_quantities(const Band& replicates) {
  std::vector<Quantity> compared;
  for (const Quantity quantity : quantities) {
    const bool measured =
        std::any_of(replicates.spreads.begin(), replicates.spreads.end(), [&](const auto& spreads) {
          return spreads[static_cast<std::size_t>(quantity)].count >= 2;
        });
    if (measured) compared.push_back(quantity);
  }
  return compared;
}

Agreement agreement(const Band& replicates,
                    const datasets::Trajectories& simulated,
                    Critical critical,
                    std::size_t first_frame) {
  Agreement result;
  result.ranks.assign(replicates.spreads.size(), -1);
  Tally total;
  for (std::size_t particle = 0; particle < static_cast<std::size_t>(replicates.particles);
       ++particle) {
    std::array<int, 4> frames_of_rank = {};
    int possible = 0;
    for (std::size_t frame = first_frame; frame < replicates.frames(); ++frame) {
      const std::size_t i = replicates.index(frame, particle);
      const Tally tally = test_pose(replicates.spreads[i], simulated.poses[i], critical);
      if (tally.made == 0) continue;
      total.passed += tally.passed;
      possible += tally.made;
      result.ranks[i] = tally.passed;
      ++frames_of_rank[static_cast<std::size_t>(tally.passed)];
    }
    ParticleAgreement scored = score_ranks(static_cast<int>(particle) + 1, frames_of_rank);
    scored.possible = possible;
    scored.percent = percent_of(scored.points, possible);
    result.per_particle.push_back(scored);
    total.made += possible;
  }
  result.percent = percent_of(total.passed, total.made);
  return result;
}

double ceiling_percent(int replicates, int runs, Critical critical) {
  const double spread = runs == 0 ? 1.0 : std::sqrt(1.0 + static_cast<double>(replicates) / runs);
  const double t = critical_value(critical, replicates) / spread;
  return 100.0 *
         (1.0 - 2.0 * boost::math::cdf(boost::math::complement(StudentT(replicates - 1), t)));
}

double leave_one_out_percent(std::span<const datasets::Trajectories> replicates,
                             Critical critical) {
  if (replicates.size() < 3) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0.0;
  for (std::size_t left_out = 0; left_out < replicates.size(); ++left_out) {
    std::vector<datasets::Trajectories> others(replicates.begin(), replicates.end());
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(left_out));
    sum += agreement(measure(others), replicates[left_out], critical).percent;
  }
  return sum / static_cast<double>(replicates.size());
}

}  // namespace graintruth::calibrate
