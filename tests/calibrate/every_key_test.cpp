// Every key of an experiment, and of the scene that it names, changed alone: either a fingerprint
// changes, so that nothing old is read back, or the key stands in a list of those that decide
// neither tracks nor simulations.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <toml++/toml.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>

#include "calibrate/problem.h"
#include "datasets/experiment/tracking_spec.h"
#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

// Films of pairs of balls, from the pictures of a lens to corrections by hand.
constexpr const char* films = R"(title = "Films"
note = "Made up"
[particle]
count = 2
mass_g = 142
spheres = [{offset_mm = -13.9, radius_mm = 22.2}, {offset_mm = 13.9, radius_mm = 22.2}]
size = {distribution = "normal", standard_deviation = 0.05, classes = 5}
[material]
elastic_modulus_gpa = 6.89
poisson_ratio = 0.35
friction_particle_particle = 0.36
friction_particle_particle_uncertainty = 0.03
friction_particle_wall = 0.35
restitution = 0.83
rolling_friction_particle_wall = 0.01
friction_particle_piston = 0.2
[rig]
kind = "hopper_column_piston"
column_width_mm = 135.0
column_depth_mm = 280.0
slope_angle_deg = 60.0
slope_height_mm = 300.0
piston_speed_mm_per_s = 46.0
piston_start_z_mm = -1.0
front_back_gap_mm = 46.0
gravity_m_per_s2 = 9.81
[camera]
frame_rate_hz = 50.0
noted_event_s = 0.2
pixel_aspect = 1.1
region_px = [0, 0, 600, 400]
fiducial_diameter_mm = 14.0
fiducials_mm = [[-290.0, 220.0], [290.0, 220.0], [-290.0, 110.0], [290.0, 110.0]]
[camera.lens]
columns = 9
rows = 6
pictures = ["lens1.png", "lens2.png", "lens3.png"]
[measure]
frame_interval_s = 0.2
frames = 25
observables = ["tracks"]
[measure.tracks]
weight = 2.0
[tune]
friction_particle_particle = {lower = 0.0, upper = 0.6, prior = {mean = 0.3, uncertainty = 0.1}}
time_step = "gate"
objective = "smooth"
[[replicate]]
name = "one"
video = "film1.mp4"
frame_rate_hz = 50.0
corrections = "repairs.csv"
[[replicate]]
video = "film2.mp4"
[[start]]
x_mm = 40.9
z_mm = 22.3
angle_rad = 0.006
[[start]]
x_mm = -40.9
z_mm = 22.3
angle_rad = 0.006
)";

constexpr const char* bin = R"(title = "A weighed bin"
[particle]
count = 200
mass_g = 0.332
plate = {semi_major_mm = 6.9, semi_minor_mm = 5.3, thickness_mm = 2.3}
[material]
elastic_modulus_gpa = 3.5
poisson_ratio = 0.3
friction_particle_particle = 0.5
friction_particle_wall = 0.4
restitution = 0.8
restitution_particle_wall = 0.7
[rig]
kind = "flat_bin_orifice"
bin_width_mm = 150.0
bin_height_mm = 210.0
front_back_gap_mm = 2.6
[tune]
friction_particle_particle = {lower = 0.0, upper = 0.7}
[[replicate]]
name = "one"
discharge = "curve.csv"
event_s = 0.5
orifice_width_mm = 100.0
[[replicate]]
name = "two"
discharge = "curve.csv"
orifice_width_mm = 60.0
held_out = true
)";

