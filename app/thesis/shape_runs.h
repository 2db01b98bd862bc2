// All beds and heaps of chapter 5, run or read back.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/thesis/examination.h"
#include "app/thesis/shape_beds.h"

namespace graintruth::app {

using RunOfShape = Studies::Json (*)(const ThesisData&,
                                     int aspect_ratio,
                                     std::uint64_t seed,
                                     const PhaseProgress&);

// What is run, and the printed numbers that it is run with.
struct ShapeKind {
  const char *name, *settings;  // of resimulation.csv
  RunOfShape run;
  std::vector<const char*> printed;
};
extern const ShapeKind bed_kind, heap_kind;

// The runs of one aspect ratio, and what is said of those that failed.
struct ShapeRuns {
  std::string label;
  std::vector<Studies::Json> runs;
  std::string failure;

  Simulated of(const char* key) const;
};

// From spheres to the longest; runs what is not stored yet, each is stored by itself.
std::vector<ShapeRuns> run_all(const ShapeKind& kind, const ThesisData& thesis, Studies& studies);
// What is stored of them, if anything.
std::vector<ShapeRuns> stored_of(const ShapeKind& kind,
                                 const ThesisData& thesis,
                                 const Studies& studies);

}  // namespace graintruth::app
