// graintruth report --pdf: the page on paper.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "tests/app/laboratory.h"
#include "tests/reports/fixture_run.h"
#include "tests/support/run_program.h"

namespace graintruth::tests {
namespace {

class ReportPdf : public testing::Test {
 protected:
  void SetUp() override { run_ = write_fixture_run(folder_ / "a run, with spaces & 100 %"); }

  TemporaryFolder folder_;
  datasets::RunFolder run_;
};

TEST_F(ReportPdf, HoldsThePageOnSheetsOfA4) {
  if (std::system("command -v chromium >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "chromium is not installed";
  const ProgramOutcome outcome = run_program({"report", run_.root.string(), "--pdf"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.out, run_.report().string() + "\n" + run_.report_pdf().string() + "\n");
  EXPECT_LT(outcome.seconds, 30.0);
  const std::string pdf = content_of(run_.report_pdf());
  EXPECT_TRUE(pdf.starts_with("%PDF-"));
  EXPECT_NE(pdf.find("%%EOF", pdf.size() - 16), std::string::npos);
  // 210 x 297 mm = 595 x 842 points
  EXPECT_NE(pdf.find("/MediaBox [0 0 594.9"), std::string::npos);
  int sheets = 0;
  for (auto at = pdf.find("/Type /Page\n"); at != std::string::npos;
       at = pdf.find("/Type /Page\n", at + 1))
    ++sheets;
  EXPECT_GE(sheets, 8);
  EXPECT_LE(sheets, 25);
}

TEST_F(ReportPdf, NeedsABrowserAndSaysSo) {
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", "/nowhere", 1);
  const ProgramOutcome outcome = run_program({"report", run_.root.string(), "--pdf"});
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("install the package chromium"), std::string::npos) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(run_.report_pdf()));
  EXPECT_TRUE(std::filesystem::exists(run_.report()));
}

// A browser that fails leaves nothing behind.
TEST_F(ReportPdf, IsWrittenWholeOrNotAtAll) {
  const std::filesystem::path fake = folder_.write("chromium", "#!/bin/sh\nexit 1\n");
  std::filesystem::permissions(fake, std::filesystem::perms::all);
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", (folder_.path().string() + ":" + path).c_str(), 1);
  const ProgramOutcome outcome = run_program({"report", run_.root.string(), "--pdf"});
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(outcome.status, 2);
  for (const auto& entry : std::filesystem::directory_iterator(run_.root))
    EXPECT_FALSE(entry.path().filename().string().starts_with("report.pdf")) << entry.path();
}

}  // namespace
}  // namespace graintruth::tests
