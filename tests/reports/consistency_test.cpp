// Verdict, words, tables and figures of a page tell the same: all of them are read back from the
// page and compared with result.json, where every kind of end of an interval occurs.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "datasets/store/run_folder.h"
#include "datasets/store/table.h"
#include "datasets/verdict/verdict.h"
#include "fixture_run.h"
#include "reports/report.h"

namespace graintruth::reports {
namespace {

using Json = nlohmann::ordered_json;

// "0.104" tells a number to half a unit of its last digit.
void expect_shown(const std::string& shown, double value, const std::string& where) {
  const auto point = shown.find('.');
  const double digits =
      point == std::string::npos ? 0.0 : static_cast<double>(shown.size() - point - 1);
  EXPECT_NEAR(std::stod(shown), value, 0.5001 * std::pow(10.0, -digits)) << where << ": " << shown;
}

class Consistency : public testing::Test {
 protected:
  void SetUp() override {
    root_ = tests::empty_folder(testing::UnitTest::GetInstance()->current_test_info()->name());
    folder_ = tests::write_fixture_run(root_);
    result_ = Json::parse(datasets::read_whole(folder_.result()));
  }
  void TearDown() override { std::filesystem::remove_all(root_); }

  Json& wall() { return result_["parameters"]["friction_particle_wall"]; }
  std::string build() {
    datasets::add_verdict(result_);
    datasets::write_whole(folder_.result(), result_.dump());
    page_ = tests::spoken(build_report(folder_));
    return page_;
  }

  // What stands in the first group of every match.
  std::vector<std::smatch> all(const std::string& pattern) {
    const std::regex expression(pattern);
    return {std::sregex_iterator(page_.begin(), page_.end(), expression), std::sregex_iterator()};
  }
  std::smatch one(const std::string& pattern) {
    const std::vector<std::smatch> found = all(pattern);
    EXPECT_EQ(found.size(), 1U) << pattern;
    return found.empty() ? std::smatch() : found.front();
  }
  Json traces(const std::string& id) {
    const auto figure = page_.find(fmt::format("<figure class=\"plot\" id=\"{}\">", id));
    EXPECT_NE(figure, std::string::npos) << id;
    const std::string before = "<script type=\"application/json\">";
    const auto begin = page_.find(before, figure) + before.size();
    return Json::parse(page_.substr(begin, page_.find("</script>", begin) - begin))["choices"][0];
  }

  // An interval in words, "0.10 to 0.14", against the numbers; a dash where its end was not found.
  static void expect_interval(const std::string& words,
                              const Json& parameter,
                              const std::string& where) {
    const bool lower = parameter.value("lower_end", "found") == "found";
    const bool upper = parameter.value("upper_end", "found") == "found";
    if (!parameter.contains("lower") || (!lower && !upper)) {
      EXPECT_EQ(words, "\u2013") << where;
      return;
    }
    const auto to = words.find(" to ");
    ASSERT_NE(to, std::string::npos) << where << ": " << words;
    const std::string first = words.substr(0, to), last = words.substr(to + 4);
    if (lower) {
      expect_shown(first, parameter["lower"], where);
    } else {
      EXPECT_EQ(first, "\u2013") << where;
    }
    if (upper) {
      expect_shown(last, parameter["upper"], where);
    } else {
      EXPECT_EQ(last, "\u2013") << where;
    }
  }

  void expect_page_tells_result(const std::string& name, const std::string& title) {
    const Json& parameter = result_["parameters"][name];
    const bool has_interval = parameter.contains("lower");
    const bool is_determined = has_interval && (parameter.value("lower_end", "found") == "found" ||
                                                parameter.value("upper_end", "found") == "found");
    // 1. The verdict
    const std::smatch tile =
        one("<dt>" + title + "</dt><dd><b>([^<]*)</b> <span>([^<]*)</span></dd>");
    if (is_determined) {
      expect_shown(tile[1], parameter["value"], "tile of " + name);
      expect_interval(tile[2], parameter, "tile of " + name);
    } else {
      EXPECT_EQ(tile[1], "\u2013") << name;
    }
    // 2. The table
    const std::smatch row = one("<th scope=\"row\"[^>]*>" + title +
                                "</th><td[^>]*>([^<]*)</td><td[^>]*>([^<]*)</td><td[^>]*>-</td>");
    expect_shown(row[1], parameter["value"], "table of " + name);
    expect_interval(row[2], parameter, "table of " + name);
    // 3. The figure of intervals, the plane of the search, the profile
    int bars = 0;
    for (const Json& trace : traces("parameter-intervals")) {
      if (trace["name"] != "95 % interval") continue;
      ++bars;
      if (trace["x"][0] != parameter.value("lower", -1.0)) continue;
      EXPECT_EQ(trace["x"][1], parameter["upper"]) << name;
      ++seen_in_figure_;
    }
    const bool is_across = name == "friction_particle_particle";
    for (const Json& trace : traces("search-plane")) {
      if (trace["mode"] != "markers" || !trace["name"].get<std::string>().starts_with("result"))
        continue;
      const char* error = is_across ? "error_x" : "error_y";
      ASSERT_EQ(trace.contains(error), is_determined) << name;
      if (!is_determined) continue;
      const double value = trace[is_across ? "x" : "y"][0];
      EXPECT_NEAR(value + trace[error]["array"][0].get<double>(), parameter["upper"], 1e-5);
      EXPECT_NEAR(value - trace[error]["arrayminus"][0].get<double>(), parameter["lower"], 1e-5);
    }
    int drawn = 0;
    for (const Json& trace : traces("search-profile")) {
      const std::string label = trace["name"];
      if (label == title + ": 95 % interval") {
        ++drawn;
        EXPECT_EQ(trace["x"][0], parameter["lower"]);
        EXPECT_EQ(trace["x"][1], parameter["upper"]);
      }
      if (label != title || !is_determined) continue;
      for (std::size_t i = 0; i < trace["x"].size(); ++i) {
        if (trace["y"][i].get<double>() > 1.0) continue;  // told from the best
        EXPECT_GE(trace["x"][i], parameter["lower"]) << name;
        EXPECT_LE(trace["x"][i], parameter["upper"]) << name;
      }
    }
    EXPECT_EQ(drawn, is_determined ? 1 : 0) << name;
  }

