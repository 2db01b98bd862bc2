// What a run must say of its own result. A warning is of one of two classes:
//   first line: it makes the answer doubtful (a film of another rig, failed simulations, a time
//   step
//     that is not resolved). It lowers the mark of the verdict and is named in its reason.
//   detail: an assumption or a limit that a careful reader wants to know.
// A sentence alone is a detail; first_line() makes the other class. In result.json `warnings` holds
// the sentences of both classes, those of the first line first, and `first_line_warnings` holds
// sentence, cause and next step of the first line.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace graintruth::datasets {

enum class WarningClass { first_line, detail };

struct Warning {
  Warning(std::string sentences)  // NOLINT: a sentence is a warning
      : text(std::move(sentences)) {}
  Warning(const char* sentences) : text(sentences) {}  // NOLINT

  WarningClass kind = WarningClass::detail;
  std::string text;   // whole sentences
  std::string cause;  // of the first line: why the answer is doubtful, a clause of at most 15 words
                      // without a full stop: "3 of 940 simulations failed"
  std::string next_step;  // of the first line: what to do, at most 10 words: "Look at ..."

  bool operator==(const Warning&) const = default;
};

Warning first_line(std::string text, std::string cause, std::string next_step);

// Writes `warnings` and `first_line_warnings`.
void add_warnings(std::span<const Warning> warnings, nlohmann::ordered_json& result);

}  // namespace graintruth::datasets
