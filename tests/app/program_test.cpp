// The verbs seen from outside: help, version and the thesis's own figures.
#include <gtest/gtest.h>

#include "tests/app/laboratory.h"
#include "tests/support/run_program.h"

namespace graintruth::tests {
namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// The verbs that the program itself lists.
std::vector<std::string> verbs() {
  std::istringstream help(run_program({"--help"}).out);
  std::vector<std::string> names;
  bool listed = false;
  for (std::string line; std::getline(help, line);) {
    if (line.starts_with("Subcommands:")) {
      listed = true;
    } else if (listed && line.starts_with("  ") && line[2] != ' ') {
      names.push_back(line.substr(2, line.find(' ', 2) - 2));
    }
  }
  return names;
}

TEST(Program, EveryVerbHasHelpWithAnExample) {
  ASSERT_GE(verbs().size(), 5u);
  for (const std::string& verb : verbs()) {
    const ProgramOutcome help = run_program({verb, "--help"});
    EXPECT_EQ(help.status, 0) << verb;
    EXPECT_TRUE(contains(help.out, "Example:\n  graintruth " + verb)) << help.out;
    EXPECT_EQ(help.err, "");
  }
}

TEST(Program, TellsItsVersion) {
  const ProgramOutcome version = run_program({"--version"});
  EXPECT_EQ(version.status, 0);
  EXPECT_TRUE(version.out.starts_with("0.")) << version.out;
}

TEST(Program, NamesWhatItCanReproduce) {
  const ProgramOutcome list = run_program({"reproduce", "--list"});
  EXPECT_EQ(list.status, 0);
  for (const char* target : {"table-4.2 ", "eq-3.7 ", "deck-f ", "all-quick "})
    EXPECT_TRUE(contains(list.out, target)) << list.out;
}

}  // namespace
}  // namespace graintruth::tests
