// What is read off outlines of closed forms.
#include "calibrate/observables/bed_profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <numbers>

#include "calibrate/observables/observable.h"
#include "datasets/store/table.h"

namespace graintruth::calibrate {

extern const ObservableKind free_surface_kind, angle_of_repose_kind, final_height_kind,
    bed_area_kind, run_out_kind;

namespace {

constexpr double grain = 0.004;  // m
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Situation situation() {
  Situation made;
  made.particle.diameter = grain;
  datasets::SeenOutline& seen = made.rig.seen_outline.emplace();
  seen.from_x = -0.08;
  seen.to_x = 0.08;
  seen.mover = datasets::SeenOutline::Mover{
      .name = "tube", .drawing = {{-0.025, 0.0}, {0.025, 0.0}, {0.025, 0.08}, {-0.025, 0.08}}};
  return made;
}

// The surface at every x of narrow columns; nothing where it is not above the floor.
datasets::Outline outline_of(const std::function<double(double)>& surface, double width = 0.0005) {
  datasets::Outline made;
  made.time = {1.0};
  for (int i = 0; i < static_cast<int>(0.16 / width); ++i) {
    made.column.push_back(-0.08 + (i + 0.5) * width);
    const double z = surface(made.column.back());
    made.height.push_back(z > 0.0 ? z : nan);
  }
  return made;
}

// Slopes of 20 degrees on the left and 30 on the right.
double two_slopes(double x) {
  const double angle = (x < 0.0 ? 20.0 : 30.0) * std::numbers::pi / 180.0;
  return 0.025 - std::abs(x) * std::tan(angle);
}

// Slopes that rise from an opening in the middle to walls at both sides, and a heap below.
TEST(BedProfile, HasTheShearAngleOfABedThatStaysAboveAndTheAreaOfTheHeapBelow) {
  Situation both = situation();
  both.rig.seen_outline->mover.reset();
  both.rig.seen_outline->surfaces = {
      {.name = "upper", .from_x = -0.08, .to_x = 0.08, .floor_z = 0.0},
      {.name = "lower", .from_x = -0.08, .to_x = 0.08, .floor_z = -0.1, .top_z = -0.01}};
  const auto rising = [](double x) {
    const double angle = (x < 0.0 ? 30.0 : 40.0) * std::numbers::pi / 180.0;
    return (std::abs(x) - 0.01) * std::tan(angle);
  };
  datasets::Recording recording;
  recording.outlines = {outline_of(rising), outline_of(two_slopes)};
  recording.outlines[0].surface = "upper";
  recording.outlines[1].surface = "lower";
  for (double& z : recording.outlines[1].height) z -= 0.1;
  const auto upper = profile_at_rest(recording, both, "upper");
  const auto lower = profile_at_rest(recording, both, "lower");
  ASSERT_TRUE(upper && lower);
  EXPECT_NEAR(slope_of(*upper, Side::left, both)->angle, 30.0 * std::numbers::pi / 180.0, 1e-9);
  EXPECT_NEAR(slope_of(*upper, Side::right, both)->angle, 40.0 * std::numbers::pi / 180.0, 1e-9);
  EXPECT_NEAR(flank_of(*lower, Side::left, both)->angle, 20.0 * std::numbers::pi / 180.0, 1e-9);
  // A triangle, to what the columns at its feet are worth
  const double base = 0.025 / std::tan(20.0 * std::numbers::pi / 180.0) +
                      0.025 / std::tan(30.0 * std::numbers::pi / 180.0);
  datasets::Experiment experiment;
  experiment.rig = both.rig;
  const Channel area =
      bed_area_kind.make_of_surface(experiment, "lower")->measure(recording, both, nullptr);
  ASSERT_EQ(area.values.size(), 1U);
  EXPECT_NEAR(area.values.front(), 0.5 * 0.025 * base, 1e-5);
}

TEST(BedProfile, HasTheAngleOfEachSlope) {
  const BedProfile profile = profile_at(outline_of(two_slopes), 0, situation());
  const auto left = flank_of(profile, Side::left, situation());
  const auto right = flank_of(profile, Side::right, situation());
  ASSERT_TRUE(left && right);
  EXPECT_NEAR(left->angle, 20.0 * std::numbers::pi / 180.0, 1e-9);
  EXPECT_NEAR(right->angle, 30.0 * std::numbers::pi / 180.0, 1e-9);
  EXPECT_NEAR(right->standard_error, 0.0, 1e-9);
  // From 80 to 20 % of the height of the highest column, from the first middle on that is there
  const double height = 0.025 - 0.25 * grain * std::tan(20.0 * std::numbers::pi / 180.0);
  const double first = (0.025 - 0.8 * height) / std::tan(std::numbers::pi / 6.0);
  const double last = (0.025 - 0.2 * height) / std::tan(std::numbers::pi / 6.0);
  EXPECT_GE(right->from_x, first);
  EXPECT_LT(right->from_x, first + 0.5 * grain);
  EXPECT_LE(right->to_x, last);
  EXPECT_GT(right->to_x, last - 0.5 * grain);
}

// Roughness of a grain's length, up and down by h: the error of the slope is that of a line through
// n/2 independent places.
TEST(BedProfile, CountsColumnsOfOneGrainOnceInTheErrorOfTheAngle) {
  const double h = 0.001;
  const auto rough = [&](double x) {
    const auto number = static_cast<long>(std::floor((x + 1.0) / grain));
    return two_slopes(x) + (number % 2 == 0 ? h : -h);
  };
  const auto flank =
      flank_of(profile_at(outline_of(rough), 0, situation()), Side::left, situation());
  ASSERT_TRUE(flank);
  const double length = flank->to_x - flank->from_x;
  const double places = std::abs(length) / grain + 0.5;
  const double spread = std::abs(length) / std::sqrt(12.0);
  const double expected =
      h / (spread * std::sqrt(places)) * std::pow(std::cos(20.0 * std::numbers::pi / 180.0), 2);
  EXPECT_NEAR(flank->roughness, h, 0.2 * h);
  EXPECT_NEAR(flank->standard_error, expected, 0.25 * expected);
}

TEST(BedProfile, EndsWhereItFallsBelowOneGrain) {
  const BedProfile profile = profile_at(outline_of(two_slopes), 0, situation());
  const double reach = 0.025 - grain;
  EXPECT_NEAR(foot_of(profile, Side::left, situation()),
              -reach / std::tan(20.0 * std::numbers::pi / 180.0),
              1e-4);
  EXPECT_NEAR(foot_of(profile, Side::right, situation()),
              reach / std::tan(30.0 * std::numbers::pi / 180.0),
              1e-4);
}

TEST(BedProfile, FirstStandsInTheTube) { EXPECT_EQ(first_width(situation()), 0.05); }

TEST(BedProfile, TakesNothingForFloorBesideALowBedAndForHiddenBetweenHighPlaces) {
  const auto holes = [](double x) {
    if (std::abs(x - 0.01) < 0.003) return -1.0;    // in the flank
    if (std::abs(x + 0.075) < 0.002) return 0.004;  // a lone grain
    return two_slopes(x);
  };
  const BedProfile profile = profile_at(outline_of(holes), 0, situation());
  const auto at = [&](double x) {
    return profile.z[static_cast<std::size_t>((x - profile.x[0]) / (0.5 * grain) + 0.5)];
  };
  EXPECT_TRUE(std::isnan(at(0.011)));
  EXPECT_EQ(at(0.07), 0.0);
  EXPECT_EQ(at(-0.071), 0.0);
  EXPECT_NEAR(at(-0.075), 0.004, 1e-9);
  EXPECT_TRUE(std::isnan(foot_of(profile, Side::right, situation())));
}

TEST(BedProfile, IsTheSameOfCoarserColumns) {
  const BedProfile fine = profile_at(outline_of(two_slopes), 0, situation());
  const BedProfile coarse = profile_at(outline_of(two_slopes, 0.004), 0, situation());
  const BedProfile own = profile_at(outline_of(two_slopes, 0.002), 0, situation());
  for (std::size_t i = 0; i < fine.x.size(); ++i) {
    if (std::abs(fine.x[i]) < 0.003 || fine.z[i] < grain || coarse.z[i] < grain) continue;
    EXPECT_NEAR(coarse.z[i], fine.z[i], 1e-9) << fine.x[i];
    EXPECT_NEAR(own.z[i], fine.z[i], 1e-9) << fine.x[i];
  }
}

TEST(BedProfile, OfNothingSeenIsNothing) {
  const BedProfile profile = profile_at(outline_of([](double) { return 0.0; }), 0, situation());
  EXPECT_FALSE(apex_of(profile));
  EXPECT_FALSE(flank_of(profile, Side::left, situation()));
}

// Without friction a bed spreads until nothing of it is seen, or no flank is left. A film that does
// not tell has nothing to compare; a simulation is compared all the same.
TEST(BedProfile, OfASimulationThatDoesNotTellIsThatOfAnEmptyFloor) {
  datasets::Experiment experiment;
  experiment.rig = situation().rig;
  datasets::Recording heap, nothing;
  heap.outlines = {outline_of(two_slopes)};
  nothing.outlines = {outline_of([](double) { return 0.0; })};
  for (const ObservableKind* kind :
       {&free_surface_kind, &angle_of_repose_kind, &final_height_kind, &run_out_kind}) {
    const auto observable = kind->make(experiment, nullptr);
    const Channel like = observable->measure(heap, situation());
    ASSERT_TRUE(like.is_known()) << kind->name;
    EXPECT_FALSE(observable->measure(nothing, situation()).is_known()) << kind->name;
    EXPECT_EQ(observable->measure(nothing, situation(), &like).values,
              std::vector<double>(like.values.size(), 0.0))
        << kind->name;
  }
}

// The profiles of three heaps of another program, and the angles that it reads off them at a
// quarter of our columns' width.
TEST(BedProfile, HasTheAnglesThatOthersReadOffTheirHeaps) {
  const auto folder =
      std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "../shared/lab-videos/heap/truth";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the lab videos are not here";
  constexpr double degree = std::numbers::pi / 180.0;
  const double angles[3][2] = {{21.623, 24.546}, {25.253, 23.832}, {23.937, 26.930}};
  double off = 0.0;
  for (int replicate = 1; replicate <= 3; ++replicate) {
    const datasets::Table table =
        datasets::read_csv(folder / ("heap_rep" + std::to_string(replicate) + "_profile.csv"));
    datasets::Outline outline;
    outline.time = {3.0};
    outline.column = table.numbers("x_m");
    for (const double z : table.numbers("z_m")) outline.height.push_back(z > 0.0 ? z : nan);
    const BedProfile profile = profile_at(outline, 0, situation());
    for (const Side side : {Side::left, Side::right}) {
      const auto flank = flank_of(profile, side, situation());
      ASSERT_TRUE(flank);
      const double truth = degree * angles[replicate - 1][side == Side::left ? 0 : 1];
      EXPECT_LT(std::abs(flank->angle - truth), flank->standard_error);
      off += (flank->angle - truth) / 6.0;
    }
  }
  EXPECT_LT(std::abs(off), 0.5 * degree);
}

}  // namespace
}  // namespace graintruth::calibrate
