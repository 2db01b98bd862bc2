// The page of several experiments calibrated together.
#include <gtest/gtest.h>

#include "fixture_run.h"
#include "reports/report.h"

namespace graintruth::reports {
namespace {

TEST(JointReport, TellsWhatEveryExperimentMakesOfTheParameters) {
  const std::filesystem::path root = tests::empty_folder("JointReport");
  const std::string page = build_report(tests::write_fixture_joint_run(root / "run"));
  std::filesystem::remove_all(root);
  const auto holds = [&](std::string_view words) {
    EXPECT_NE(page.find(words), std::string::npos) << words;
  };
  holds("Calibration and validation report");  // an orifice was held out
  holds("One set of parameters was sought for 2 experiments");
  holds("agreement 87.2\u00a0% (a perfect model: 91.4\u00a0%)");
  holds("flow rates 2.1\u00a0% too low on average, 1 orifice(s) held out");
  holds("70.0\u00a0%");  // 2 x 0.35 of 0.3 + 2 x 0.35
  holds("<a href=\"piston/report.html\">piston</a>: Balls &lt;on&gt; a piston");
  for (const char* id : {"agreement", "tracks", "films", "flow"})
    EXPECT_EQ(page.find(std::string("<section id=\"") + id), std::string::npos) << id;
  for (const char* absence : {"No agreement with tracks", "lacks measured.json", "tracking.json"})
    EXPECT_EQ(page.find(absence), std::string::npos) << absence;
}

TEST(JointReport, SaysSoWhereTheExperimentsAreMissing) {
  const std::filesystem::path root = tests::empty_folder("JointReport");
  const datasets::RunFolder folder = tests::write_fixture_joint_run(root / "run");
  std::string text = datasets::read_whole(folder.result());
  const std::string key = "\"experiments\"";
  text.replace(text.find(key), key.size(), "\"trials\"");
  datasets::write_whole(folder.result(), text);
  const std::string page = build_report(folder);
  std::filesystem::remove_all(root);
  EXPECT_NE(page.find("does not name the experiments"), std::string::npos);
}

}  // namespace
}  // namespace graintruth::reports
