#include "bench/sim/peer_cases.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <random>
#include <set>
#include <stdexcept>
#include <utility>

#include "sim/engine/neighbours.h"

namespace graintruth::bench {
namespace {

using sim::Vec2;
using sim::Vec3;

constexpr std::uint64_t kSeed = 2000;
constexpr double kDensity = 2650.0;   // kg/m3; of the rods and of the spheres in the box
constexpr double kUnitRadius = 0.01;  // m

double sphere_volume(double radius) {
  return 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
}

// Thesis 4.3: 200 buttons, ellipses of semi-axes 6.9 and 5.3 mm, 2.3 mm thick, as seven inscribed
// spheres, in a bin 15 cm wide with an orifice of 10 cm.
PeerCase buttons() {
  constexpr double a = 6.9e-3, b = 5.3e-3, thickness = 2.3e-3;
  PeerCase bed;
  bed.name = "s1";
  bed.planar = true;
  bed.clump_count = 200;
  // A circle inscribed in the ellipse at c has r^2 = b^2 (1 - c^2/(a^2 - b^2)), |c| <= (a^2 -
  // b^2)/a
  const double last = (a * a - b * b) / a;
  for (int i = -3; i <= 3; ++i) {
    const double centre = last * i / 3.0;
    bed.spheres.push_back(
        {Vec3(centre, 0.0, 0.0), b * std::sqrt(1.0 - centre * centre / (a * a - b * b))});
  }
  bed.mass = 0.332e-3;
  const double flat = thickness * thickness / 12.0;
  bed.inertia = bed.mass * Vec3(b * b / 4.0 + flat, (a * a + b * b) / 4.0, a * a / 4.0 + flat);
  bed.restitution = 0.72;
  bed.wall_friction = 0.2;
  bed.width = 0.15;
  bed.height = 0.6;
  bed.time_step = 4.5e-6;
  bed.short_run = 2000;
  bed.long_run = 10000;
  bed.lammps_skin = bed.liggghts_skin = 3e-4;
  return bed;
}

// Thesis 5: 5000 rods of three touching spheres with the volume of a sphere of 1 cm, in a bin 1 m
// wide with an orifice of 70 cm.
PeerCase rods() {
  PeerCase bed;
  bed.name = "s2";
  bed.planar = true;
  bed.clump_count = 5000;
  const double radius = kUnitRadius * std::cbrt(1.0 / 3.0);
  bed.spheres = sim::chain_of_spheres(3, radius, 2.0 * radius);
  bed.mass = kDensity * sphere_volume(kUnitRadius);
  const double along = 0.4 * bed.mass * radius * radius;
  const double across = along + bed.mass / 3.0 * 8.0 * radius * radius;
  bed.inertia = Vec3(along, across, across);
  bed.restitution = 0.163;  // damping ratio 0.5 of the unclipped law
  bed.width = 1.0;
  bed.height = 6.0;
  bed.time_step = 1e-5;
  bed.short_run = 300;
  bed.long_run = 1100;
  bed.lammps_skin = bed.liggghts_skin = 5e-4;
  return bed;
}

// Thesis 3.9.4: clumps of aspect ratio 2 made of 2, 3 or 5 spheres, or single spheres, in a box on
// a floor of 20 x 10 cm.
PeerCase boxed(int spheres_each, int count) {
  PeerCase bed;
  bed.name =
      spheres_each > 1 ? "s3c" + std::to_string(spheres_each) : "s3n" + std::to_string(count);
  bed.clump_count = count;
  bed.mass = kDensity * sphere_volume(kUnitRadius);
  if (spheres_each > 1) {
    bed.spheres =
        sim::chain_of_spheres(spheres_each, kUnitRadius, 2.0 * kUnitRadius / (spheres_each - 1));
    bed.mass *= 2.0;
  } else {
    bed.spheres = {{Vec3::Zero(), kUnitRadius}};
  }
  const double along = 0.4 * bed.mass * kUnitRadius * kUnitRadius;
  const double across = spheres_each > 1 ? along + bed.mass * kUnitRadius * kUnitRadius : along;
  bed.inertia = Vec3(along, across, across);
  bed.width = 0.2;
  bed.depth = 0.1;
  bed.height = 2.0;
  bed.time_step = 1e-5;
  bed.short_run = 2000;
  bed.long_run = 10000;
  bed.lammps_skin = 1.5e-3;
  bed.liggghts_skin = 5e-4;
  return bed;
}

PeerCase discharging(PeerCase bed, double orifice, int short_run, int long_run) {
  bed.name += "flow";
  bed.orifice = orifice;
  bed.short_run = short_run;
  bed.long_run = long_run;
  bed.lammps_skin *= 2.0;
  bed.liggghts_skin *= 2.0;
  return bed;
}

sim::Scene empty_scene(const PeerCase& bed, bool with_friction) {
  sim::Scene scene;
  scene.planar = bed.planar;
  const int grain = scene.add_material(bed.material);
  const int wall = scene.add_material(bed.material);
  const double share = with_friction ? 1.0 : 0.0;
  scene.surfaces.set(grain, grain, {share * bed.friction, bed.restitution});
  scene.surfaces.set(grain, wall, {share * bed.wall_friction, bed.restitution});
  scene.add_type(sim::make_clump(bed.spheres, {.mass = bed.mass, .inertia = bed.inertia}, grain));
  scene.add_wall(sim::plane_wall(Vec3::Zero(), Vec3::UnitX(), {}, wall));
  scene.add_wall(sim::plane_wall(Vec3(bed.width, 0.0, 0.0), -Vec3::UnitX(), {}, wall));
  if (!bed.planar) {
    scene.add_wall(sim::plane_wall(Vec3::Zero(), Vec3::UnitY(), {}, wall));
    scene.add_wall(sim::plane_wall(Vec3(0.0, bed.depth, 0.0), -Vec3::UnitY(), {}, wall));
  }
  if (bed.orifice == 0.0) {
    scene.add_wall(sim::plane_wall(Vec3::Zero(), Vec3::UnitZ(), {}, wall));
  } else {
    const double strip = 0.5 * (bed.width - bed.orifice);
    scene.add_wall(sim::segment_wall(Vec2::Zero(), Vec2(strip, 0.0), {}, wall));
    scene.add_wall(sim::segment_wall(Vec2(bed.width - strip, 0.0), Vec2(bed.width, 0.0), {}, wall));
  }
  return scene;
}

// Uniform in [0, 1) with the same value on every machine (std::uniform_real_distribution is not).
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

// Buttons: a lattice ten wide, angles uniform in the plane.
void place_on_lattice(const PeerCase& bed, std::mt19937_64& random, sim::Scene& scene) {
  const double length = 2.0 * scene.types[0].bounding_radius;
  const int columns = static_cast<int>(bed.width / (1.02 * length));
  for (int i = 0; i < bed.clump_count; ++i) {
    const Vec2 place((i % columns + 0.5) * bed.width / columns,
                     (i / columns + 0.55) * 1.02 * length);
    scene.add_planar_body(0, place, std::numbers::pi * uniform(random));
  }
}

// Rods: each falls straight down at a random place and angle until it touches; the lowest of ten
// tries is kept.
void drop_in_layer(const PeerCase& bed, std::mt19937_64& random, sim::Scene& scene) {
  constexpr int kTries = 10;
  constexpr std::size_t kSurface = 3000;  // spheres placed before these are buried
  constexpr double kGap = 1e-5;           // m
  std::vector<std::pair<Vec2, double>> placed;
  for (int i = 0; i < bed.clump_count; ++i) {
    Vec2 lowest(0.0, 1e9);
    double angle_of_lowest = 0.0;
    for (int k = 0; k < kTries; ++k) {
      const double angle = std::numbers::pi * uniform(random);
      const Vec2 along(std::cos(angle), std::sin(angle));
      double half_width = 0.0;
      for (const auto& sphere : bed.spheres) {
        half_width = std::max(half_width, std::abs(sphere.centre.x() * along.x()) + sphere.radius);
      }
      half_width += 1e-4;
      Vec2 place(half_width + (bed.width - 2.0 * half_width) * uniform(random), 0.0);
      const std::size_t first = placed.size() > kSurface ? placed.size() - kSurface : 0;
      for (const auto& sphere : bed.spheres) {
        const Vec2 offset = sphere.centre.x() * along;
        place.y() = std::max(place.y(), sphere.radius - offset.y());
        for (std::size_t p = first; p < placed.size(); ++p) {
          const double reach = sphere.radius + placed[p].second;
          const double aside = placed[p].first.x() - place.x() - offset.x();
          const double above = reach * reach - aside * aside;
          if (above <= 0.0) continue;
          place.y() = std::max(place.y(), placed[p].first.y() + std::sqrt(above) - offset.y());
        }
      }
      if (place.y() < lowest.y()) {
        lowest = place;
        angle_of_lowest = angle;
      }
    }
    lowest.y() += kGap;
    const Vec2 along(std::cos(angle_of_lowest), std::sin(angle_of_lowest));
    for (const auto& sphere : bed.spheres) {
      placed.push_back({lowest + sphere.centre.x() * along, sphere.radius});
    }
    scene.add_planar_body(0, lowest, angle_of_lowest);
  }
}

// Box: a lattice with orientations uniform on the sphere; single spheres a little off the lattice.
void place_in_box(const PeerCase& bed, std::mt19937_64& random, sim::Scene& scene) {
  const double pitch = 2.02 * scene.types[0].bounding_radius;
  const int nx = static_cast<int>(bed.width / pitch), ny = static_cast<int>(bed.depth / pitch);
  for (int i = 0; i < bed.clump_count; ++i) {
    Vec3 place((i % nx + 0.5) * bed.width / nx,
               (i / nx % ny + 0.5) * bed.depth / ny,
               (i / (nx * ny) + 0.55) * pitch);
    sim::Quat turn = sim::Quat::Identity();
    if (bed.spheres.size() == 1) {
      place.x() += 1e-4 * (uniform(random) - 0.5);
      place.y() += 1e-4 * (uniform(random) - 0.5);
    } else {
      // Shoemake (1992): three uniform numbers make a uniform rotation
      const double u = uniform(random), v = 2.0 * std::numbers::pi * uniform(random),
                   w = 2.0 * std::numbers::pi * uniform(random);
      turn = sim::Quat(std::sqrt(u) * std::cos(w),
                       std::sqrt(1.0 - u) * std::sin(v),
                       std::sqrt(1.0 - u) * std::cos(v),
                       std::sqrt(u) * std::sin(w));
    }
    scene.add_body(0, place, turn);
  }
}

std::vector<Pose> poses_of(const sim::State& state) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    poses.push_back({state.position[i], state.orientation[i].normalized()});
  }
  return poses;
}

