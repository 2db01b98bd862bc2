#include "tracking/tracking_summary.h"

#include <utility>

namespace graintruth::tracking {

void TrackingSummary::warn(std::string sentence) {
  warnings.push_back(std::move(sentence));
  if (grade == Grade::ok) grade = Grade::warn;
}

void TrackingSummary::fail(std::string sentence) {
  failures.push_back(sentence);
  warnings.push_back(std::move(sentence));
  grade = Grade::fail;
}

std::string to_string(Grade grade) {
  switch (grade) {
    case Grade::ok:
      return "ok";
    case Grade::warn:
      return "warn";
    case Grade::fail:
      return "fail";
  }
  return "";
}

}  // namespace graintruth::tracking
