// What stands around the grains, as data: walls with their motions, how a run begins and where
// grains leave. x right, z up, y out of the picture; the origin is the laboratory's own.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/scene/scene_file.h"

namespace graintruth::datasets {

// A rigid wall seen edge-on: a segment extruded along y. Both faces are solid.
struct Wall {
  std::string name;
  double from_x = 0.0, from_z = 0.0;  // m
  double to_x = 0.0, to_z = 0.0;      // m
};

// A horizontal face that stands still until the start event and then moves at a constant speed.
struct MovingFace {
  double face_z = 0.0;      // m, before the event
  double left_x = 0.0;      // m
  double right_x = 0.0;     // m
  double velocity_z = 0.0;  // m/s, negative downwards
};

// An upright box that holds the bed, seen from the front. Its floor is at z = 0.
struct BedBox {
  double left_x = 0.0, right_x = 0.0;  // m, of the side walls
  double height = 0.0;                 // m, of the side walls above the floor

  double width() const { return right_x - left_x; }
};

// Where grains leave: downwards, between two edges at one height.
struct Opening {
  double left_x = 0.0, right_x = 0.0;  // m
  double z = 0.0;                      // m

  double width() const { return right_x - left_x; }
};

// How the outline of the bed is looked for in a film: drawings in the plane of the scale (y = 0), x
// and z in m. Empty where the drawing of the rig does not tell.
struct SeenOutline {
  using Polygon = std::vector<Eigen::Vector2d>;

  // What moves, and hides what is behind it: a tube, a gate. At rest until the start event.
  struct Mover {
    std::string name;                                    // of its wall
    Polygon drawing;                                     // before the event
    Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  // m/s, as stated
    bool speed_is_stated = false;                        // else the film alone tells it
    double radius = 0.0;  // m, of an upright tube about the middle of its drawing; 0: flat
  };
  // What turns about the line of sight all the time: a drum. Grains are seen inside it alone.
  struct Drum {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // m
    double radius = 0.0;                               // m, inside
    double turning = 0.0;                              // rad/s, counter-clockwise as seen
  };

  // A free surface that is looked for by itself where there are several: of the bed that stays
  // above, of the heap below.
  struct Surface {
    std::string name;                 // "upper"
    double from_x = 0.0, to_x = 0.0;  // m, where its grains may come to lie
    double floor_z = 0.0;             // m, of the level floor under them
    std::optional<double> top_z;      // m, of what closes the room above them; none: open
  };

  double from_x = 0.0, to_x = 0.0;  // m, where grains may come to lie
  double floor_z = 0.0;             // m, of the level floor under them; of a drum its lowest point
  std::vector<Polygon> grains_before;  // grains are seen here before the event
  std::vector<Polygon> grains_after;   // and here once all is at rest, or steady
  std::vector<Polygon> empty;          // none is ever seen here
  std::optional<Mover> mover;
  std::optional<Drum> drum;
  std::vector<Surface> surfaces;  // empty: one without a name, over all that is above
};

// All surfaces, also where it is one without a name.
std::vector<SeenOutline::Surface> surfaces_of(const SeenOutline& seen);
// None where no surface has this name.
std::optional<SeenOutline::Surface> surface_named(const SeenOutline& seen, std::string_view name);

// From where a simulation begins.
enum class BeginsFrom {
  mean_of_replicates,  // the same start, placed anew every time: their mean, and their spread
  each_replicate,      // a bed of its own in every replicate
  filling              // as the scene fills itself
};

// What replicates may set otherwise than their rig, in SI: an orifice, a speed. Replicates with the
// same settings belong to one condition.
struct RigSetting {
  std::string name;  // the key without its unit
  double value = 0.0;
  std::string_view unit;  // SI

  friend bool operator==(const RigSetting&, const RigSetting&) = default;
};

// Of a scene whose grains are those of the experiment
inline constexpr int grain_material = 0;
inline constexpr int wall_material = 1;
// How soft grains may be that flow. A softer contact lasts longer and allows a longer time step;
// above that stiffness flow hardly depends on it.
inline constexpr double softened_overlap_of_flow = 0.01;

struct Rig {
  std::string kind;  // of [rig], for sentences; nobody asks what it is
  SceneData scene;   // walls with their motions, filling and phases; grains as `brings_grains` says
  bool brings_grains = false;  // the scene has particles, materials and surfaces of its own
  int filled_count = 0;        // grains, where [rig] says how many; 0: [particle] does
  BeginsFrom begins_from = BeginsFrom::filling;
  double gravity = 9.81;          // m/s2, along -z
  double softened_overlap = 0.0;  // of a grain's diameter, in the hardest impact; 0: never softened
  std::vector<RigSetting> settings;
  // Which other experiment with the same grains tells apart what this one leaves together, for
  // sentences: "a drum ..."; empty where none is known.
  std::string complement;
  std::vector<std::string> observables;  // what is compared where [measure] names nothing

  // As the camera sees it
  std::vector<Wall> walls;
  std::optional<MovingFace> moving_face;
  std::optional<BedBox> bed;
  std::optional<Opening> opening;
  std::optional<SeenOutline> seen_outline;  // where the bed's free surface is what is seen of it
  double front_back_gap = 0.0;              // m, clear distance of the panes; 0: not one layer
};

// The middles of the columns in which an outline is compared, m: half a grain wide, with an edge at
// x = 0.
std::vector<double> outline_columns(const SeenOutline::Surface& surface, double grain_diameter);
// Of all that is seen.
std::vector<double> outline_columns(const SeenOutline& seen, double grain_diameter);

// "orifice 65 mm", or empty where nothing is set.
std::string words_on(const std::vector<RigSetting>& settings);

}  // namespace graintruth::datasets
