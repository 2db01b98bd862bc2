// Beds and heaps of chapter 5: how they are made, run, and measured.
#include "app/thesis/shape_beds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_01.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>

#include "app/run/data_folder.h"
#include "app/run/interrupt.h"
#include "app/scenes/hopper_measures.h"
#include "app/thesis/row.h"
#include "app/thesis/shape_pictures.h"
#include "calibrate/engines/scene_run.h"
#include "sim/shapes/profile.h"

namespace graintruth::app {

namespace {

using Json = Studies::Json;

const std::string parameters = "table_5_1_parameters";
const std::string scalars = "ch5_scalars";

// What the thesis's mesh of squares sees of a grain.
struct Grain {
  int aspect_ratio = 1;
  double length = 0.0;  // m
  double area = 0.0;    // m2, in the picture plane
};

Grain grain_of(const ThesisData& thesis, int aspect_ratio) {
  const double radius = thesis.si(parameters, "radius_equivalent_sphere");
  const double volume = 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
  const double element = sim::chain_of_volume(aspect_ratio, aspect_ratio, volume).front().radius;
  return {aspect_ratio,
          2.0 * aspect_ratio * element,
          aspect_ratio * std::numbers::pi * element * element};
}

// Grains of random orientation on a loose lattice from below, each off its site by a little at
// random: spheres let down from a lattice as it stands would stay in columns.
std::vector<datasets::ScenePlace> loose_lattice(const ThesisData& thesis,
                                                const Grain& grain,
                                                std::uint64_t seed) {
  boost::random::mt19937_64 generator(seed);
  boost::random::uniform_01<double> uniform;
  const double width = thesis.si(parameters, "hopper_width");
  const double off_site = thesis.setting("shape", "off_site");
  const int columns = static_cast<int>(width / (grain.length + 2.0 * off_site));
  const double pitch = width / columns;
  const auto drawn = [&] { return off_site * (2.0 * uniform(generator) - 1.0); };
  std::vector<datasets::ScenePlace> places(
      static_cast<std::size_t>(thesis.number(parameters, "particles")));
  for (std::size_t i = 0; i < places.size(); ++i) {
    const int row = static_cast<int>(i) / columns, column = static_cast<int>(i) % columns;
    places[i].position.x() = (column + 0.5) * pitch - 0.5 * width + drawn();
    places[i].position.z() = (row + 0.5) * pitch + drawn();
    places[i].angle = std::numbers::pi * uniform(generator);
  }
  return places;
}

// The hopper for grains of this aspect ratio; walls as high as the loose lattice is.
datasets::SceneFile hopper_for(const ThesisData& thesis, const Grain& grain, std::uint64_t seed) {
  datasets::SceneFile file = datasets::load_scene(scene_of_hopper());
  file.particles.front().count = 0;
  file.particles.front().chain =
      datasets::SceneChain{grain.aspect_ratio,
                           static_cast<double>(grain.aspect_ratio),
                           thesis.si(parameters, "radius_equivalent_sphere")};
  file.places = loose_lattice(thesis, grain, seed);
  const double height = file.places.back().position.z() + 2.0 * grain.length;
  const double width = thesis.si(parameters, "hopper_width");
  const double orifice = width * thesis.si(parameters, "orifice_over_hopper_width");
  const std::map<std::string, std::array<double, 3>> ends = {
      {"left", {-0.5 * width, -0.5 * width, height}},
      {"right", {0.5 * width, 0.5 * width, height}},
      {"floor_left", {-0.5 * width, -0.5 * orifice, 0.0}},
      {"orifice_panel", {-0.5 * orifice, 0.5 * orifice, 0.0}},
      {"floor_right", {0.5 * orifice, 0.5 * width, 0.0}}};
  for (datasets::SceneWall& wall : file.walls) {
    const auto& [from, to, top] = ends.at(wall.name);
    wall.points[0] = {from, 0.0, 0.0};
    wall.points[1] = {to, 0.0, top};
  }
  return file;
}

// Skewness m3/m2^1.5 and kurtosis m4/m2^2 (3 for a normal distribution).
struct DistributionShape {
  double mean = no_number, skewness = no_number, kurtosis = no_number;
};

DistributionShape shape_of(const std::vector<double>& values) {
  const double count = static_cast<double>(values.size());
  DistributionShape shape;
  shape.mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
  double second = 0.0, third = 0.0, fourth = 0.0;
  for (const double value : values) {
    const double off = value - shape.mean;
    second += off * off / count;
    third += off * off * off / count;
    fourth += off * off * off * off / count;
  }
  shape.skewness = third / std::pow(second, 1.5);
  shape.kurtosis = fourth / (second * second);
  return shape;
}

// Of the lower nine tenths of the bed, which the ragged surface does not touch.
double bulk_fraction(const std::vector<sim::Vec3>& centres, double width, const Grain& grain) {
  const double height = 0.9 * top_of(centres);
  const auto below = std::count_if(
      centres.begin(), centres.end(), [&](const sim::Vec3& c) { return c.z() < height; });
  return static_cast<double>(below) * grain.area / (width * height);
}

// Force on the walls whose names begin so, N.
sim::Vec3 force_on(const datasets::SceneFile& file,
                   const calibrate::SceneFrame& frame,
                   const char* name) {
  sim::Vec3 sum = sim::Vec3::Zero();
  for (std::size_t w = 0; w < file.walls.size(); ++w)
    if (file.walls[w].name.starts_with(name)) sum += frame.wall_force[w];
  return sum;
}

// Share of all grains that have left against time, %.
struct DischargeLine {
  double delay = no_number;      // s, until it has begun
  double rate = no_number;       // % a second, of the straight part
  double roughness = no_number;  // %, rms distance from the straight line
};

DischargeLine straight_part(const std::vector<double>& time,
                            const std::vector<double>& percent,
                            const ThesisData& thesis) {
  const auto in_percent = [&](const char* name) { return 100.0 * thesis.setting("shape", name); };
  DischargeLine line;
  std::vector<double> t, p;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (std::isnan(line.delay) && percent[i] >= in_percent("delay_share")) line.delay = time[i];
    if (percent[i] < in_percent("steady_from") || percent[i] > in_percent("steady_to")) continue;
    t.push_back(time[i]);
    p.push_back(percent[i]);
  }
  if (t.size() < 5 || percent.back() < in_percent("steady_to")) return line;
  const double count = static_cast<double>(t.size());
  const double mean_t = std::accumulate(t.begin(), t.end(), 0.0) / count;
  const double mean_p = std::accumulate(p.begin(), p.end(), 0.0) / count;
  double across = 0.0, along = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    across += (t[i] - mean_t) * (p[i] - mean_p);
    along += (t[i] - mean_t) * (t[i] - mean_t);
  }
  line.rate = across / along;
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double off = p[i] - mean_p - line.rate * (t[i] - mean_t);
    squares += off * off;
  }
  line.roughness = std::sqrt(squares / count);
  return line;
}

