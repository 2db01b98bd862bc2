// Every case of docs/verification.md. A reference that is not beside the source folder is skipped,
// never passed.
#include <gtest/gtest.h>

#include "tests/sim/cases/check.h"

namespace graintruth::sim::cases {

// As gtest prints it
void PrintTo(const Case& one, std::ostream* out) { *out << one.title; }

namespace {

class Verification : public testing::TestWithParam<Case> {};

TEST_P(Verification, Holds) {
  bool is_missing = false;
  for (const Check& check : GetParam().run()) {
    is_missing = is_missing || check.verdict() == Verdict::not_run;
    EXPECT_NE(check.verdict(), Verdict::fail)
        << check.what << ": " << check.residual << (check.at_least ? ", at least " : ", at most ")
        << check.tolerance << " (" << check.source << ")";
  }
  if (is_missing && !HasFailure()) GTEST_SKIP() << "a reference is not beside the source folder";
}

INSTANTIATE_TEST_SUITE_P(Simulator,
                         Verification,
                         testing::ValuesIn(all_cases()),
                         [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace graintruth::sim::cases
