// The known simulation by which a node is tried before any result of it is taken.
#pragma once

#include "calibrate/engines/simulation_spec.h"

namespace graintruth::calibrate {

// A few clumps that fall into a box, roll and rest, by the embedded engine: every kind of contact,
// every mathematical function that it uses. It takes some hundredths of a second.
SimulationSpec canary_spec();

}  // namespace graintruth::calibrate
