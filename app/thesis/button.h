// The buttons of the macro experiment (Table 4.3), which chapter 3 borrows too (errata 1).
#pragma once

#include "app/thesis/thesis_data.h"
#include "sim/laws/material.h"
#include "sim/shapes/profile.h"

namespace graintruth::app {

struct Ellipse {
  double along = 0.0, across = 0.0;  // m; semi-axes
};
Ellipse button_ellipse(const ThesisData& thesis);

sim::Material button_material(const ThesisData& thesis);

// kg/m3, of an elliptic plate.
double button_density(const ThesisData& thesis);

// d = 2 sqrt(ab) (4.6), m.
double button_diameter(const ThesisData& thesis);

// Seven spheres on eight chords, centres about the middle (section 2.2.2).
sim::ProfileFit button_fit(const ThesisData& thesis);

}  // namespace graintruth::app
