// What chapter 5 of the thesis draws of a bed: where it is dense, where marked grains go, which
// grains are fast, and how the walls are pressed. Kept by a run so that its report can draw it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "app/thesis/studies.h"
#include "calibrate/engines/scene_run.h"

namespace graintruth::app {

double top_of(const std::vector<sim::Vec3>& centres);  // m

// The mesh of section 5.3.1, from the left wall and the floor on.
struct Squares {
  double side = 0.0;   // m
  double width = 0.0;  // m, of the hopper
};

// Solid fraction of each square that holds a grain's centre: `x` and `z` of its middle, m, and
// `fraction`. `area` of a grain in the picture plane, m2.
Studies::Json solid_fraction_of_squares(const std::vector<sim::Vec3>& centres,
                                        const Squares& squares,
                                        double area);

// Normal force on the side walls by tenths of the height of the bed at rest, from below, N; mean of
// both walls, in the first frame after the opening.
std::vector<double> force_by_tenths(const datasets::SceneFile& file,
                                    const calibrate::SceneRun& run,
                                    std::size_t rest);

// The same of the left wall against `time` since the opening, s, until `until`: one list a tenth.
Studies::Json wall_history(const datasets::SceneFile& file,
                           const calibrate::SceneRun& run,
                           std::size_t rest,
                           double until);

// Grains below `height` (m) by their share of the largest speed among them: `x`, `z`, m, and
// `class`, 0 slow, 1 between, 2 fast (Figure 5.18).
Studies::Json speed_classes(const sim::State& state, double height, double slow, double fast);

// Of the grains that lie nearest to the middles of `in_a_row` by `in_a_row` equal fields of the
// bed, row by row from below, frame by frame until they have left: `x` and `z`, m, `turned`,
// degrees since rest, and `sideways`, m/s, the speed along x.
Studies::Json paths_of_marked(const calibrate::SceneRun& run,
                              std::size_t rest,
                              double width,
                              int in_a_row);

}  // namespace graintruth::app
