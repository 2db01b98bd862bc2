// The registry of parameters: everything that a calibration may move, with its name, its unit, the
// values that it can have, and what it sets in a scene. One file of this folder defines a
// parameter, one line of kinds.def makes it known.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/scene/scene_file.h"
#include "datasets/store/units.h"

namespace graintruth::datasets {

struct Material;

struct ParameterKind {
  // Of all of one kind that a rig may have, the beginning of the name: "friction_particle_" is
  // followed by the name of a wall.
  std::string_view name;
  bool is_of_a_wall = false;
  std::string_view unit;  // of its values in every file: SI, "-" where it has none
  Units units;            // that keys of experiment files may give it in
  Range range;            // of the values that it can have at all
  double usual_lower = 0.0, usual_upper = 0.0;  // bounds of a search, where the user states none
  // In reports, alone and within a sentence; a parameter of a wall has the wall's name after it
  std::string_view title;   // "Friction, particle to particle"
  std::string_view phrase;  // "friction between particles"
  // What it is where nothing is stated: the same as another parameter, or else `neutral`.
  std::string_view same_as = {};
  double neutral = 0.0;
  // Of what [material] states beside bench values: that value.
  double (*stated_in)(const Material& material) = nullptr;
  bool sets_stiffness = false;    // where it is tuned, grains are simulated as stiff as it says
  bool is_always_stated = false;  // every experiment gives its bench value, every result its value
  // The measurement that fixes it on the bench: "a drop test of the particle"
  std::string_view bench_test;
  // Why the bench may say otherwise than particles in motion
  std::string_view bench_differs;
  // Sets it in a scene. `wall` is the rest of the name of a parameter of a wall.
  void (*apply)(double value, std::string_view wall, SceneData& scene);
  // What a scene has, where all that it concerns agree.
  std::optional<double> (*value_in)(std::string_view wall, const SceneData& scene);
};

// In the order in which every table shows them and in which they are applied: what is general comes
// before what is special.
std::span<const ParameterKind* const> parameter_kinds();

// A name that an experiment uses, and what it means; none where nobody knows the name.
struct Parameter {
  const ParameterKind* kind = nullptr;
  std::string name;
  std::string wall;  // of a parameter of a wall; else empty

  std::string unit() const { return std::string(kind->unit); }
  std::string title() const;
  std::string phrase() const;
};
std::optional<Parameter> find_parameter(std::string_view name);
// As above, of a name that is known to be one. Throws std::logic_error.
Parameter parameter_named(std::string_view name);

// Whether `first` comes before `second` in tables.
bool comes_before(std::string_view first, std::string_view second);

// The names without those of walls, for sentences.
std::vector<std::string> plain_parameter_names();

}  // namespace graintruth::datasets
