// Any scene file of `graintruth simulate` as a rig, with its grains, walls, filling and times.
#include <fmt/format.h>

#include <cmath>

#include "datasets/rigs/rig_kind.h"

namespace graintruth::datasets {

namespace {

// Segments of a planar scene, as a camera sees them.
std::vector<Wall> seen_walls(const SceneData& scene) {
  std::vector<Wall> walls;
  for (const SceneWall& wall : scene.walls) {
    if (wall.kind != SceneWall::Kind::segment || !wall.motion.velocity.isZero(0.0)) continue;
    walls.push_back({wall.name,
                     wall.points[0].x(),
                     wall.points[0].z(),
                     wall.points[1].x(),
                     wall.points[1].z()});
  }
  return walls;
}

void read(RigSection& section, const RigContext& context, Rig& rig) {
  TomlSection& keys = section.rig();
  const std::filesystem::path file = context.folder / keys.text("scene");
  if (!std::filesystem::is_regular_file(file))
    keys.fail("scene", fmt::format("names '{}', but there is no such file", file.string()));
  const SceneFile scene = load_scene(file);
  if (context.inputs) {
    context.inputs->push_back(file);
    context.inputs->insert(context.inputs->end(), scene.inputs.begin(), scene.inputs.end());
  }
  if (context.notes)
    context.notes->insert(context.notes->end(), scene.warnings.begin(), scene.warnings.end());
  rig.scene = scene;
  rig.gravity = scene.gravity.norm();
  rig.walls = seen_walls(scene);
  rig.begins_from = BeginsFrom::filling;
  if (scene.exit_height) rig.observables = {"discharge_rate", "what_stays"};
}

}  // namespace

extern constinit const RigKind scene_of_a_file{.name = "scene",
                                               .meaning = "any scene file of 'graintruth simulate'",
                                               .brings_grains = true,
                                               .read = read};

}  // namespace graintruth::datasets
