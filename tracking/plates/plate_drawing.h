// A plate over a film or in a simulation.
#pragma once

#include "tracking/particle_tracker.h"
#include "tracking/plates/plate.h"

namespace graintruth::tracking {

// Its rim, and its long axis where that is known; else its nominal lie.
void draw_plate(cv::Mat& picture,
                const Camera& camera,
                const DrawnBody& body,
                const PlateShape& shape);

}  // namespace graintruth::tracking
