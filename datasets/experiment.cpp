#include "datasets/experiment.h"

#include <fmt/format.h>

#include <cmath>
#include <set>
#include <stdexcept>

#include "datasets/experiment/pictures.h"
#include "datasets/input_error.h"
#include "datasets/toml_section.h"
#include "datasets/tuned_parameters.h"

namespace graintruth::datasets {

namespace {

constexpr Range poisson_range{-1.0, 0.4999, false, "a Poisson ratio above -1 and below 0.5"};

BenchValue read_bench_value(TomlSection& section, const std::string& name) {
  return {section.quantity(name, plain, range_of(name)),
          section.optional_quantity(name + "_uncertainty", plain, not_negative).value_or(0.0)};
}

Particle read_particle(TomlSection section, Purpose purpose) {
  const bool only_tracked = purpose == Purpose::tracking;
  Particle particle;
  const auto count = section.optional_whole_number("count", 1, 100000);
  particle.mass = section.optional_quantity("mass", mass_units, positive).value_or(0.0);
  if (section.has("body")) particle.body = read_named_body(section);
  // Bodies of their own kind may come and go
  if (!count && !(only_tracked && particle.body)) section.whole_number("count", 1, 100000);
  if (particle.mass == 0.0 && !only_tracked) section.quantity("mass", mass_units, positive);
  particle.count = count.value_or(0);
  for (TomlSection& sphere : section.sections("spheres")) {
    particle.spheres.push_back({sphere.quantity("offset", length_units),
                                sphere.quantity("radius", length_units, positive)});
    sphere.finish();
  }
  if (auto plate = section.optional_section("plate")) {
    particle.plate = EllipticalPlate{plate->quantity("semi_major", length_units, positive),
                                     plate->quantity("semi_minor", length_units, positive),
                                     plate->quantity("thickness", length_units, positive)};
    if (particle.plate->semi_minor > particle.plate->semi_major) {
      plate->fail(plate->has("semi_minor_mm") ? "semi_minor_mm" : "semi_minor_m",
                  "must not exceed semi_major (both are half axes)");
    }
    plate->finish();
  }
  if (particle.plate && particle.body)
    section.fail("body", "is given beside 'plate'; keep one of them");
  if (particle.spheres.empty() && !particle.plate && !(only_tracked && particle.body)) {
    section.fail("spheres",
                 "is missing; write spheres = [{offset_mm = ..., radius_mm = ...}, ...]");
  }
  section.finish();
  return particle;
}

Material read_material(TomlSection section) {
  Material material;
  material.elastic_modulus = section.quantity("elastic_modulus", pressure_units, positive);
  material.poisson_ratio = section.quantity("poisson_ratio", plain, poisson_range);
  material.friction_particle_particle = read_bench_value(section, "friction_particle_particle");
  material.friction_particle_wall = read_bench_value(section, "friction_particle_wall");
  material.restitution = read_bench_value(section, "restitution");
  section.finish();
  return material;
}

// A flat V hopper above a column in which a piston sinks; the throat is at z = 0, x = +-width/2.
void read_hopper_column_piston(TomlSection& section, Rig& rig) {
  const double half = 0.5 * section.quantity("column_width", length_units, positive);
  const double depth = section.quantity("column_depth", length_units, positive);
  const double slope = section.quantity("slope_angle", angle_units, positive);
  const double height = section.quantity("slope_height", length_units, positive);
  const double speed = section.quantity("piston_speed", speed_units, positive);
  const double face = section.optional_quantity("piston_start_z", length_units).value_or(0.0);
  if (slope >= 90.0 * radians_per_degree) {
    section.fail(section.has("slope_angle_deg") ? "slope_angle_deg" : "slope_angle_rad",
                 "must be below 90 degrees (measured from the horizontal)");
  }
  const double run = height / std::tan(slope);
  rig.walls = {{"column_left", -half, -depth, -half, 0.0},
               {"column_right", half, -depth, half, 0.0},
               {"slope_left", -half, 0.0, -half - run, height},
               {"slope_right", half, 0.0, half + run, height}};
  rig.piston = Piston{.face_z = face, .left_x = -half, .right_x = half, .velocity_z = -speed};
}

// Side walls, and the floor left and right of the orifice.
std::vector<Wall> walls_of(const FlatBin& bin) {
  const double side = 0.5 * bin.width, edge = 0.5 * bin.orifice_width;
  std::vector<Wall> walls = {{"side_left", -side, 0.0, -side, bin.height},
                             {"side_right", side, 0.0, side, bin.height}};
  if (edge < side) {
    walls.push_back({"floor_left", -side, 0.0, -edge, 0.0});
    walls.push_back({"floor_right", edge, 0.0, side, 0.0});
  }
  return walls;
}

double read_orifice(TomlSection& section, const std::optional<FlatBin>& bin) {
  const double width = section.quantity("orifice_width", length_units, positive);
  if (bin && width > bin->width) {
    section.fail(
        section.has("orifice_width_mm") ? "orifice_width_mm" : "orifice_width_m",
        fmt::format(
            "is {:.4g} mm, wider than the bin of {:.4g} mm", 1e3 * width, 1e3 * bin->width));
  }
  return width;
}

bool gives_orifice(TomlSection& section) {
  return section.has("orifice_width_m") || section.has("orifice_width_cm") ||
         section.has("orifice_width_mm");
}

void read_flat_bin_orifice(TomlSection& section, Rig& rig) {
  FlatBin bin;
  bin.width = section.quantity("bin_width", length_units, positive);
  bin.height = section.quantity("bin_height", length_units, positive);
  rig.bin = bin;
  if (gives_orifice(section)) rig.bin->orifice_width = read_orifice(section, rig.bin);
  rig.walls = walls_of(*rig.bin);
}

void read_walls(TomlSection& section, Rig& rig) {
  for (TomlSection& wall : section.sections("wall")) {
    rig.walls.push_back({wall.optional_text("name").value_or(""),
                         wall.quantity("from_x", length_units),
                         wall.quantity("from_z", length_units),
                         wall.quantity("to_x", length_units),
                         wall.quantity("to_z", length_units)});
    const Wall& made = rig.walls.back();
    if (made.from_x == made.to_x && made.from_z == made.to_z) {
      wall.fail("to_x_m", "makes a wall of no length: from and to are the same point");
    }
    wall.finish();
  }
  if (auto piston = section.optional_section("piston")) {
    rig.piston = Piston{.face_z = piston->quantity("face_z", length_units),
                        .left_x = piston->quantity("left_x", length_units),
                        .right_x = piston->quantity("right_x", length_units),
                        .velocity_z = piston->quantity("velocity_z", speed_units)};
    if (!(rig.piston->left_x < rig.piston->right_x)) {
      piston->fail("right_x_m", "must lie to the right of left_x");
    }
    piston->finish();
  }
  if (rig.walls.empty()) section.fail("wall", "is missing; at least one [[rig.wall]] is needed");
}

Rig read_rig(TomlSection section) {
  Rig rig;
  rig.front_back_gap = section.quantity("front_back_gap", length_units, positive);
  rig.gravity = section.optional_quantity("gravity", acceleration_units, positive).value_or(9.81);
  const std::string kind = section.text("kind");
  if (kind == "hopper_column_piston") {
    read_hopper_column_piston(section, rig);
  } else if (kind == "flat_bin_orifice") {
    read_flat_bin_orifice(section, rig);
  } else if (kind == "walls") {
    read_walls(section, rig);
  } else {
    section.fail("kind",
                 fmt::format("is '{}', but must be 'hopper_column_piston', 'flat_bin_orifice' or "
                             "'walls'",
                             kind));
  }
  section.finish();
  return rig;
}

std::vector<StartPlace> read_starts(TomlSection& root, int count) {
  std::vector<StartPlace> starts;
  for (TomlSection& start : root.sections("start")) {
    starts.push_back({start.quantity("x", length_units),
                      start.quantity("z", length_units),
                      start.optional_quantity("angle", angle_units).value_or(0.0)});
    start.finish();
  }
  if (!starts.empty() && static_cast<int>(starts.size()) != count) {
    root.fail("start",
              fmt::format("gives {} starting places for {} particles", starts.size(), count));
  }
  return starts;
}

// The one file that a replicate names, and under which key.
const char* read_file(TomlSection& section,
                      const std::filesystem::path& folder,
                      const std::optional<FlatBin>& bin,
                      Replicate& replicate) {
  const auto video = section.optional_text("video");
  const auto tracks = section.optional_text("tracks");
  const auto discharge = section.optional_text("discharge");
  if (video.has_value() + tracks.has_value() + discharge.has_value() != 1)
    section.fail("video", "is needed, or 'tracks', or 'discharge': exactly one of the three");
  if (discharge && !bin) section.fail("discharge", "needs a rig of kind 'flat_bin_orifice'");
  const char* key = video ? "video" : tracks ? "tracks" : "discharge";
  const std::filesystem::path path = folder / (video ? *video : tracks ? *tracks : *discharge);
  if (!(video ? is_film(path) : std::filesystem::is_regular_file(path)))
    section.fail(key, fmt::format("names '{}', but there is no such file", path.string()));
  (video ? replicate.video : tracks ? replicate.tracks : replicate.discharge) = path;
  return key;
}

// What only concerns files of others: their clock, their pixels, their axes.
void read_source(TomlSection& section, Replicate& replicate) {
  TrackSource& source = replicate.source;
  const auto only_for = [&](bool fits, std::string_view key, std::string_view files) {
    if (!fits) section.fail(key, fmt::format("is only known of {}", files));
  };
  source.frame_rate = replicate.frame_rate;
  if (const auto event = section.optional_quantity("event", time_units)) {
    only_for(replicate.video.empty(),
             section.has("event_s") ? "event_s" : "event_ms",
             "tracks and discharge curves; on films the event is found");
    source.event_time = *event;
  }
  source.scale = section.optional_quantity("scale", scale_units, positive);
  const bool tracks = !replicate.tracks.empty();
  if (source.scale) only_for(tracks, "scale_px_per_mm", "tracks");
  const auto pair = [&](const std::optional<std::vector<double>>& numbers)
      -> std::optional<std::array<double, 2>> {
    if (!numbers) return std::nullopt;
    only_for(tracks, "origin_px", "tracks");
    return std::array{(*numbers)[0], (*numbers)[1]};
  };
  source.origin_px = pair(section.optional_numbers("origin", 2, pixel_units));
  source.origin = pair(section.optional_numbers("origin", 2, length_units));
  if (source.origin_px && source.origin) section.fail("origin_px", "gives 'origin' a second time");
  if (const auto direction = section.optional_text("y_axis")) {
    only_for(tracks, "y_axis", "tracks");
    if (*direction != "down" && *direction != "up")
      section.fail("y_axis", "must be \"down\" (as in pictures) or \"up\"");
    source.y_is_up = *direction == "up";
  }
}

// Of pictures that a pattern names that of their folder.
std::string usual_name(const std::filesystem::path& file) {
  const bool is_pattern = file.filename().string().find('*') != std::string::npos;
  const bool is_folder = !file.has_filename();  // its path ends with a slash
  return (is_pattern || is_folder ? file.parent_path().filename() : file.stem()).string();
}

std::vector<Replicate> read_replicates(TomlSection& root,
                                       const std::filesystem::path& folder,
                                       const std::optional<FlatBin>& bin,
                                       Purpose purpose) {
  std::vector<Replicate> replicates;
  std::set<std::string> names;
  for (TomlSection& section : root.sections("replicate")) {
    Replicate replicate;
    const char* key = read_file(section, folder, bin, replicate);
    replicate.name = section.optional_text("name").value_or(usual_name(replicate.file()));
    if (replicate.name.empty() || replicate.name.find('/') != std::string::npos) {
      section.fail("name", "must be a plain file name");
    }
    if (!names.insert(replicate.name).second) {
      section.fail(section.has("name") ? "name" : key,
                   fmt::format("makes a second replicate called '{}'", replicate.name));
    }
    replicate.frame_rate = section.optional_quantity("frame_rate", rate_units, positive);
    read_source(section, replicate);
    if (gives_orifice(section)) {
      if (!bin) section.fail("orifice_width_mm", "needs a rig of kind 'flat_bin_orifice'");
      replicate.orifice_width = read_orifice(section, bin);
    } else if (bin && bin->orifice_width == 0.0) {
      section.fail("orifice_width_mm", "is missing; give it here or once in [rig]");
    }
    replicate.held_out = section.optional_flag("held_out");
    if (replicate.held_out && !bin)
      section.fail("held_out", "needs a rig of kind 'flat_bin_orifice'");
    if (const auto corrections = section.optional_text("corrections")) {
      replicate.corrections = folder / *corrections;
      if (!std::filesystem::is_regular_file(replicate.corrections)) {
        section.fail(
            "corrections",
            fmt::format("names '{}', but there is no such file", replicate.corrections.string()));
      }
    }
    section.finish();
    replicates.push_back(std::move(replicate));
  }
  if (replicates.empty() && purpose == Purpose::tracking)
    root.fail("replicate", "is missing; write [[replicate]] and video = \"...\" for each film");
  if (replicates.size() < 2 && purpose == Purpose::calibration) {
    root.fail(
        "replicate",
        fmt::format("is given {} time(s), but at least 2 replicates are needed: the spread between "
                    "them is what the model is compared with",
                    replicates.size()));
  }
  return replicates;
}

Measurement read_measurement(TomlSection section) {
  Measurement measurement;
  measurement.frame_interval = section.quantity("frame_interval", time_units, positive);
  measurement.frames = section.whole_number("frames", 2, 100000);
  const std::string compared = section.optional_text("compare").value_or("particles");
  if (compared == "heap_height") {
    measurement.compared = Compared::heap_height;
  } else if (compared != "particles") {
    section.fail("compare", "must be \"particles\" or \"heap_height\"");
  }
  section.finish();
  return measurement;
}

}  // namespace

std::string_view name_of(ObjectiveForm form) {
  return form == ObjectiveForm::smooth ? "smooth" : "requested";
}

const BenchValue& bench_value(const Material& material, std::string_view parameter) {
  if (parameter == parameter_names[0]) return material.friction_particle_particle;
  if (parameter == parameter_names[1]) return material.friction_particle_wall;
  if (parameter == parameter_names[2]) return material.restitution;
  throw std::logic_error("no such parameter: " + std::string(parameter));
}

std::string experiment_name(const std::filesystem::path& file) {
  return file.stem() == "experiment" && file.has_parent_path()
             ? std::filesystem::absolute(file).parent_path().filename().string()
             : file.stem().string();
}

Experiment load_experiment(const std::filesystem::path& file, Purpose purpose) {
  const toml::table parsed = parse_toml(file);
  TomlSection root(parsed, file, "");
  if (root.has("experiment") && !root.has("particle")) {
    root.fail("experiment",
              "lists experiments that are calibrated together, which only 'calibrate' and 'check' "
              "take; give the file of one of them");
  }
  Experiment experiment;
  experiment.file = file;
  experiment.name = experiment_name(file);
  // What a calibration cannot do without; of a film that is only tracked, what is there
  const bool only_tracked = purpose == Purpose::tracking;
  const auto is_read = [&](const char* key) { return !only_tracked || root.has(key); };
  experiment.title = is_read("title") ? root.text("title") : experiment.name;
  experiment.note = root.optional_text("note").value_or("");
  experiment.particle = read_particle(root.section("particle"), purpose);
  if (is_read("material")) experiment.material = read_material(root.section("material"));
  if (is_read("rig")) experiment.rig = read_rig(root.section("rig"));
  experiment.starts = read_starts(root, experiment.particle.count);
  experiment.replicates = read_replicates(root, file.parent_path(), experiment.rig.bin, purpose);
  bool films = false;
  for (const Replicate& replicate : experiment.replicates) films |= !replicate.video.empty();
  // A camera is only needed by those who filmed.
  if (films || root.has("camera"))
    experiment.camera = read_camera(root.section("camera"), file.parent_path(), films);
  for (Replicate& replicate : experiment.replicates)
    replicate.source.usual_frame_rate = experiment.camera.frame_rate;
  if (auto section = root.optional_section("measure"))
    experiment.measurement = read_measurement(*section);
  if (auto section = root.optional_section("tune")) read_tuned(*section, experiment);
  root.finish();
  return experiment;
}

Experiment as_filmed(const Experiment& experiment, const Replicate& replicate) {
  Experiment filmed = experiment;
  filmed.camera.frame_rate = replicate.frame_rate.value_or(experiment.camera.frame_rate);
  if (filmed.rig.bin && replicate.orifice_width) {
    filmed.rig.bin->orifice_width = *replicate.orifice_width;
    filmed.rig.walls = walls_of(*filmed.rig.bin);
  }
  return filmed;
}

std::map<std::string, double> read_parameter_table(const std::filesystem::path& file) {
  const toml::table parsed = parse_toml(file);
  TomlSection root(parsed, file, "");
  std::map<std::string, double> values;
  for (const char* name : parameter_names) {
    if (const auto value = root.optional_quantity(name, plain, range_of(name)))
      values[name] = *value;
  }
  root.finish();
  return values;
}

}  // namespace graintruth::datasets