constexpr const char* walls = R"(title = "Walls"
[particle]
count = 1
mass_g = 4.2
chain = {count = 3, radius_mm = 5.0, spacing_mm = 6.0}
[material]
elastic_modulus_gpa = 6.89
poisson_ratio = 0.35
friction_particle_particle = 0.36
friction_particle_wall = 0.35
restitution = 0.83
[rig]
kind = "walls"
front_back_gap_mm = 11.0
[[rig.wall]]
name = "floor"
from_x_mm = -100.0
from_z_mm = 0.0
to_x_mm = 100.0
to_z_mm = 1.0
[rig.piston]
face_z_mm = 50.0
left_x_mm = -10.0
right_x_mm = 10.0
velocity_z_mm_per_s = -5.0
[measure]
compare = "particles"
[[replicate]]
name = "two"
tracks = "tracks.csv"
[[replicate]]
name = "one"
tracks = "tracks.csv"
scale_px_per_mm = 3.0
origin_px = [10.0, 20.0]
y_axis = "down"
[[start]]
x_mm = 1.0
z_mm = 6.0
angle_rad = 0.1
)";

constexpr const char* scene = R"(title = "A scene"
[rig]
kind = "scene"
scene = "box.toml"
[measure]
frame_interval_s = 0.02
frames = 5
observables = ["push"]
[measure.push]
column = "force_n"
engine_curve = "wall_force_floor_z_n"
unit = "N"
title = "Force on the floor"
weight = 1.5
[[replicate]]
name = "one"
curves = "curve.csv"
[[replicate]]
name = "two"
curves = "curve.csv"
)";

constexpr const char* box = R"(title = "A box"
dimensions = 3
gravity_m_per_s2 = [0.0, 0.0, -9.81]
[[material]]
name = "grain"
elastic_modulus_mpa = 50.0
poisson_ratio = 0.3
[[material]]
name = "wall"
rigid = true
[[surfaces]]
first = "grain"
second = "grain"
friction = 0.4
restitution = 0.6
static_friction = 0.5
rolling_friction = 0.1
[[surfaces]]
first = "grain"
second = "wall"
friction = 0.3
restitution = 0.5
[law]
tangential_damping = 0.9
[[particle]]
name = "clump"
material = "grain"
count = 20
density_g_per_cm3 = 1.2
spheres = [{x_mm = 0.0, y_mm = 0.0, z_mm = 0.0, radius_mm = 4.0}, {x_mm = 4.0, y_mm = 1.0, z_mm = 0.0, radius_mm = 3.0}]
[[wall]]
name = "floor"
material = "wall"
shape = "plane"
point_mm = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
[[wall]]
name = "lid"
material = "wall"
shape = "disk"
centre_mm = [0.0, 0.0, 300.0]
normal = [0.0, 0.0, -1.0]
radius_mm = 50.0
velocity_mm_per_s = [0.0, 0.0, 10.0]
[fill]
method = "lattice"
low_mm = [-30.0, -30.0, 0.0]
high_mm = [30.0, 30.0, 200.0]
clearance_mm = 1.0
[settle]
longest_s = 0.3
[run]
duration_s = 0.1
output_interval_s = 0.02
fastest_impact_m_per_s = 2.0
)";

// Keys without their unit that decide neither tracks nor simulations: words, bounds and weights of
// a search, and names of files (their content counts).
const std::set<std::string> without_effect = {"title",
                                              "note",
                                              "friction_particle_particle_uncertainty",
                                              "lower",
                                              "upper",
                                              "mean",
                                              "uncertainty",
                                              "weight",
                                              "video",
                                              "pictures",
                                              "unit",
                                              "objective",
                                              "held_out",
                                              "time_step",
                                              "corrections",
                                              "discharge",
                                              "tracks",
                                              "curves",
                                              "scene"};

// What a word may be instead.
const std::map<std::string, std::string> other_words = {
    {"normal", "uniform"},
    {"smooth", "requested"},
    {"gate", "joint"},
    {"lattice", "rain"},
    {"particles", "heap_height"},
    {"down", "up"},
    {"wall_force_floor_z_n", "wall_force_floor_x_n"}};

