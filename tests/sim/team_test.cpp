// Every task once, whatever threads do: the bits of a simulation rest on it.
#include "sim/engine/team.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <numeric>
#include <thread>
#include <vector>

namespace graintruth::sim {
namespace {

class TeamOf : public testing::TestWithParam<int> {};

TEST_P(TeamOf, DoesEveryTaskOfEveryRoundOnce) {
  Team team(GetParam());
  constexpr int kRounds = 20000, kMostTasks = 40;
  std::vector<int> done(kMostTasks);
  for (int round = 0; round < kRounds; ++round) {
    const int count = round % (kMostTasks + 1);
    std::fill(done.begin(), done.end(), 0);
    // A plain int: two workers on one task, or a round that ends too soon, is a race that the sums
    // below show
    team.run(count, [&](int worker, int i) {
      ASSERT_LT(worker, GetParam());
      done[static_cast<std::size_t>(i)] += round + 1;
    });
    for (int i = 0; i < kMostTasks; ++i)
      ASSERT_EQ(done[static_cast<std::size_t>(i)], i < count ? round + 1 : 0) << round;
  }
}

// More threads than any machine of ours has cores: most of them are late for most rounds.
INSTANTIATE_TEST_SUITE_P(Workers, TeamOf, testing::Values(1, 2, 3, 16));

TEST(Team, WakesAfterAPause) {
  Team team(3);
  for (int round = 0; round < 5; ++round) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // long enough to fall asleep
    std::array<int, 100> done{};
    team.run(100, [&](int, int i) { ++done[static_cast<std::size_t>(i)]; });
    EXPECT_EQ(std::accumulate(done.begin(), done.end(), 0), 100);
  }
}

}  // namespace
}  // namespace graintruth::sim
