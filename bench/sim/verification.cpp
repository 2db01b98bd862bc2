// The page docs/verification.md: every case with source, tolerance, residual and verdict.
// Usage: bench_sim_verification FILE. Exit status 1 when a case fails or a reference is missing.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>

#include "tests/sim/cases/check.h"

namespace {

using namespace graintruth::sim::cases;

const char* word_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass:
      return "PASS";
    case Verdict::falls_short:
      return "SHORT";
    case Verdict::fail:
      return "FAIL";
    case Verdict::not_run:
      return "NOT RUN";
  }
  return "";
}

std::string text_of(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", number);
  return text;
}

struct Tally {
  int of[4] = {};
  void count(Verdict verdict) { of[static_cast<int>(verdict)] += 1; }
  int with(Verdict verdict) const { return of[static_cast<int>(verdict)]; }
};

std::string table_of(const Case& one, Tally& tally) {
  std::string text = std::string("\n## ") + one.title + "\n\n";
  if (*one.note != '\0') text += std::string(one.note) + "\n\n";
  text += "| case | source | tolerance | residual | verdict |\n|---|---|---|---|---|\n";
  for (const Check& check : one.run()) {
    const Verdict verdict = check.verdict();
    tally.count(verdict);
    const std::string bound = (check.at_least ? ">= " : "") + text_of(check.tolerance);
    const std::string found = check.is_missing ? "" : text_of(check.residual);
    text += "| " + check.what + " | " + check.source + " | " + (check.is_missing ? "" : bound) +
            " | " + found + " | " + word_of(verdict) + " |\n";
  }
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: bench_sim_verification FILE\n";
    return EXIT_FAILURE;
  }
  Tally tally;
  std::string tables;
  for (const Case& one : all_cases()) tables += table_of(one, tally);
  for (const Case& one : long_cases()) tables += table_of(one, tally);
  std::string sum;
  for (const Verdict verdict :
       {Verdict::pass, Verdict::falls_short, Verdict::fail, Verdict::not_run}) {
    if (!sum.empty()) sum += ", ";
    sum += std::to_string(tally.with(verdict)) + " " + word_of(verdict);
  }
  const std::string page =
      "# Verification of the simulator\n\n"
      "Made by `./run verify`; do not edit. All cases but the last are tests too (`ctest -R "
      "Verification`); they are\n"
      "defined in `tests/sim/cases/`. A residual is the worst of its line; tolerances are those of "
      "the\n"
      "source. Published curves that are not part of this repository are looked for in\n"
      "`../shared/references`; without them their lines are NOT RUN, never PASS. SHORT: the "
      "residual "
      "is beyond\n"
      "what is asked for, and known to be; tests hold it to where it is.\n\n" +
      sum + ".\n" + tables;
  const std::string draft = std::string(argv[1]) + ".part";
  std::ofstream out(draft);
  out << page;
  out.close();
  if (!out || std::rename(draft.c_str(), argv[1]) != 0) {
    std::cerr << argv[1] << ": cannot be written\n";
    return EXIT_FAILURE;
  }
  std::cout << sum << '\n';
  const bool holds = tally.with(Verdict::fail) + tally.with(Verdict::not_run) == 0;
  return holds ? EXIT_SUCCESS : EXIT_FAILURE;
}
