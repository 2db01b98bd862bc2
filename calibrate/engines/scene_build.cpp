#include "calibrate/engines/scene_build.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <set>
#include <stdexcept>
#include <utility>

#include "datasets/store/input_error.h"
#include "sim/laws/elementary.h"
#include "sim/laws/restitution.h"
#include "sim/shapes/profile.h"

namespace graintruth::calibrate {

namespace {

using datasets::InputError;
using datasets::SceneData;
using datasets::SceneParticle;
using datasets::SceneWall;
using datasets::SizeSpread;

// Spheres whose origin is farther from their centre of mass than this share of their length are
// warned of, because the places that they are given are those of the centre of mass.
constexpr double noteworthy_offset = 0.005;
constexpr double noteworthy_protrusion = 0.01;  // of the length

// x with P(X < x) = share of a standard normal X, by bisection.
double normal_quantile(double share) {
  double low = -7.0, high = 7.0;  // within the range of exact_erf
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (0.5 + 0.5 * sim::exact_erf(middle / std::sqrt(2.0)) < share ? low : high) = middle;
  }
  return low;
}

// Middles of equally likely classes, shifted and stretched to mean 1 and the given deviation.
std::vector<double> size_classes(const SizeSpread& size) {
  if (size.kind == SizeSpread::Kind::none) return {1.0};
  std::vector<double> middles;
  for (int i = 0; i < size.classes; ++i) {
    const double share = (i + 0.5) / size.classes;
    if (size.kind == SizeSpread::Kind::uniform) {
      middles.push_back(share);
    } else {
      const double normal = normal_quantile(share);
      const double spread =
          std::sqrt(sim::exact_log1p(size.standard_deviation * size.standard_deviation));
      middles.push_back(size.kind == SizeSpread::Kind::normal ? normal
                                                              : sim::exact_exp(spread * normal));
    }
  }
  double mean = 0.0, variance = 0.0;
  for (const double middle : middles) mean += middle / size.classes;
  for (const double middle : middles) variance += (middle - mean) * (middle - mean) / size.classes;
  for (double& middle : middles) {
    middle = 1.0 + size.standard_deviation * (middle - mean) / std::sqrt(variance);
  }
  return middles;
}

std::vector<sim::ElementSphere> shape_of(const SceneParticle& particle, double& protrusion) {
  if (particle.profile) {
    const datasets::SceneProfile& given = *particle.profile;
    std::vector<sim::ProfilePoint> points;
    for (const auto& [x, y] : given.points) points.push_back({x, y});
    const sim::Profile profile = points.empty()
                                     ? sim::ellipse_profile(given.ellipse[0], given.ellipse[1])
                                     : sim::Profile(std::move(points));
    sim::ProfileFit fit = sim::fit_profile(profile, given.chords);
    protrusion = fit.protrusion;
    return std::move(fit.spheres);
  }
  if (particle.chain) {
    const double radius = particle.chain->ball_radius;
    const double volume =
        sim::mass_properties_of_union(sim::chain_of_spheres(1, radius, 0.0)).volume;
    return sim::chain_of_volume(particle.chain->count, particle.chain->aspect_ratio, volume);
  }
  std::vector<sim::ElementSphere> spheres;
  for (const datasets::SceneSphere& sphere : particle.spheres) {
    spheres.push_back({sphere.centre, sphere.radius});
  }
  return spheres;
}

sim::Clump scaled_clump(const SceneParticle& particle,
                        const std::vector<sim::ElementSphere>& nominal,
                        double scale) {
  std::vector<sim::ElementSphere> spheres = nominal;
  for (sim::ElementSphere& sphere : spheres) {
    sphere.centre *= scale;
    sphere.radius *= scale;
  }
  sim::MassChoice choice;
  choice.density = particle.density;
  if (particle.mass) choice.mass = *particle.mass * sim::exact_pow(scale, 3);
  if (particle.inertia) choice.inertia = *particle.inertia * sim::exact_pow(scale, 5);
  return sim::make_clump(std::move(spheres), choice, particle.material);
}

EnclosingBall enclosing_ball(const sim::Clump& clump) {
  sim::Vec3 low = clump.spheres.front().centre, high = low;
  for (const sim::ElementSphere& sphere : clump.spheres) {
    low = low.cwiseMin(sphere.centre - sim::Vec3::Constant(sphere.radius));
    high = high.cwiseMax(sphere.centre + sim::Vec3::Constant(sphere.radius));
  }
  EnclosingBall ball{0.5 * (low + high), 0.0};
  for (const sim::ElementSphere& sphere : clump.spheres) {
    ball.radius = std::max(ball.radius, (sphere.centre - ball.centre).norm() + sphere.radius);
  }
  return ball;
}

bool lies_on_a_line(const std::vector<sim::ElementSphere>& spheres) {
  return std::all_of(spheres.begin(), spheres.end(), [](const sim::ElementSphere& sphere) {
    return sphere.centre.y() == 0.0 && sphere.centre.z() == 0.0;
  });
}

// To a thousandth of a millimetre, and 0 without a sign.
double in_mm(double metres) { return std::round(1e6 * metres) / 1e3 + 0.0; }

void add_particle(const SceneParticle& particle, BuiltScene& built) {
  ParticleKind kind;
  const std::vector<sim::ElementSphere> nominal = shape_of(particle, kind.protrusion);
  if (lies_on_a_line(nominal)) kind.roughness = sim::surface_error_of(nominal);
  for (const double scale : size_classes(particle.size)) {
    sim::Clump clump = scaled_clump(particle, nominal, scale);
    if (particle.inertia && !clump.input_from_body.isApprox(sim::Quat::Identity())) {
      throw std::invalid_argument(
          "inertia can be given only where the axes of the shape are "
          "principal, but here they are not");
    }
    built.enclosing.push_back(enclosing_ball(clump));
    kind.types.push_back(built.scene.add_type(std::move(clump)));
  }
  const sim::Clump& clump = built.scene.types[kind.types.front()];
  if (clump.merged_spheres > 0) {
    built.warnings.push_back(
        fmt::format("{} of the spheres of '{}' stand in it twice; they count once.",
                    clump.merged_spheres,
                    particle.name));
  }
  const double length = 2.0 * built.enclosing[kind.types.front()].radius;
  if (!particle.spheres.empty() && clump.centre_in_input.norm() > noteworthy_offset * length) {
    built.warnings.push_back(fmt::format(
        "The centre of mass of '{}' lies {:.2f} % of its length off the origin of its shape, at x "
        "{:.4g}, y {:.4g}, z {:.4g} mm; places are those of the centre of mass, so move its "
        "spheres "
        "by x {:.4g}, y {:.4g}, z {:.4g} mm.",
        particle.name,
        100.0 * clump.centre_in_input.norm() / length,
        in_mm(clump.centre_in_input.x()),
        in_mm(clump.centre_in_input.y()),
        in_mm(clump.centre_in_input.z()),
        in_mm(-clump.centre_in_input.x()),
        in_mm(-clump.centre_in_input.y()),
        in_mm(-clump.centre_in_input.z())));
  }
  if (kind.protrusion > noteworthy_protrusion * length) {
    built.warnings.push_back(
        fmt::format("A sphere of '{}' reaches {:.2f} mm outside the profile; give more chords, or "
                    "accept it where the profile turns sharply.",
                    particle.name,
                    1e3 * kind.protrusion));
  }
  built.kinds.push_back(std::move(kind));
}

// `body` is the number that parts of one rigid body get, `merged` the facets of a mesh that stood
// in it before.
std::vector<sim::Wall> walls_of(const SceneWall& wall, int body, int& merged) {
  using Kind = SceneWall::Kind;
  const auto& points = wall.points;
  switch (wall.kind) {
    case Kind::segment:
      return {sim::segment_wall(sim::into_plane(points[0]), sim::into_plane(points[1]))};
    case Kind::plane:
      return {sim::plane_wall(points[0], wall.normal)};
    case Kind::polygon:
      return {sim::polygon_wall(points)};
    case Kind::disk:
      return {sim::disk_wall(points[0], wall.normal, wall.radius)};
    case Kind::cylinder:
      return {sim::cylinder_wall(points[0], points[1], wall.radius)};
    case Kind::mesh: {
      sim::MeshWalls mesh = sim::mesh_walls(points, body);
      merged = mesh.merged;
      return mesh.facets;
    }
  }
  return {};
}

// The number of the rigid body of which a wall, or the facets of a mesh, are parts.
int body_of_wall(const SceneData& file, std::size_t wall, const BuiltScene& built) {
  for (std::size_t w = 0; w < built.owner.size(); ++w) {
    const std::string& body = file.walls[built.owner[w]].body;
    if (!body.empty() && body == file.walls[wall].body) return built.scene.walls[w].body;
  }
  return built.scene.next_wall_body();
}

sim::WallMotion motion_of(const datasets::SceneMotion& motion, double event) {
  return {.velocity = motion.velocity,
          .start_time = event + motion.start,
          .end_time = event + motion.end,
          .angular_velocity = motion.angular_velocity,
          .pivot = motion.pivot};
}

// What stands in a scene is checked by the simulator, whose sentences get the name of the file.
template <class Function>
void naming(const std::string& origin, const std::string& what, Function function) {
  try {
    function();
  } catch (const std::invalid_argument& error) {
    std::string_view complaint = error.what();
    constexpr std::string_view of_simulator = "Scene: ";
    if (complaint.starts_with(of_simulator)) complaint.remove_prefix(of_simulator.size());
    throw InputError(fmt::format("{}: {}{}.", origin, what, complaint));
  }
}

// Walls are not repeated: each is the same along a periodic axis, or ends where no grain on the
// other side can see its end.
void check_wall_at_period(const BuiltScene& built,
                          std::size_t owner,
                          const SceneWall& wall,
                          double reach) {
  constexpr double parallel = 1e-9;
  constexpr double endless = std::numeric_limits<double>::infinity();
  sim::Vec3 low = sim::Vec3::Constant(endless), high = -low;
  for (std::size_t w = 0; w < built.owner.size(); ++w) {
    if (built.owner[w] != static_cast<int>(owner)) continue;
    const sim::Box box = sim::box_of(built.scene.walls[w]);
    low = low.cwiseMin(box.low);
    high = high.cwiseMax(box.high);
  }
  const sim::Period& period = built.scene.period;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(period.length[axis] > 0.0)) continue;
    const double from = period.low[axis], to = from + period.length[axis];
    const auto refuse = [&](const std::string& what) {
      throw InputError(
          fmt::format("{}: wall '{}' {} along {}.", built.origin, wall.name, what, "xyz"[axis]));
    };
    if (wall.kind == SceneWall::Kind::plane && std::abs(wall.normal.normalized()[axis]) > parallel)
      refuse("is not the same everywhere, but the scene is periodic");
    if (wall.motion.velocity[axis] != 0.0) refuse("moves, but the scene is periodic");
    const bool is_inside = low[axis] >= from + reach && high[axis] <= to - reach;
    const bool is_through = low[axis] <= from - reach && high[axis] >= to + reach;
    if (is_inside || is_through) continue;
    refuse(
        fmt::format("goes from {:.4g} to {:.4g} mm; it must end at least {:.4g} mm, a radius of "
                    "the largest particle, before the ends of the period or behind them,",
                    1e3 * low[axis],
                    1e3 * high[axis],
                    1e3 * reach));
  }
}

