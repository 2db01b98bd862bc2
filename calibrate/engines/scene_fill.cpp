#include "calibrate/engines/scene_fill.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_01.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "datasets/store/input_error.h"
#include "sim/engine/neighbours.h"
#include "sim/engine/periodic_cell.h"
#include "sim/engine/relaxation.h"
#include "sim/laws/elementary.h"

namespace graintruth::calibrate {

namespace {

using datasets::InputError;
using datasets::SceneData;
using sim::Vec3;

double share(Generator& generator) { return boost::random::uniform_01<double>()(generator); }

// Uniform over all rotations (Shoemake 1992).
sim::Quat random_rotation(Generator& generator) {
  const double u = share(generator);
  const double first = 2.0 * std::numbers::pi * share(generator);
  const double second = 2.0 * std::numbers::pi * share(generator);
  return {std::sqrt(u) * sim::steady_cos(second),
          std::sqrt(1.0 - u) * sim::steady_sin(first),
          std::sqrt(1.0 - u) * sim::steady_cos(first),
          std::sqrt(u) * sim::steady_sin(second)};
}

// A body whose shape's x axis has this picture angle, then is turned by `azimuth` about z.
sim::Body turned_body(
    const SceneData& file, const BuiltScene& built, int type, double angle, double azimuth) {
  const sim::Quat& input_from_body = built.scene.types[type].input_from_body;
  sim::Body body;
  body.type = type;
  if (file.is_planar) {
    body.picture_angle = angle + sim::picture_angle_of(input_from_body);
    body.orientation = sim::orientation_from_picture_angle(body.picture_angle);
  } else {
    body.orientation = sim::turn_about(Vec3::UnitZ(), azimuth) *
                       sim::orientation_from_picture_angle(angle) * input_from_body;
  }
  return body;
}

sim::Body oriented_body(const SceneData& file,
                        const BuiltScene& built,
                        int type,
                        Generator& generator) {
  if (!file.fill.random_orientation) return turned_body(file, built, type, file.fill.angle, 0.0);
  if (file.is_planar) {
    return turned_body(file, built, type, 2.0 * std::numbers::pi * share(generator), 0.0);
  }
  sim::Body body;
  body.type = type;
  body.orientation = random_rotation(generator);
  return body;
}

// Puts the middle of the body's enclosing ball at a point.
void centre_on(const BuiltScene& built, const Vec3& point, sim::Body& body) {
  body.position = point - body.orientation * built.enclosing[body.type].centre;
}

Vec3 middle_of(const BuiltScene& built, const sim::Body& body) {
  return body.position + body.orientation * built.enclosing[body.type].centre;
}

// Distance to the nearest wall, m; below zero behind a plane.
double room_at(const std::vector<sim::Wall>& walls, const Vec3& point) {
  double least = std::numeric_limits<double>::infinity();
  for (const sim::Wall& wall : walls) {
    least = std::min(least, sim::look_at(wall, point).distance);
  }
  return least;
}

// Whether a ball can come straight down to a site from the top of the region: under the slopes of a
// hopper it cannot. Each stride is as long as there is room all round; `strides_left` bounds the
// work.
bool is_open_to_top(
    const std::vector<sim::Wall>& walls, Vec3 site, double top, double radius, long& strides_left) {
  for (; site.z() < top; --strides_left) {
    const double room = room_at(walls, site);
    if (room < radius || strides_left < 0) return false;
    site.z() += room;
  }
  return true;
}

// Whether all of a ball lies inside a cylinder.
bool lies_within(const datasets::SceneRoom& room, const Vec3& middle, double radius) {
  const Vec3 axis = (room.to - room.from).normalized();
  const Vec3 away = middle - room.from;
  const double along = away.dot(axis);
  return along >= radius && along <= (room.to - room.from).norm() - radius &&
         (away - along * axis).norm() <= room.radius - radius;
}

// A seeded step off a site, at most the filling's jitter along every axis; shorter where a wall is.
Vec3 jitter_at(const Vec3& site,
               const SceneData& file,
               const BuiltScene& built,
               double radius,
               Generator& generator) {
  constexpr int most_halvings = 5;
  Vec3 step;
  for (int axis = 0; axis < 3; ++axis)
    step[axis] = (2.0 * share(generator) - 1.0) * *file.fill.jitter;
  if (file.is_planar) step.y() = 0.0;
  for (int i = 0; i < most_halvings; ++i) {
    if (room_at(built.scene.walls, site + step) >= radius) return step;
    step *= 0.5;
  }
  return Vec3::Zero();
}

bool is_clear_of_bodies(const BuiltScene& built,
                        const std::vector<sim::Body>& bodies,
                        const Vec3& middle,
                        double radius) {
  return std::all_of(bodies.begin(), bodies.end(), [&](const sim::Body& body) {
    const double apart = radius + built.enclosing[body.type].radius;
    return sim::nearest(built.scene.period, middle_of(built, body) - middle).squaredNorm() >=
           apart * apart;
  });
}

// Largest enclosing radius of the types, m.
double largest_radius(const BuiltScene& built, const std::vector<int>& types) {
  double radius = 0.0;
  for (const int type : types) radius = std::max(radius, built.enclosing[type].radius);
  return radius;
}

[[noreturn]] void refuse_lattice(const BuiltScene& built,
                                 std::size_t placed,
                                 std::size_t wanted,
                                 double pitch) {
  throw InputError(
      fmt::format("{}: the region of [fill] has room for {} of {} particles on a lattice of {:.4g} "
                  "mm; make it larger, or the clearance smaller.",
                  built.origin,
                  placed,
                  wanted,
                  1e3 * pitch));
}

}  // namespace

std::vector<int> draw_types(const SceneData& file, const BuiltScene& built, Generator& generator) {
  std::vector<int> types;
  for (std::size_t p = 0; p < file.particles.size(); ++p) {
    const std::vector<int>& classes = built.kinds[p].types;
    for (int i = 0; i < file.particles[p].count; ++i) {
      const auto drawn =
          classes.size() > 1
              ? static_cast<std::size_t>(share(generator) * static_cast<double>(classes.size()))
              : 0;
      types.push_back(classes[std::min(drawn, classes.size() - 1)]);
    }
  }
  if (file.particles.size() > 1) {
    for (std::size_t i = types.size(); i > 1; --i) {
      const auto j = static_cast<std::size_t>(share(generator) * static_cast<double>(i));
      std::swap(types[i - 1], types[std::min(j, i - 1)]);
    }
  }
  return types;
}

void add_places(const SceneData& file, BuiltScene& built) {
  for (const datasets::ScenePlace& place : file.places) {
    const std::vector<int>& classes = built.kinds[place.particle].types;
    sim::Body body =
        turned_body(file, built, classes[classes.size() / 2], place.angle, place.azimuth);
    body.position = place.position;
    body.velocity = place.velocity;
    body.angular_velocity = place.angular_velocity;
    built.scene.bodies.push_back(body);
  }
}

void add_lattice(const SceneData& file,
                 const std::vector<int>& types,
                 Generator& generator,
                 BuiltScene& built) {
  const datasets::SceneFill& fill = file.fill;
  const double radius = largest_radius(built, types);
  const bool is_centred = fill.body_centred.value_or(false) && !file.is_planar;
  // From a site to those in the middles of cells around it: half a cell's diagonal
  const double pitch = (2.0 * radius + fill.clearance) * (is_centred ? 2.0 / std::sqrt(3.0) : 1.0);
  const Vec3 size = fill.high - fill.low;
  // Half a clearance to each side; round-off must not cost a row
  const auto sites = [&](int axis) {
    return std::max(static_cast<long>(std::floor(size[axis] / pitch + 1e-9)), 0L);
  };
  const long rows = file.is_planar ? 1 : sites(1);
  const std::vector<sim::Body> placed = built.scene.bodies;
  std::size_t next = 0;
  // A region can be so large, and so full of walls, that looking at all of it would take for ever
  long strides_left = 1000000 + 100 * static_cast<long>(types.size());
  const double reach = radius * (1.0 - 1e-9);  // round-off must not cost a row either
  const auto is_free = [&](const Vec3& site) {
    const double top = fill.high.z() - radius;
    if (fill.within && !lies_within(*fill.within, site, reach)) return false;
    return room_at(built.scene.walls, site) >= reach &&
           (fill.within || is_open_to_top(built.scene.walls, site, top, reach, strides_left)) &&
           is_clear_of_bodies(built, placed, site, radius);
  };
  // Of a body-centred lattice every second layer lies in the middles of the cells
  const long layers = (is_centred ? 2 : 1) * sites(2);
  for (long k = 0; k < layers && next < types.size(); ++k) {
    const double aside = is_centred && k % 2 == 1 ? 1.0 : 0.5;
    const double up = is_centred ? 0.5 * static_cast<double>(k + 1) : static_cast<double>(k) + 0.5;
    for (long j = 0; j < rows && next < types.size(); ++j) {
      for (long i = 0; i < sites(0) && next < types.size(); ++i) {
        const Vec3 cell(static_cast<double>(i) + aside, static_cast<double>(j) + aside, up);
        Vec3 site = fill.low + pitch * cell;
        if (file.is_planar) site.y() = 0.0;
        if (--strides_left < 0) refuse_lattice(built, next, types.size(), pitch);
        if (!is_free(site)) continue;
        sim::Body body = oriented_body(file, built, types[next++], generator);
        if (fill.jitter) site += jitter_at(site, file, built, reach, generator);
        centre_on(built, site, body);
        built.scene.bodies.push_back(body);
      }
    }
  }
  if (next < types.size()) refuse_lattice(built, next, types.size(), pitch);
}

std::vector<datasets::Pose> rows_of(const SceneData& file, std::uint64_t seed) {
  const datasets::SceneFill& fill = file.fill;
  // Scenes share the seeds of an evaluation, but not their beds
  Generator generator(seed + static_cast<std::uint64_t>(fill.number));
  boost::random::uniform_real_distribution<double> even(0.0, 1.0);
  const double width = fill.high.x() - fill.low.x();
  const double length = fill.length;
  const int columns = std::max(1, static_cast<int>(width / (1.02 * length)));
  const double pitch = width / columns;
  int count = 0;
  for (const datasets::SceneParticle& particle : file.particles) count += particle.count;
  std::vector<datasets::Pose> bed;
  for (int i = 0; i < count; ++i) {
    const double slack = (even(generator) - 0.5) * (pitch - length);
    const int column = i % columns, row = i / columns;
    bed.push_back({(column + 0.5) * pitch - 0.5 * width + slack,
                   (row + 0.5) * 1.02 * length,
                   std::numbers::pi * even(generator)});
  }
  return bed;
}

double place_poses(std::span<const datasets::Pose> poses,
                   const datasets::Pose& standard_deviation,
                   std::span<const int> types,
                   Generator& generator,
                   BuiltScene& built) {
  boost::random::normal_distribution<double> normal;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const datasets::Pose& pose = poses[i];
    const double x = pose.x + standard_deviation.x * normal(generator);
    const double z = pose.z + standard_deviation.z * normal(generator);
    const double angle = pose.angle + standard_deviation.angle * normal(generator);
    const sim::Quat& input_from_body = built.scene.types[types[i]].input_from_body;
    built.scene.add_planar_body(types[i], {x, z}, angle + sim::picture_angle_of(input_from_body));
  }
  const sim::RelaxationSummary relaxed = sim::relax_overlaps(built.scene);
  return relaxed.converged ? 0.0 : relaxed.overlap_after;
}

