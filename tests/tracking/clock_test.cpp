#include "tracking/film/clock.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <random>

namespace graintruth::tracking {
namespace {

constexpr double pixel = 1.0e-3;  // m
constexpr int particles = 8, frames = 60;

// Where particle p is at an instant, counted in frames: some at rest, some pushed, some falling
// from an instant of their own and stopped by the floor.
datasets::Pose place(int particle, double instant) {
  const double x = 0.05 * particle;
  if (particle < 2) return {x, 0.0, 0.0};
  if (particle < 5) return {x + 1.2e-3 * instant, 0.1 - 0.4e-3 * particle * instant, 0.0};
  const double falling = std::max(0.0, instant - 8.0 - 2.0 * particle);
  return {x, std::max(0.0, 0.3 - 0.5 * 0.4e-3 * falling * falling), 0.0};
}

datasets::Trajectories filmed_at(const std::vector<double>& instants) {
  datasets::Trajectories tracks = datasets::make_trajectories(instants.size(), particles, true);
  std::mt19937 generator(5);
  std::normal_distribution<double> noise(0.0, 0.05 * pixel);
  for (std::size_t k = 0; k < instants.size(); ++k) {
    tracks.time[k] = static_cast<double>(k);
    for (int p = 0; p < particles; ++p) {
      datasets::Pose pose = place(p, instants[k]);
      pose.x += noise(generator);
      pose.z += noise(generator);
      tracks.poses[tracks.index(k, static_cast<std::size_t>(p))] = pose;
    }
  }
  return tracks;
}

// As the pictures taken at these instants would change: all that moves adds its part, above what
// the camera's noise does.
PictureClock clock_of(const std::vector<double>& instants) {
  constexpr double noise = 0.4, a_metre = 100.0;  // grey levels
  PictureClock clock;
  for (std::size_t k = 0; k < instants.size(); ++k) {
    clock.moments.push_back(static_cast<double>(k));
    double change = noise;
    for (int p = 0; p < particles && k > 0; ++p) {
      const datasets::Pose before = place(p, instants[k - 1]), now = place(p, instants[k]);
      change += a_metre * std::hypot(now.x - before.x, now.z - before.z);
    }
    clock.changes.push_back(k > 0 && instants[k] == instants[k - 1] ? 0.0 : change);
  }
  return clock;
}

ClockFaults faults_of(const std::vector<double>& instants) {
  return find_clock_faults(filmed_at(instants), pixel, clock_of(instants));
}

std::vector<double> even() {
  std::vector<double> instants;
  for (int k = 0; k < frames; ++k) instants.push_back(k);
  return instants;
}

TEST(Clock, FindsNothingInAnEvenFilm) {
  const ClockFaults faults = faults_of(even());
  EXPECT_TRUE(faults.repeated.empty());
  EXPECT_TRUE(faults.jumps.empty());
  EXPECT_TRUE(describe(faults, {}).empty());
}

RC_GTEST_PROP(Clock, FindsAPictureThatIsMissing, ()) {
  const int at = *rc::gen::inRange(4, frames - 4);
  std::vector<double> instants = even();
  instants.erase(instants.begin() + at);
  const ClockFaults faults = faults_of(instants);
  RC_ASSERT(faults.jumps == std::vector<int>{at});
  RC_ASSERT(faults.repeated.empty());
  RC_ASSERT(describe(faults, {}).size() == 1U);
}

RC_GTEST_PROP(Clock, FindsAPictureThatIsShownAgain, ()) {
  const int at = *rc::gen::inRange(4, frames - 4);
  std::vector<double> instants = even();
  const bool instead_of_another = *rc::gen::arbitrary<bool>();
  if (instead_of_another)
    instants[static_cast<std::size_t>(at)] -= 1.0;
  else
    instants.insert(instants.begin() + at, instants[static_cast<std::size_t>(at - 1)]);
  const ClockFaults faults = faults_of(instants);
  RC_ASSERT(faults.repeated == std::vector<int>{at});
  RC_ASSERT(faults.jumps.empty());
  RC_ASSERT(describe(faults, {}).size() == 1U);
  RC_ASSERT(describe(faults, {at}).empty());  // the reader told already
}

// A bed that slips all at once moves as if a picture were missing, and so does one whose places are
// found badly; where stamps or pictures say otherwise nothing is told.
TEST(Clock, TellsNothingWhereOneOfTheThreeWitnessesDisagrees) {
  constexpr int at = 20;
  std::vector<double> instants = even();
  instants.erase(instants.begin() + at);
  const datasets::Trajectories tracks = filmed_at(instants);
  const PictureClock clock = clock_of(instants);
  const auto jumps = [&](const PictureClock& told) {
    return find_clock_faults(tracks, pixel, told).jumps;
  };
  ASSERT_EQ(jumps(clock), std::vector<int>{at});
  // 1. The clock counts what is missing, or each picture has its own stamp
  PictureClock counting = clock, stamped = clock;
  for (std::size_t k = at; k < counting.moments.size(); ++k) counting.moments[k] += 1.0;
  EXPECT_TRUE(jumps(counting).empty());
  for (double& moment : stamped.moments) moment *= 1.01;
  EXPECT_TRUE(jumps(stamped).empty());
  // 2. The picture shows no more that is new than others
  PictureClock alike = clock;
  alike.changes[at] = alike.changes[at + 1];
  EXPECT_TRUE(jumps(alike).empty());
  // 3. Half of the particles do not move further than before
  datasets::Trajectories halved = tracks;
  for (std::size_t k = at; k < halved.frames(); ++k)
    for (const std::size_t p : {2U, 3U})
      halved.poses[halved.index(k, p)] = tracks.poses[tracks.index(k - 1, p)];
  EXPECT_TRUE(find_clock_faults(halved, pixel, clock).jumps.empty());
  // The same of a picture that nothing moves into, but that is another
  std::vector<double> repeating = even();
  repeating.insert(repeating.begin() + at, repeating[at - 1]);
  PictureClock other = clock_of(repeating);
  EXPECT_EQ(find_clock_faults(filmed_at(repeating), pixel, other).repeated, std::vector<int>{at});
  other.changes[at] = other.changes[at + 1];
  EXPECT_TRUE(find_clock_faults(filmed_at(repeating), pixel, other).repeated.empty());
}

// Compression renews some pictures of a film at rest, and places jump with them. Nothing moves into
// the picture between, which shows nothing new.
TEST(Clock, TakesNoCompressionForARepeatedPicture) {
  constexpr std::size_t between = 8, starts = 30;
  datasets::Trajectories tracks = datasets::make_trajectories(frames, particles, true);
  PictureClock clock;
  double moved = 0.0;
  for (std::size_t k = 0; k < frames; ++k) {
    clock.moments.push_back(static_cast<double>(k));
    clock.changes.push_back(k == between ? 0.03 : 1.1);
    const bool jumps = k == between - 1 || k == between + 1;
    if (jumps || k >= starts) moved += 0.8 * pixel;
    for (std::size_t p = 0; p < particles; ++p)
      tracks.poses[tracks.index(k, p)] = {0.05 * static_cast<double>(p) + moved, moved, 0.0};
  }
  const ClockFaults faults = find_clock_faults(tracks, pixel, clock);
  EXPECT_TRUE(faults.repeated.empty());
  EXPECT_TRUE(faults.jumps.empty());
}

// Places that are found badly jump to and fro; what does not stand out of that is no fault.
TEST(Clock, TellsNothingOfWhatDoesNotStandOutOfTheNoise) {
  std::vector<double> instants = even();
  instants.erase(instants.begin() + 20);
  datasets::Trajectories tracks = filmed_at(instants);
  std::mt19937 generator(8);
  std::normal_distribution<double> noise(0.0, 0.5 * pixel);
  for (datasets::Pose& pose : tracks.poses) {
    pose.x += noise(generator);
    pose.z += noise(generator);
  }
  const ClockFaults faults = find_clock_faults(tracks, pixel, clock_of(instants));
  EXPECT_TRUE(faults.jumps.empty());
  EXPECT_TRUE(faults.repeated.empty());
}

}  // namespace
}  // namespace graintruth::tracking
