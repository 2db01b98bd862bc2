// The grain of an experiment: what is simulated for it, and what a camera sees of it.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "datasets/experiment/named_body.h"
#include "datasets/scene/scene_file.h"
#include "datasets/store/toml_section.h"

namespace graintruth::datasets {

// One ball of the nominal particle, on its long axis.
struct AxialSphere {
  double offset = 0.0;  // m, centre along the long axis, from the particle's nominal centre of mass
  double radius = 0.0;  // m
};

// A flat plate with an elliptical outline that stands upright in the picture plane: a button.
struct EllipticalPlate {
  double semi_major = 0.0;  // m
  double semi_minor = 0.0;  // m
  double thickness = 0.0;   // m, along y

  // A disc looks the same however it turns: the outline of what is rounder than this tells no
  // angle.
  bool shows_angle() const { return semi_major > 1.05 * semi_minor; }
};

struct Particle {
  int count = 0;        // how many lie in the rig; 0 where a film need not tell
  double mass = 0.0;    // kg, of one
  SceneParticle model;  // what is simulated for one, its long axis along x
  // In the picture plane
  double diameter = 0.0;             // m, of a disc of the area that is seen
  double seen_area = 0.0;            // m2
  double length = 0.0;               // m, of the long axis
  double half_width = 0.0;           // m, half of its extent across that
  double thickness = 0.0;            // m, across the panes
  bool shows_angle = true;           // how it is turned can be seen
  std::vector<AxialSphere> spheres;  // where balls on the long axis make it up; else empty
  std::optional<NamedBody> body;     // what the camera sees, where that is not the spheres
};

// What an experiment file is read for. Films can be tracked without a rig, materials, masses or a
// second replicate; what is given is checked all the same.
enum class Purpose { calibration, tracking };

// [particle]. Shapes are those of scene files; spheres may also be given by their offset on the
// long axis, a plate by its half axes and thickness, and what a camera sees as a named body.
//
// `rig_may_count`: how many there are may be left to the rig; then count is 0.
Particle read_particle(TomlSection section,
                       Purpose purpose,
                       bool rig_may_count,
                       const std::filesystem::path& folder,
                       std::vector<std::filesystem::path>& inputs);
void set_count(int count, Particle& particle);
// As many grains as the model stands for one of. The mass is that stated, else NaN.
Particle particle_of(const SceneParticle& model, int count);
// That of a scene which brings its own; more than one kind of grain has the first one's looks.
Particle particle_of(const SceneData& scene);

// Of any sphere of the model, or half its width, m.
double largest_radius(const SceneParticle& model);

// m: no grain passes an opening that is narrower. Across the picture, or in three dimensions across
// its panes too; of grains of several sizes, of the smallest.
enum class Passage { in_one_layer, in_three_dimensions };
double narrowest_width(const Particle& particle, Passage passage);

// kg/m3, as far as the shape tells without a calculation of its volume; 0 and infinity where it
// tells nothing, or no mass is stated.
struct DensityBounds {
  double lower = 0.0, upper = 0.0;
};
DensityBounds density_bounds(const Particle& particle);

// Throws InputError at the mass where no solid is so dense. Notes a density below that of solids.
void check_density(TomlSection section,
                   const Particle& particle,
                   const std::filesystem::path& file,
                   std::vector<std::string>& notes);

}  // namespace graintruth::datasets
