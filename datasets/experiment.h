// What a laboratory did and wants to know: the experiment file, read, checked and in SI units.
// x right, z up, y out of the picture; the origin is the laboratory's own.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/experiment/camera.h"
#include "datasets/experiment/named_body.h"
#include "datasets/track_files.h"

namespace graintruth::datasets {

// A bench value. The uncertainty is one standard deviation; 0 where the laboratory gave none.
struct BenchValue {
  double value = 0.0;
  double standard_uncertainty = 0.0;
};

// One ball of the nominal particle, on its long axis.
struct AxialSphere {
  double offset = 0.0;  // m, centre along the long axis, from the particle's nominal centre of mass
  double radius = 0.0;  // m
};

// A flat plate with an elliptical outline that stands upright in the picture plane: a button.
struct EllipticalPlate {
  double semi_major = 0.0;  // m
  double semi_minor = 0.0;  // m
  double thickness = 0.0;   // m, along y

  // A disc looks the same however it turns: the outline of what is rounder than this tells no
  // angle.
  bool shows_angle() const { return semi_major > 1.05 * semi_minor; }
};

struct Particle {
  int count = 0;                         // how many lie in the rig; 0 where a film need not tell
  std::vector<AxialSphere> spheres;      // at least one, unless the particle is a plate
  double mass = 0.0;                     // kg
  std::optional<EllipticalPlate> plate;  // what the camera sees, where that is not the spheres
  std::optional<NamedBody> body;         // the same, of other kinds
};

struct Material {
  double elastic_modulus = 0.0;           // Pa
  double poisson_ratio = 0.0;             // -
  BenchValue friction_particle_particle;  // static friction by tilting, say
  BenchValue friction_particle_wall;
  BenchValue restitution;
};

// The bench value of a parameter, by the names that TunedParameter knows.
const BenchValue& bench_value(const Material& material, std::string_view parameter);

// A rigid wall seen edge-on: a segment extruded along y. Both faces are solid.
struct Wall {
  std::string name;
  double from_x = 0.0, from_z = 0.0;  // m
  double to_x = 0.0, to_z = 0.0;      // m
};

// A horizontal face that stands still until the start event and then moves at a constant speed.
struct Piston {
  double face_z = 0.0;      // m, before the event
  double left_x = 0.0;      // m
  double right_x = 0.0;     // m
  double velocity_z = 0.0;  // m/s, negative downwards
};

// An upright bin with a flat floor and an orifice in its middle, closed until the start event. The
// origin is the middle of the orifice on the floor's upper face.
struct FlatBin {
  double width = 0.0;          // m, between the side walls
  double height = 0.0;         // m, of the side walls above the floor
  double orifice_width = 0.0;  // m; 0 where only the replicates tell it
};

struct Rig {
  std::vector<Wall> walls;
  std::optional<Piston> piston;
  std::optional<FlatBin> bin;
  double front_back_gap = 0.0;  // m, clear distance of the panes; the particles move in one layer
  double gravity = 9.81;        // m/s2, along -z
};

// Where a particle nominally lies before the event; gives it its number.
struct StartPlace {
  double x = 0.0, z = 0.0;  // m
  double angle = 0.0;       // rad
};

struct Replicate {
  std::string name;                     // stem of the file unless given
  std::filesystem::path video;          // exactly one of these three is given
  std::filesystem::path tracks;         // see track_files.h
  std::filesystem::path discharge;      // of a bin; see discharge_curve.h
  TrackSource source;                   // how the file of tracks is meant; event_time of both files
  std::optional<double> frame_rate;     // Hz, where it is not the camera's
  std::optional<double> orifice_width;  // m, where it is not the rig's
  std::filesystem::path corrections;  // CSV of corrections made by hand; empty where there are none
  // Kept out of the calibration, to be predicted. Where no replicate of a bin says so, see
  // calibrate/bin_problem.h.
  std::optional<bool> held_out;

  const std::filesystem::path& file() const {
    return !video.empty() ? video : !tracks.empty() ? tracks : discharge;
  }
};

// What of the particles is compared: every particle's own track, or only how high the heap of them
// reaches, for films in which particles cannot be told apart.
enum class Compared { particles, heap_height };

// When and what is compared.
struct Measurement {
  Compared compared = Compared::particles;
  double frame_interval = 0.2;  // s
  int frames = 25;              // at 0, frame_interval, ... from the event
};

// A parameter that the calibration may move.
struct TunedParameter {
  std::string name;  // friction_particle_particle, friction_particle_wall or restitution
  double lower = 0.0;
  double upper = 0.0;
  // What is known of it besides the data: the mean of a Gaussian and its standard deviation.
  std::optional<BenchValue> prior = {};
};

// How the time step is found: the largest at which the answer does not change, before the search;
// or as one more axis of the search, where it may be traded against the parameters.
enum class TimeStepRule { gate, joint };

// What the search minimises: the smooth distance of what was measured, or what the model is judged
// by in the end: one minus the agreement of tracks, and for bins the constants of Beverloo's law
// and of the kinematic model.
enum class ObjectiveForm { smooth, requested };
std::string_view name_of(ObjectiveForm form);

struct Experiment {
  std::filesystem::path file;
  std::string name;  // stem of the file: names the run folder
  std::string title;
  std::string note;     // provenance that every report must repeat, e.g. that films are synthetic
  std::string part_of;  // title of the joint calibration that it is read for; empty: none
  Particle particle;
  Material material;
  Rig rig;
  Camera camera;
  std::vector<StartPlace> starts;  // empty, or one a particle
  std::vector<Replicate> replicates;
  Measurement measurement;
  std::vector<TunedParameter> tuned;
  TimeStepRule time_step_rule = TimeStepRule::gate;
  ObjectiveForm objective = ObjectiveForm::smooth;
};

// The name that an experiment file gives to its run: its stem, or that of its folder where the file
// is called experiment.toml.
std::string experiment_name(const std::filesystem::path& file);

// What an experiment file is read for. Films can be tracked without a rig, materials, masses or a
// second replicate; what is given is checked all the same.
enum class Purpose { calibration, tracking };

// Reads, converts to SI and checks an experiment file. Throws InputError with file, line and key
// for a key that is unknown or missing, a unit that does not fit, or a value that cannot be. Does
// not open videos, tracks or curves, but they must exist.
Experiment load_experiment(const std::filesystem::path& file,
                           Purpose purpose = Purpose::calibration);

// The experiment as one replicate was made and filmed: with its own orifice and frame rate in `rig`
// and `camera`.
Experiment as_filmed(const Experiment& experiment, const Replicate& replicate);

// A TOML file of contact parameters, name = value, with the names that TunedParameter knows. Throws
// InputError for an unknown name or an impossible value.
std::map<std::string, double> read_parameter_table(const std::filesystem::path& file);

}  // namespace graintruth::datasets
