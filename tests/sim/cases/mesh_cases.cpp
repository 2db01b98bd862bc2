// A surface is what it is, however it is cut into facets: bodies that fall on meshes against the
// same bodies on the plane wall.
#include <array>
#include <functional>
#include <numbers>

#include "sim/simulation.h"
#include "tests/sim/cases/check.h"

namespace graintruth::sim::cases {
namespace {

const std::string kPlane = "the same body on the plane wall";

using Corners = std::vector<Vec3>;  // three a facet

void add_facet(const Vec3& a, const Vec3& b, const Vec3& c, Corners& mesh) {
  mesh.insert(mesh.end(), {a, b, c});
}

// A square floor about the origin in z = 0, `cells` by `cells` squares of side `edge`, each cut
// along one diagonal or the other.
Corners floor_of(int cells, double edge, bool other_diagonal = false) {
  const auto corner = [&](int i, int j) {
    return Vec3((i - 0.5 * cells) * edge, (j - 0.5 * cells) * edge, 0.0);
  };
  Corners mesh;
  for (int i = 0; i < cells; ++i) {
    for (int j = 0; j < cells; ++j) {
      const Vec3 a = corner(i, j), b = corner(i + 1, j), c = corner(i + 1, j + 1),
                 d = corner(i, j + 1);
      if (other_diagonal) {
        add_facet(a, b, d, mesh);
        add_facet(b, c, d, mesh);
      } else {
        add_facet(a, b, c, mesh);
        add_facet(a, c, d, mesh);
      }
    }
  }
  return mesh;
}

Corners both(Corners first, const Corners& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

// The same surface a second time, a hair below: as a drawing that was exported twice.
Corners nearly_twice(Corners mesh) {
  Corners again = mesh;
  for (Vec3& corner : again) corner.z() -= 1e-9;
  return both(std::move(mesh), again);
}

Corners the_other_way_round(Corners mesh) {
  for (std::size_t i = 0; i < mesh.size(); i += 3) std::swap(mesh[i], mesh[i + 1]);
  return mesh;
}

// Large facets for x < 0 that meet small ones, whose corners lie on their sides.
Corners t_jointed() {
  Corners mesh;
  for (int j = -1; j < 1; ++j) {
    const double low = 0.06 * j, high = low + 0.06;
    add_facet({-0.06, low, 0.0}, {0.0, low, 0.0}, {0.0, high, 0.0}, mesh);
    add_facet({-0.06, low, 0.0}, {0.0, high, 0.0}, {-0.06, high, 0.0}, mesh);
  }
  Corners fine = floor_of(8, 0.015);
  for (std::size_t i = 0; i < fine.size(); i += 3) {
    if (std::min({fine[i].x(), fine[i + 1].x(), fine[i + 2].x()}) > -1e-9) {
      add_facet(fine[i], fine[i + 1], fine[i + 2], mesh);
    }
  }
  return mesh;
}

struct Floor {
  const char* name;
  Corners mesh;
};
std::vector<Floor> floors() {
  return {{"coarse", floor_of(1, 0.12)},
          {"fine", floor_of(30, 0.004)},
          {"with T joints", t_jointed()},
          {"twice", both(floor_of(8, 0.015), floor_of(8, 0.015))},
          {"twice, the other way round",
           both(floor_of(8, 0.015), the_other_way_round(floor_of(8, 0.015)))},
          {"along both diagonals", both(floor_of(8, 0.015), floor_of(8, 0.015, true))},
          {"nearly twice", nearly_twice(floor_of(8, 0.015))},
          {"coarse and fine at once", both(floor_of(1, 0.12), floor_of(8, 0.015))}};
}

// Where a floor lies: aligned with the axes, or turned so that no number of a corner is zero.
Mat3 tilted() {
  return (Eigen::AngleAxisd(0.21, Vec3::UnitY()) * Eigen::AngleAxisd(-0.13, Vec3::UnitX()) *
          Eigen::AngleAxisd(0.4, Vec3::UnitZ()))
      .toRotationMatrix();
}

// A row of `spheres` touching balls over the floor, which `turn` turns, with friction and e = 0.6.
// It starts with the given speeds in the frame of the floor, with or without weight.
struct Fall {
  int spheres = 1;
  double height = 0.005;  // m; below the balls
  Vec3 velocity = Vec3::Zero();
  double gravity = 9.81;
  double friction = 0.4;
  double tilt = 0.0;  // rad; of the row against the floor
};
constexpr double kRadius = 0.005, kRestitution = 0.6;

Scene falling(const Fall& fall, const Mat3& turn) {
  Scene scene;
  scene.gravity = turn * Vec3(0.0, 0.0, -fall.gravity);
  const int grain = scene.add_material({2e7, 0.3});
  scene.add_material(rigid_material());
  scene.surfaces.set(grain, 1, {.friction = fall.friction, .restitution = kRestitution});
  const int type = scene.add_type(
      make_clump(chain_of_spheres(fall.spheres, kRadius, 2.0 * kRadius), {.density = 1100.0}));
  const Quat turned(turn * Eigen::AngleAxisd(fall.tilt, Vec3::UnitY()).toRotationMatrix());
  scene.add_body(
      type, turn * Vec3(0.0013, 0.0007, kRadius + fall.height), turned, turn * fall.velocity);
  return scene;
}

void add_plane(const Mat3& turn, Scene& scene) {
  scene.add_wall(plane_wall(Vec3::Zero(), turn * Vec3::UnitZ(), {}, 1));
}
void add_mesh(Corners mesh, const Mat3& turn, Scene& scene) {
  for (Vec3& corner : mesh) corner = turn * corner;
  for (const Wall& wall : mesh_walls(mesh, scene.next_wall_body(), {}, 1).facets) {
    scene.add_wall(wall);
  }
}

const std::array<Mat3, 2>& turns() {
  static const std::array<Mat3, 2> both{Mat3::Identity(), tilted()};
  return both;
}

// Rebound speed across the floor over impact speed, without weight.
double rebound_of(const Scene& scene, const Vec3& normal, double speed) {
  Simulation simulation(scene, {.time_step = {.impact_speed = speed, .steps_per_contact = 200.0}});
  simulation.run_until(0.006);
  return simulation.state().velocity[0].dot(normal) / speed;
}

std::vector<Check> rebounds_on_meshes() {
  std::vector<Check> checks;
  constexpr double kSpeed = 0.5;
  for (const Floor& floor : floors()) {
    Worst worst;
    for (const Mat3& turn : turns()) {
      for (const int spheres : {1, 2, 3, 5}) {
        Scene on_mesh = falling(
            {.spheres = spheres, .height = 0.0005, .velocity = {0.0, 0.0, -kSpeed}, .gravity = 0.0},
            turn);
        add_mesh(floor.mesh, turn, on_mesh);
        worst.see_ratio(rebound_of(on_mesh, turn.col(2), kSpeed), kRestitution);
      }
    }
    checks.push_back(within(
        std::string("floor ") + floor.name + ": e = 0.6 of 1, 2, 3, 5 balls in a row, relative",
        "as asked, issue 22",
        5e-3,
        worst.value));
  }
  return checks;
}

// The largest distance from the path on the plane wall, m, until the fifth rebound.
double distance_of_paths(const Fall& fall, const Mat3& turn, const Corners& mesh) {
  Scene on_plane = falling(fall, turn), on_mesh = on_plane;
  add_plane(turn, on_plane);
  add_mesh(mesh, turn, on_mesh);
  Simulation plane(on_plane), facets(on_mesh);
  double largest = 0.0;
  int rebounds = 0;
  double before = -1.0;
  for (int i = 1; rebounds < 5 && i < 2000; ++i) {
    plane.run_until(5e-4 * i);
    facets.run_until(5e-4 * i);
    const State &a = plane.state(), &b = facets.state();
    largest = std::max(largest, (a.position[0] - b.position[0]).norm());
    const double rising = a.velocity[0].dot(turn.col(2));
    if (before < 0.0 && rising > 0.0) ++rebounds;
    before = rising;
  }
  return rebounds == 5 ? largest : NAN;
}

std::vector<Check> paths_on_meshes() {
  std::vector<Check> checks;
  for (const Floor& floor : floors()) {
    Worst worst;
    for (const Mat3& turn : turns()) {
      for (const int spheres : {1, 2, 3}) {
        worst.see(distance_of_paths(
            {.spheres = spheres, .velocity = {0.11, 0.07, 0.0}, .tilt = spheres == 1 ? 0.0 : 0.3},
            turn,
            floor.mesh));
      }
    }
    checks.push_back(within(std::string("floor ") + floor.name +
                                ": path of 1, 2, 3 balls in a row until the fifth rebound, m",
                            kPlane + ", issue 22",
                            1e-6,
                            worst.value));
  }
  return checks;
}

// A drum about y of `sides` flat sides, each two triangles, from the inside; its lowest side is
// level and lies in z = 0, or its lowest edge does.
Corners drum_of(int sides, double radius, bool edge_below) {
  const double half = std::numbers::pi / sides;
  const double low = edge_below ? radius : radius * std::cos(half);
  const auto corner = [&](int i, double y) {
    const double angle = (2 * i + (edge_below ? 0 : 1)) * half;
    return Vec3(radius * std::sin(angle), y, low - radius * std::cos(angle));
  };
  Corners mesh;
  for (int i = 0; i < sides; ++i) {
    add_facet(corner(i, -0.06), corner(i + 1, -0.06), corner(i + 1, 0.06), mesh);
    add_facet(corner(i, -0.06), corner(i + 1, 0.06), corner(i, 0.06), mesh);
  }
  return mesh;
}

// A wedge hopper: two walls of the given slope that meet in the line x = z = 0.
Corners hopper_of(double slope) {
  Corners mesh;
  for (const double side : {-1.0, 1.0}) {
    const Vec3 up(side * std::cos(slope), 0.0, std::sin(slope));
    const Vec3 along(0.0, 0.06, 0.0);
    add_facet(-along, along, 0.2 * up + along, mesh);
    add_facet(-along, 0.2 * up + along, 0.2 * up - along, mesh);
  }
  return mesh;
}

std::vector<Check> rebounds_in_drums_and_hoppers() {
  constexpr double kSpeed = 0.5;
  const Mat3 level = Mat3::Identity();
  Worst on_side, in_edge;
  for (const int sides : {24, 90, 360}) {
    for (const bool edge_below : {false, true}) {
      for (const int spheres : {1, 2, 3, 5}) {
        Scene scene = falling(
            {.spheres = spheres, .height = 0.0005, .velocity = {0.0, 0.0, -kSpeed}, .gravity = 0.0},
            level);
        // The row lies along the drum
        scene.bodies[0].position.x() = 0.0;
        scene.bodies[0].orientation =
            Quat(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitZ()));
        add_mesh(drum_of(sides, 0.1, edge_below), level, scene);
        (edge_below ? in_edge : on_side)
            .see_ratio(rebound_of(scene, Vec3::UnitZ(), kSpeed), kRestitution);
      }
    }
  }
  Worst on_slope;
  const double slope = 60.0 * std::numbers::pi / 180.0;
  for (const int spheres : {1, 2, 3, 5}) {
    const Mat3 turn = Eigen::AngleAxisd(-slope, Vec3::UnitY()).toRotationMatrix();
    Scene scene = falling(
        {.spheres = spheres, .height = 0.0005, .velocity = {0.0, 0.0, -kSpeed}, .gravity = 0.0},
        turn);
    scene.bodies[0].position += 0.1 * turn.col(0);
    add_mesh(hopper_of(slope), level, scene);
    on_slope.see_ratio(rebound_of(scene, turn.col(2), kSpeed), kRestitution);
  }
  return {within("drum of 24, 90, 360 sides, on a side: e = 0.6, relative",
                 "as asked, issue 22",
                 5e-3,
                 on_side.value),
          within("the same, in an edge between two sides, relative",
                 "as asked, issue 22",
                 5e-3,
                 in_edge.value),
          within("hopper of 60 degrees, on its wall: e = 0.6, relative",
                 "as asked, issue 22",
                 5e-3,
                 on_slope.value)};
}

constexpr std::array kCases = {
    Case{"ReboundsOnMeshes", "Restitution on meshes", rebounds_on_meshes},
    Case{"PathsOnMeshes", "Bouncing over a mesh", paths_on_meshes},
    Case{"ReboundsInDrumsAndHoppers",
         "Restitution in drums and hoppers of triangles",
         rebounds_in_drums_and_hoppers}};

}  // namespace

std::span<const Case> mesh_cases() { return kCases; }

}  // namespace graintruth::sim::cases
