// The outline of a bed as a file.
#include "datasets/store/outline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

using namespace graintruth::datasets;

namespace {

constexpr double unseen = std::numeric_limits<double>::quiet_NaN();

Outline some_outline() {
  Outline outline;
  outline.column = {-0.003, -0.001, 0.001, 0.003};
  outline.time = {-0.02, 0.0, 1.0 / 3.0};
  outline.height = {unseen, 0.1, 0.2, unseen, 0.01, 0.02, unseen, unseen, 0.1, 0.2, 0.3, 0.4};
  outline.sigma = outline.height;
  for (double& sigma : outline.sigma) sigma *= 0.01;
  return outline;
}

void expect_complaint(const std::string& text, const std::string& words) {
  const graintruth::tests::TemporaryFolder folder;
  const auto file = folder.path() / "a.outline.csv";
  std::ofstream(file) << "time_s,column_m,height_m,sigma_m\n" << text;
  try {
    read_outlines(file);
    FAIL() << "nothing was said of " << text;
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

}  // namespace

TEST(Outline, ReadsBackWithTheSameBits) {
  const graintruth::tests::TemporaryFolder folder;
  const auto file = folder.path() / "a.outline.csv";
  const Outline written = some_outline();
  write_outlines(file, {&written, 1});
  const Outline read = read_outlines(file).front();
  EXPECT_EQ(read.column, written.column);
  EXPECT_EQ(read.time, written.time);
  ASSERT_EQ(read.height.size(), written.height.size());
  ASSERT_EQ(read.sigma.size(), written.sigma.size());
  for (std::size_t i = 0; i < written.height.size(); ++i) {
    if (std::isnan(written.height[i])) {
      EXPECT_TRUE(std::isnan(read.height[i]));
    } else {
      EXPECT_EQ(read.height[i], written.height[i]);
      EXPECT_EQ(read.sigma[i], written.sigma[i]);
    }
  }
}

TEST(Outline, FillsColumnsThatAreNeverSeen) {
  const graintruth::tests::TemporaryFolder folder;
  const auto file = folder.path() / "a.outline.csv";
  std::ofstream(file) << "time_s,column_m,height_m\n0,0.001,0.1\n0,0.002,0.1\n0,0.004,0.2\n";
  const Outline read = read_outlines(file).front();
  ASSERT_EQ(read.column.size(), 4u);
  EXPECT_NEAR(read.column[2], 0.003, 1e-12);
  EXPECT_TRUE(std::isnan(read.height[2]));
  EXPECT_TRUE(read.sigma.empty());
}

TEST(Outline, SaysWhatCannotBe) {
  expect_complaint("0,0.001,0.1,0.01\n0,0.001,0.1,0.01\n", ":3: column_m = 0.001 stands twice");
  expect_complaint("1,0.001,0.1,0.01\n0,0.001,0.1,0.01\n", ":3: time_s goes back");
  expect_complaint("0,0.001,0.1,0\n", ":2: sigma_m is a standard uncertainty");
  expect_complaint("0,0.001,0.1,1\n0,0.002,0.1,1\n0,0.0035,0.1,1\n", "whole number of steps");
  expect_complaint("0,,0.1,1\n", ":2: a row needs numbers in time_s and column_m");
}

TEST(Outline, OfSeveralSurfacesIsOneFile) {
  const graintruth::tests::TemporaryFolder folder;
  const auto file = folder.path() / "a.outline.csv";
  std::vector<Outline> written = {some_outline(), some_outline()};
  written[0].surface = "upper";
  written[1].surface = "lower";
  for (double& x : written[1].column) x *= 2.0;
  write_outlines(file, written);
  const std::vector<Outline> read = read_outlines(file);
  ASSERT_EQ(read.size(), 2U);
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].surface, written[i].surface);
    EXPECT_EQ(read[i].column, written[i].column);
    EXPECT_EQ(read[i].time, written[i].time);
    EXPECT_EQ(read[i].height[1], written[i].height[1]);
  }
  // Rows of both may stand by time as well
  std::ofstream(file) << "time_s,surface,column_m,height_m\n0,lower,0.001,0.1\n0,upper,0.001,0.2\n"
                         "1,lower,0.001,0.3\n1,upper,0.001,0.4\n";
  const std::vector<Outline> mixed = read_outlines(file);
  ASSERT_EQ(mixed.size(), 2U);
  EXPECT_EQ(mixed[1].surface, "upper");
  EXPECT_EQ(mixed[1].height, (std::vector<double>{0.2, 0.4}));
}

TEST(Outline, NamesTheSurfaceInEveryRow) {
  const graintruth::tests::TemporaryFolder folder;
  const auto file = folder.path() / "a.outline.csv";
  std::ofstream(file) << "surface,time_s,column_m,height_m\nupper,0,0.001,0.1\n,0,0.002,0.1\n";
  try {
    read_outlines(file);
    FAIL() << "nothing was said";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(":3: surface is empty"), std::string::npos)
        << error.what();
  }
}
