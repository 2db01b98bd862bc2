// Figures 4.12 to 4.18 of the thesis of our bins, with what the thesis prints of its own.
#pragma once

#include "app/thesis/macro_runs.h"

namespace graintruth::app {

// The same orifices, filled with friction and without.
struct MacroRuns {
  std::vector<OrificeRuns> with_friction, without_friction;
};

void draw_bins(Examination& exam, const ThesisData& thesis, const MacroRuns& runs);

}  // namespace graintruth::app
