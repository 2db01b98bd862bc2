// Outlines of heaps in closed form, with the scatter that heaps have: neighbouring columns err
// together, and so do all columns of a flank. For tests of statistics, not of physics.
#pragma once

#include <filesystem>

#include "calibrate/problem.h"
#include "tests/support/closed_engine.h"

namespace graintruth::calibrate::toy {

// A heap of 400 grains of 4 mm, seen from the side. Its slope rises with both frictions between
// particles; how round its top is tells sliding friction a little. Of one filling, which the seed
// draws: both flanks are steeper or flatter together, one more than the other, the top stands
// aside, and grains make the surface rough over their own size, if at all.
datasets::Outline heap(double sliding_friction,
                       double rolling_friction,
                       const std::vector<double>& columns,
                       std::uint64_t seed,
                       bool is_rough = true);

// As the template of a lifted cylinder has it, with free_surface compared and tables that are
// empty, in this folder.
datasets::Experiment heap_experiment(const std::filesystem::path& folder, int replicates);

// The replicates of these frictions, as a problem. Its engine is to be put in.
Problem heap_problem(const datasets::Experiment& experiment,
                     double sliding_friction,
                     double rolling_friction,
                     std::uint64_t seed);

// Chaotic contacts make another heap of the same seed at other parameters; else it scatters alike.
enum class Contacts { chaotic, alike };
tests::ClosedEngine heap_engine(Contacts contacts);

}  // namespace graintruth::calibrate::toy
