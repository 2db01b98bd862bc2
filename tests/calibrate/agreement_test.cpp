#include "calibrate/agreement.h"

#include <gtest/gtest.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cmath>

namespace graintruth::calibrate {
namespace {

// Independent normal values about 0: `repeats` trajectories of frames x particles.
std::vector<datasets::Trajectories> normal_repeats(int repeats,
                                                   std::size_t frames,
                                                   int particles,
                                                   std::uint64_t seed) {
  boost::random::mt19937_64 generator(seed);
  boost::random::normal_distribution<double> normal(0.0, 0.01);
  std::vector<datasets::Trajectories> all;
  for (int r = 0; r < repeats; ++r) {
    all.push_back(datasets::make_trajectories(frames, particles, false));
    for (datasets::Pose& pose : all.back().poses)
      pose = {normal(generator), normal(generator), normal(generator)};
  }
  return all;
}

TEST(CriticalValue, IsTheThesiss196OrStudents) {
  EXPECT_EQ(critical_value(Critical::thesis_196, 5), 1.96);
  EXPECT_NEAR(critical_value(Critical::student_t, 5), 2.7764451051977987, 1e-12);  // t(0.975, 4)
}

TEST(ScoreRanks, IsEquation43) {
  const ParticleAgreement row = score_ranks(4, {0, 3, 2, 20});
  EXPECT_EQ(row.points, 67);
  EXPECT_NEAR(row.percent, 89.3333, 1e-3);
}

// Errata 5: the score of a perfect model and of a sixth replicate, for n = 5.
TEST(CeilingPercent, HasItsKnownValues) {
  EXPECT_NEAR(ceiling_percent(5, 0, Critical::thesis_196), 87.8445, 1e-3);
  EXPECT_NEAR(ceiling_percent(5, 1, Critical::thesis_196), 53.1559, 1e-3);
  EXPECT_NEAR(ceiling_percent(5, 0, Critical::student_t), 95.0, 1e-9);
  EXPECT_NEAR(ceiling_percent(5, 1, Critical::student_t), 67.9657, 1e-3);
  EXPECT_NEAR(ceiling_percent(5, 10, Critical::thesis_196), 81.5, 0.05);
}

// The same by drawing: means of 10 perfect runs against intervals of 5 replicates, scored by the
// function itself.
TEST(CeilingPercent, AgreesWithMonteCarlo) {
  for (const Critical critical : {Critical::thesis_196, Critical::student_t}) {
    const auto replicates = normal_repeats(5, 200, 100, 1);
    const auto runs = normal_repeats(10, 200, 100, 2);
    const double drawn =
        agreement(measure(replicates), mean_track(measure(runs)), critical).percent;
    // 60000 independent tests: standard error 0.16 %.
    EXPECT_NEAR(drawn, ceiling_percent(5, 10, critical), 0.6);
  }
}

TEST(LeaveOneOut, IsTheScoreOfASingleRunAgainstFour) {
  const auto replicates = normal_repeats(5, 200, 100, 3);
  EXPECT_NEAR(leave_one_out_percent(replicates, Critical::thesis_196),
              ceiling_percent(4, 1, Critical::thesis_196),
              0.6);
  EXPECT_TRUE(std::isnan(leave_one_out_percent(normal_repeats(2, 2, 2, 4), Critical::thesis_196)));
}

TEST(Agreement, RanksCountQuantitiesInsideTheInterval) {
  std::vector<datasets::Trajectories> replicates;
  for (const double offset : {-1.0, 0.0, 1.0}) {
    replicates.push_back(datasets::make_trajectories(1, 1, false));
    replicates.back().poses[0] = {offset, offset, 0.1 * offset};
  }
  // Half widths: 1.96 / sqrt(3) = 1.1316 for x and z, 0.11316 for the angle.
  const auto rank = [&](double x, double z, double angle) {
    datasets::Trajectories simulated = datasets::make_trajectories(1, 1, false);
    simulated.poses[0] = {x, z, angle};
    return agreement(measure(replicates), simulated, Critical::thesis_196).ranks[0];
  };
  EXPECT_EQ(rank(0, 0, 0), 3);
  EXPECT_EQ(rank(1.13, -1.13, 0.113), 3);
  EXPECT_EQ(rank(1.14, 0, 0), 2);
  EXPECT_EQ(rank(1.14, -1.14, 0.114), 0);
  EXPECT_EQ(rank(0, 0, 3.14159265358979), 3);  // half a turn looks the same
}

TEST(Agreement, AParticleThatTheModelLostScoresNothing) {
  const auto replicates = normal_repeats(5, 4, 2, 5);
  datasets::Trajectories lost = datasets::make_trajectories(4, 2, false);
  EXPECT_EQ(agreement(measure(replicates), lost, Critical::student_t).percent, 0.0);
}

TEST(Agreement, TheFirstFrameCanBeLeftOut) {
  const auto replicates = normal_repeats(5, 2, 3, 6);
  datasets::Trajectories simulated = mean_track(measure(replicates));
  for (std::size_t particle = 0; particle < 3; ++particle) simulated.poses[particle] = {9, 9, 0.8};
  EXPECT_EQ(agreement(measure(replicates), simulated, Critical::student_t, 1).percent, 100.0);
  EXPECT_LT(agreement(measure(replicates), simulated, Critical::student_t, 0).percent, 70.0);
}

}  // namespace
}  // namespace graintruth::calibrate