void check_period(const SceneData& file, const BuiltScene& built) {
  if (!file.period.is_given()) return;
  double reach = 0.0;
  for (const sim::Clump& type : built.scene.types) reach = std::max(reach, type.bounding_radius);
  for (int axis = 0; axis < 3; ++axis) {
    const double length = file.period.length[axis];
    if (length == 0.0 || length >= 4.0 * reach) continue;
    throw InputError(
        fmt::format("{}: the period along {} is {:.4g} mm, but must be at least two lengths of the "
                    "largest particle, {:.4g} mm.",
                    built.origin,
                    "xyz"[axis],
                    1e3 * length,
                    4e3 * reach));
  }
  const bool fills = std::any_of(file.particles.begin(),
                                 file.particles.end(),
                                 [](const auto& particle) { return particle.count > 0; });
  for (int axis = 0; fills && axis < 3; ++axis) {
    const double from = file.period.low[axis], to = from + file.period.length[axis];
    if (to == from || (file.fill.low[axis] >= from && file.fill.high[axis] <= to)) continue;
    throw InputError(fmt::format(
        "{}: the region of [fill] goes from {:.4g} to {:.4g} mm along {}, but the period "
        "from {:.4g} to {:.4g} mm; grains must begin within it.",
        built.origin,
        1e3 * file.fill.low[axis],
        1e3 * file.fill.high[axis],
        "xyz"[axis],
        1e3 * from,
        1e3 * to));
  }
  for (std::size_t owner = 0; owner < file.walls.size(); ++owner)
    check_wall_at_period(built, owner, file.walls[owner], reach);
}

}  // namespace

