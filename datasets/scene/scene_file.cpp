#include "datasets/scene/scene_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "datasets/scene/deck.h"
#include "datasets/scene/geometry_files.h"
#include "datasets/scene/scene_particle.h"
#include "datasets/store/input_error.h"
#include "datasets/store/table.h"
#include "datasets/store/toml_section.h"

namespace graintruth::datasets {

namespace {

using Eigen::Vector3d;

constexpr Range friction_range{0.0, 5.0, true, "a friction from 0 to 5"};
constexpr Range restitution_range{0.0, 1.0, false, "a restitution above 0 and at most 1"};
constexpr Range poisson_range{-1.0, 0.4999, false, "a Poisson ratio above -1 and below 0.5"};
constexpr Range modulus_range{1e3, 1e13, true, "a modulus from 1 kPa to 10 TPa"};
constexpr Range length_range{0.0, 1e3, false, "a length above 0 and at most 1 km"};
constexpr Range place_range{-1e4, 1e4, true, "a place within 10 km of the origin"};
constexpr Range speed_range{0.0, 1e3, true, "a speed not below 0 and at most 1 km/s"};
constexpr Range duration_range{0.0, 1e5, false, "a time above 0 and at most 1e5 s"};
constexpr Range not_later{0.0, 1e5, true, "a time from 0 to 1e5 s"};
constexpr int most_particles = 200000;

Vector3d vector_of(const std::vector<double>& numbers) {
  return {numbers[0], numbers[1], numbers[2]};
}

// A point of the scene: far ones are a slip of the unit.
Vector3d read_point(TomlSection& section, std::string_view stem) {
  const Vector3d point = vector_of(section.numbers(stem, 3, length_units));
  if (!(point.cwiseAbs().maxCoeff() <= place_range.upper)) {
    section.fail(fmt::format("{}_m", stem), fmt::format("must be {}", place_range.words));
  }
  return point;
}

int index_of(TomlSection& section,
             std::string_view key,
             const std::string& name,
             const std::vector<std::string>& names) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    std::string known;
    for (const std::string& each : names) {
      known += fmt::format("{}'{}'", known.empty() ? "" : ", ", each);
    }
    section.fail(key, fmt::format("names '{}', but known are {}", name, known));
  }
  return static_cast<int>(found - names.begin());
}

std::vector<std::string> names_of(const std::vector<SceneMaterial>& materials) {
  std::vector<std::string> names;
  for (const SceneMaterial& material : materials) names.push_back(material.name);
  return names;
}

std::vector<SceneMaterial> read_materials(TomlSection& root) {
  std::vector<SceneMaterial> materials;
  for (TomlSection& section : root.sections("material")) {
    SceneMaterial material;
    material.name = section.text("name");
    const std::vector<std::string> names = names_of(materials);
    if (std::find(names.begin(), names.end(), material.name) != names.end()) {
      section.fail("name", fmt::format("makes a second material called '{}'", material.name));
    }
    material.is_rigid = section.optional_flag("rigid").value_or(false);
    if (!material.is_rigid) {
      material.elastic_modulus = section.quantity("elastic_modulus", pressure_units, modulus_range);
      material.poisson_ratio = section.quantity("poisson_ratio", plain, poisson_range);
    }
    section.finish();
    materials.push_back(std::move(material));
  }
  if (materials.empty()) root.fail("material", "is missing; at least one [[material]] is needed");
  return materials;
}

std::vector<SceneSurfaces> read_surfaces(TomlSection& root,
                                         const std::vector<SceneMaterial>& materials) {
  const std::vector<std::string> names = names_of(materials);
  std::vector<SceneSurfaces> all;
  for (TomlSection& section : root.sections("surfaces")) {
    SceneSurfaces surfaces;
    surfaces.first = index_of(section, "first", section.text("first"), names);
    surfaces.second = index_of(section, "second", section.text("second"), names);
    surfaces.friction = section.quantity("friction", plain, friction_range);
    surfaces.restitution = section.quantity("restitution", plain, restitution_range);
    surfaces.static_friction =
        section.optional_quantity("static_friction", plain, friction_range).value_or(0.0);
    surfaces.rolling_friction =
        section.optional_quantity("rolling_friction", plain, friction_range).value_or(0.0);
    if (surfaces.static_friction > 0.0 && surfaces.static_friction < surfaces.friction) {
      section.fail("static_friction", "must not be below friction");
    }
    section.finish();
    all.push_back(surfaces);
  }
  return all;
}