std::optional<sim::Body> rain_drop(const SceneData& file,
                                   const BuiltScene& built,
                                   const sim::Scene& now,
                                   int type,
                                   Generator& generator) {
  constexpr int tries = 60;
  const datasets::SceneFill& fill = file.fill;
  const double radius = built.enclosing[type].radius + 0.5 * fill.clearance;
  const Vec3 room = fill.high - fill.low - Vec3::Constant(2.0 * radius);
  if (room.x() < 0.0 || room.z() < 0.0 || (!file.is_planar && room.y() < 0.0)) {
    throw InputError(
        fmt::format("{}: the region of [fill] is smaller than a particle.", built.origin));
  }
  sim::Body body = oriented_body(file, built, type, generator);
  for (int i = 0; i < tries; ++i) {
    const double across = share(generator), along = share(generator);
    Vec3 middle = fill.low + Vec3::Constant(radius);
    middle += Vec3(across * room.x(), along * room.y(), room.z());
    if (file.is_planar) middle.y() = 0.0;
    if (room_at(now.walls, middle) < radius ||
        !is_clear_of_bodies(built, now.bodies, middle, radius)) {
      continue;
    }
    centre_on(built, middle, body);
    body.velocity = Vec3(0.0, 0.0, -fill.speed);
    return body;
  }
  return std::nullopt;
}