// Falls with light damping, then comes to rest under strong damping.
std::vector<Pose> settle(PeerCase bed) {
  bed.orifice = 0.0;
  std::mt19937_64 random(kSeed);
  sim::Scene scene = empty_scene(bed, false);
  if (!bed.planar) {
    place_in_box(bed, random, scene);
  } else if (bed.clump_count <= 1000) {
    place_on_lattice(bed, random, scene);
  } else {
    drop_in_layer(bed, random, scene);
  }
  sim::SimulationOptions options = options_of(bed);
  options.global_damping = 3.0;
  sim::Simulation simulation(scene, options);
  for (const auto& [damping, until] : {std::pair(3.0, 0.8), std::pair(100.0, 1.0)}) {
    simulation.set_global_damping(damping);
    const sim::RunSummary summary = simulation.run_until(until);
    if (summary.status != sim::RunStatus::completed) throw std::runtime_error(summary.message);
  }
  return poses_of(simulation.state());
}

std::vector<Pose> read_poses(const std::filesystem::path& file) {
  std::vector<Pose> poses;
  std::ifstream in(file);
  Pose pose;
  while (in >> pose.position.x() >> pose.position.y() >> pose.position.z() >>
         pose.orientation.w() >> pose.orientation.x() >> pose.orientation.y() >>
         pose.orientation.z()) {
    poses.push_back(pose);
  }
  return poses;
}