// How the grains inside the hopper move in a frame, or in several together.
struct InnerMotion {
  std::array<double, 3> rotational = {}, translational = {};  // J; left, centre, right (5.3, 5.4)
  std::array<double, 3> sideways = {}, downwards = {};  // m/s; lower, middle, upper third at rest

  void add(const InnerMotion& other) {
    for (std::size_t third = 0; third < rotational.size(); ++third) {
      rotational[third] += other.rotational[third];
      translational[third] += other.translational[third];
      sideways[third] += other.sideways[third];
      downwards[third] += other.downwards[third];
    }
  }
};

InnerMotion motion_in(const calibrate::SceneRun& run,
                      const sim::State& state,
                      double width,
                      double height) {
  InnerMotion motion;
  const auto third = [](double share) { return std::clamp(static_cast<int>(3.0 * share), 0, 2); };
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    const sim::Vec3 &place = state.position[i], &velocity = state.velocity[i];
    if (place.z() < 0.0) continue;
    const sim::Clump& clump = run.scene.types[run.scene.bodies[i].type];
    const int across = third(place.x() / width + 0.5), up = third(place.z() / height);
    const double spin = state.angular_velocity[i].y();
    motion.rotational[across] += 0.5 * clump.inertia.y() * spin * spin;
    motion.translational[across] += 0.5 * clump.mass * velocity.squaredNorm();
    motion.sideways[up] += std::abs(velocity.x());
    motion.downwards[up] += std::abs(velocity.z());
  }
  return motion;
}

double sum_of(const std::array<double, 3>& parts) { return parts[0] + parts[1] + parts[2]; }

// Centres of the grains that have not left.
std::vector<sim::Vec3> inside_of(const sim::State& state) {
  std::vector<sim::Vec3> inside;
  for (const sim::Vec3& place : state.position)
    if (place.z() >= 0.0) inside.push_back(place);
  return inside;
}

