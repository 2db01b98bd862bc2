#include "calibrate/compare/agreement.h"

#include <gtest/gtest.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cmath>

#include "calibrate/observables/track_results.h"

namespace graintruth::calibrate {
namespace {

// Independent normal values about 0: `repeats` tracks of frames x particles.
std::vector<Channel> normal_repeats(int repeats, int frames, int particles, std::uint64_t seed) {
  boost::random::mt19937_64 generator(seed);
  boost::random::normal_distribution<double> normal(0.0, 0.01);
  std::vector<Channel> all(static_cast<std::size_t>(repeats));
  for (Channel& channel : all) {
    channel.values.resize(static_cast<std::size_t>(3 * frames * particles));
    for (double& value : channel.values) value = normal(generator);
  }
  return all;
}

std::vector<double> mean_of(const std::vector<Channel>& repeats, const ChannelShape& shape) {
  return WeightedMeans(pointers_to(repeats), shape).mean();
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
    const ChannelShape shape = shape_of_tracks(100);
    const double drawn = percent_of_tests_passed(
        spreads_of(pointers_to(replicates), shape), shape, mean_of(runs, shape), critical);
    // 60000 independent tests: standard error 0.16 %.
    EXPECT_NEAR(drawn, ceiling_percent(5, 10, critical), 0.6);
  }
}

TEST(LeaveOneOut, IsTheScoreOfASingleRunAgainstFour) {
  const auto percent = [](const std::vector<Channel>& replicates, std::size_t particles) {
    return leave_one_out_percent(
        pointers_to(replicates), shape_of_tracks(particles), Critical::thesis_196);
  };
  EXPECT_NEAR(percent(normal_repeats(5, 200, 100, 3), 100),
              ceiling_percent(4, 1, Critical::thesis_196),
              0.6);
  EXPECT_TRUE(std::isnan(percent(normal_repeats(2, 2, 2, 4), 2)));
}

TEST(Agreement, RanksCountQuantitiesInsideTheInterval) {
  const ChannelShape shape = shape_of_tracks(1);
  std::vector<Channel> replicates;
  for (const double offset : {-1.0, 0.0, 1.0})
    replicates.push_back({.values = {offset, offset, 0.1 * offset}});
  // Half widths: 1.96 / sqrt(3) = 1.1316 for x and z, 0.11316 for the angle.
  const auto rank = [&](double x, double z, double angle) {
    return agreement(spreads_of(pointers_to(replicates), shape),
                     shape,
                     {x, z, angle},
                     Critical::thesis_196)
        .ranks[0];
  };
  EXPECT_EQ(rank(0, 0, 0), 3);
  EXPECT_EQ(rank(1.13, -1.13, 0.113), 3);
  EXPECT_EQ(rank(1.14, 0, 0), 2);
  EXPECT_EQ(rank(1.14, -1.14, 0.114), 0);
  EXPECT_EQ(rank(0, 0, 3.14159265358979), 3);  // half a turn looks the same
}

TEST(Agreement, AParticleThatTheModelLostScoresNothing) {
  const auto replicates = normal_repeats(5, 4, 2, 5);
  const ChannelShape shape = shape_of_tracks(2);
  const std::vector<double> lost(24, std::nan(""));
  EXPECT_EQ(agreement(spreads_of(pointers_to(replicates), shape), shape, lost, Critical::student_t)
                .percent,
            0.0);
}

TEST(Agreement, TheFirstFrameCanBeLeftOut) {
  const auto replicates = normal_repeats(5, 2, 3, 6);
  const ChannelShape shape = shape_of_tracks(3);
  std::vector<double> simulated = mean_of(replicates, shape);
  for (std::size_t i = 0; i < 9; ++i) simulated[i] = i % 3 == 2 ? 0.8 : 9.0;
  const auto percent = [&](std::size_t first_frame) {
    return agreement(spreads_of(pointers_to(replicates), shape),
                     shape,
                     simulated,
                     Critical::student_t,
                     first_frame)
        .percent;
  };
  EXPECT_EQ(percent(1), 100.0);
  EXPECT_LT(percent(0), 70.0);
}

}  // namespace
}  // namespace graintruth::calibrate
