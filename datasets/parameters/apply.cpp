#include "datasets/parameters/apply.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "datasets/parameters/parameter.h"

namespace graintruth::datasets {

namespace {

std::set<int> materials_of_particles(const SceneData& scene) {
  std::set<int> materials;
  for (const SceneParticle& particle : scene.particles) materials.insert(particle.material);
  return materials;
}

bool is_called(const SceneWall& wall, std::string_view name) {
  return wall.name == name || wall.name.starts_with(fmt::format("{}_", name));
}

// A copy of a material that only the walls of this name have.
int own_material(std::string_view name, int shared, SceneData& scene) {
  const int own = static_cast<int>(scene.materials.size());
  scene.materials.push_back(scene.materials[shared]);
  scene.materials.back().name = name;
  for (std::size_t i = 0, count = scene.surfaces.size(); i < count; ++i) {
    SceneSurfaces copy = scene.surfaces[i];
    if (copy.first != shared && copy.second != shared) continue;
    if (copy.first == shared) copy.first = own;
    if (copy.second == shared) copy.second = own;
    scene.surfaces.push_back(copy);
  }
  for (SceneWall& wall : scene.walls) {
    if (is_called(wall, name) && wall.material == shared) wall.material = own;
  }
  return own;
}

}  // namespace

void apply_parameters(const ParameterSet& parameters, SceneData& scene) {
  for (const auto& [name, value] : parameters) {
    const Parameter parameter = parameter_named(name);
    parameter.kind->apply(value, parameter.wall, scene);
  }
}

void for_particle_particle(SceneData& scene, const std::function<void(SceneSurfaces&)>& set) {
  const std::set<int> particles = materials_of_particles(scene);
  for (SceneSurfaces& surfaces : scene.surfaces) {
    if (particles.contains(surfaces.first) && particles.contains(surfaces.second)) set(surfaces);
  }
}

void for_particle_wall(SceneData& scene, const std::function<void(SceneSurfaces&)>& set) {
  const std::set<int> particles = materials_of_particles(scene);
  for (SceneSurfaces& surfaces : scene.surfaces) {
    if (particles.contains(surfaces.first) != particles.contains(surfaces.second)) set(surfaces);
  }
}

void for_particle_on(std::string_view wall,
                     SceneData& scene,
                     const std::function<void(SceneSurfaces&)>& set) {
  const std::set<int> particles = materials_of_particles(scene);
  std::set<int> materials;
  for (const SceneWall& one : scene.walls) {
    if (is_called(one, wall)) materials.insert(one.material);
  }
  for (int material : materials) {
    const bool is_shared =
        particles.contains(material) ||
        std::any_of(scene.walls.begin(), scene.walls.end(), [&](const SceneWall& other) {
          return other.material == material && !is_called(other, wall);
        });
    if (is_shared) material = own_material(wall, material, scene);
    for (SceneSurfaces& surfaces : scene.surfaces) {
      const int first = surfaces.first, second = surfaces.second;
      if ((first == material && particles.contains(second)) ||
          (second == material && particles.contains(first)))
        set(surfaces);
    }
  }
}

namespace {

// Surfaces of a copy of the scene, which the setters may change.
class Agreed {
 public:
  explicit Agreed(Member member) : member_(member) {}
  void look_at(const SceneSurfaces& surfaces) {
    differs_ |= value_ && *value_ != surfaces.*member_;
    value_ = surfaces.*member_;
  }
  std::optional<double> value() const { return differs_ ? std::nullopt : value_; }

 private:
  Member member_;
  std::optional<double> value_;
  bool differs_ = false;
};

template <class Visit>
std::optional<double> agreed(const SceneData& scene, Member member, Visit visit) {
  Agreed agreed(member);
  SceneData copy = scene;
  visit(copy, [&](SceneSurfaces& surfaces) { agreed.look_at(surfaces); });
  return agreed.value();
}

}  // namespace

std::optional<double> between_particles(const SceneData& scene, Member member) {
  return agreed(scene, member, for_particle_particle);
}

std::optional<double> between_particle_and_wall(const SceneData& scene, Member member) {
  return agreed(scene, member, for_particle_wall);
}

std::optional<double> on_wall(std::string_view wall, const SceneData& scene, Member member) {
  return agreed(
      scene, member, [&](SceneData& copy, const auto& look) { for_particle_on(wall, copy, look); });
}

std::optional<double> on_all(const SceneData& scene, Member member) {
  return agreed(scene, member, [](SceneData& copy, const auto& look) {
    for (SceneSurfaces& surfaces : copy.surfaces) look(surfaces);
  });
}

bool has_wall(const SceneData& scene, std::string_view wall) {
  return std::any_of(scene.walls.begin(), scene.walls.end(), [&](const SceneWall& one) {
    return is_called(one, wall);
  });
}

}  // namespace graintruth::datasets