std::string stem_of(const std::string& key) {
  static const std::set<std::string> units = {
      "m", "cm", "mm", "s", "ms", "kg", "g", "rad", "deg", "pa", "kpa", "mpa", "gpa", "hz", "px"};
  std::string stem = key;
  for (const char* speed : {"_mm_per_s", "_m_per_s2", "_m_per_s", "_g_per_cm3", "_px_per_mm"}) {
    if (stem.ends_with(speed)) return stem.substr(0, stem.size() - std::string(speed).size());
  }
  const auto bar = stem.rfind('_');
  if (bar != std::string::npos && units.contains(stem.substr(bar + 1))) stem.resize(bar);
  return stem;
}

class EveryKey : public testing::Test {
 protected:
  EveryKey() {
    // Those with an x have the same content under another name
    for (const std::string end : {"", "x"}) {
      for (const char* name : {"film1.mp4", "film2.mp4", "lens1.png", "lens2.png", "lens3.png"})
        folder_.write(name + end, name);
      folder_.write("repairs.csv" + end, "frame,action,particle\n");
      folder_.write("curve.csv" + end, "time_s,mass_kg,force_n\n0,0,1\n1,0.01,2\n");
      folder_.write("tracks.csv" + end, "frame,time_s,particle,x,y\n0,0,1,0,0\n1,0.1,1,0,0\n");
      folder_.write("box.toml" + end, box);
    }
  }

  // Of every simulation that a calibration could ask for, and of every film.
  std::vector<std::string> prints_of(const std::filesystem::path& file) {
    const datasets::Experiment experiment = datasets::load_experiment(file);
    std::vector<datasets::Recording> recordings(experiment.replicates.size());
    for (datasets::Recording& recording : recordings) {
      if (experiment.starts.empty()) {
        recording.discharge = datasets::DischargeCurve{.time = {0.0, 1.0}, .mass = {0.0, 0.01}};
        continue;
      }
      recording.tracks =
          datasets::make_trajectories(1, static_cast<int>(experiment.starts.size()), false);
      for (std::size_t i = 0; i < experiment.starts.size(); ++i) {
        const auto& [x, z, angle] = experiment.starts[i];
        recording.tracks->poses[i] = {x, z, angle};
      }
    }
    const Problem problem = plan_problem(experiment, recordings);
    std::vector<std::string> prints;
    for (std::size_t i = 0; i < problem.scenes.size(); ++i)
      prints.push_back(
          fingerprint_of(problem.spec_of(i, datasets::bench_parameters(experiment), 0.1, 1)));
    for (const datasets::Replicate& replicate : experiment.replicates) {
      if (!replicate.video.empty())
        prints.push_back(
            datasets::fingerprint(datasets::make_tracking_spec(experiment, replicate)));
    }
    for (const datasets::Replicate& replicate : experiment.replicates)
      prints.push_back(source_of(replicate));
    prints.push_back(measuring_text(experiment));
    return prints;
  }

  // How files of others are read; they are read anew in every run.
  static std::string source_of(const datasets::Replicate& replicate) {
    const datasets::TrackSource& source = replicate.source;
    const std::array<double, 2> origin = source.origin_px.value_or(std::array{0.0, 0.0});
    return fmt::format("{} {} {} {} {}",
                       source.event_time,
                       source.scale.value_or(0.0),
                       origin[0],
                       origin[1],
                       source.y_is_up.value_or(false));
  }

  std::filesystem::path write(const std::string& name, const toml::table& table) {
    std::ostringstream text;
    text << table;
    return folder_.write(name, text.str());
  }

