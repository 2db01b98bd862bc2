// When a film begins to change, told by its pictures alone: a suggestion before anything is known
// of scale and grains.
#pragma once

#include <optional>
#include <vector>

namespace graintruth::tracking {

struct FirstChange {
  int picture = 0;         // the first that differs as none at rest does
  double certainty = 0.0;  // standard deviations of rest by which the changes exceed it
};

// `changes`: how far each picture after the first is from the first one, in any measure. Nothing
// where no picture stands out after at least five at rest. One or two that stand out alone are
// flicker, or pictures that a codec stores anew.
std::optional<FirstChange> find_first_change(const std::vector<double>& changes);

}  // namespace graintruth::tracking
