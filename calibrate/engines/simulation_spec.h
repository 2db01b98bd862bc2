// Everything that decides one simulation: plain data, written and read as JSON. Its fingerprint
// names the simulation in the journal, in caches and in run.json.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "datasets/experiment/simulator.h"
#include "datasets/parameters/parameter_set.h"
#include "datasets/scene/scene_file.h"
#include "datasets/store/outline.h"
#include "datasets/store/trajectories.h"

namespace graintruth::calibrate {

// Grains of one layer that begin where a film shows them: at these poses, each moved by a draw of
// the standard deviations. Without poses the scene's own filling counts.
struct FilmedStart {
  std::vector<datasets::Pose> poses;
  datasets::Pose standard_deviation{0.0, 0.0, 0.0};
};

// In which columns the outline of a surface is kept, and seen from where.
struct OutlinePlan {
  std::vector<double> columns;  // m, middles of columns of equal width
  datasets::Eye eye;
  std::string surface = {};  // its name; empty where the rig has one
  std::optional<double> from_z = {},
                        to_z = {};  // m; of balls whose middles lie between these alone
};

// What is kept of a simulation, at the frames of the phases from the event on.
struct RecordPlan {
  bool tracks = true;
  std::vector<std::string> curves;  // by the names of recording.h
  std::vector<OutlinePlan> outlines = {};
};

struct SimulationSpec {
  std::string engine = "embedded";
  std::string engine_version;         // of the numbers that it gives
  datasets::ParameterSet parameters;  // as asked for; what they set stands in the scene
  double time_step_fraction = 0.0;    // of the Rayleigh step, thesis eq 1.28 with pi
  std::uint64_t seed = 0;             // draws everything that is drawn
  datasets::SceneData scene;
  FilmedStart start;
  RecordPlan record;
  std::optional<datasets::ForeignEngine> foreign = {};  // of an engine that is another program
};

// Throws std::invalid_argument that names the field where the text is no spec.
std::string to_text(const SimulationSpec& spec);
SimulationSpec spec_from_text(const std::string& text);

// 32 hexadecimal digits of the text.
std::string fingerprint_of(const SimulationSpec& spec);

// What a person would call the parts of a spec, and the fingerprint of each: to say what changed.
using SpecParts = std::vector<std::pair<std::string, std::string>>;
SpecParts parts_of(const SimulationSpec& spec);

}  // namespace graintruth::calibrate
