// graintruth new: an annotated experiment file to start from.
#include <fmt/format.h>

#include "app/commands.h"
#include "datasets/input_error.h"
#include "datasets/run_folder.h"

namespace graintruth::app {

namespace {

// Every key that the loader knows, with its unit and how a laboratory finds its value. It loads as
// it stands once films of these names lie beside it.
constexpr const char* micro_template =
    R"(# An experiment for graintruth. Every length, angle, time and mass has its unit in the key: _m, _cm or _mm; _rad or
# _deg; _s or _ms; _kg or _g; _pa, _kpa, _mpa or _gpa. Write the unit that you measured in.
# x points right, z up; choose the origin yourself and use it everywhere (here: the middle of the throat).
# Paths are relative to this file. Replace every value by yours, then run: graintruth check experiment.toml

title = "Two-ball particles let down through a V hopper by a sinking piston"
# Repeated in every report; leave it out if there is nothing to say.
note = "Values of the template: replace them."

[particle]
count = 10                         # particles in the rig
mass_g = 142                       # of one particle; weigh many and divide
# The balls that make one particle, along its long axis; offsets from its centre of mass. Films are tracked of two
# balls, as here, or of one: {offset_mm = 0, radius_mm = 5}, which shows no angle.
spheres = [
  {offset_mm = -13.915, radius_mm = 22.225},
  {offset_mm = 13.915, radius_mm = 22.225},
]

# Bench values. A parameter under [tune] starts from no assumption about them, but what the films cannot tell is held
# at its bench value. Each friction and the restitution may have <name>_uncertainty, one standard deviation.
[material]
elastic_modulus_gpa = 6.89         # Young's modulus of the ball
poisson_ratio = 0.35
friction_particle_particle = 0.36  # tilting test: tangent of the angle at which one slides on the other
friction_particle_particle_uncertainty = 0.03
friction_particle_wall = 0.35      # the same on a piece of the wall
friction_particle_wall_uncertainty = 0.03
restitution = 0.83                 # drop test: square root of rebound height over drop height

# A V hopper above a column in which a piston sinks; the throat is at z = 0, the middle of the column at x = 0.
# For any other rig write kind = "walls", one [[rig.wall]] per wall with name, from_x_mm, from_z_mm, to_x_mm, to_z_mm,
# and, if something sinks, [rig.piston] with face_z_mm, left_x_mm, right_x_mm, velocity_z_mm_per_s (negative: down).
[rig]
kind = "hopper_column_piston"
column_width_mm = 135
column_depth_mm = 280              # from the throat down
slope_angle_deg = 60               # of the hopper, from the horizontal
slope_height_mm = 300
piston_speed_mm_per_s = 46         # downwards, from the start event
piston_start_z_mm = 0              # its face before the event
front_back_gap_mm = 46             # between the panes; a little more than a ball, so that one layer fits
gravity_m_per_s2 = 9.81

# The camera looks straight at the panes and does not move. Dark dots on light ground, in the plane of the particle
# centres, spread over the whole picture; at least 4, better 8 or more.
[camera]
frame_rate_hz = 50                 # true rate of the recording: film a stop watch once
pixel_aspect = 1.0                 # width of a pixel over its height; 1 for nearly every camera
noted_event_s = 0.2                # when the piston starts, in seconds of film; only checks what is found; may be left out
fiducial_diameter_mm = 14
fiducials_mm = [                   # [x, z] of each centre, by ruler
  [-290, 220],
  [290, 220],
  [-290, 0],
  [290, 0],
  [-290, -220],
  [290, -220],
  [-160, -110],
  [160, -110],
]

# When experiment and simulation are compared: at 0, one interval, two intervals, ... after the start event.
[measure]
frame_interval_s = 0.2
frames = 25

# What the calibration may move, and within what bounds. Leave out what is known well enough. What you know besides the
# films may stand there too: prior = "bench" (the bench value with its uncertainty) or {mean = ..., uncertainty = ...}.
[tune]
friction_particle_particle = {lower = 0.0, upper = 0.6}
friction_particle_wall = {lower = 0.0, upper = 0.7}
restitution = {lower = 0.3, upper = 0.95}

# One film for each repetition with the same start, at least 2; the intervals narrow quickly up to 5 or 6.
# In place of a film: tracks = "film1.csv" with the columns time_s (0 at the event), particle, x_m, z_m, angle_rad.
[[replicate]]
video = "film1.mp4"

[[replicate]]
video = "film2.mp4"

[[replicate]]
video = "film3.mp4"

[[replicate]]
video = "film4.mp4"

[[replicate]]
video = "film5.mp4"

# Where the particles lie before the event, one [[start]] a particle, in any order; particle n is the one that starts
# in place n. angle: of the long axis, counter-clockwise from +x. Without any, the first frame numbers the particles.
[[start]]
x_mm = 40.86
z_mm = 22.3
angle_deg = 0.3

[[start]]
x_mm = -67.64
z_mm = 44.68
angle_deg = 120

[[start]]
x_mm = -18.63
z_mm = 36.09
angle_deg = 94.7

[[start]]
x_mm = 35.41
z_mm = 66.46
angle_deg = 0.1

[[start]]
x_mm = -29.36
z_mm = 91.08
angle_deg = 13.1

[[start]]
x_mm = 81
z_mm = 94.37
angle_deg = 131.4

[[start]]
x_mm = -103.77
z_mm = 107.27
angle_deg = 120

[[start]]
x_mm = 18.39
z_mm = 120.78
angle_deg = 132.1

[[start]]
x_mm = -51.62
z_mm = 129.57
angle_deg = 13

[[start]]
x_mm = 119.53
z_mm = 134.57
angle_deg = 60
)";

// A bin that runs out: nothing to start from but the rig and the films.
constexpr const char* macro_template =
    R"(# An experiment for graintruth: a bin of plates that runs out through an orifice. Every length, angle, time and mass has
# its unit in the key: _m, _cm or _mm; _s or _ms; _kg or _g; _pa to _gpa. Write the unit that you measured in.
# x points right, z up; the origin is the middle of the orifice on the floor's upper face.
# Paths are relative to this file. Replace every value by yours, then run: graintruth check experiment.toml

title = "Elliptical plates running out of a flat-bottomed bin"
# Repeated in every report; leave it out if there is nothing to say.
note = "Values of the template: replace them."

[particle]
count = 200                        # in the bin at first; every film must show as many
mass_g = 0.332                     # of one particle; weigh many and divide
# What the camera sees: an ellipse, by its SEMI-axes (half the lengths that a calliper shows), and its thickness.
plate = {semi_major_mm = 6.9, semi_minor_mm = 5.3, thickness_mm = 2.3}

# Bench values.
[material]
elastic_modulus_gpa = 3.5          # Young's modulus
poisson_ratio = 0.3
friction_particle_particle = 0.61  # tilting test: tangent of the angle at which one slides on the other
friction_particle_wall = 0.67      # the same on a piece of the wall
restitution = 0.74                 # drop test: square root of rebound height over drop height

[rig]
kind = "flat_bin_orifice"
bin_width_mm = 150                 # between the side walls
bin_height_mm = 210                # of the side walls above the floor
front_back_gap_mm = 2.6            # between the panes; a little more than a plate, so that one layer fits

# The camera looks straight at the panes and does not move. Dark dots on light ground, in the plane of the particles,
# beside the bin; at least 4, better 8 or more. A short exposure (1/1000 s or less) keeps falling particles sharp.
[camera]
frame_rate_hz = 100                # the true rate of the recording, not what the file says
fiducial_diameter_mm = 6
fiducials_mm = [
  [-112, -20], [112, -20], [-142, -20], [142, -20],
  [-112, 50], [112, 50], [-142, 50], [142, 50],
  [-112, 120], [112, 120], [-142, 120], [142, 120],
  [-112, 190], [112, 190], [-142, 190], [142, 190],
]

[tune]
friction_particle_particle = {lower = 0.0, upper = 0.7}
friction_particle_wall = {lower = 0.0, upper = 0.7}

# One film a replicate, with the width of its orifice. It must show the bed at rest for some frames, and go on until the
# flow has stopped. Three orifices or more give Beverloo's C and k. At least one orifice needs a second film, better all of
# them a third: how films of one orifice differ is all that tells how exactly a rate is known.
# In place of a video: tracks = "file.csv" of trackpy, TrackMate or ImageJ, or discharge = "file.csv" of a load cell (time
# and mass); docs/imports.md tells what to state beside them.
# held_out = true keeps a film out of the calibration, to be predicted. Where no film says so, orifices narrower than six
# particle diameters are held out, as long as two wider ones remain.
[[replicate]]
video = "orifice075_rep1.mp4"
orifice_width_mm = 75

[[replicate]]
video = "orifice075_rep2.mp4"
orifice_width_mm = 75

[[replicate]]
video = "orifice085_rep1.mp4"
orifice_width_mm = 85

[[replicate]]
video = "orifice100_rep1.mp4"
orifice_width_mm = 100
)";

}  // namespace

int run_new(const NewCommand& command) {
  const std::filesystem::path file = command.folder / "experiment.toml";
  if (std::filesystem::exists(file)) {
    throw datasets::InputError(fmt::format(
        "{}: is there already and is not overwritten; give another folder.", file.string()));
  }
  std::error_code error;
  std::filesystem::create_directories(command.folder, error);
  if (error) {
    throw datasets::InputError(fmt::format("{}: the folder cannot be made ({}); give another one.",
                                           command.folder.string(),
                                           error.message()));
  }
  datasets::write_whole(file, command.kind == "macro" ? macro_template : micro_template);
  fmt::print(
      "{0}\nPut your films beside it, replace its values by yours, then: graintruth check {0}\n",
      file.string());
  return 0;
}

}  // namespace graintruth::app