void write_poses(const std::vector<Pose>& poses, const std::filesystem::path& file) {
  std::filesystem::create_directories(file.parent_path());
  const std::filesystem::path unfinished = file.string() + ".part";
  {
    std::ofstream out(unfinished);
    out.precision(17);
    for (const Pose& pose : poses) {
      out << pose.position.transpose() << ' ' << pose.orientation.w() << ' '
          << pose.orientation.vec().transpose() << '\n';
    }
  }
  std::filesystem::rename(unfinished, file);
}

}  // namespace

std::vector<PeerCase> peer_cases() {
  return {buttons(),
          discharging(buttons(), 0.10, 10000, 16000),
          rods(),
          discharging(rods(), 0.70, 2000, 3000),
          boxed(2, 200),
          boxed(3, 200),
          boxed(5, 200),
          boxed(1, 400),
          boxed(1, 600),
          boxed(1, 1000)};
}

std::vector<Pose> settled_bed(const PeerCase& peer_case, const std::filesystem::path& folder) {
  const std::string bed = peer_case.name.substr(0, peer_case.name.find("flow"));
  const std::filesystem::path file = folder / (bed + ".poses");
  std::vector<Pose> poses = read_poses(file);
  if (static_cast<int>(poses.size()) == peer_case.clump_count) return poses;
  std::fprintf(stderr, "settling the bed of %s\n", bed.c_str());
  poses = settle(peer_case);
  write_poses(poses, file);
  return poses;
}