  void expect_consistent() {
    seen_in_figure_ = 0;
    expect_page_tells_result("friction_particle_particle", "Friction, particle to particle");
    expect_page_tells_result("friction_particle_wall", "Friction, particle to wall");
    // The verdict is that of the data
    const datasets::Verdict verdict = datasets::judge(result_);
    EXPECT_NE(page_.find("</span> " + std::string(datasets::words_of(verdict.mark)) + "</h2>"),
              std::string::npos);
    EXPECT_NE(page_.find("<p class=\"next\">" + datasets::next_words(verdict) + "</p>"),
              std::string::npos);
  }

  std::filesystem::path root_;
  datasets::RunFolder folder_;
  Json result_;
  std::string page_;
  int seen_in_figure_ = 0;
};

TEST_F(Consistency, OfIntervalsThatWereFound) {
  const std::string page = build();
  expect_consistent();
  EXPECT_EQ(seen_in_figure_, 2);
  EXPECT_NE(
      page.find("a friction between particles and walls of 0.171 (95 % interval 0.148 to 0.196)"),
      std::string::npos);
  // Scores: verdict, words and table
  EXPECT_NE(page.find("88.7 % of the compared values"), std::string::npos);
  EXPECT_NE(one("Mean of 10 simulations \\(the score\\)</th><td[^>]*>88.7 %</td>").size(), 0U);
}

TEST_F(Consistency, OfAnIntervalThatIsOpenAbove) {
  wall().update({{"upper", 0.6}, {"upper_end", "open"}, {"interval_status", "open_above"}});
  const std::string page = build();
  expect_consistent();
  EXPECT_EQ(seen_in_figure_, 2);
  EXPECT_NE(page.find("open above"), std::string::npos);
  EXPECT_NE(page.find("Open: every value up to that bound"), std::string::npos);
  EXPECT_EQ(page.find("0.148 to 0.6"), std::string::npos);
  EXPECT_NE(page.find("triangle-right"), std::string::npos);
  EXPECT_EQ(page.find("udget ended"), std::string::npos);
}

TEST_F(Consistency, OfAnIntervalThatTheBudgetLeftUnfinished) {
  wall().update(
      {{"upper", 0.6}, {"upper_end", "budget_ended"}, {"interval_status", "budget_ended"}});
  std::string page = build();
  expect_consistent();
  EXPECT_NE(
      page.find("The budget ended before the interval of friction between particles and walls "
                "was found."),
      std::string::npos);
  wall().update({{"lower", 0.0}, {"lower_end", "budget_ended"}});
  page = build();
  expect_consistent();
  EXPECT_EQ(seen_in_figure_, 1);
  EXPECT_NE(page.find("This is no word of the data"), std::string::npos);
  EXPECT_EQ(page.find("friction between particles and walls is not identified"), std::string::npos);
}

TEST_F(Consistency, OfAParameterThatTheDataDoNotDetermine) {
  wall() = result_["parameters"]["restitution"];
  wall()["value"] = 0.35;
  wall()["bench_value"] = 0.35;
  const std::string page = build();
  expect_consistent();
  EXPECT_EQ(page.find("udget ended"), std::string::npos);
  EXPECT_NE(page.find("The friction between particles and walls is not identified"),
            std::string::npos);
}

// Ten seconds are enough for the verdict, and a few minutes for what is not folded.
TEST_F(Consistency, TakesFewWords) {
  const std::string page = build();
  const auto begin = page.find("<section id=\"verdict\"");
  const std::string verdict = page.substr(begin, page.find("</section>", begin) - begin);
  EXPECT_LE(tests::words_in(tests::visible_text("<body>" + verdict)), 60);
  EXPECT_LT(tests::words_in(tests::visible_text(page)), 1500);
  EXPECT_GT(tests::words_in(tests::visible_text(page)), 300);
}

TEST_F(Consistency, OfNumbersThatDoNotExist) {
  Json& agreement = result_["agreement"];
  for (auto& [key, value] : agreement.items())
    if (value.is_number()) value = std::nan("");
  result_["objective"]["noise"] = nullptr;
  const std::string page = build();
  const std::string seen = tests::visible_text(page);
  EXPECT_FALSE(std::regex_search(seen, std::regex("\\b(nan|inf|null)\\b"))) << seen;
}

}  // namespace
}  // namespace graintruth::reports
