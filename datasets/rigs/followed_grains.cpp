#include "datasets/rigs/followed_grains.h"

#include <cmath>

namespace graintruth::datasets {

namespace {

constexpr double settling_time = 0.3;  // s of rest on the still face before the event

// The fastest collision that must be resolved: a fall by a tenth of the largest ball's diameter,
// which grains that follow a slow face rarely exceed; the time-step gate checks what that leaves
// out.
double fastest_impact(const Particle& particle, double gravity) {
  return std::sqrt(2.0 * gravity * 0.1 * 2.0 * largest_radius(particle.model));
}

}  // namespace

SceneWall segment_of(const Wall& wall) {
  SceneWall made;
  made.name = wall.name;
  made.material = wall_material;
  made.kind = SceneWall::Kind::segment;
  made.points = {{wall.from_x, 0.0, wall.from_z}, {wall.to_x, 0.0, wall.to_z}};
  return made;
}

void follow_grains(const RigContext& context, Rig& rig) {
  for (const Wall& wall : rig.walls) rig.scene.walls.push_back(segment_of(wall));
  if (const auto& face = rig.moving_face) {
    SceneWall wall =
        segment_of({"piston", face->left_x, face->face_z, face->right_x, face->face_z});
    wall.motion.velocity = {0.0, 0.0, face->velocity_z};
    rig.scene.walls.push_back(std::move(wall));
  }
  rig.begins_from = BeginsFrom::mean_of_replicates;
  rig.observables = {"tracks"};
  const double impact = fastest_impact(*context.particle, rig.gravity);
  rig.scene.phases = {{.name = "settle",
                       .duration = settling_time,
                       .fastest_impact = impact,
                       .restitution_at_most = settling_restitution},
                      {.name = "run", .fastest_impact = impact}};
  rig.scene.event_phase = 1;
}

}  // namespace graintruth::datasets
