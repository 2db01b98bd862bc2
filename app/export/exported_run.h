// What other programs need of a run: its particle, the contact that was calibrated, and how to see
// that they took it.
#pragma once

#include <string>
#include <vector>

#include "calibrate/parameters.h"
#include "datasets/store/run_folder.h"
#include "sim/laws/material.h"
#include "sim/shapes/clump.h"

namespace graintruth::app {

struct ExportedRun {
  sim::Clump particle;            // long axis along x
  bool has_own_inertia = false;   // stated, other than that of its spheres: a flat plate
  sim::Material material;         // as simulated
  double material_modulus = 0.0;  // Pa; of the experiment, where it was simulated softer
  calibrate::ParameterSet parameters;
  double gravity = 0.0;    // m/s2
  double time_step = 0.0;  // s, as calibrated

  // Of the run, else what it is where nothing is stated: that of a more general parameter, or none.
  double parameter(std::string_view name) const;
  // On the floor of the drop
  double restitution() const { return parameter("restitution_particle_wall"); }
};

// From run.json and result.json. Throws datasets::InputError naming the file and what it lacks.
ExportedRun read_exported_run(const datasets::RunFolder& folder);

// A particle that stands upright and is thrown at a rigid floor without weight: it lands on the
// sphere that reaches farthest, right below its centre of mass.
struct Drop {
  Eigen::Matrix3d upright = Eigen::Matrix3d::Identity();  // turns the particle to stand so
  double speed = 0.0;         // m/s; of a fall by a tenth of the largest sphere's diameter
  double time_step = 0.0;     // s; 200 to a contact, and not above the calibrated one
  double touch_height = 0.0;  // m; of the centre of mass when the sphere touches
  double start_height = 0.0;  // m; one contact duration above that
  long steps = 0;             // ten contact durations
  std::size_t sphere = 0;     // which one lands
};
Drop drop_of(const ExportedRun& run);

}  // namespace graintruth::app