void check_start(const SceneData& file, const BuiltScene& built) {
  constexpr double tolerated = 0.01;  // of a radius
  const sim::Scene& scene = built.scene;
  const auto refuse = [&](std::size_t body, const std::string& complaint) {
    throw InputError(fmt::format("{}: particle {} at x {:.4g}, y {:.4g}, z {:.4g} mm {}.",
                                 built.origin,
                                 body + 1,
                                 1e3 * scene.bodies[body].position.x(),
                                 1e3 * scene.bodies[body].position.y(),
                                 1e3 * scene.bodies[body].position.z(),
                                 complaint));
  };
  // 1. Walls
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const sim::Body& body = scene.bodies[i];
    for (const sim::ElementSphere& sphere : scene.types[body.type].spheres) {
      const Vec3 centre = body.position + body.orientation * sphere.centre;
      for (std::size_t w = 0; w < scene.walls.size(); ++w) {
        const double distance = sim::look_at(scene.walls[w], centre).distance;
        if (distance > (1.0 - tolerated) * sphere.radius) continue;
        refuse(i,
               fmt::format("{} wall '{}'; move it, or the wall",
                           distance < -sphere.radius ? "lies behind" : "overlaps",
                           file.walls[built.owner[w]].name));
      }
    }
  }
  // 2. One another
  std::vector<Vec3> positions;
  std::vector<double> radii;
  for (const sim::Body& body : scene.bodies) {
    positions.push_back(body.position);
    radii.push_back(scene.types[body.type].bounding_radius);
  }
  sim::CellList<3> cells;
  std::vector<sim::IndexPair> pairs;
  sim::find_near_pairs<3>(positions, radii, 0.0, cells, pairs, sim::periodic_cell<3>(scene.period));
  for (const sim::IndexPair& pair : pairs) {
    const sim::Body& a = scene.bodies[pair.first];
    const sim::Body& b = scene.bodies[pair.second];
    for (const sim::ElementSphere& first : scene.types[a.type].spheres) {
      for (const sim::ElementSphere& second : scene.types[b.type].spheres) {
        const Vec3 apart = sim::nearest(
            scene.period,
            b.position + b.orientation * second.centre - a.position - a.orientation * first.centre);
        const double overlap = first.radius + second.radius - apart.norm();
        if (overlap > tolerated * std::min(first.radius, second.radius)) {
          refuse(pair.second, fmt::format("overlaps particle {}", pair.first + 1));
        }
      }
    }
  }
}

}  // namespace graintruth::calibrate
