// graintruth export: the calibrated particle and contact for other engines, or everything as plain
// tables.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <kainjow/mustache.hpp>
#include <numbers>

#include "app/export/exported_run.h"
#include "app/run/assets.h"
#include "app/run/made_folders.h"
#include "app/verbs/commands.h"
#include "calibrate/engines/engine_laws.h"
#include "datasets/imports/track_files.h"
#include "datasets/parameters/parameter.h"
#include "datasets/store/input_error.h"
#include "datasets/store/table.h"
#include "reports/page/run_data.h"
#include "reports/page/words.h"
#include "sim/simulation.h"

namespace graintruth::app {

namespace {

namespace mustache = kainjow::mustache;
using datasets::number_text;
using mustache::data;
using Rebound = std::function<double(double restitution, int contacts)>;

std::string filled(const std::string& name, const data& values) {
  mustache::mustache page{std::string(asset("export/" + name + ".mustache"))};
  page.set_custom_escape([](const std::string& text) { return text; });
  std::string text = page.render(values);
  if (!page.is_valid()) throw std::logic_error(name + ": " + page.error_message());
  return text;
}

void set(data& values, const std::string& name, double value) {
  values.set(name, number_text(value));
}

// Without the minus of a zero, which would only puzzle.
std::string coordinate(double value) { return number_text(value == 0.0 ? 0.0 : value); }

double volume_of(const sim::ElementSphere& sphere) {
  return 4.0 / 3.0 * std::numbers::pi * std::pow(sphere.radius, 3);
}

// Of the spheres, each counted whole.
double volume_of_spheres(const sim::Clump& clump) {
  double volume = 0.0;
  for (const sim::ElementSphere& sphere : clump.spheres) volume += volume_of(sphere);
  return volume;
}

data sphere_list(const sim::Clump& clump, const Drop& drop) {
  data spheres = data::type::list;
  const double density = clump.mass / volume_of_spheres(clump);
  int number = 0;
  for (const sim::ElementSphere& sphere : clump.spheres) {
    data row = data::type::object;
    row.set("number", std::to_string(++number));
    const sim::Vec3 turned = drop.upright * sphere.centre;
    for (int axis = 0; axis < 3; ++axis) {
      const std::string name(1, "xyz"[axis]);
      row.set(name, coordinate(sphere.centre[axis]));
      row.set("upright_" + name, coordinate(turned[axis]));
    }
    set(row, "radius", sphere.radius);
    set(row, "diameter", 2.0 * sphere.radius);
    set(row, "mass", density * volume_of(sphere));
    spheres.push_back(row);
  }
  return spheres;
}

void set_particle(data& values, const ExportedRun& run) {
  const sim::Clump& clump = run.particle;
  values.set("particle", true);
  values.set("has_own_inertia", run.has_own_inertia);
  values.set("is_softened", run.material.youngs_modulus < run.material_modulus);
  values.set("material_modulus", fmt::format("{:.6g}", run.material_modulus));
  set(values, "youngs_modulus", run.material.youngs_modulus);
  values.set("is_clump", clump.spheres.size() > 1);
  values.set("sphere_count", std::to_string(clump.spheres.size()));
  values.set("spheres", sphere_list(clump, drop_of(run)));
  set(values, "mass", clump.mass);
  set(values, "volume", clump.volume);
  set(values, "density", clump.mass / clump.volume);
  set(values, "sphere_density", clump.mass / volume_of_spheres(clump));
  for (int axis = 0; axis < 3; ++axis)
    set(values, std::string("inertia_") + "xyz"[axis], clump.inertia[axis]);
}

void set_contact(data& values, const ExportedRun& run) {
  const sim::Surfaces surfaces{.restitution = run.restitution()};
  const sim::PairMaterial pair = sim::mix(run.material,
                                          run.material,
                                          surfaces,
                                          sim::Tension::clipped,
                                          sim::SimulationOptions{}.tangential_damping);
  set(values, "wall_modulus", 1e6 * run.material.youngs_modulus);
  set(values, "poisson_ratio", run.material.poisson_ratio);
  set(values, "tangential_damping", pair.tangential_damping);
  for (const std::string& name : datasets::plain_parameter_names())
    set(values, name, run.parameter(name));
  set(values, "gravity", run.gravity);
  set(values, "time_step", run.time_step);
}

// What a deck does not set: no file of it asks for the parameter. The elastic modulus is that of
// the material.
void set_unmapped(data& values, const ExportedRun& run, const std::string& text_of_deck) {
  data rows = data::type::list;
  for (const auto& [name, value] : run.parameters) {
    const datasets::Parameter parameter = datasets::parameter_named(name);
    if (parameter.kind->sets_stiffness ||
        text_of_deck.find("{{" + name + "}}") != std::string::npos)
      continue;
    data row = data::type::object;
    row.set("name", name);
    row.set("value", fmt::format("{:.6g}", value));
    row.set("phrase", parameter.phrase());
    rows.push_back(row);
  }
  values.set("unmapped", rows);
}

void set_drop(data& values, const ExportedRun& run) {
  const Drop drop = drop_of(run);
  const double skin = 0.1 * run.particle.smallest_radius;
  const double point = 1e-9 * run.particle.smallest_radius;
  set(values, "speed", drop.speed);
  set(values, "drop_step", drop.time_step);
  set(values, "start_height", drop.start_height);
  set(values, "start_low", drop.start_height - point);
  set(values, "start_high", drop.start_height + point);
  double mean_centre = drop.start_height;
  for (const sim::ElementSphere& sphere : run.particle.spheres)
    mean_centre +=
        (drop.upright * sphere.centre).z() / static_cast<double>(run.particle.spheres.size());
  set(values, "mean_centre_low", mean_centre - point);
  set(values, "mean_centre_high", mean_centre + point);
  set(values, "point", point);
  set(values, "minus_point", -point);
  values.set("steps", std::to_string(drop.steps));
  // A wall of YADE is 2.8 times softer: contacts last 2.8^0.4 times as long
  values.set("yade_steps", std::to_string(2 * drop.steps));
  set(values, "skin", skin);
  set(values, "room", 10.0 * run.particle.bounding_radius);
  // Two spheres of a body, or of two that touch, are never further apart
  set(values, "cutoff", 4.0 * run.particle.bounding_radius + skin);
}

void set_rebound(data& values, const ExportedRun& run, const Rebound& rebound) {
  const auto four_digits = [](double value) { return fmt::format("{:.4f}", value); };
  const double asked = run.restitution();
  values.set("rebound", four_digits(rebound(asked, 1)));
  values.set("rebound_of_two", four_digits(rebound(asked, 2)));
  const auto better = calibrate::restitution_to_ask([&](double e) { return rebound(e, 1); }, asked);
  values.set("restitution_to_ask", better ? data(four_digits(*better)) : data(false));
  const auto between = calibrate::restitution_to_ask([&](double e) { return rebound(e, 1); },
                                                     run.parameter("restitution"));
  values.set("restitution_to_ask_of_particles",
             between ? data(four_digits(*between)) : data(false));
  values.set("rebound_of_two_to_ask", better ? four_digits(rebound(*better, 2)) : "");
}

// An end of an interval; where it was not found the number is only the bound of the search.
std::string end_text(double value, const std::string& kind) {
  if (kind == "open") return "open";
  return kind == "budget_ended" ? "not found" : fmt::format("{:.4g}", value);
}

// The head of README.md, which all targets share.
void set_run(data& values, const reports::RunData& run) {
  std::string title = reports::text(run.result, {"title"});
  if (title.empty()) title = reports::text(run.run, {"configuration", "title"});
  if (title.empty()) title = "A run without a title";
  values.set("title", title);
  const std::string note = reports::text(run.result, {"note"});
  values.set("note", note.empty() ? data(false) : data(note));
  values.set("run", run.folder.root.filename().string());
  data rows = data::type::list;
  for (const auto& [name, parameter] : reports::at(run.result, {"parameters"}).items()) {
    const double lower = reports::number(parameter, {"lower"});
    const double upper = reports::number(parameter, {"upper"});
    data row = data::type::object;
    row.set("name", name);
    row.set("value", fmt::format("{:.6g}", reports::number(parameter, {"value"})));
    row.set("interval",
            std::isfinite(lower) && std::isfinite(upper)
                ? fmt::format("{} to {}",
                              end_text(lower, reports::text(parameter, {"lower_end"})),
                              end_text(upper, reports::text(parameter, {"upper_end"})))
                : std::string("none"));
    row.set("status", reports::text(parameter, {"status"}));
    rows.push_back(row);
  }
  values.set("has_parameters", !rows.list_value().empty());
  values.set("parameters", rows);
}

using Files = std::vector<std::pair<std::filesystem::path, std::string>>;  // name, content

std::string readme(data values, const std::string& target, const std::string& engine) {
  // Six digits are enough for a reader
  for (const char* name :
       {"mass", "volume", "inertia_x", "inertia_y", "inertia_z", "time_step", "youngs_modulus"}) {
    if (const data* exact = values.get(name); exact != nullptr)
      values.set(name, fmt::format("{:.6g}", std::stod(exact->string_value())));
  }
  values.set("target", target);
  values.set("engine", engine);
  const std::string notes = filled(target + "/notes.md", values);
  values.set("notes", mustache::partial([notes]() -> std::string { return notes; }));
  return filled("README.md", values);
}

Files engine_files(const std::string& target, const datasets::RunFolder& folder) {
  const ExportedRun run = read_exported_run(folder);
  data values = data::type::object;
  set_run(values, reports::read_run_data(folder));
  set_particle(values, run);
  set_contact(values, run);
  set_drop(values, run);
  const double sphere = volume_of(run.particle.spheres[drop_of(run).sphere]);
  const double share = sphere / volume_of_spheres(run.particle);
  values.set("sphere_share", fmt::format("{:.3g}", share));

  std::string engine;
  std::vector<std::string> names;
  if (target == "liggghts") {
    constexpr double least = 0.05;  // LIGGGHTS stops with an error there
    const double lowest = std::min(run.parameter("restitution"), run.restitution());
    if (lowest <= least) {
      throw datasets::InputError(fmt::format(
          "{}: the restitution is {}, but LIGGGHTS takes none of {} or less; export to lammps or "
          "yade, or raise it in result.json.",
          folder.result().string(),
          number_text(lowest),
          least));
    }
    engine = "LIGGGHTS";
    names = {"particle.in", "contact.in", "drop.in"};
    set_rebound(values, run, calibrate::liggghts_rebound);
  } else if (target == "lammps") {
    engine = "LAMMPS";
    names = {"particle.mol", "contact.in", "drop.in"};
    set_rebound(values, run, calibrate::lammps_rebound);
  } else {
    engine = "YADE";
    names = {"particle.py", "drop.py"};
    set_rebound(values, run, [share](double restitution, int contacts) {
      return calibrate::yade_rebound(restitution, contacts, share);
    });
  }
  std::string templates;
  for (const std::string& name : names)
    templates += asset(fmt::format("export/{}/{}.mustache", target, name));
  set_unmapped(values, run, templates);
  Files files = {{"README.md", readme(values, target, engine)}};
  for (const std::string& name : names)
    files.emplace_back(name, filled(fmt::format("{}/{}", target, name), values));
  return files;
}

std::string sphere_table(const sim::Clump& clump) {
  datasets::Table table({"x_m", "y_m", "z_m", "radius_m"});
  for (const sim::ElementSphere& sphere : clump.spheres) {
    table.add({coordinate(sphere.centre.x()),
               coordinate(sphere.centre.y()),
               coordinate(sphere.centre.z()),
               number_text(sphere.radius)});
  }
  return to_csv(table);
}

std::string particle_table(const ExportedRun& run) {
  datasets::Table table({"quantity", "value", "unit"});
  const auto row = [&](const char* name, double value, const char* unit) {
    table.add({name, number_text(value), unit});
  };
  row("mass", run.particle.mass, "kg");
  row("volume_of_union", run.particle.volume, "m3");
  row("inertia_x", run.particle.inertia.x(), "kg m2");
  row("inertia_y", run.particle.inertia.y(), "kg m2");
  row("inertia_z", run.particle.inertia.z(), "kg m2");
  row("youngs_modulus", run.material.youngs_modulus, "Pa");
  row("poisson_ratio", run.material.poisson_ratio, "-");
  row("gravity", run.gravity, "m/s2");
  row("time_step", run.time_step, "s");
  return to_csv(table);
}

std::string parameter_table(const reports::RunData& run) {
  datasets::Table table(
      {"name", "value", "lower", "upper", "unit", "status", "bench_value", "interval_status"});
  for (const auto& [name, parameter] : reports::at(run.result, {"parameters"}).items()) {
    table.add({name,
               number_text(reports::number(parameter, {"value"})),
               number_text(reports::number(parameter, {"lower"})),
               number_text(reports::number(parameter, {"upper"})),
               reports::text(parameter, {"unit"}),
               reports::text(parameter, {"status"}),
               number_text(reports::number(parameter, {"bench_value"})),
               reports::text(parameter, {"interval_status"})});
  }
  return to_csv(table);
}

// With the column names that trackpy and its friends look for.
std::string track_table(const std::filesystem::path& file) {
  const datasets::Trajectories tracks = datasets::read_tracks(file);
  datasets::Table table({"frame", "particle", "x", "y", "angle_rad", "time_s"});
  for (std::size_t frame = 0; frame < tracks.frames(); ++frame) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(tracks.particles); ++i) {
      const datasets::Pose& pose = tracks.poses[tracks.index(frame, i)];
      if (!std::isfinite(pose.x) || !std::isfinite(pose.z)) continue;
      table.add({std::to_string(frame),
                 std::to_string(i + 1),
                 number_text(pose.x),
                 number_text(pose.z),
                 number_text(pose.angle),
                 number_text(tracks.time[frame])});
    }
  }
  return to_csv(table);
}

