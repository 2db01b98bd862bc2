// Table 4.2 of the thesis, row by row, from the ranks that it prints.
#include <gtest/gtest.h>

#include "calibrate/compare/agreement.h"
#include "datasets/store/table.h"

namespace graintruth::calibrate {
namespace {

const datasets::Table& printed() {
  static const datasets::Table table =
      datasets::read_csv(GRAINTRUTH_SOURCE_DIR "/datasets/thesis/table_4_2_agreement.csv");
  return table;
}

std::array<int, 4> ranks_of(std::size_t row) {
  std::array<int, 4> ranks = {};
  for (std::size_t rank = 0; rank < 4; ++rank) {
    ranks[rank] = printed().integer(row, "frames_rank" + std::to_string(rank));
  }
  return ranks;
}

class Table42 : public testing::TestWithParam<std::size_t> {};

TEST_P(Table42, PointsAndPercentFollowFromTheRanks) {
  const std::size_t row = GetParam();
  const ParticleAgreement scored =
      score_ranks(printed().integer(row, "particle_no"), ranks_of(row));
  const bool is_misprint = scored.particle == 9;  // errata 3: 62 points, printed 63
  EXPECT_EQ(scored.points + (is_misprint ? 1 : 0),
            printed().integer(row, "weighted_points_printed"));
  if (!is_misprint) {
    EXPECT_NEAR(scored.percent, printed().number(row, "agreement_printed_percent"), 0.05);
  }
}

INSTANTIATE_TEST_SUITE_P(Particle, Table42, testing::Range<std::size_t>(0, 10));

TEST(Table42Total, Is615Of750AndNotThePrinted8213) {
  int points = 0;
  for (std::size_t row = 0; row < printed().rows(); ++row)
    points += score_ranks(0, ranks_of(row)).points;
  EXPECT_EQ(points, 615);
  EXPECT_DOUBLE_EQ(100.0 * points / 750, 82.0);
}

}  // namespace
}  // namespace graintruth::calibrate
