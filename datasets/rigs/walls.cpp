// Walls stated one by one, and a piston if there is one.
#include "datasets/rigs/followed_grains.h"
#include "datasets/rigs/rig_kind.h"

namespace graintruth::datasets {

namespace {

void read(RigSection& section, const RigContext& context, Rig& rig) {
  TomlSection& keys = section.rig();
  for (TomlSection& wall : keys.sections("wall")) {
    rig.walls.push_back({wall.optional_text("name").value_or(""),
                         wall.quantity("from_x", length_units),
                         wall.quantity("from_z", length_units),
                         wall.quantity("to_x", length_units),
                         wall.quantity("to_z", length_units)});
    const Wall& made = rig.walls.back();
    if (made.from_x == made.to_x && made.from_z == made.to_z) {
      wall.fail("to_x_m", "makes a wall of no length: from and to are the same point");
    }
    wall.finish();
  }
  if (auto piston = keys.optional_section("piston")) {
    rig.moving_face = {.face_z = piston->quantity("face_z", length_units),
                       .left_x = piston->quantity("left_x", length_units),
                       .right_x = piston->quantity("right_x", length_units),
                       .velocity_z = piston->quantity("velocity_z", speed_units)};
    if (!(rig.moving_face->left_x < rig.moving_face->right_x)) {
      piston->fail("right_x_m", "must lie to the right of left_x");
    }
    piston->finish();
  }
  if (rig.walls.empty()) keys.fail("wall", "is missing; at least one [[rig.wall]] is needed");
  follow_grains(context, rig);
}

}  // namespace

extern constinit const RigKind walls_one_by_one{
    .name = "walls", .meaning = "walls one by one, with or without a piston", .read = read};

}  // namespace graintruth::datasets