// One word of a few; what the law has already where there is no such key.
void read_choice(TomlSection& section,
                 const char* key,
                 std::initializer_list<std::string_view> words,
                 std::string& choice) {
  const auto given = section.optional_text(key);
  if (!given) return;
  if (std::find(words.begin(), words.end(), *given) == words.end()) {
    section.fail(key,
                 fmt::format("is '{}', but must be one of {}", *given, fmt::join(words, ", ")));
  }
  choice = *given;
}

// A stiffness that goes with one kind of spring: needed there, refused elsewhere.
double read_stiffness(TomlSection& section, const char* stem, bool is_needed) {
  if (is_needed) return section.quantity(stem, stiffness_units, positive);
  if (section.optional_quantity(stem, stiffness_units)) {
    section.fail(stem, "belongs to another spring than the one that is chosen");
  }
  return 0.0;
}

SceneLaw read_law(TomlSection section) {
  SceneLaw law;
  read_choice(
      section, "normal_spring", {"hertz", "linear", "secant", "incremental"}, law.normal_spring);
  read_choice(section,
              "tangential_spring",
              {"mindlin", "mindlin_scaled", "constant"},
              law.tangential_spring);
  read_choice(section, "coulomb_limit", {"whole", "spring"}, law.coulomb_limit);
  read_choice(section, "tension", {"clipped", "allowed"}, law.tension);
  read_choice(section, "damping_form", {"exact", "thesis"}, law.damping_form);
  read_choice(section, "damping_sharing", {"inv_sqrt_n", "inv_n", "none"}, law.damping_sharing);
  law.linear_stiffness = read_stiffness(section, "linear_stiffness", law.normal_spring == "linear");
  law.tangential_stiffness =
      read_stiffness(section, "tangential_stiffness", law.tangential_spring == "constant");
  law.tangential_damping =
      section.optional_quantity("tangential_damping", plain, not_negative).value_or(1.0);
  section.finish();
  return law;
}

void require_surfaces(TomlSection& root, const SceneFile& scene) {
  const auto is_given = [&](int a, int b) {
    return std::any_of(scene.surfaces.begin(), scene.surfaces.end(), [&](const SceneSurfaces& s) {
      return (s.first == a && s.second == b) || (s.first == b && s.second == a);
    });
  };
  const auto require = [&](int a, int b) {
    if (is_given(a, b)) return;
    root.fail("surfaces",
              fmt::format("says nothing of '{}' on '{}', which may touch; write [[surfaces]] with "
                          "first, second, friction, restitution",
                          scene.materials[a].name,
                          scene.materials[b].name));
  };
  for (const SceneParticle& particle : scene.particles) {
    for (const SceneParticle& other : scene.particles) require(particle.material, other.material);
    for (const SceneWall& wall : scene.walls) require(particle.material, wall.material);
  }
}

std::vector<SceneParticle> read_particles(TomlSection& root, SceneFile& scene) {
  std::vector<SceneParticle> particles;
  for (TomlSection& section : root.sections("particle")) {
    SceneParticle particle;
    particle.name = section.text("name");
    particle.material =
        index_of(section, "material", section.text("material"), names_of(scene.materials));
    if (scene.materials[particle.material].is_rigid) {
      section.fail("material", "is rigid, but particles must be elastic");
    }
    particle.count = section.optional_whole_number("count", 0, most_particles).value_or(0);
    read_particle_shape(section, scene.file.parent_path(), scene.inputs, particle);
    if (scene.is_planar) require_one_layer(section, particle);
    particle.density = section.optional_quantity("density", density_units, positive);
    particle.mass = section.optional_quantity("mass", mass_units, positive);
    if (particle.density.has_value() == particle.mass.has_value()) {
      section.fail("density_kg_per_m3", "is needed, or 'mass_kg': exactly one of the two");
    }
    if (const auto inertia = section.optional_numbers("inertia", 3, inertia_units)) {
      particle.inertia = vector_of(*inertia);
      if (!(particle.inertia->minCoeff() > 0.0)) {
        section.fail("inertia_kg_m2", "must be three moments above 0");
      }
    }
    if (auto size = section.optional_section("size")) particle.size = read_size_spread(*size);
    section.finish();
    particles.push_back(std::move(particle));
  }
  if (particles.empty()) root.fail("particle", "is missing; at least one [[particle]] is needed");
  return particles;
}