sim::Scene scene_of(const PeerCase& peer_case, const std::vector<Pose>& poses) {
  sim::Scene scene = empty_scene(peer_case, true);
  for (const Pose& pose : poses) scene.add_body(0, pose.position, pose.orientation);
  return scene;
}

sim::SimulationOptions options_of(const PeerCase& peer_case) {
  // Nothing but the cap limits the step: it is the engines' common one
  return {.time_step = {.fraction = 1.0,
                        .impact_speed = 1e-3,
                        .steps_per_contact = 1.0,
                        .largest = peer_case.time_step}};
}

std::vector<PlacedSphere> placed_spheres(const PeerCase& peer_case,
                                         const std::vector<Pose>& poses) {
  std::vector<PlacedSphere> placed;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    for (const sim::ElementSphere& sphere : peer_case.spheres) {
      placed.push_back({static_cast<int>(i),
                        poses[i].position + poses[i].orientation * sphere.centre,
                        sphere.radius});
    }
  }
  return placed;
}

ContactCount count_contacts(const PeerCase& peer_case, const std::vector<PlacedSphere>& spheres) {
  std::vector<Vec3> centres;
  std::vector<double> radii;
  for (const PlacedSphere& sphere : spheres) {
    centres.push_back(sphere.centre);
    radii.push_back(sphere.radius);
  }
  sim::CellList<3> cells;
  std::vector<sim::IndexPair> near;
  sim::find_near_pairs<3>(centres, radii, 0.0, cells, near);
  ContactCount count;
  std::set<std::pair<int, int>> touching;
  for (const sim::IndexPair& pair : near) {
    const int a = spheres[pair.first].body, b = spheres[pair.second].body;
    if (a == b) continue;
    ++count.between_spheres;
    touching.insert(std::minmax(a, b));
  }
  const sim::Scene scene = empty_scene(peer_case, true);
  std::set<std::pair<int, int>> at_walls;
  for (const PlacedSphere& sphere : spheres) {
    for (int w = 0; w < static_cast<int>(scene.walls.size()); ++w) {
      if (sim::look_at(scene.walls[w], sphere.centre).distance >= sphere.radius) continue;
      ++count.with_walls;
      at_walls.insert({sphere.body, w});
    }
  }
  count.bodies_per_body =
      static_cast<double>(2 * touching.size() + at_walls.size()) / peer_case.clump_count;
  return count;
}

}  // namespace graintruth::bench