// Element spheres that reach down to the floor.
int floor_contacts(const calibrate::SceneRun& run, const sim::State& state) {
  int contacts = 0;
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    for (const sim::ElementSphere& sphere : run.scene.types[run.scene.bodies[i].type].spheres) {
      const double z = (state.position[i] + state.orientation[i] * sphere.centre).z();
      if (z - sphere.radius < 0.0) ++contacts;
    }
  }
  return contacts;
}

}  // namespace

std::filesystem::path scene_of_hopper() { return data_folder() / "scenes" / "shape_study.toml"; }

Json run_bed(const ThesisData& thesis,
             int aspect_ratio,
             std::uint64_t seed,
             const PhaseProgress& progress) {
  const Grain grain = grain_of(thesis, aspect_ratio);
  const datasets::SceneFile file = hopper_for(thesis, grain, seed);
  const calibrate::SceneRun run =
      calibrate::run_scene(file, {.seed = seed, .stop = is_interrupted, .progress = progress});
  if (run.status != sim::RunStatus::completed || !run.reached_event)
    return {{"failed", run.message}};
  const auto percent_of = [&](const char* name) { return 100.0 * thesis.setting("shape", name); };
  const auto share_of = [&](const char* name) {
    return thesis.number(scalars, name) * unit_in_si("percent");
  };

  // 1. At rest: the last frame before the opening
  std::size_t rest = 0;
  while (rest + 1 < run.frames.size() && run.frames[rest + 1].state.time <= run.event_time + 1e-9)
    ++rest;
  const calibrate::SceneFrame& bed = run.frames[rest];
  const std::vector<sim::Vec3>& centres = bed.state.position;
  const double width = thesis.si(parameters, "hopper_width");
  const Squares mesh{thesis.number(scalars, "solid_fraction_mesh") * unit_in_si("cm"), width};
  const Json squares = solid_fraction_of_squares(centres, mesh, grain.area);
  const DistributionShape shape = shape_of(squares.at("fraction").get<std::vector<double>>());
  double weight = 0.0;
  for (const sim::Body& body : run.scene.bodies)
    weight += run.scene.types[body.type].mass * -file.gravity.z();
  const double on_floor =
      -(force_on(file, bed, "floor") + force_on(file, bed, "orifice")).z() / weight;
  const double on_left = std::abs(force_on(file, bed, "left").x());
  const double on_right = std::abs(force_on(file, bed, "right").x());

  // 2. Running out
  std::vector<double> time, percent;
  std::vector<sim::State> early;                     // when the first bands of shear show
  InnerMotion motion;                                // summed over the straight part
  std::array<std::vector<double>, 3> energy_ratios;  // frame by frame: left, centre, right
  Json squares_running;                              // in the middle of the straight part
  double largest_on_left = 0.0;
  for (std::size_t f = rest; f < run.frames.size(); ++f) {
    const calibrate::SceneFrame& frame = run.frames[f];
    const double since = frame.state.time - run.event_time;
    time.push_back(since);
    percent.push_back(100.0 * frame.bed.discharged / static_cast<double>(centres.size()));
    if (since > 0.0 && since <= thesis.setting("shape", "pulse_time"))
      largest_on_left = std::max(largest_on_left, std::abs(force_on(file, frame, "left").x()));
    if (since >= thesis.setting("shape", "band_from") &&
        since <= thesis.setting("shape", "band_to"))
      early.push_back(frame.state);
    const InnerMotion now = motion_in(run, frame.state, width, top_of(centres));
    for (std::size_t third = 0; third < energy_ratios.size(); ++third)
      energy_ratios[third].push_back(now.rotational[third] / now.translational[third]);
    if (squares_running.is_null() &&
        percent.back() >= 0.5 * (percent_of("steady_from") + percent_of("steady_to"))) {
      squares_running = solid_fraction_of_squares(inside_of(frame.state), mesh, grain.area);
    }
    if (percent.back() >= percent_of("steady_from") && percent.back() <= percent_of("steady_to"))
      motion.add(now);
  }
  const DischargeLine line = straight_part(time, percent, thesis);
  const auto band = shear_band_angle(early,
                                     {.height = thesis.setting("shape", "band_height"),
                                      .row_height = thesis.setting("shape", "band_row"),
                                      .slow_share = share_of("velocity_class_slow")});
  return {{"fraction", bulk_fraction(centres, width, grain)},
          {"skewness", shape.skewness},
          {"kurtosis", shape.kurtosis},
          {"coordination", bed.bed.coordination},
          {"bottom_error", 100.0 * std::abs(on_floor - 1.0)},
          {"rested", run.phases.front().came_to_rest},
          {"rest_time", run.phases.front().end - run.phases.front().start},
          {"wall_force_per_height", 0.5 * (on_left + on_right) / top_of(centres)},
          {"floor_contacts", floor_contacts(run, bed.state)},
          {"wall_strips", force_by_tenths(file, run, rest)},
          {"wall_history", wall_history(file, run, rest, thesis.setting("shape", "pulse_time"))},
          {"delay", line.delay},
          {"rate", line.rate},
          {"roughness", line.roughness},
          {"energy_ratio", sum_of(motion.rotational) / sum_of(motion.translational)},
          {"energy_ratio_left", motion.rotational[0] / motion.translational[0]},
          {"energy_ratio_centre", motion.rotational[1] / motion.translational[1]},
          {"energy_ratio_right", motion.rotational[2] / motion.translational[2]},
          {"energy_ratio_sides",
           (motion.rotational[0] + motion.rotational[2]) /
               (motion.translational[0] + motion.translational[2])},
          {"sideways_below", motion.sideways[0] / motion.downwards[0]},
          {"sideways_above", motion.sideways[2] / motion.downwards[2]},
          {"band_angle", band ? *band / unit_in_si("deg") : no_number},
          {"pulse", on_left > 0.0 ? largest_on_left / on_left : no_number},
          {"time", time},
          {"percent", percent},
          {"energy_ratios_in_time",
           {{"left", energy_ratios[0]}, {"centre", energy_ratios[1]}, {"right", energy_ratios[2]}}},
          {"squares", squares},
          {"squares_running", squares_running},
          {"speed_classes",
           early.empty() ? Json::object()
                         : speed_classes(early.back(),
                                         thesis.setting("shape", "drawn_height"),
                                         share_of("velocity_class_slow"),
                                         share_of("velocity_class_fast"))},
          {"marked", paths_of_marked(run, rest, width, thesis.count("shape", "marked_in_a_row"))}};
}