// Velocity or turning of the wall (`prefix` empty) or of its surface alone.
SceneMotion read_motion(TomlSection& section, const std::string& prefix) {
  SceneMotion motion;
  if (const auto velocity = section.optional_numbers(prefix + "velocity", 3, speed_units)) {
    motion.velocity = vector_of(*velocity);
    if (!(motion.velocity.norm() <= speed_range.upper)) {
      section.fail(prefix + "velocity_m_per_s", "must be at most 1 km/s");
    }
  }
  constexpr Range turning_range{-1e4, 1e4, true, "a rate within 1e4 rad/s"};
  if (const auto rate =
          section.optional_quantity(prefix + "turning", turning_units, turning_range)) {
    const Vector3d axis = vector_of(section.numbers("axis", 3, plain));
    if (!(axis.norm() > 0.0)) section.fail("axis", "must have a length");
    motion.angular_velocity = *rate * axis.normalized();
    motion.pivot = read_point(section, "pivot");
  }
  return motion;
}

void read_motions(TomlSection& section, SceneWall& wall) {
  wall.motion = read_motion(section, "");
  wall.drag = read_motion(section, "surface_");
  const double start = section.optional_quantity("start", time_units, not_later).value_or(0.0);
  const auto end = section.optional_quantity("end", time_units, not_later);
  if (end && !(*end > start)) section.fail("end_s", "must be later than start");
  for (SceneMotion* motion : {&wall.motion, &wall.drag}) {
    motion->start = start;
    if (end) motion->end = *end;
  }
  if (const auto opens = section.optional_quantity("opens", time_units, not_later)) {
    wall.opens_at = *opens;
  }
}

// The six sides of a box, without those that `open` names.
std::vector<SceneWall> box_sides(TomlSection& section, const SceneWall& box) {
  const Vector3d low = read_point(section, "low"), high = read_point(section, "high");
  if (!((high - low).minCoeff() > 0.0)) {
    section.fail("high_m", "must be above low in x, y and z");
  }
  std::vector<std::string> open;
  if (const auto list = section.optional_text("open")) {
    std::string word;
    for (const char letter : *list + " ") {
      if (letter != ' ' && letter != ',') {
        word += letter;
      } else if (!word.empty()) {
        open.push_back(std::exchange(word, ""));
      }
    }
  }
  const double x0 = low.x(), y0 = low.y(), z0 = low.z();
  const double x1 = high.x(), y1 = high.y(), z1 = high.z();
  const std::vector<std::pair<std::string, std::vector<Vector3d>>> sides = {
      {"bottom", {{x0, y0, z0}, {x1, y0, z0}, {x1, y1, z0}, {x0, y1, z0}}},
      {"top", {{x0, y0, z1}, {x1, y0, z1}, {x1, y1, z1}, {x0, y1, z1}}},
      {"left", {{x0, y0, z0}, {x0, y1, z0}, {x0, y1, z1}, {x0, y0, z1}}},
      {"right", {{x1, y0, z0}, {x1, y1, z0}, {x1, y1, z1}, {x1, y0, z1}}},
      {"front", {{x0, y0, z0}, {x1, y0, z0}, {x1, y0, z1}, {x0, y0, z1}}},
      {"back", {{x0, y1, z0}, {x1, y1, z0}, {x1, y1, z1}, {x0, y1, z1}}}};
  std::vector<SceneWall> walls;
  for (const auto& [name, corners] : sides) {
    const auto found = std::find(open.begin(), open.end(), name);
    if (found != open.end()) {
      open.erase(found);
      continue;
    }
    SceneWall side = box;
    side.name = fmt::format("{}_{}", box.name, name);
    side.kind = SceneWall::Kind::polygon;
    side.points = corners;
    walls.push_back(std::move(side));
  }
  if (!open.empty()) {
    section.fail("open",
                 fmt::format("names '{}', but the sides are bottom, top, left, right, front, back",
                             open.front()));
  }
  return walls;
}

