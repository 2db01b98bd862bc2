// A flat V hopper above a column in which a piston sinks; the throat is at z = 0, x = +-width/2.
#include <cmath>

#include "datasets/rigs/followed_grains.h"
#include "datasets/rigs/rig_kind.h"

namespace graintruth::datasets {

namespace {

void read(RigSection& section, const RigContext& context, Rig& rig) {
  TomlSection& keys = section.rig();
  const double half = 0.5 * keys.quantity("column_width", length_units, positive);
  if (context.particle != nullptr)
    require_passage(section, "column_width", 2.0 * half, *context.particle, Passage::in_one_layer);
  const double depth = keys.quantity("column_depth", length_units, positive);
  const double slope = keys.quantity("slope_angle", angle_units, positive);
  const double height = keys.quantity("slope_height", length_units, positive);
  // Without it every replicate states its own
  const auto speed = section.setting("piston_speed", speed_units, positive, rig);
  const double face = keys.optional_quantity("piston_start_z", length_units).value_or(0.0);
  if (slope >= 90.0 * radians_per_degree) {
    keys.fail(keys.has("slope_angle_deg") ? "slope_angle_deg" : "slope_angle_rad",
              "must be below 90 degrees (measured from the horizontal)");
  }
  const double run = height / std::tan(slope);
  rig.walls = {{"column_left", -half, -depth, -half, 0.0},
               {"column_right", half, -depth, half, 0.0},
               {"slope_left", -half, 0.0, -half - run, height},
               {"slope_right", half, 0.0, half + run, height}};
  rig.moving_face = {
      .face_z = face, .left_x = -half, .right_x = half, .velocity_z = -speed.value_or(0.0)};
  follow_grains(context, rig);
}

}  // namespace

extern constinit const RigKind hopper_column_piston{
    .name = "hopper_column_piston",
    .meaning = "a flat V hopper above a column in which a piston sinks",
    .template_name = "micro",
    .read = read};

}  // namespace graintruth::datasets
