// What every refusal of the program has in common.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/app/laboratory.h"
#include "tests/support/run_program.h"

namespace graintruth::tests {

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class BadInput : public testing::Test {
 protected:
  std::string out() const { return (folder_ / "out/run").string(); }

  // calibrate on an experiment of this text.
  ProgramOutcome calibrate(const std::string& text) {
    const auto file = folder_.write("experiment.toml", text);
    return run_program({"calibrate", file.string(), "--out", out(), "--quiet"});
  }

  // One line on stderr, a whole sentence that holds all of the parts; exit status 2, and no folder.
  void expect_refusal(const ProgramOutcome& outcome, const std::vector<std::string>& parts) {
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_TRUE(outcome.err.starts_with("graintruth: ")) << outcome.err;
    EXPECT_TRUE(outcome.err.ends_with(".\n") || outcome.err.ends_with("?\n")) << outcome.err;
    for (const std::string& part : parts)
      EXPECT_TRUE(contains(outcome.err, part)) << part << " is not in: " << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
  }

  // The experiment with a film of this content as its third replicate.
  std::string with_film(const std::string& content) {
    const auto film = folder_.write("bad.mp4", content);
    return with(film_experiment(), (bundled_micro() / "rep3.mp4").string(), film.string());
  }

  TemporaryFolder folder_;
};

}  // namespace graintruth::tests
