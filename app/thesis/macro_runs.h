// The bin of section 4.3 emptied again and again: five orifices, two ways of filling.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/thesis/examination.h"
#include "app/thesis/studies.h"

namespace graintruth::app {

// All runs of one orifice and one way of filling.
struct OrificeRuns {
  std::string label;     // of the orifice, as the thesis prints it in cm
  double orifice = 0.0;  // m
  Studies::Json runs;

  // The finite ones of a quantity over the fillings. Of each run:
  //   rate (kg/s), density (kg/m2), flowing_fraction: of the steady stretch; fraction: at rest
  //   pauses; arches: pauses before the bed is almost empty, and the jam at the end if there is one
  //   completed
  //   B, B_finite (m): of the velocity profile by the thesis's form, and by an orifice of its width
  std::vector<double> values(const char* key) const;
  Simulated of(const char* key) const { return over_seeds(values(key)); }

  // Mean and standard deviation over the runs, place by place; NaN where not every run knows it.
  //   discharged (kg), solid_fraction: by time (s); velocity (m/s, downwards): by x (m)
  struct Band {
    std::vector<double> mean, spread;
  };
  Band band(const char* key) const;
};

// Runs what is not stored yet.
std::vector<OrificeRuns> run_bins(const ThesisData& thesis, Studies& studies, bool frictionless);

}  // namespace graintruth::app
