// The page in a real browser: everything drawn, nothing complained about, nothing asked of the
// network.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "datasets/store/run_folder.h"
#include "fixture_run.h"
#include "reports/report.h"

namespace graintruth::reports {
namespace {

constexpr const char* browser = "/usr/bin/chromium";

struct Visit {
  int status = -1;
  std::string document;  // after its scripts have run
  std::string console;   // warnings, errors and refused requests
};

// Opens a page from disk. Lines of the browser's own log that are not about the page are left out.
Visit visit(const std::filesystem::path& page,
            const std::filesystem::path& scratch,
            int width = 1280) {
  std::filesystem::remove_all(scratch);
  std::filesystem::create_directories(scratch);
  const std::string command = fmt::format(
      "HOME='{0}' timeout 120 {1} --headless --no-sandbox --disable-gpu --disable-quic "
      "--no-first-run "
      "--disable-background-networking --disable-component-update --disable-sync "
      "--user-data-dir='{0}/profile' "
      "--window-size={3},1000 --virtual-time-budget=20000 --enable-logging=stderr --v=0 "
      "--dump-dom 'file://{2}' "
      ">'{0}/document' 2>'{0}/log'",
      scratch.string(),
      browser,
      page.string(),
      width);
  Visit result;
  result.status = std::system(command.c_str());
  result.document = datasets::read_whole(scratch / "document");
  std::ifstream log(scratch / "log");
  for (std::string text; std::getline(log, text);)
    if (text.find("CONSOLE") != std::string::npos) result.console += text + "\n";
  return result;
}

class BrowserPage : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(browser)) GTEST_SKIP() << browser << " is not installed";
    root_ = tests::empty_folder(testing::UnitTest::GetInstance()->current_test_info()->name());
    folder_ = tests::write_fixture_run(root_ / "run");
  }
  void TearDown() override {
    if (!root_.empty()) std::filesystem::remove_all(root_);
  }

  std::filesystem::path root_;
  datasets::RunFolder folder_;
};

// How many figures the page has; each was drawn, without a word on the console.
int figures_drawn(const Visit& seen) {
  EXPECT_EQ(seen.status, 0);
  EXPECT_EQ(seen.console, "");
  const int figures = tests::occurrences(seen.document, "<figure class=\"plot\"");
  EXPECT_NE(seen.document.find(fmt::format("data-figures-drawn=\"{}\"", figures)),
            std::string::npos);
  return figures;
}

TEST_F(BrowserPage, DrawsEveryFigureWithoutComplaint) {
  write_report(folder_);
  const Visit seen = visit(folder_.report(), root_ / "browser");
  const int figures = figures_drawn(seen);
  EXPECT_EQ(figures, 12);
  EXPECT_NE(seen.document.find("data-figures-failed=\"0\""), std::string::npos);
  EXPECT_GE(tests::occurrences(seen.document, "class=\"main-svg\""), figures);
}

TEST_F(BrowserPage, OffersEveryTableToBeSortedAndCopied) {
  write_report(folder_);
  const Visit seen = visit(folder_.report(), root_ / "browser");
  EXPECT_EQ(seen.console, "");
  const int tables = tests::occurrences(seen.document, "<div class=\"table-box\"");
  EXPECT_GE(tables, 10);
  EXPECT_EQ(tests::occurrences(seen.document, ">Copy as CSV</button>"), tables);
  EXPECT_GE(tests::occurrences(seen.document, "<th scope=\"col\"><button type=\"button\">"),
            tables);
}

// The heads of two columns pressed by a script of the test's: numbers are sorted as numbers, and
// what is not there comes last.
TEST_F(BrowserPage, SortsATableByItsNumbers) {
  write_report(folder_);
  std::string page = datasets::read_whole(folder_.report());
  const char* const table =
      "<p class=\"caption\">t</p>"
      "<div class=\"table-box\"><table id=\"sorted\"><thead><tr><th>a</th></tr></thead><tbody>"
      "<tr><td>10 %</td></tr><tr><td>\u2013</td></tr><tr><td>\u22129</td></tr>"
      "<tr><td>2 \u00d7 10\u207b\u00b3</td></tr><tr "
      "class=\"total\"><td>0</td></tr></tbody></table></div>";
  page.insert(page.find("</main>"), table);
  page.insert(page.rfind("</body>"),
              "<script>document.querySelector('#sorted button').click();</script>");
  datasets::write_whole(folder_.report(), page);
  const Visit seen = visit(folder_.report(), root_ / "browser");
  EXPECT_EQ(seen.console, "");
  std::size_t at = seen.document.find("id=\"sorted\"");
  for (const char* cell : {"\u22129<", "2 \u00d7 10\u207b\u00b3<", "10 %<", "\u2013<", ">0<"}) {
    at = seen.document.find(cell, at);
    ASSERT_NE(at, std::string::npos) << cell;
  }
}

// By its slider one picture is shown at a time; without scripts, and on paper, three.
TEST_F(BrowserPage, ShowsFilmAndSimulationByASlider) {
  const std::string plain = build_report(folder_);
  EXPECT_EQ(plain.find("type=\"range\""), std::string::npos);
  EXPECT_EQ(tests::occurrences(plain, "class=\"key\""), 3);
  write_report(folder_);
  std::string page = datasets::read_whole(folder_.report());
  page.insert(page.find("</body>"),
              "<script>const slider = document.querySelector('.side-by-side input');"
              "slider.value = 2; slider.dispatchEvent(new Event('input'));</script>");
  datasets::write_whole(folder_.report(), page);
  const Visit seen = visit(folder_.report(), root_ / "browser");
  EXPECT_EQ(seen.console, "");
  EXPECT_NE(seen.document.find("class=\"side-by-side scrubbed\""), std::string::npos);
  EXPECT_EQ(tests::occurrences(seen.document, "class=\"key shown\""), 1);
  EXPECT_EQ(tests::occurrences(seen.document, "class=\"key\""), 2);
  EXPECT_NE(seen.document.find("aria-valuetext=\"4.80&nbsp;s\""), std::string::npos);
}