Vector3d read_normal(TomlSection& section) {
  const Vector3d normal = vector_of(section.numbers("normal", 3, plain));
  if (!(normal.norm() > 0.0)) section.fail("normal", "must have a length");
  return normal.normalized();
}

void read_segment(TomlSection& section, SceneWall& wall) {
  for (const char* end : {"from", "to"}) {
    const auto xz = section.numbers(end, 2, length_units);
    wall.points.emplace_back(xz[0], 0.0, xz[1]);
  }
  if (wall.points[0] == wall.points[1]) section.fail("to_m", "is the same point as from");
}

void read_mesh(TomlSection& section, SceneFile& scene, SceneWall& wall) {
  const std::filesystem::path file = scene.file.parent_path() / section.text("file");
  Mesh mesh = read_stl(file, read_length_unit(section, "file_unit"));
  wall.points = std::move(mesh.corners);
  if (!mesh.note.empty()) scene.warnings.push_back(std::move(mesh.note));
  if (const auto offset = section.optional_numbers("offset", 3, length_units)) {
    for (Vector3d& corner : wall.points) corner += vector_of(*offset);
  }
  scene.inputs.push_back(file);
}

std::vector<SceneWall> read_wall(TomlSection& section, SceneFile& scene) {
  using Kind = SceneWall::Kind;
  SceneWall wall;
  wall.name = section.text("name");
  wall.material =
      index_of(section, "material", section.text("material"), names_of(scene.materials));
  const std::string shape = section.text("shape");
  read_motions(section, wall);
  wall.body = section.optional_text("body").value_or("");
  if (shape == "box") return box_sides(section, wall);
  if (shape == "segment") {
    wall.kind = Kind::segment;
    read_segment(section, wall);
  } else if (shape == "plane") {
    wall.kind = Kind::plane;
    wall.points = {read_point(section, "point")};
    wall.normal = read_normal(section);
  } else if (shape == "polygon") {
    wall.kind = Kind::polygon;
    for (const auto& row : section.rows("corners", 3, length_units)) {
      wall.points.push_back(vector_of(row));
    }
    if (wall.points.size() < 3) section.fail("corners_m", "must list at least three corners");
  } else if (shape == "disk") {
    wall.kind = Kind::disk;
    wall.points = {read_point(section, "centre")};
    wall.normal = read_normal(section);
    wall.radius = section.quantity("radius", length_units, length_range);
  } else if (shape == "cylinder") {
    wall.kind = Kind::cylinder;
    wall.points = {read_point(section, "from"), read_point(section, "to")};
    if (wall.points[0] == wall.points[1]) section.fail("to_m", "is the same point as from");
    wall.radius = section.quantity("radius", length_units, length_range);
  } else if (shape == "mesh") {
    wall.kind = Kind::mesh;
    read_mesh(section, scene, wall);
  } else {
    section.fail("shape",
                 fmt::format("is '{}', but must be 'segment', 'plane', 'polygon', 'box', 'disk', "
                             "'cylinder' or 'mesh'",
                             shape));
  }
  return {wall};
}

std::vector<SceneWall> read_walls(TomlSection& root, SceneFile& scene) {
  std::vector<SceneWall> walls;
  for (TomlSection& section : root.sections("wall")) {
    for (SceneWall& wall : read_wall(section, scene)) {
      for (const SceneWall& other : walls) {
        if (other.name == wall.name) {
          section.fail("name", fmt::format("makes a second wall called '{}'", wall.name));
        }
        const bool moves_alike = other.motion == wall.motion && other.drag == wall.drag;
        if (!wall.body.empty() && other.body == wall.body && !moves_alike) {
          section.fail("body",
                       fmt::format("makes one body of '{}' and '{}', which do not move alike",
                                   other.name,
                                   wall.name));
        }
      }
      walls.push_back(std::move(wall));
    }
    section.finish();
  }
  return walls;
}

