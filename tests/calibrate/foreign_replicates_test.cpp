// Replicates that do not belong are named, those that do are not; by made-up replicates, of which
// it is known, and by the bundled truth.
#include "calibrate/knowledge/foreign_replicates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>

#include "tests/support/read_rows.h"

namespace graintruth::calibrate {
namespace {

using Values = std::vector<std::vector<double>>;

std::vector<std::string> names_of(std::size_t count) {
  std::vector<std::string> names;
  for (std::size_t i = 1; i <= count; ++i) names.push_back("rep" + std::to_string(i));
  return names;
}

std::vector<RepeatedCondition> one_condition(std::size_t count) {
  RepeatedCondition condition;
  for (std::size_t i = 0; i < count; ++i) condition.replicates.push_back(i);
  return {condition};
}

// Replicates that scatter by 1 about 100; values have `common` of their variance in common.
Values repeats(std::size_t count, std::size_t values, double common, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Values all;
  for (std::size_t r = 0; r < count; ++r) {
    const double shared = std::sqrt(common) * normal(random);
    std::vector<double>& own = all.emplace_back();
    for (std::size_t i = 0; i < values; ++i)
      own.push_back(100.0 + shared + std::sqrt(1.0 - common) * normal(random));
  }
  return all;
}

std::vector<std::string> texts_of(const std::vector<datasets::Warning>& warnings) {
  std::vector<std::string> texts;
  for (const datasets::Warning& warning : warnings) {
    EXPECT_EQ(warning.kind, datasets::WarningClass::first_line);
    texts.push_back(warning.text);
  }
  return texts;
}

std::vector<std::string> said_of(const std::vector<RepeatedQuantity>& quantities) {
  const std::size_t count = quantities.front().values.size();
  return texts_of(foreign_replicates(names_of(count), one_condition(count), quantities));
}

// The whole procedure, two quantities of every replicate: one experiment in a hundred at most.
TEST(ForeignReplicates, AreFalselyNamedInOneExperimentOfAHundred) {
  std::mt19937_64 random(4);
  constexpr int experiments = 250;
  for (const std::size_t count : {3, 5}) {
    for (const double common : {0.0, 0.9}) {
      int wrong = 0;
      for (int i = 0; i < experiments; ++i) {
        const std::vector<RepeatedQuantity> quantities = {
            {.name = "a", .values = repeats(count, 12, common, random)},
            {.name = "b", .values = repeats(count, 1, 0.0, random)}};
        wrong += said_of(quantities).empty() ? 0 : 1;
      }
      EXPECT_LE(wrong, false_alarm * experiments + 4.0 * std::sqrt(false_alarm * experiments))
          << count << " replicates, " << common;
    }
  }
}

// A pooled rate: three replicates of each of five conditions, relative scatter 2 %.
TEST(ForeignReplicates, AreFalselyNamedAsSeldomInPooledConditions) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  constexpr int experiments = 100;
  std::vector<RepeatedCondition> conditions;
  for (std::size_t c = 0; c < 5; ++c)
    conditions.push_back({"orifice " + std::to_string(c), {3 * c, 3 * c + 1, 3 * c + 2}});
  int wrong = 0, found = 0;
  for (int i = 0; i < experiments; ++i) {
    RepeatedQuantity rate{.name = "rate", .is_pooled = true, .is_relative = true};
    for (std::size_t r = 0; r < 15; ++r)
      rate.values.push_back({(1.0 + static_cast<double>(r / 3)) * (1.0 + 0.02 * normal(random))});
    wrong += foreign_replicates(names_of(15), conditions, std::vector{rate}).empty() ? 0 : 1;
    rate.values[4][0] *= 1.25;  // a film of a wider orifice
    const auto said = texts_of(foreign_replicates(names_of(15), conditions, std::vector{rate}));
    found += said.size() == 1 && said.front().starts_with("rep5 ") ? 1 : 0;
  }
  EXPECT_LE(wrong, false_alarm * experiments + 4.0 * std::sqrt(false_alarm * experiments));
  EXPECT_GE(found, 0.99 * experiments);
}

// One of five that is off by eight standard deviations in each of twelve values.
TEST(ForeignReplicates, OneOfFiveIsNamedWithWhatItDoesToTheMean) {
  std::mt19937_64 random(6);
  int named = 0;
  constexpr int experiments = 200;
  for (int i = 0; i < experiments; ++i) {
    RepeatedQuantity tracks{.name = "tracks", .unit = "m", .values = repeats(5, 12, 0.0, random)};
    std::uniform_int_distribution<std::size_t> which(0, 4);
    const std::size_t foreign = which(random);
    for (std::size_t k = 0; k < 12; ++k) tracks.values[foreign][k] += k % 2 == 0 ? 8.0 : -8.0;
    const auto said = said_of({tracks});
    named += said.size() == 1 &&
             said.front().starts_with("rep" + std::to_string(foreign + 1) + " may not belong");
  }
  EXPECT_GE(named, 0.95 * experiments);
  // In numbers: 14, where four others have 4 in the mean
  const auto said = said_of(
      {{.name = "rate", .unit = "kg/s", .values = {{4.01}, {3.99}, {4.02}, {3.98}, {14.0}}}});
  ASSERT_EQ(said.size(), 1U);
  EXPECT_NE(
      said.front().find("its rate is 14 kg/s, where the other 4 have 4 kg/s in the mean; with "
                        "it the mean is 6 kg/s"),
      std::string::npos)
      << said.front();
}

// Two others hardly show how replicates scatter; the width of a grain does not need them.
TEST(ForeignReplicates, OneOfThreeIsNamedByTheWidthOfAGrain) {
  const Values places = {{0.0, 0.10}, {0.001, 0.101}, {0.03, 0.13}};
  const auto said =
      said_of({{.name = "starting places", .unit = "m", .values = places, .width = 0.02}});
  ASSERT_EQ(said.size(), 1U);
  EXPECT_TRUE(said.front().starts_with("rep3 may not belong")) << said.front();
  EXPECT_NE(said.front().find("29.5 mm (rms)"), std::string::npos) << said.front();
  EXPECT_TRUE(
      said_of({{.name = "starting places", .unit = "m", .values = places, .width = 0.2}}).empty());
  // Grains that mix end farther apart than they are wide, all of them
  EXPECT_TRUE(
      said_of({{.name = "tracks", .unit = "m", .values = {{0.0}, {0.05}, {0.11}}, .width = 0.02}})
          .empty());
}

TEST(ForeignReplicates, OfTwoNobodyCanTellWhichIsWrong) {
  const auto said = said_of(
      {{.name = "tracks", .unit = "m", .values = {{0.0, 0.1}, {0.05, 0.15}}, .width = 0.02}});
  ASSERT_EQ(said.size(), 1U);
  EXPECT_TRUE(said.front().starts_with("rep1 and rep2 may not show the same")) << said.front();
  EXPECT_NE(said.front().find("add a third"), std::string::npos);
  const auto by_errors = [](double error) {
    return said_of({{.name = "rate", .values = {{1.0}, {1.3}}, .errors = {{error}, {error}}}});
  };
  EXPECT_EQ(by_errors(0.02).size(), 1U);  // ten errors apart
  EXPECT_EQ(by_errors(0.06).size(), 0U);  // less than four
}

TEST(ForeignReplicates, ThatAgreeByLuckAreNotMoreExactThanTheySay) {
  RepeatedQuantity rate{.name = "rate", .values = {{1.0}, {1.0001}, {1.0}, {0.9999}, {1.02}}};
  EXPECT_EQ(said_of({rate}).size(), 1U);
  rate.errors = Values(5, {0.01});
  EXPECT_EQ(said_of({rate}).size(), 0U);
}

// Directions of axes are the same half a turn on.
TEST(ForeignReplicates, ADirectionIsTheSameHalfATurnOn) {
  const double half_turn = std::acos(-1.0);
  EXPECT_TRUE(said_of({{.name = "tracks",
                        .values = {{0.01}, {0.02}, {-0.01}, {0.015}, {half_turn + 0.012}},
                        .difference = {Difference::half_turn}}})
                  .empty());
}

TEST(ForeignReplicates, AReplicateThatTellsNothingIsLeftOut) {
  EXPECT_TRUE(said_of({{.name = "rate", .values = {{1.0}, {}, {1.1}, {0.9}}}}).empty());
  EXPECT_TRUE(said_of({{.name = "rate", .values = {{std::nan("")}, {1.0}, {1.1}, {0.9}}}}).empty());
}

// Places of the ten particles of the bundled truth in time, m.
std::vector<double> bundled_tracks(int replicate) {
  std::vector<double> values;
  const auto file = std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "datasets/micro/truth" /
                    ("rep" + std::to_string(replicate) + "_tracks.csv");
  for (const tests::Row& row : tests::read_rows(file)) {
    if (static_cast<int>(std::lround(50.0 * tests::number(row, "time_s"))) % 10 != 0) continue;
    values.push_back(tests::number(row, "x_m"));
    values.push_back(tests::number(row, "z_m"));
  }
  return values;
}

TEST(ForeignReplicates, TheBundledFiveBelongAndAnotherInTheirPlaceDoesNot) {
  RepeatedQuantity tracks{.name = "tracks", .unit = "m", .width = 0.022};
  for (int n = 1; n <= 5; ++n) tracks.values.push_back(bundled_tracks(n));
  EXPECT_TRUE(said_of({tracks}).empty());
  // Seen in a mirror, as a film of another arrangement would be
  for (std::size_t foreign = 0; foreign < 5; ++foreign) {
    RepeatedQuantity mirrored = tracks;
    for (std::size_t i = 0; i < mirrored.values[foreign].size(); i += 2)
      mirrored.values[foreign][i] *= -1.0;
    const auto said = said_of({mirrored});
    ASSERT_EQ(said.size(), 1U) << foreign;
    EXPECT_TRUE(said.front().starts_with("rep" + std::to_string(foreign + 1) + " may not"));
  }
}

}  // namespace
}  // namespace graintruth::calibrate