// What a script at the end of the page puts into data-seen.
std::string seen_by(const std::string& script,
                    const datasets::RunFolder& folder,
                    const std::filesystem::path& scratch,
                    int width) {
  write_report(folder);
  std::string page = datasets::read_whole(folder.report());
  page.insert(page.rfind("</body>"),
              "<script>document.body.dataset.seen = (() => { " + script + " })();</script>");
  datasets::write_whole(folder.report(), page);
  const Visit visited = visit(folder.report(), scratch, width);
  EXPECT_EQ(visited.console, "");
  const std::string before = "data-seen=\"";
  const auto begin = visited.document.find(before);
  if (begin == std::string::npos) return "";
  const auto first = begin + before.size();
  return visited.document.substr(first, visited.document.find('"', first) - first);
}

// On a telephone nothing but tables and code, which have their own bars, is wider than the page,
// and the verdict with its next step stands on the first screen. The browser of the tests makes no
// window narrower than 500 px.
TEST_F(BrowserPage, FitsANarrowScreen) {
  const std::string seen = seen_by(
      "const next = document.querySelector('.verdict .next').getBoundingClientRect();"
      "return [window.innerWidth <= 500,"
      " document.documentElement.scrollWidth <= window.innerWidth, next.bottom < 700].join();",
      folder_,
      root_ / "browser",
      400);
  EXPECT_EQ(seen, "true,true,true");
}

TEST_F(BrowserPage, UnfoldsForPaperAlone) {
  const std::string seen = seen_by(
      "const count = () => document.querySelectorAll('details[open]').length;"
      "const all = document.querySelectorAll('details').length;"
      "const seen = [count()];"
      "window.dispatchEvent(new Event('beforeprint')); seen.push(count() === all && all > 5);"
      "window.dispatchEvent(new Event('afterprint')); seen.push(count());"
      "return seen.join();",
      folder_,
      root_ / "browser",
      1280);
  EXPECT_EQ(seen, "0,true,0");
}

TEST_F(BrowserPage, DrawsWhatThereIsWhenTablesAreAbsent) {
  std::filesystem::remove_all(root_ / "run" / "tables");
  std::filesystem::remove(folder_.tracking());
  write_report(folder_);
  const Visit seen = visit(folder_.report(), root_ / "browser");
  EXPECT_EQ(seen.console, "");
  EXPECT_NE(seen.document.find("data-figures-drawn=\"2\""), std::string::npos);
}

TEST_F(BrowserPage, DrawsTheFlowOutOfABin) {
  const datasets::RunFolder flow = tests::write_fixture_flow_run(root_ / "flow");
  write_report(flow);
  const Visit seen = visit(flow.report(), root_ / "browser");
  EXPECT_GE(figures_drawn(seen), 3);
  for (const char* id :
       {"flow-curves", "flow-profiles", "flow-beverloo", "compared-figure-velocity-profile"})
    EXPECT_NE(seen.document.find(fmt::format("id=\"{}\"", id)), std::string::npos) << id;
}

// Menus of conditions move together; one that lacks the choice stays.
TEST_F(BrowserPage, MovesMenusOfTheSameKindTogether) {
  const datasets::RunFolder flow = tests::write_fixture_flow_run(root_ / "flow");
  auto result = nlohmann::ordered_json::parse(datasets::read_whole(flow.result()));
  for (const char* condition : {"orifice width 100 mm", "orifice width 200 mm"}) {
    auto other = result["channels"].back();
    other["observable"] = "other";
    other["condition"] = condition;
    result["channels"].push_back(other);
  }
  datasets::write_whole(flow.result(), result.dump());
  std::string page = build_report(flow);
  page.insert(page.rfind("</body>"),
              "<script>const menus = document.querySelectorAll('[id^=compared] select');"
              "const seen = [];"
              "for (const place of [1, 0]) {"
              "menus[0].selectedIndex = place; menus[0].dispatchEvent(new Event('change'));"
              "seen.push(menus[1].selectedOptions[0].textContent);"
              "}"
              "menus[1].selectedIndex = 1; menus[1].dispatchEvent(new Event('change'));"
              "seen.push(menus[0].selectedIndex);"
              "document.body.dataset.seen = seen.join();</script>");
  datasets::write_whole(flow.report(), page);
  const Visit seen = visit(flow.report(), root_ / "browser");
  EXPECT_EQ(seen.console, "");
  EXPECT_NE(seen.document.find("data-seen=\"orifice width 100 mm,orifice width 100 mm,0\""),
            std::string::npos);
}

TEST_F(BrowserPage, DrawsTheSearchOfSeveralExperiments) {
  const datasets::RunFolder several = tests::write_fixture_run_of_several(root_ / "several");
  write_report(several);
  const Visit seen = visit(several.report(), root_ / "browser");
  EXPECT_GE(figures_drawn(seen), 3);
}

// Guards the tests above: a request that the page's policy refuses must show in the console.
TEST_F(BrowserPage, WouldBeRefusedTheNetwork) {
  std::string page = build_report(folder_);
  page.insert(page.find("</body>"), "<img src=\"http://127.0.0.1:9/picture.png\">");
  datasets::write_whole(folder_.report(), page);
  const Visit seen = visit(folder_.report(), root_ / "browser");
  EXPECT_NE(seen.console.find("Content Security Policy"), std::string::npos);
}

}  // namespace
}  // namespace graintruth::reports