Json run_heap(const ThesisData& thesis,
              int aspect_ratio,
              std::uint64_t seed,
              const PhaseProgress& progress) {
  const auto setting = [&](const char* name) { return thesis.setting("heap", name); };
  const Grain grain = grain_of(thesis, aspect_ratio);
  datasets::SceneFile file = hopper_for(thesis, grain, seed);
  const double half_width = 0.5 * thesis.si(parameters, "hopper_width");
  const double gravity = -file.gravity.z();
  const double impact = thesis.si(scalars, fmt::format("impact_velocity_AR{}", aspect_ratio));

  // 1. A stream into the middle that is as fast on the heap as the thesis's was
  file.places.clear();
  file.particles.front().count = thesis.count("heap", "grains");
  const double top = setting("height") + setting("drop");
  file.fill = {
      .method = datasets::SceneFill::Method::rain,
      .low = {-0.5 * setting("stream_width"), 0.0, top - 2.0 * grain.length},
      .high = {0.5 * setting("stream_width"), 0.0, top},
      .interval = setting("interval"),
      .speed = std::sqrt(std::max(0.0, impact * impact - 2.0 * gravity * setting("drop")))};
  for (datasets::SceneWall& wall : file.walls) {
    if (wall.points[0].x() == wall.points[1].x()) wall.points[1].z() = top;  // the sides
    wall.opens_at = std::numeric_limits<double>::infinity();
  }

  // 2. Frictional from its first grain, looked at as soon as the last has landed
  file.phases.resize(1);
  datasets::ScenePhase& phase = file.phases.front();
  phase.until_rest = false;
  phase.duration = setting("wait");
  phase.output_interval = phase.duration;
  phase.global_damping = 0.0;
  phase.fastest_impact = 1.5 * impact;
  phase.friction_between_particles = thesis.si(scalars, "heap_friction");
  phase.friction_with_walls = thesis.si(scalars, "heap_friction");
  file.event_phase = 0;
  const calibrate::SceneRun run =
      calibrate::run_scene(file, {.seed = seed, .stop = is_interrupted, .progress = progress});
  if (run.status != sim::RunStatus::completed) return {{"failed", run.message}};
  const auto slope = heap_slope(run.frames.back().state.position, half_width, grain.length);
  return {{"slope", slope ? *slope / unit_in_si("deg") : no_number}};
}

}  // namespace graintruth::app