SceneFill read_fill(TomlSection section, bool is_planar) {
  SceneFill fill;
  const std::string method = section.text("method");
  if (method == "rain") {
    fill.method = SceneFill::Method::rain;
    fill.interval = section.quantity("interval", time_units, duration_range);
    fill.speed = section.optional_quantity("speed", speed_units, speed_range).value_or(0.0);
  } else if (method != "lattice") {
    section.fail("method", fmt::format("is '{}', but must be 'lattice' or 'rain'", method));
  }
  if (is_planar) {
    const auto low = section.numbers("low", 2, length_units);
    const auto high = section.numbers("high", 2, length_units);
    fill.low = {low[0], 0.0, low[1]};
    fill.high = {high[0], 0.0, high[1]};
  } else {
    fill.low = read_point(section, "low");
    fill.high = read_point(section, "high");
  }
  const Vector3d size = fill.high - fill.low;
  if (!(size.x() > 0.0 && size.z() > 0.0 && (is_planar || size.y() > 0.0)) ||
      !(size.maxCoeff() <= length_range.upper)) {
    section.fail("high_m", "must lie above and to the right of low");
  }
  fill.clearance = section.optional_quantity("clearance", length_units, not_negative).value_or(0.0);
  fill.jitter = section.optional_quantity("jitter", length_units, not_negative);
  if (fill.jitter && fill.method != SceneFill::Method::lattice)
    section.fail(section.key_of("jitter", length_units), "is only known of a lattice");
  if (fill.jitter && *fill.jitter > 0.5 * fill.clearance) {
    section.fail(section.key_of("jitter", length_units),
                 fmt::format("is {:.4g} mm, but particles would touch each other above half the "
                             "clearance, {:.4g} mm",
                             1e3 * *fill.jitter,
                             0.5e3 * fill.clearance));
  }
  if (const auto angle = section.optional_quantity("angle", angle_units)) {
    fill.angle = *angle;
    fill.random_orientation = false;
  }
  section.finish();
  return fill;
}

std::vector<ScenePlace> read_places(TomlSection& root, const SceneFile& scene) {
  std::vector<std::string> names;
  for (const SceneParticle& particle : scene.particles) names.push_back(particle.name);
  std::vector<ScenePlace> places;
  for (TomlSection& section : root.sections("place")) {
    ScenePlace place;
    place.particle = index_of(section, "particle", section.text("particle"), names);
    place.position = {section.quantity("x", length_units, place_range),
                      section.optional_quantity("y", length_units, place_range).value_or(0.0),
                      section.quantity("z", length_units, place_range)};
    place.angle = section.optional_quantity("angle", angle_units).value_or(0.0);
    place.azimuth = section.optional_quantity("azimuth", angle_units).value_or(0.0);
    if (scene.is_planar && (place.position.y() != 0.0 || place.azimuth != 0.0)) {
      section.fail("particle", "leaves the layer: a planar scene has no y_mm and no azimuth_deg");
    }
    if (const auto velocity = section.optional_numbers("velocity", 3, speed_units)) {
      place.velocity = vector_of(*velocity);
    }
    if (const auto spin = section.optional_numbers("spin", 3, turning_units)) {
      place.angular_velocity = vector_of(*spin);
    }
    if (!(place.velocity.norm() <= speed_range.upper)) {
      section.fail("velocity_m_per_s", "must be at most 1 km/s");
    }
    section.finish();
    places.push_back(place);
  }
  return places;
}

void read_pace(TomlSection& section, ScenePhase& phase) {
  phase.time_step_fraction =
      section.optional_quantity("time_step_fraction", plain, step_fraction).value_or(0.5);
  phase.fastest_impact =
      section.optional_quantity("fastest_impact", speed_units, positive).value_or(1.0);
}

ScenePhase read_settle(TomlSection section) {
  ScenePhase phase;
  phase.name = "settle";
  phase.until_rest = true;
  phase.duration = section.quantity("longest", time_units, duration_range);
  phase.friction_between_particles = section.optional_quantity("friction", plain, friction_range);
  phase.friction_with_walls = phase.friction_between_particles;
  phase.restitution = section.optional_quantity("restitution", plain, restitution_range);
  phase.global_damping =
      section.optional_quantity("global_damping", rate_units, not_negative).value_or(0.0);
  phase.output_interval =
      section.optional_quantity("output_interval", time_units, duration_range).value_or(0.0);
  read_pace(section, phase);
  section.finish();
  return phase;
}