std::vector<sim::ElementSphere> spheres_of(const SceneParticle& particle) {
  double protrusion = 0.0;
  return shape_of(particle, protrusion);
}

BuiltScene build_scene(const SceneData& file, const std::string& origin) {
  BuiltScene built{.origin = origin};
  built.scene.planar = file.is_planar;
  built.scene.gravity = file.gravity;
  built.scene.period = {file.period.low, file.period.length};
  for (const datasets::SceneMaterial& material : file.materials) {
    built.scene.add_material(material.is_rigid
                                 ? sim::rigid_material()
                                 : sim::Material{material.elastic_modulus, material.poisson_ratio});
  }
  for (const SceneParticle& particle : file.particles) {
    naming(origin, fmt::format("particle '{}': ", particle.name), [&] {
      add_particle(particle, built);
    });
  }
  for (std::size_t w = 0; w < file.walls.size(); ++w) {
    naming(origin, fmt::format("wall '{}': ", file.walls[w].name), [&] {
      int merged = 0;
      const int body = body_of_wall(file, w, built);
      for (sim::Wall& wall : walls_of(file.walls[w], body, merged)) {
        if (!file.walls[w].body.empty()) wall.body = body;
        wall.material = file.walls[w].material;
        // Checked with its motion, which it gets at the event
        wall.motion = motion_of(file.walls[w].motion, 0.0);
        wall.drag = motion_of(file.walls[w].drag, 0.0);
        sim::Scene alone;
        alone.planar = file.is_planar;
        alone.materials = built.scene.materials;
        alone.add_wall(wall);
        sim::check(alone);
        wall.motion = {};
        wall.drag = {};
        built.scene.add_wall(wall);
        built.owner.push_back(static_cast<int>(w));
      }
      if (merged > 0) {
        built.warnings.push_back(
            fmt::format("{} of the facets of '{}' stand in it twice; they count once.",
                        merged,
                        file.walls[w].name));
      }
    });
  }
  naming(origin, "", [&] { sim::check(built.scene); });
  check_period(file, built);
  return built;
}

