// A film of the run beside a simulation at the parameters found, for people who would rather look.
#pragma once

#include "app/run/session.h"
#include "calibrate/ensemble.h"
#include "calibrate/problem.h"

namespace graintruth::app {

// side_by_side.mp4, side_by_side.json and stills in side_by_side/: of the middle condition among
// those calibrated on the film that is nearest to the mean of all, and one simulation of it.
// Nothing where there is no film; a note on the terminal where it cannot be drawn, and no word
// where the user wants to stop.
void draw_side_by_side(Session& session,
                       const calibrate::Problem& problem,
                       const calibrate::EvaluationPoint& point);

}  // namespace graintruth::app