// tracks/*.csv, without the tables of stagnant zones beside them, in the order of their names.
std::vector<std::filesystem::path> track_files(const datasets::RunFolder& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code absent;
  for (const auto& entry : std::filesystem::directory_iterator(folder.root / "tracks", absent)) {
    const std::filesystem::path name = entry.path().filename();
    if (name.extension() == ".csv" && name.stem().extension() != ".stagnant")
      files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

Files plain_tables(const datasets::RunFolder& folder) {
  const reports::RunData run = reports::read_run_data(folder);
  data values = data::type::object;
  set_run(values, run);
  Files files;
  const bool has_particle =
      !reports::list(run.run, {"configuration", "particle", "spheres"}).empty();
  if (run.result.is_object() && has_particle) {
    const ExportedRun exported = read_exported_run(folder);
    set_particle(values, exported);
    files.emplace_back("particle_spheres.csv", sphere_table(exported.particle));
    files.emplace_back("particle.csv", particle_table(exported));
  }
  if (!reports::at(run.result, {"parameters"}).empty())
    files.emplace_back("parameters.csv", parameter_table(run));
  const std::vector<std::filesystem::path> tracks = track_files(folder);
  for (const std::filesystem::path& file : tracks)
    files.emplace_back("tracks" / file.filename(), track_table(file));
  if (files.empty()) {
    throw datasets::InputError(
        fmt::format("{}: holds neither calibrated parameters nor tracks, so there is nothing to "
                    "export.",
                    folder.root.string()));
  }
  values.set("has_tracks", !tracks.empty());
  if (!tracks.empty()) values.set("first_track", tracks.front().filename().string());
  files.emplace_back("README.md", readme(values, "csv", "plain tables"));
  return files;
}

}  // namespace

int run_export(const ExportCommand& command) {
  const datasets::RunFolder folder{command.run_folder};
  const Files files = command.to == "csv" ? plain_tables(folder) : engine_files(command.to, folder);
  const std::filesystem::path out =
      command.out.empty() ? folder.root / "export" / command.to : command.out;
  const MadeFolders made(out);
  for (const auto& [name, content] : files) {
    const std::filesystem::path file = out / name;
    datasets::make_folder(file.parent_path());
    datasets::write_whole(file, content);
  }
  fmt::print("{}\n", (out / "README.md").string());
  return 0;
}

}  // namespace graintruth::app
