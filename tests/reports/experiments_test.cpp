// The page of several experiments calibrated together.
#include <gtest/gtest.h>

#include "fixture_run.h"
#include "reports/report.h"

namespace graintruth::reports {
namespace {

TEST(SeveralExperiments, TellsWhatEveryExperimentMakesOfTheParameters) {
  const std::filesystem::path root = tests::empty_folder("SeveralExperiments");
  const std::string page = build_report(tests::write_fixture_run_of_several(root / "run"));
  std::filesystem::remove_all(root);
  const auto holds = [&](std::string_view words) {
    EXPECT_NE(page.find(words), std::string::npos) << words;
  };
  holds("Calibration and validation report");  // an orifice was held out
  holds("One set of parameters was sought for 2 experiments");
  holds("agreement 87.2\u00a0% (a perfect model: 91.4\u00a0%)");
  holds("flow rates 2.1\u00a0% too low on average, orifices held out: 1");
  holds("discharge rate and what stays");
  holds("70.0\u00a0%");  // 2 x 0.35 of 0.3 + 2 x 0.35
  holds("<a href=\"piston/report.html\">piston</a>: Balls &lt;on&gt; a piston");
  for (const char* id : {"agreement", "tracks", "compared", "films", "film-and-simulation", "flow"})
    EXPECT_EQ(page.find(std::string("<section id=\"") + id), std::string::npos) << id;
  for (const char* absence : {"lacks measured.json", "tracking.json"})
    EXPECT_EQ(page.find(absence), std::string::npos) << absence;
}

}  // namespace
}  // namespace graintruth::reports
