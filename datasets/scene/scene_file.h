// A scene to simulate: particles, walls, how they are filled and what happens then, read from a
// scene file or a deck of the thesis, checked and in SI units. Plain data; x right, z up, y away
// from the viewer.
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace graintruth::datasets {

struct SceneMaterial {
  std::string name;
  bool is_rigid = false;
  double elastic_modulus = 0.0;  // Pa
  double poisson_ratio = 0.0;
};

// What two materials do to each other.
struct SceneSurfaces {
  int first = 0, second = 0;  // indices into SceneFile::materials
  double friction = 0.0;
  double restitution = 1.0;
  double static_friction = 0.0;   // 0: the same as friction
  double rolling_friction = 0.0;  // of the reduced radius
};

// Forms of the contact law other than the default one, by the names that sim gives them.
struct SceneLaw {
  std::string normal_spring = "hertz";
  std::string tangential_spring = "mindlin";
  std::string coulomb_limit = "whole";
  std::string tension = "clipped";
  std::string damping_form = "exact";
  std::string damping_sharing = "inv_sqrt_n";
  double linear_stiffness = 0.0;      // N/m; with the linear normal spring alone
  double tangential_stiffness = 0.0;  // N/m; with the constant tangential spring alone
  double tangential_damping = 1.0;    // over that along the normal
};

struct SceneSphere {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // m
  double radius = 0.0;                               // m
};

// A body of revolution about x, to be filled with spheres along equal chords.
struct SceneProfile {
  std::vector<std::array<double, 2>> points;  // m; place on the axis, half-width
  std::array<double, 2> ellipse{};            // m; half-lengths instead, where there are no points
  int chords = 0;
};

// Equal spheres in a row, with the volume of one ball.
struct SceneChain {
  int count = 0;
  double aspect_ratio = 1.0;
  double ball_radius = 0.0;  // m
};

// Sizes relative to nominal: equally likely classes of a distribution of mean 1.
struct SizeSpread {
  enum class Kind { none, uniform, normal, lognormal };
  Kind kind = Kind::none;
  double standard_deviation = 0.0;  // relative
  int classes = 1;
};

// A kind of particle. Exactly one of spheres, profile and chain says its shape.
struct SceneParticle {
  std::string name;
  int material = 0;
  int count = 0;  // to be filled; places come on top
  std::vector<SceneSphere> spheres;
  std::optional<SceneProfile> profile;
  std::optional<SceneChain> chain;
  std::optional<double> density;           // kg/m3
  std::optional<double> mass;              // kg; wins over the density
  std::optional<Eigen::Vector3d> inertia;  // kg m2; about the axes of the shape, wins over both
  SizeSpread size;
};

// Times count from the event.
struct SceneMotion {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          // m/s
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  // rad/s, right-handed
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero();             // m
  double start = 0.0;                                          // s
  double end = std::numeric_limits<double>::infinity();        // s
  bool operator==(const SceneMotion&) const = default;
};

struct SceneWall {
  enum class Kind { segment, plane, polygon, disk, cylinder, mesh };
  std::string name;
  int material = 0;
  Kind kind = Kind::plane;
  // m; segment and cylinder: two ends, plane: a point, disk: its centre, polygon: corners,
  // mesh: three corners a facet
  std::vector<Eigen::Vector3d> points;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();          // plane, disk
  double radius = 0.0;                                        // m; disk, cylinder
  SceneMotion motion;                                         // of the wall
  SceneMotion drag;                                           // of its surface alone
  double opens_at = std::numeric_limits<double>::infinity();  // s after the event
  std::string body;  // walls with the same word are parts of one rigid body
};

// The room inside a cylinder, open at both ends.
struct SceneRoom {
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = Eigen::Vector3d::UnitZ();  // m, of its axis
  double radius = 0.0;                                                            // m
};

// How the counted particles come in.
struct SceneFill {
  // rows: planar particles at random angles, in rows from the floor of the region up, that touch
  // neither each other nor its sides
  enum class Method { lattice, rain, rows };
  Method method = Method::lattice;
  Eigen::Vector3d low = Eigen::Vector3d::Zero();   // m; the region, of centres' bounding balls
  Eigen::Vector3d high = Eigen::Vector3d::Zero();  // m
  double clearance = 0.0;                          // m; between bounding balls
  // m; lattice: how far each particle lies off its site at most, along every axis. Equal balls that
  // lie straight above each other stay so for ever.
  std::optional<double> jitter;
  // lattice: a second site in the middle of eight, so that half as much room again is filled; then
  // `clearance` is kept between these
  std::optional<bool> body_centred;
  std::optional<SceneRoom> within;  // lattice: only sites of which all of the particle lies in here
  bool random_orientation = true;
  double angle = 0.0;     // rad; picture angle where not random
  double interval = 0.0;  // s; rain: from one to the next
  double speed = 0.0;     // m/s; rain: downwards
  double length = 0.0;    // m; rows: of a particle; neighbours lie 2 % of it apart
  int number = 0;         // rows: tells fillings of the same seed apart
};

// One particle put where the scene says.
struct ScenePlace {
  int particle = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // m
  double angle = 0.0;                                  // rad; picture angle of the long axis
  double azimuth = 0.0;                                // rad; then turned about z
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // m/s
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  // rad/s
};

// One stretch of the simulation. What is set holds for this phase instead of the surfaces' own.
struct ScenePhase {
  std::string name;
  double duration = 0.0;            // s; at most
  bool until_rest = false;          // ends earlier, when nothing moves any more
  double output_interval = 0.0;     // s; 0: only the end is kept
  double time_step_fraction = 0.5;  // of the Rayleigh step
  double fastest_impact = 1.0;      // m/s; collisions up to this speed are resolved
  double global_damping = 0.0;      // 1/s
  std::optional<double> friction_between_particles;
  std::optional<double> friction_with_walls;
  std::optional<double> restitution;
  std::optional<double> restitution_at_most;  // lowers that of the surfaces, where it is above this
  std::optional<double> damping_ratio;        // in place of a restitution: beta of thesis 1.20
};

// All that decides what happens.
// Where a scene repeats itself: what leaves it at low + length comes back at low.
struct ScenePeriod {
  Eigen::Vector3d low = Eigen::Vector3d::Zero();     // m
  Eigen::Vector3d length = Eigen::Vector3d::Zero();  // m; 0 along an axis that does not repeat
  bool is_given() const { return !length.isZero(0.0); }
};

struct SceneData {
  bool is_planar = false;                                      // one layer
  Eigen::Vector3d gravity = Eigen::Vector3d(0.0, 0.0, -9.81);  // m/s2
  ScenePeriod period;
  std::vector<SceneMaterial> materials;
  std::vector<SceneSurfaces> surfaces;
  SceneLaw law;
  std::vector<SceneParticle> particles;
  std::vector<SceneWall> walls;
  SceneFill fill;
  std::vector<ScenePlace> places;
  std::vector<ScenePhase> phases;
  int event_phase = 0;                 // time 0 is its start: walls move and open from then on
  std::optional<double> exit_height;   // m; particles below it count as discharged
  std::optional<double> leaves_below;  // m; particles below it are taken out, frame by frame
};

struct SceneFile : SceneData {
  std::filesystem::path file;
  std::string name;  // stem of the file: names the run folder
  std::string title;
  std::vector<std::filesystem::path> inputs;  // other files that were read
  std::vector<std::string> warnings;          // sentences
};

// Decks of the thesis end in .txt, scene files in .toml.
bool is_deck(const std::filesystem::path& file);

// The file that says what a deck leaves out, where no other is named: the .toml beside it.
std::filesystem::path sidecar_beside(const std::filesystem::path& deck);

// Reads a scene file, or a deck with its sidecar. Throws InputError with
// file, line and key for whatever cannot be used.
SceneFile load_scene(const std::filesystem::path& file);
SceneFile load_scene(const std::filesystem::path& file, const std::filesystem::path& sidecar);

}  // namespace graintruth::datasets