ScenePhase read_run(TomlSection section, SceneFile& scene) {
  ScenePhase phase;
  phase.name = "run";
  phase.duration = section.quantity("duration", time_units, duration_range);
  phase.output_interval = section.quantity("output_interval", time_units, duration_range);
  if (phase.duration / phase.output_interval > 1e5) {
    section.fail("output_interval_s", "would make more than 100000 frames");
  }
  scene.exit_height = section.optional_quantity("exit_height", length_units, place_range);
  read_pace(section, phase);
  section.finish();
  return phase;
}

ScenePeriod read_period(TomlSection section, bool is_planar) {
  ScenePeriod period;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string key(1, "xyz"[axis]);
    const auto ends = section.optional_numbers(key, 2, length_units);
    if (!ends) continue;
    const std::string as_written = section.key_of(key, length_units);
    if (is_planar && axis == 1)
      section.fail(as_written, "is given, but one layer does not repeat along y");
    if (!((*ends)[1] > (*ends)[0]))
      section.fail(as_written, "must be two numbers, the smaller first");
    if (!(std::max(std::abs((*ends)[0]), std::abs((*ends)[1])) <= place_range.upper))
      section.fail(as_written, fmt::format("must be two places, each {}", place_range.words));
    period.low[axis] = (*ends)[0];
    period.length[axis] = (*ends)[1] - (*ends)[0];
  }
  section.finish();
  if (!period.is_given())
    section.fail("x_mm",
                 "is missing, as are y_mm and z_mm: give the ends of the cell along one of them");
  return period;
}

SceneFile load_toml_scene(const std::filesystem::path& file) {
  TomlSection root = TomlFile(file).root();
  SceneFile scene;
  scene.file = file;
  scene.name = file.stem().string();
  scene.title = root.text("title");
  const int dimensions = root.whole_number("dimensions", 2, 3);
  scene.is_planar = dimensions == 2;
  if (const auto gravity = root.optional_numbers("gravity", 3, acceleration_units)) {
    scene.gravity = vector_of(*gravity);
    if (!(scene.gravity.norm() <= 1e4)) root.fail("gravity_m_per_s2", "must be at most 1e4");
  }
  if (auto period = root.optional_section("periodic"))
    scene.period = read_period(*period, scene.is_planar);
  scene.materials = read_materials(root);
  scene.surfaces = read_surfaces(root, scene.materials);
  if (auto law = root.optional_section("law")) scene.law = read_law(*law);
  scene.particles = read_particles(root, scene);
  scene.walls = read_walls(root, scene);
  require_surfaces(root, scene);
  scene.places = read_places(root, scene);
  int counted = 0;
  for (const SceneParticle& particle : scene.particles) counted += particle.count;
  if (counted > most_particles) {
    root.fail("particle", fmt::format("asks for more than {} particles", most_particles));
  }
  if (counted > 0 || root.has("fill")) {
    scene.fill = read_fill(root.section("fill"), scene.is_planar);
  }
  if (counted == 0 && scene.places.empty()) {
    root.fail("particle", "places nothing: give a count and [fill], or [[place]]");
  }
  if (auto settle = root.optional_section("settle")) {
    scene.phases.push_back(read_settle(*settle));
  }
  scene.event_phase = static_cast<int>(scene.phases.size());
  scene.phases.push_back(read_run(root.section("run"), scene));
  root.finish();
  return scene;
}

}  // namespace

bool is_deck(const std::filesystem::path& file) { return file.extension() == ".txt"; }

std::filesystem::path sidecar_beside(const std::filesystem::path& deck) {
  return std::filesystem::path(deck).replace_extension(".toml");
}

SceneFile load_scene(const std::filesystem::path& file) {
  return load_scene(file, sidecar_beside(file));
}

SceneFile load_scene(const std::filesystem::path& file, const std::filesystem::path& sidecar) {
  if (is_deck(file)) return load_deck(file, sidecar);
  return load_toml_scene(file);
}

}  // namespace graintruth::datasets
