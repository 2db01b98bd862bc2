// Beds and heaps of chapter 5 of the thesis: how they are made, run, and measured.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/thesis/studies.h"
#include "app/thesis/thesis_data.h"

namespace graintruth::app {

// For the runs of beds and heaps: the phase, how much of it is done, and where it is.
using PhaseProgress =
    std::function<void(const std::string& phase, double share, const std::string& detail)>;

// The scene that beds and heaps are made from.
std::filesystem::path scene_of_hopper();

// One bed of grains of this aspect ratio from its lattice to its discharge: what was measured of
// it, by name, or only `failed`: what went wrong.
Studies::Json run_bed(const ThesisData& thesis,
                      int aspect_ratio,
                      std::uint64_t seed,
                      const PhaseProgress& progress);

// A heap poured into the middle of the same hopper, its orifice closed, at the thesis's speed of
// impact: its slope, or `failed`.
Studies::Json run_heap(const ThesisData& thesis,
                       int aspect_ratio,
                       std::uint64_t seed,
                       const PhaseProgress& progress);

}  // namespace graintruth::app
