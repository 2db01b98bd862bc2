// Run folders of an older version, which told the kind of a run and no channels.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "fixture_run.h"
#include "reports/report.h"

namespace graintruth::reports {
namespace {

std::string page_of(const std::string& name) {
  const std::filesystem::path root =
      std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "tests/reports/run_90ba708" / name;
  return tests::spoken(build_report({root}));
}

std::vector<std::string> sections_of(const std::string& page) {
  const std::string before = "<section id=\"";
  std::vector<std::string> ids;
  for (auto at = page.find(before); at != std::string::npos; at = page.find(before, at + 1)) {
    const auto first = at + before.size();
    ids.push_back(page.substr(first, page.find('"', first) - first));
  }
  return ids;
}

void expect_whole(const std::string& page) {
  for (const char* damage : {"This section cannot be made",
                             "is not valid JSON",
                             "holds no JSON object",
                             "holds something else",
                             "cut off",
                             "There is no verdict"})
    EXPECT_EQ(page.find(damage), std::string::npos) << damage;
  // The database is not kept beside the tests
  EXPECT_NE(page.find("The run folder lacks journal.db, which"), std::string::npos);
}

void expect_words(const std::string& page, const std::vector<std::string>& all) {
  for (const std::string& words : all) EXPECT_NE(page.find(words), std::string::npos) << words;
}

using Sections = std::vector<std::string>;

TEST(OldRuns, OfBallsHaveTheirWholeReport) {
  const std::string page = page_of("balls");
  expect_whole(page);
  EXPECT_EQ(sections_of(page),
            (Sections{"verdict",
                      "parameters",
                      "film-and-simulation",
                      "agreement",
                      "tracks",
                      "search",
                      "time-step",
                      "films",
                      "method",
                      "thesis",
                      "provenance"}));
  expect_words(page,
               {"a friction between particles of 0.14 (95 % interval 0.10 to 0.60)",
                "95 % interval of the replicates for 63.9 % of all values (x, z and angle",
                "test of separate models",
                "replicate 5"});
  EXPECT_EQ(page.find("An older version of the program"), std::string::npos);
}

TEST(OldRuns, OfABinHaveTheirWholeReport) {
  const std::string page = page_of("bin");
  expect_whole(page);
  EXPECT_EQ(sections_of(page),
            (Sections{"verdict",
                      "parameters",
                      "film-and-simulation",
                      "compared",
                      "flow",
                      "search",
                      "time-step",
                      "films",
                      "method",
                      "provenance"}));
  expect_words(page,
               {"Predicted, not fitted: the flow through 65 mm",
                "Fitted to the flow through 85 mm and 100 mm",
                "−17.4 %",
                ">Flow rate<",
                ">Remaining<",
                ">0.043<",
                "id=\"flow-curves\"",
                "An older version of the program made this run"});
}

TEST(OldRuns, OfSeveralExperimentsHaveTheirWholeReport) {
  const std::string page = page_of("several");
  expect_whole(page);
  EXPECT_EQ(
      sections_of(page),
      (Sections{
          "verdict", "parameters", "experiments", "search", "time-step", "method", "provenance"}));
  expect_words(page,
               {"balls: agreement 57.2 % (a perfect model: 91.4 %)",
                "bin: flow rates 13.9 % too high on average",
                "<a href=\"balls/report.html\">",
                "56.9 %"});  // 2 x 0.1469 of that and 0.2221
}

}  // namespace
}  // namespace graintruth::reports