namespace {

// The value that goes by a name; the reader of scene files lets no other name in.
template <class Value>
Value named(const std::string& name, std::initializer_list<std::pair<const char*, Value>> values) {
  for (const auto& [known, value] : values) {
    if (name == known) return value;
  }
  throw std::invalid_argument("there is no '" + name + "' in the contact law");
}

}  // namespace

void use_law(const datasets::SceneLaw& law, sim::SimulationOptions& options) {
  using Normal = sim::NormalSpring;
  using Tangential = sim::TangentialSpring;
  using Sharing = sim::DampingSharing;
  options.normal_spring = named<Normal>(law.normal_spring,
                                        {{"hertz", Normal::hertz},
                                         {"linear", Normal::linear},
                                         {"secant", Normal::secant},
                                         {"incremental", Normal::incremental}});
  options.tangential_spring = named<Tangential>(law.tangential_spring,
                                                {{"mindlin", Tangential::mindlin},
                                                 {"mindlin_scaled", Tangential::mindlin_scaled},
                                                 {"constant", Tangential::constant}});
  options.coulomb_limit = named<sim::CoulombLimit>(
      law.coulomb_limit,
      {{"whole", sim::CoulombLimit::whole}, {"spring", sim::CoulombLimit::spring}});
  options.tension = named<sim::Tension>(
      law.tension, {{"clipped", sim::Tension::clipped}, {"allowed", sim::Tension::allowed}});
  options.damping_form = named<sim::DampingForm>(
      law.damping_form, {{"exact", sim::DampingForm::exact}, {"thesis", sim::DampingForm::thesis}});
  options.damping_sharing = named<Sharing>(
      law.damping_sharing,
      {{"inv_sqrt_n", Sharing::inv_sqrt_n}, {"inv_n", Sharing::inv_n}, {"none", Sharing::none}});
  options.linear_stiffness = law.linear_stiffness;
  options.tangential_stiffness = law.tangential_stiffness;
  options.tangential_damping = law.tangential_damping;
}

void use_surfaces(const SceneData& file,
                  const datasets::ScenePhase& phase,
                  sim::SurfaceTable& surfaces) {
  std::set<int> of_particles;
  for (const SceneParticle& particle : file.particles) of_particles.insert(particle.material);
  for (const datasets::SceneSurfaces& given : file.surfaces) {
    const bool between = of_particles.contains(given.first) && of_particles.contains(given.second);
    sim::Surfaces now{.friction = given.friction,
                      .restitution = given.restitution,
                      .static_friction = given.static_friction,
                      .rolling_friction = given.rolling_friction};
    const auto& friction = between ? phase.friction_between_particles : phase.friction_with_walls;
    if (friction) {
      now.friction = *friction;
      now.static_friction = 0.0;
    }
    if (phase.restitution) now.restitution = *phase.restitution;
    if (phase.restitution_at_most)
      now.restitution = std::min(*phase.restitution_at_most, now.restitution);
    // The rebound that this beta gives with the thesis's own law, which may pull
    if (phase.damping_ratio) {
      now.restitution = sim::restitution_of(*phase.damping_ratio, sim::Tension::allowed);
    }
    surfaces.set(given.first, given.second, now);
  }
}

void start_walls(const SceneData& file,
                 const BuiltScene& built,
                 double time,
                 sim::Simulation& simulation) {
  for (std::size_t w = 0; w < built.owner.size(); ++w) {
    const SceneWall& wall = file.walls[built.owner[w]];
    const int index = static_cast<int>(w);
    const sim::WallMotion motion = motion_of(wall.motion, time);
    const sim::WallMotion drag = motion_of(wall.drag, time);
    if (!motion.is_none()) simulation.set_wall_motion(index, motion);
    if (!drag.is_none()) simulation.set_wall_drag(index, drag);
    if (std::isfinite(wall.opens_at)) simulation.open_wall(index, time + wall.opens_at);
  }
}

}  // namespace graintruth::calibrate
