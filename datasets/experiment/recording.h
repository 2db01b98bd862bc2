// What one replicate shows, filmed, weighed or simulated: the one form in which experiment and
// simulation meet, so that both are measured by the same functions. Any part may be missing.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/imports/discharge_curve.h"
#include "datasets/store/outline.h"
#include "datasets/store/trajectories.h"

namespace graintruth::datasets {

// A quantity in time, or a single number without one.
struct Curve {
  std::vector<double> time;   // s from the start event, rising; empty: values have no time
  std::vector<double> value;  // SI
  std::vector<double> sigma;  // standard uncertainty of each; empty where none is known
};

struct Recording {
  std::optional<Trajectories> tracks;       // grains as the camera sees them
  std::vector<Outline> outlines;            // the free surfaces of the bed, each once
  std::optional<DischargeCurve> discharge;  // mass that has left
  std::map<std::string, Curve> curves;      // by name, with the unit at its end: lid_force_n
  std::vector<std::string> notes;           // sentences on how the files were understood

  // By the name of its surface; null where it was not recorded.
  const Outline* outline_of(std::string_view surface) const {
    for (const Outline& outline : outlines)
      if (outline.surface == surface) return &outline;
    return nullptr;
  }
};

}  // namespace graintruth::datasets
