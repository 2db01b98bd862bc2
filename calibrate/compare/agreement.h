// The thesis's degree of agreement (section 4.2.3, eqs 4.2-4.3, Table 4.2): how many of x, z and
// angle of the simulation lie inside the replicates' interval, per particle and frame; and what
// such a score can be at best.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "calibrate/compare/weighted_means.h"

namespace graintruth::calibrate {

// Half width of the 95 % interval of the mean, in units of s / sqrt(n): the thesis's 1.96, or
// Student's t(0.975, n - 1), which is what "95 %" asks for when s comes from n values.
enum class Critical { thesis_196, student_t };
double critical_value(Critical critical, int replicates);

// A row of Table 4.2.
struct ParticleAgreement {
  int particle = 0;                        // from 1
  std::array<int, 4> frames_of_rank = {};  // frames in which 0, 1, 2, 3 quantities lie inside
  int points = 0;                          // eq 4.3: sum of rank x frames
  int possible = 0;      // points to be had: one a quantity that was measured, and frame
  double percent = 0.0;  // points of those possible
};

struct Agreement {
  double percent = 0.0;  // interval tests passed, of all that could be made
  std::vector<ParticleAgreement> per_particle;
  std::vector<int> ranks;  // 0..3, moment after moment; -1 where the body was not measured
};

// Eq 4.3 and its percentage for given counts of frames at each rank, where all three quantities
// were measured in every frame.
ParticleAgreement score_ranks(int particle, const std::array<int, 4>& frames_of_rank);

// Ranks the values of `simulated` against mean +- critical s / sqrt(n) of the replicates, body by
// body: a body has as many quantities as the shape tells differences of. Moments before
// `first_moment` are left out (the first one's spread is only that of placing). No floor under the
// interval: this is eq 4.2 as it stands.
Agreement agreement(std::span<const Spread> replicates,
                    const ChannelShape& shape,
                    const std::vector<double>& simulated,
                    Critical critical,
                    std::size_t first_moment = 0);
// Its percentage alone.
double percent_of_tests_passed(std::span<const Spread> replicates,
                               const ChannelShape& shape,
                               const std::vector<double>& simulated,
                               Critical critical);

// Expected percentage for a perfect model averaged over `runs` runs, with n replicates (runs = 0:
// the true mean). The difference of the two means over s / sqrt(n) is sqrt(1 + n / runs) times
// Student's t with n - 1 degrees of freedom.
double ceiling_percent(int replicates, int runs, Critical critical);

// Mean score of each replicate against the interval of the others: what a repeat of the experiment
// itself scores. NaN with fewer than three replicates.
double leave_one_out_percent(std::span<const Channel* const> replicates,
                             const ChannelShape& shape,
                             Critical critical);

}  // namespace graintruth::calibrate
