// The section that shows every compared quantity, whatever the run compared.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "datasets/store/table.h"
#include "fixture_run.h"
#include "reports/report.h"

namespace graintruth::reports {
namespace {

using Json = nlohmann::ordered_json;

class Compared : public testing::Test {
 protected:
  void SetUp() override {
    root_ = tests::empty_folder(testing::UnitTest::GetInstance()->current_test_info()->name());
    folder_ = tests::write_fixture_run(root_);
  }
  void TearDown() override { std::filesystem::remove_all(root_); }

  // With these channels in place of tracks and what is told of them
  std::string page_of(const std::vector<Json>& channels) {
    Json result = Json::parse(datasets::read_whole(folder_.result()));
    result.erase("agreement");
    result["channels"] = channels;
    datasets::write_whole(folder_.result(), result.dump());
    std::filesystem::remove(folder_.table("bands"));
    return tests::spoken(build_report(folder_));
  }

  std::filesystem::path root_;
  datasets::RunFolder folder_;
};

// A number of one condition.
Json number(const char* condition, double measured, double half, double simulated) {
  return {{"observable", "impact_energy"},
          {"title", "Energy of the impact"},
          {"condition", condition},
          {"unit", "J"},
          {"axis", {{"name", ""}, {"unit", ""}, {"values", Json::array()}}},
          {"measured", {measured}},
          {"lower", {measured - half}},
          {"upper", {measured + half}},
          {"simulated", {simulated}},
          {"held_out", false}};
}

// A force at three moments.
Json curve(const char* condition, const Json& simulated) {
  return {{"observable", "wall_force"},
          {"title", "Force on the wall"},
          {"condition", condition},
          {"unit", "N"},
          {"axis", {{"name", "time"}, {"unit", "s"}, {"values", {0.0, 0.5, 1.0}}}},
          {"measured", {1.0, 2.0, 3.0}},
          {"lower", {0.5, 1.5, 2.5}},
          {"upper", {1.5, 2.5, 3.5}},
          {"simulated", simulated},
          {"held_out", false}};
}

// The row of the section's tables that has this cell, its cells parted by bars.
std::string row_with(const std::string& page, const std::string& cell) {
  const auto at = page.find(">" + cell + "</t", page.find("<section id=\"compared\""));
  if (at == std::string::npos) return "";
  const auto first = page.rfind("<tr", at);
  std::string row, all = page.substr(first, page.find("</tr>", at) - first);
  for (auto close = all.find("</t"); close != std::string::npos;
       close = all.find("</t", close + 1)) {
    const auto open = all.rfind('>', close);
    row += all.substr(open + 1, close - open - 1) + "|";
  }
  return row;
}

TEST_F(Compared, ListsNumbersOverConditions) {
  Json held_out = number("drop height 2 m", 4.0, 0.2, 4.5);
  held_out["held_out"] = true;
  const std::string page = page_of({number("drop height 1 m", 2.0, 0.1, 2.05), held_out});
  EXPECT_NE(page.find("<h3 id=\"compared-impact-energy\">Energy of the impact</h3>"),
            std::string::npos);
  EXPECT_EQ(row_with(page, "drop height 1 m"),
            "drop height 1 m|2.00|1.90 to 2.10|2.05|0.05|yes|calibration|");
  EXPECT_EQ(row_with(page, "drop height 2 m"),
            "drop height 2 m|4.00|3.80 to 4.20|4.50|0.50|no|prediction|");
  EXPECT_NE(page.find("Energy of the impact: the simulated mean lies inside the 95 % interval of "
                      "the measured mean for 1 of 2 values."),
            std::string::npos);
  EXPECT_EQ(page.find("id=\"compared-figure"), std::string::npos);
}

TEST_F(Compared, DrawsCurvesWithAMenuOverConditions) {
  Json held_out = curve("fill 2 kg", {1.0, 2.6, 3.6});
  held_out["held_out"] = true;
  const std::string page = page_of({curve("fill 1 kg", {1.1, 2.1, 3.1}), held_out});
  EXPECT_NE(page.find("<figure class=\"plot\" id=\"compared-figure-wall-force\">"),
            std::string::npos);
  EXPECT_NE(page.find("<option value=\"0\">fill 1 kg</option>"), std::string::npos);
  EXPECT_NE(page.find("<option value=\"1\">fill 2 kg (predicted)</option>"), std::string::npos);
  EXPECT_NE(page.find("\"Force on the wall (N)\""), std::string::npos);
  EXPECT_NE(page.find("\"Time since the start event (s)\""), std::string::npos);
  EXPECT_EQ(row_with(page, "fill 1 kg"), "fill 1 kg|calibration|3|3|100.0 %|");
  EXPECT_EQ(row_with(page, "fill 2 kg"), "fill 2 kg|prediction|3|1|33.3 %|");
}

// The tables of the same run count the same, particle by particle.
TEST_F(Compared, CountsValuesOfTracksInsideAndSaysWhereTheyAreShown) {
  const auto ranks = datasets::read_csv(folder_.table("ranks"));
  int inside = 0;
  for (std::size_t row = 0; row < ranks.rows(); ++row)
    inside += ranks.integer(row, "rank_student_t");
  const std::string page = tests::spoken(build_report(folder_));
  EXPECT_NE(
      page.find("30 values at each of 26 values of time. The sections \u201cAgreement\u201d and "
                "\u201cTracks\u201d show them."),
      std::string::npos);
  EXPECT_EQ(row_with(page, "780"),
            fmt::format("calibration|780|{}|{:.1f} %|", inside, 100.0 * inside / 780));
}

// Axes of bodies with equal ends point the same way after half a turn, a wheel does not.
TEST_F(Compared, TakesDirectionsOfTracksModuloHalfATurn) {
  Json tracks = curve("", {1.0 + std::numbers::pi, 2.0, 3.0 - std::numbers::pi});
  tracks["unit"] = "rad";
  EXPECT_EQ(row_with(page_of({tracks}), "33.3 %"), "calibration|3|1|33.3 %|");
  for (const char* key : {"measured", "lower", "upper", "simulated"}) {
    Json values = Json::array();
    for (const Json& value : tracks[key]) values.insert(values.end(), {0.0, value});
    tracks[key] = values;
  }
  tracks["unit"] = "m, rad";
  EXPECT_EQ(row_with(page_of({tracks}), "6"), "calibration|6|6|100.0 %|");
}

TEST_F(Compared, ShowsUnitsAsAReaderExpectsThem) {
  const std::string page =
      tests::spoken(build_report(tests::write_fixture_flow_run(root_ / "flow")));
  EXPECT_NE(page.find("Discharge rate (g/s)"), std::string::npos);
  EXPECT_EQ(row_with(page, "orifice width 50 mm"),
            "orifice width 50 mm|75.0|71.0 to 79.0|69.0|−6.0|no|prediction|");
  EXPECT_NE(page.find("\"Velocity profile (mm/s)\""), std::string::npos);
  EXPECT_NE(page.find("\"x (mm)\""), std::string::npos);
}

TEST_F(Compared, SaysOfAConstantOfAllConditionsThatItIsOfAll) {
  Json law = number("drop height 1 m", 0.5, 0.1, 0.7);
  law["observable"] = "law";
  law["measured"] = {0.5, 1.5};
  law["lower"] = {0.4, 1.4};
  law["upper"] = {0.6, 1.6};
  law["simulated"] = {0.7, 1.5};
  const std::string page = page_of(
      {number("drop height 1 m", 2.0, 0.1, 2.0), number("drop height 2 m", 4.0, 0.1, 4.0), law});
  EXPECT_EQ(row_with(page, "all together"), "all together|1|0.50|0.40 to 0.60|0.70|0.20|no|");
}

TEST_F(Compared, LivesWithoutIntervalsAndSimulations) {
  Json lone = number("", 2.0, 0.1, 2.0);
  lone["lower"] = {nullptr};
  lone["simulated"] = Json::array();
  EXPECT_EQ(row_with(page_of({lone}), "2.00"), "2.00|–|–|–|–|calibration|");
  Json unknown = curve("", {nullptr, 2.0, nullptr});
  unknown["upper"] = {nullptr, 2.5, nullptr};
  EXPECT_EQ(row_with(page_of({unknown}), "100.0 %"), "calibration|1|1|100.0 %|");
}

TEST_F(Compared, EscapesHostileNames) {
  const std::string hostile = "\"><script>alert('owned')</script>";
  Json channel = curve(hostile.c_str(), {1.0, 2.0, 3.0});
  for (const char* key : {"observable", "title", "unit"}) channel[key] = hostile;
  channel["axis"]["name"] = hostile;
  EXPECT_EQ(page_of({channel}).find("<script>alert"), std::string::npos);
}

TEST_F(Compared, TellsWhatEachQuantityLeavesOfTheObjective) {
  Json result = Json::parse(datasets::read_whole(folder_.result()));
  result["objective"]["shares"] = {{"wall_force", 0.26}, {"beverloo_2", 0.5}};
  datasets::write_whole(folder_.result(), result.dump());
  const std::string page = page_of({curve("", {1.0, 2.0, 3.0})});
  EXPECT_EQ(row_with(page, "0.26"), "Force on the wall|0.26|");
  EXPECT_EQ(row_with(page, "0.50"), "Beverloo 2|0.50|");
}

TEST_F(Compared, IsLeftOutWhereARunTellsNothingOfIt) {
  EXPECT_EQ(page_of({}).find("id=\"compared"), std::string::npos);
}

}  // namespace
}  // namespace graintruth::reports
