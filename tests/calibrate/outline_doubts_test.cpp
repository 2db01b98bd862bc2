// What outlines show to be wrong, on tables of closed forms; and what is right is not doubted.
#include "calibrate/knowledge/outline_doubts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>

#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

constexpr double grain = 0.004;  // m
constexpr double sigma = 0.05 * grain;
constexpr double width = 0.002;  // m, of columns
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

using Surface = std::function<double(double x, double time)>;

class OutlineDoubts : public testing::Test {
 protected:
  // The template of `graintruth new` with all its tables.
  datasets::Experiment load(const std::string& name) {
    std::ifstream file(GRAINTRUTH_SOURCE_DIR "/app/new/" + name + "/experiment.toml");
    const std::string text(std::istreambuf_iterator<char>(file), {});
    for (const char* table :
         {"heap1", "heap2", "heap3", "collapse1", "collapse2", "slow1", "slow2", "fast1", "fast2"})
      folder_.write(std::string(table) + ".outline.csv", "time_s,column_m,height_m\n");
    return datasets::load_experiment(folder_.write("experiment.toml", text));
  }

  // Of one surface above the floor.
  static datasets::Recording seen(const datasets::Experiment& experiment,
                                  const std::vector<double>& times,
                                  const Surface& surface) {
    datasets::Recording recording;
    datasets::Outline& outline = recording.outlines.emplace_back();
    outline.column = datasets::outline_columns(*experiment.rig.seen_outline, grain);
    outline.time = times;
    for (const double time : times) {
      for (const double x : outline.column) {
        const double z = surface(x, time);
        const bool is_seen = experiment.rig.seen_outline->drum ? std::isfinite(z) : z > 0.0;
        outline.height.push_back(is_seen ? z : nan);
        outline.sigma.push_back(is_seen ? sigma : nan);
      }
    }
    return recording;
  }

  static std::vector<std::string> doubts(const datasets::Experiment& experiment,
                                         const std::vector<datasets::Recording>& recordings) {
    std::vector<std::string> sentences;
    for (const datasets::Warning& doubt : doubts_about_outlines(experiment, recordings)) {
      EXPECT_EQ(doubt.kind, datasets::WarningClass::first_line);
      sentences.push_back(doubt.text);
    }
    return sentences;
  }

  static void expect_one(const std::vector<std::string>& sentences, const std::string& words) {
    ASSERT_EQ(sentences.size(), 1U) << testing::PrintToString(sentences);
    EXPECT_NE(sentences.front().find(words), std::string::npos) << sentences.front();
  }

  tests::TemporaryFolder folder_;
};

double cone(double x) { return 0.018 - 0.4 * std::abs(x); }

// A column of 40 mm beside the left end that falls within 0.4 s to a wedge 100 mm long.
double wedge(double x, double time, double column = 0.04) {
  if (time <= 0.0) return x < column ? 0.03 : 0.0;
  return 0.024 * (1.0 - x / 0.1);
}

TEST_F(OutlineDoubts, AreNoneOfWhatIsRight) {
  const datasets::Experiment heap = load("lifted_cylinder");
  std::vector<datasets::Recording> heaps;
  for (const double aside : {-0.3 * grain, 0.4 * grain, 0.1 * grain})
    heaps.push_back(seen(heap, {1.0}, [&](double x, double) { return cone(x - aside); }));
  EXPECT_EQ(doubts(heap, heaps), std::vector<std::string>{});
  const datasets::Experiment column = load("column_collapse");
  const auto still = seen(
      column, {-0.1, 0.5, 0.7, 0.9, 1.1}, [](double x, double time) { return wedge(x, time); });
  EXPECT_EQ(doubts(column, {still, still}), std::vector<std::string>{});
}

TEST_F(OutlineDoubts, SayThatATubeStoodOffItsAxis) {
  const datasets::Experiment heap = load("lifted_cylinder");
  std::vector<datasets::Recording> heaps;
  for (const double more : {-0.05 * grain, 0.04 * grain, 0.01 * grain})
    heaps.push_back(
        seen(heap, {1.0}, [&](double x, double) { return cone(x - 0.5 * grain - more); }));
  expect_one(doubts(heap, heaps), "0.5 grains and more than chance");
}

TEST_F(OutlineDoubts, SayThatAFrontReachedTheWall) {
  const datasets::Experiment column = load("column_collapse");
  const auto reached = seen(column, {1.0}, [](double x, double) { return 0.02 - 0.05 * x; });
  const auto other = seen(column, {1.0}, [](double x, double) { return wedge(x, 1.0); });
  expect_one(doubts(column, {reached, other}), "the end at 200 mm");
}

TEST_F(OutlineDoubts, SayThatABedStillMoves) {
  const datasets::Experiment column = load("column_collapse");
  const auto moving = seen(column, {0.5, 0.7, 0.9, 1.1}, [](double x, double time) {
    return (0.024 - 0.01 * time) * (1.0 - x / (0.08 + 0.03 * time));
  });
  const auto still =
      seen(column, {0.5, 0.7, 0.9, 1.1}, [](double x, double time) { return wedge(x, time); });
  expect_one(doubts(column, {moving, still}), "ends before the bed is at rest");
  // Errors as large as the change tell nothing
  datasets::Recording blurred = moving;
  for (double& one : blurred.outlines.front().sigma) one *= 40.0;
  EXPECT_EQ(doubts(column, {blurred, still}), std::vector<std::string>{});
}

TEST_F(OutlineDoubts, SayThatAPictureIsMirrored) {
  const datasets::Experiment column = load("column_collapse");
  const auto mirrored = seen(column, {1.0}, [](double x, double) { return wedge(0.2 - x, 1.0); });
  const auto right = seen(column, {1.0}, [](double x, double) { return wedge(x, 1.0); });
  const std::vector<std::string> said = doubts(column, {mirrored, right});
  ASSERT_FALSE(said.empty());
  EXPECT_NE(said.front().find("the picture is mirrored"), std::string::npos) << said.front();

  const datasets::Experiment drum = load("rotating_drum");
  std::vector<double> times;
  for (int i = 0; i < 60; ++i) times.push_back(0.1 * i);
  // It turns clockwise, so that the bed lies higher on the left
  const auto turning = [&](double slope) {
    return seen(drum, times, [=](double x, double time) {
      return slope * x + 2e-4 * std::sin(700.0 * x + 2.0 * std::sin(9.0 * time) + 3.0 * time);
    });
  };
  EXPECT_EQ(doubts(drum, {turning(-0.5), turning(-0.5), turning(-0.5), turning(-0.5)}),
            std::vector<std::string>{});
  expect_one(doubts(drum, {turning(0.5), turning(-0.5), turning(-0.5), turning(-0.5)}),
             "rises to the right, but the drum is said to turn clockwise");
}

TEST_F(OutlineDoubts, SayThatAColumnIsNotAsWideAsItsRig) {
  const datasets::Experiment column = load("column_collapse");
  const auto scaled = [&](double factor) {
    return seen(column, {-0.1, 0.5, 0.7, 0.9, 1.1}, [=](double x, double time) {
      return factor * wedge(x / factor, time);
    });
  };
  expect_one(doubts(column, {scaled(1.1), scaled(1.0)}), "the scale is off");
}

}  // namespace
}  // namespace graintruth::calibrate
