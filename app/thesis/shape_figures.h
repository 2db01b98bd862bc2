// The figures of chapter 5, of our beds.
#pragma once

#include <vector>

#include "app/thesis/shape_runs.h"

namespace graintruth::app {

// Where one bed is drawn, it is the first of its aspect ratio.
void draw_beds(Examination& exam, const ThesisData& thesis, const std::vector<ShapeRuns>& beds);

}  // namespace graintruth::app
