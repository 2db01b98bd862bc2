#include "datasets/verdict/warning.h"

#include <nlohmann/json.hpp>

namespace graintruth::datasets {

Warning first_line(std::string text, std::string cause, std::string next_step) {
  Warning warning(std::move(text));
  warning.kind = WarningClass::first_line;
  warning.cause = std::move(cause);
  warning.next_step = std::move(next_step);
  return warning;
}

void add_warnings(std::span<const Warning> warnings, nlohmann::ordered_json& result) {
  auto sentences = nlohmann::ordered_json::array(), first = sentences;
  for (const Warning& warning : warnings) {
    if (warning.kind != WarningClass::first_line) continue;
    sentences.push_back(warning.text);
    first.push_back(
        {{"text", warning.text}, {"cause", warning.cause}, {"next_step", warning.next_step}});
  }
  for (const Warning& warning : warnings)
    if (warning.kind == WarningClass::detail) sentences.push_back(warning.text);
  result["warnings"] = std::move(sentences);
  result["first_line_warnings"] = std::move(first);
}

}  // namespace graintruth::datasets