  // Changes one leaf after the other and looks what it does.
  void walk(toml::node& node, const std::string& key, const std::function<void()>& changed) {
    const auto with = [&](auto& value, auto other) {
      const auto before = value.get();
      value = other(before);
      changed_key_ = stem_of(key);
      changed();
      value = before;
    };
    if (auto* table = node.as_table()) {
      for (auto& [name, child] : *table) walk(child, std::string(name.str()), changed);
    } else if (auto* array = node.as_array()) {
      for (toml::node& child : *array) walk(child, key, changed);
    } else if (auto* number = node.as_floating_point()) {
      with(*number, [](double before) { return 1.001 * before + 1e-6; });
    } else if (auto* whole = node.as_integer()) {
      with(*whole, [](std::int64_t before) { return before + 1; });
    } else if (auto* flag = node.as_boolean()) {
      with(*flag, [](bool before) { return !before; });
    } else if (auto* text = node.as_string()) {
      with(*text, [](const std::string& before) {
        const auto other = other_words.find(before);
        return other == other_words.end() ? before + "x" : other->second;
      });
    }
  }

  // Walks the file of this name; `experiment` is what is loaded.
  void expect_that_every_key_counts(const std::string& name,
                                    const char* text,
                                    const std::string& experiment,
                                    const std::set<std::string>& cannot_change_alone,
                                    const std::set<std::string>& no_effect_here = {}) {
    toml::table table = toml::parse(text);
    write(name, table);
    const std::vector<std::string> before = prints_of(folder_ / experiment);
    std::set<std::string> refused, changing;
    walk(table, "", [&] {
      write(name, table);
      try {
        const bool is_another = prints_of(folder_ / experiment) != before;
        if (is_another) changing.insert(changed_key_);
        if (!is_another)
          EXPECT_TRUE(without_effect.contains(changed_key_) ||
                      no_effect_here.contains(changed_key_))
              << name << ": " << changed_key_ << " changes no fingerprint";
        else
          EXPECT_FALSE(without_effect.contains(changed_key_)) << name << ": " << changed_key_;
      } catch (const datasets::InputError&) {
        refused.insert(changed_key_);
      }
    });
    EXPECT_EQ(refused, cannot_change_alone) << name;
    EXPECT_GE(changing.size(), 3U) << name;
    write(name, toml::parse(text));
    EXPECT_EQ(prints_of(folder_ / experiment), before);
  }

  tests::TemporaryFolder folder_;
  std::string changed_key_;
};

TEST_F(EveryKey, OfAnExperimentWithFilms) {
  expect_that_every_key_counts(
      "films.toml", films, "films.toml", {"count", "kind", "observables"}, {"name"});
}

TEST_F(EveryKey, OfAWeighedBin) {
  // Grains are simulated softer than they are, in one layer whatever the gap; nothing is filmed
  expect_that_every_key_counts(
      "bin.toml", bin, "bin.toml", {"kind"}, {"elastic_modulus", "front_back_gap", "name"});
}

TEST_F(EveryKey, OfWallsAndTracksOfOthers) {
  expect_that_every_key_counts(
      "walls.toml", walls, "walls.toml", {"count", "kind"}, {"front_back_gap", "name"});
}

TEST_F(EveryKey, OfASceneAsARig) {
  expect_that_every_key_counts(
      "scene.toml", scene, "scene.toml", {"kind", "observables"}, {"name"});
}

TEST_F(EveryKey, OfTheSceneThatARigNames) {
  folder_.write("scene.toml", scene);
  // Of a normal the length says nothing
  expect_that_every_key_counts(
      "box.toml",
      box,
      "scene.toml",
      {"dimensions", "first", "material", "method", "name", "rigid", "second", "shape"},
      {"normal"});
}

// What the files of a film hold counts, too.
TEST_F(EveryKey, AndTheContentOfEveryFile) {
  const auto file = folder_.write("films.toml", films);
  std::vector<std::string> before = prints_of(file);
  for (const char* name : {"film1.mp4", "film2.mp4", "lens2.png", "repairs.csv"}) {
    folder_.write(name, std::string(name) + " changed");
    const std::vector<std::string> after = prints_of(file);
    EXPECT_NE(after, before) << name;
    before = after;
  }
}

}  // namespace
}  // namespace graintruth::calibrate
