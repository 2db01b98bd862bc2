// Chapter 5 simulated again: beds of one volume a particle and aspect ratios from one to four
// consolidate and run out of a flat hopper. The thesis's claims, one a row.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_01.hpp>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>

#include "app/data_folder.h"
#include "app/interrupt.h"
#include "app/reproduce/targets.h"
#include "app/scene_run.h"
#include "calibrate/ensemble.h"
#include "datasets/run_folder.h"
#include "sim/profile.h"

namespace graintruth::app {

namespace {

using Json = Studies::Json;

const std::string parameters = "table_5_1_parameters";
const std::string scalars = "ch5_scalars";
const std::string shapes = "table_5_2_solid_fraction_shape";

std::filesystem::path scene_of_hopper() { return data_folder() / "scenes" / "shape_study.toml"; }

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

// Solid fractions of the squares that hold a grain's centre (section 5.3.1).
std::vector<double> square_fractions(const std::vector<sim::Vec3>& centres,
                                     double side,
                                     const Grain& grain) {
  std::map<std::pair<int, int>, int> counts;
  for (const sim::Vec3& centre : centres) {
    ++counts[{static_cast<int>(std::floor(centre.x() / side)),
              static_cast<int>(std::floor(centre.z() / side))}];
  }
  std::vector<double> fractions;
  for (const auto& [square, count] : counts)
    fractions.push_back(count * grain.area / (side * side));
  return fractions;
}

double top_of(const std::vector<sim::Vec3>& centres) {
  double top = 0.0;
  for (const sim::Vec3& centre : centres) top = std::max(top, centre.z());
  return top;
}

// Of the lower nine tenths of the bed, which the ragged surface does not touch.
double bulk_fraction(const std::vector<sim::Vec3>& centres, double width, const Grain& grain) {
  const double height = 0.9 * top_of(centres);
  const auto below = std::count_if(
      centres.begin(), centres.end(), [&](const sim::Vec3& c) { return c.z() < height; });
  return static_cast<double>(below) * grain.area / (width * height);
}

// Force on the walls whose names begin so, N.
sim::Vec3 force_on(const datasets::SceneFile& file, const SceneFrame& frame, const char* name) {
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

// How the grains inside the hopper move, summed over the frames of the straight part.
struct InnerMotion {
  std::array<double, 3> rotational = {}, translational = {};  // J; left, centre, right (5.3, 5.4)
  std::array<double, 3> sideways = {}, downwards = {};  // m/s; lower, middle, upper third at rest

  void add(const SceneRun& run, const sim::State& state, double width, double height) {
    const auto third = [](double share) { return std::clamp(static_cast<int>(3.0 * share), 0, 2); };
    for (std::size_t i = 0; i < state.position.size(); ++i) {
      const sim::Vec3 &place = state.position[i], &velocity = state.velocity[i];
      if (place.z() < 0.0) continue;
      const sim::Clump& clump = run.scene.types[run.scene.bodies[i].type];
      const int across = third(place.x() / width + 0.5), up = third(place.z() / height);
      const double spin = state.angular_velocity[i].y();
      rotational[across] += 0.5 * clump.inertia.y() * spin * spin;
      translational[across] += 0.5 * clump.mass * velocity.squaredNorm();
      sideways[up] += std::abs(velocity.x());
      downwards[up] += std::abs(velocity.z());
    }
  }
};

double sum_of(const std::array<double, 3>& parts) { return parts[0] + parts[1] + parts[2]; }

// How far the beds of one aspect ratio are: consolidation and discharge are a half of each.
class BedsProgress {
 public:
  BedsProgress(std::string job, int beds, ProgressLine& line)
      : job_(std::move(job)), shares_(static_cast<std::size_t>(beds)), line_(line) {}

  // For the run of one bed, on any thread.
  auto of(int bed) {
    return [this, bed, first = std::string()](
               const std::string& phase, double share, const std::string& detail) mutable {
      if (first.empty()) first = phase;
      shares_[static_cast<std::size_t>(bed)] = (phase == first ? 0.0 : 0.5) + 0.5 * share;
      double sum = 0.0;
      for (const std::atomic<double>& one : shares_) sum += one;
      line_.show(job_, sum / static_cast<double>(shares_.size()), phase + " " + detail);
    };
  }

 private:
  std::string job_;
  std::vector<std::atomic<double>> shares_;
  ProgressLine& line_;
};

// One bed from its lattice to its discharge; what went wrong when it did not come to its end.
Json run_bed(const ThesisData& thesis, const Grain& grain, SceneRunOptions options) {
  const datasets::SceneFile file = hopper_for(thesis, grain, options.seed);
  options.stop = is_interrupted;
  const SceneRun run = run_scene(file, options);
  if (run.status != sim::RunStatus::completed || !run.reached_event)
    return {{"failed", run.message}};

  // 1. At rest: the last frame before the opening
  std::size_t rest = 0;
  while (rest + 1 < run.frames.size() && run.frames[rest + 1].state.time <= run.event_time + 1e-9)
    ++rest;
  const SceneFrame& bed = run.frames[rest];
  const std::vector<sim::Vec3>& centres = bed.state.position;
  const double side = thesis.number(scalars, "solid_fraction_mesh") * unit_in_si("cm");
  const double width = thesis.si(parameters, "hopper_width");
  const DistributionShape shape = shape_of(square_fractions(centres, side, grain));
  double weight = 0.0;
  for (const sim::Body& body : run.scene.bodies)
    weight += run.scene.types[body.type].mass * -file.gravity.z();
  const double on_floor =
      -(force_on(file, bed, "floor") + force_on(file, bed, "orifice")).z() / weight;
  const double on_side = std::abs(force_on(file, bed, "left").x());

  // 2. Running out
  std::vector<double> time, percent;
  double largest_on_side = 0.0;
  for (std::size_t f = rest; f < run.frames.size(); ++f) {
    const SceneFrame& frame = run.frames[f];
    time.push_back(frame.state.time - run.event_time);
    percent.push_back(100.0 * frame.bed.discharged / static_cast<double>(centres.size()));
    if (time.back() > 0.0 && time.back() <= thesis.setting("shape", "pulse_time"))
      largest_on_side = std::max(largest_on_side, std::abs(force_on(file, frame, "left").x()));
  }
  const DischargeLine line = straight_part(time, percent, thesis);
  InnerMotion motion;
  for (std::size_t i = 0; i < percent.size(); ++i) {
    if (percent[i] >= 100.0 * thesis.setting("shape", "steady_from") &&
        percent[i] <= 100.0 * thesis.setting("shape", "steady_to"))
      motion.add(run, run.frames[rest + i].state, width, top_of(centres));
  }
  return {{"fraction", bulk_fraction(centres, width, grain)},
          {"skewness", shape.skewness},
          {"kurtosis", shape.kurtosis},
          {"coordination", bed.bed.coordination},
          {"bottom_error", 100.0 * std::abs(on_floor - 1.0)},
          {"rested", run.phases.front().came_to_rest},
          {"delay", line.delay},
          {"rate", line.rate},
          {"roughness", line.roughness},
          {"energy_ratio", sum_of(motion.rotational) / sum_of(motion.translational)},
          {"energy_ratio_centre", motion.rotational[1] / motion.translational[1]},
          {"energy_ratio_sides",
           (motion.rotational[0] + motion.rotational[2]) /
               (motion.translational[0] + motion.translational[2])},
          {"sideways_below", motion.sideways[0] / motion.downwards[0]},
          {"sideways_above", motion.sideways[2] / motion.downwards[2]},
          {"pulse", on_side > 0.0 ? largest_on_side / on_side : no_number},
          {"time", time},
          {"percent", percent}};
}

// The runs of one aspect ratio, and what is said of those that failed.
struct Beds {
  std::string label;
  std::vector<Json> runs;
  std::string failure;

  std::vector<double> values(const char* key) const {
    std::vector<double> found;
    for (const Json& run : runs)
      if (run.at(key).is_number()) found.push_back(run.at(key).get<double>());
    return found;
  }
  Simulated of(const char* key) const {
    const std::vector<double> found = values(key);
    return found.empty() ? Simulated{.seeds = 0} : over_seeds(found);
  }
};

std::vector<Beds> run_beds(const ThesisData& thesis, Studies& studies) {
  const int seeds = thesis.count("shape", "seeds");
  const auto drawn = calibrate::make_seeds(studies.seed(), "shape", seeds);
  const std::string inputs = fmt::format("{} {} {} particles in {} m",
                                         thesis.settings_text("shape"),
                                         datasets::file_hash(scene_of_hopper()),
                                         thesis.number(parameters, "particles"),
                                         thesis.si(parameters, "hopper_width"));
  std::vector<Beds> all;
  for (const double ratio : thesis.settings("shape", "aspect_ratios")) {
    const Grain grain = grain_of(thesis, static_cast<int>(std::lround(ratio)));
    const std::string name = fmt::format("study-shape-aspect-ratio-{}", grain.aspect_ratio);
    const Json stored = studies.result(name, inputs, [&] {
      std::vector<Json> found(drawn.size());
      BedsProgress progress(name, seeds, studies.progress());
      studies.in_parallel(seeds, [&](int i) {
        const auto which = static_cast<std::size_t>(i);
        found[which] = run_bed(thesis, grain, {.seed = drawn[which], .progress = progress.of(i)});
      });
      return Json(found);
    });
    Beds& beds = all.emplace_back(Beds{std::to_string(grain.aspect_ratio), {}, {}});
    for (const Json& run : stored) {
      if (run.contains("failed")) {
        beds.failure = run.at("failed").get<std::string>();
      } else {
        beds.runs.push_back(run);
      }
    }
  }
  return all;
}

double separation(const Simulated& a, const Simulated& b) { return std::hypot(a.spread, b.spread); }

// 100 (1 - b/a), its spread from both.
Simulated fall_percent(const Simulated& a, const Simulated& b) {
  const double ratio = b.mean / a.mean;
  return {100.0 * (1.0 - ratio),
          100.0 * ratio * std::hypot(a.spread / a.mean, b.spread / b.mean),
          std::min(a.seeds, b.seeds)};
}

// Section 5.3.1: packing.
void examine_packing(Examination& exam, const ThesisData& thesis, const std::vector<Beds>& beds) {
  const Simulated first = beds[0].of("fraction"), second = beds[1].of("fraction"),
                  last = beds.back().of("fraction");
  exam.claim_value("solid fraction: fall from aspect ratio 1 to 4",
                   thesis.printed(scalars, "solid_fraction_drop_AR1_to_AR4"),
                   fall_percent(first, last),
                   100.0 * thesis.setting("shape", "fraction_tolerance"),
                   fmt::format("{:.3f}, {:.3f}, {:.3f}, {:.3f}; thickness of the layer not counted",
                               first.mean,
                               second.mean,
                               beds[2].of("fraction").mean,
                               last.mean));
  exam.claim(
      "solid fraction: most of the fall lies between 2 and 4",
      {"most", "percent", "sec 5.3.1"},
      {.mean = 100.0 * (second.mean - last.mean) / (first.mean - last.mean), .seeds = last.seeds},
      no_number,
      second.mean - last.mean > first.mean - second.mean,
      "share of the fall");
  const double tolerance = 100.0 * thesis.setting("shape", "coordination_tolerance");
  exam.claim_value("coordination: fall from aspect ratio 1 to 2",
                   thesis.printed(scalars, "coordination_change_AR1_to_AR2"),
                   fall_percent(beds[0].of("coordination"), beds[1].of("coordination")),
                   tolerance,
                   "contacts of two particles count once");
  exam.claim_value("coordination: fall from aspect ratio 2 to 4",
                   thesis.printed(scalars, "coordination_change_AR2_to_AR4"),
                   fall_percent(beds[1].of("coordination"), beds.back().of("coordination")),
                   tolerance,
                   "contacts of two particles count once");
  const std::array errors = {"bottom_force_error_AR1", "bottom_force_error_AR2"};
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const Printed printed = thesis.printed(scalars, errors[i]);
    const Simulated error = beds[i].of("bottom_error");
    exam.claim(fmt::format("aspect ratio {}: force on the bottom off the weight", beds[i].label),
               printed,
               error,
               printed.value(),
               error.mean <= printed.value(),
               "claimed: no more than printed");
  }
  const datasets::Table& table = thesis.table(shapes);
  for (std::size_t row = 0; row < std::min(table.rows(), beds.size()); ++row) {
    for (const char* column : {"skewness", "kurtosis"}) {
      const Simulated found = beds[row].of(column);
      exam.claim_value(
          fmt::format("aspect ratio {}: {} of solid fraction", beds[row].label, column),
          thesis.cell(shapes, row, column, "-"),
          found,
          2.0 * found.spread,
          "within two standard deviations of ours: the thesis's is one bed");
    }
  }
}

// Section 5.3.3: discharge.
void examine_discharge(Examination& exam, const ThesisData& thesis, const std::vector<Beds>& beds) {
  Curve curve{.id = "shape-discharge",
              .caption = "Grains that have left against time, first bed of each aspect ratio.",
              .x_title = "Time (s)",
              .y_title = "Discharged (%)"};
  for (std::size_t i = 0; i < beds.size(); ++i) {
    const std::string ratio = "aspect ratio " + beds[i].label;
    exam.claim_value(ratio + ": delay of the discharge",
                     thesis.printed(scalars, "initial_discharge_delay"),
                     beds[i].of("delay"),
                     thesis.setting("shape", "delay_tolerance"));
    const Simulated pulse = beds[i].of("pulse");
    exam.claim(ratio + (i == 0 ? ": no pulse of the wall force at the opening"
                               : ": a pulse of the wall force at the opening"),
               {i == 0 ? "almost constant" : "pulse", "-", "sec 5.3.3.1"},
               pulse,
               no_number,
               i == 0
                   ? pulse.mean <= 1.0 + 2.0 * pulse.spread
                   : pulse.mean > beds[0].of("pulse").mean + separation(pulse, beds[0].of("pulse")),
               "largest force on a side wall over that at rest");
    if (!beds[i].runs.empty()) {
      curve.series.push_back({.name = ratio,
                              .x = beds[i].runs.front().at("time").get<std::vector<double>>(),
                              .y = beds[i].runs.front().at("percent").get<std::vector<double>>(),
                              .is_ours = true,
                              .is_line = true});
    }
    if (i == 0) continue;
    const Simulated rate = beds[i].of("rate"), before = beds[i - 1].of("rate");
    exam.claim(fmt::format("{}: slower than aspect ratio {}", ratio, beds[i - 1].label),
               {"slower", "percent/s", "sec 5.3.3"},
               rate,
               no_number,
               rate.mean < before.mean - separation(rate, before),
               fmt::format("of all particles; at {} {:.1f}", beds[i - 1].label, before.mean));
    const Simulated rough = beds[i].of("roughness"), smoother = beds[i - 1].of("roughness");
    exam.claim(
        fmt::format("{}: rougher discharge than aspect ratio {}", ratio, beds[i - 1].label),
        {"rougher", "percent", "sec 5.3.3"},
        rough,
        no_number,
        rough.mean > smoother.mean + separation(rough, smoother),
        fmt::format(
            "rms distance from the straight line; at {} {:.2f}", beds[i - 1].label, smoother.mean));
  }
  exam.add_curve(curve);
}

// Section 5.3.2.2: rotation and sideways motion while it runs out.
void examine_motion(Examination& exam, const std::vector<Beds>& beds) {
  for (std::size_t i = 0; i < beds.size(); ++i) {
    const std::string ratio = "aspect ratio " + beds[i].label;
    const Simulated above = beds[i].of("sideways_above"), below = beds[i].of("sideways_below");
    exam.claim(ratio + ": less sideways motion in the upper third than in the lower",
               {"less", "-", "sec 5.3.2.2"},
               above,
               no_number,
               above.mean < below.mean - separation(above, below),
               fmt::format("sideways over downward speed; below {:.3f}", below.mean));
    const Simulated centre = beds[i].of("energy_ratio_centre"),
                    sides = beds[i].of("energy_ratio_sides");
    exam.claim(ratio + ": grains rotate less in the centre than at the sides",
               {"less", "-", "sec 5.3.2.2"},
               centre,
               no_number,
               centre.mean < sides.mean - separation(centre, sides),
               fmt::format("energy ratio (5.2); at the sides {:.3g}", sides.mean));
    if (i == 0) continue;
    const Simulated whole = beds[i].of("energy_ratio"), spheres = beds[0].of("energy_ratio");
    exam.claim(ratio + ": grains rotate less than spheres",
               {"less", "-", "sec 5.3.2.2"},
               whole,
               no_number,
               whole.mean < spheres.mean - separation(whole, spheres),
               fmt::format("energy ratio (5.2); of spheres {:.3g}", spheres.mean));
  }
}

// Claims that these runs are not measured for.
void list_what_is_left(Examination& exam, const ThesisData& thesis) {
  const auto left = [&](const char* where, const char* quantity) {
    exam.not_run(where, thesis.printed(scalars, quantity), "not measured");
  };
  left("beds come to rest after", "consolidation_stable_time");
  left("angle of the shear band, not spherical", "shear_band_angle_nonspherical");
  left("angle of the shear band, spheres", "shear_band_angle_spheres");
  exam.not_run(
      "a steeper heap than that of spheres", {"steeper", "-", "sec 5.3.3"}, "not measured");
  exam.not_run(
      "wall pressure rises with the aspect ratio", {"rises", "-", "sec 5.3.3.1"}, "not measured");
}

}  // namespace

void simulate_shapes(Examination& exam, const ThesisData& thesis, Studies& studies) {
  const std::vector<Beds> beds = run_beds(thesis, studies);
  bool has_all = true;
  for (const Beds& of : beds) {
    if (!of.failure.empty())
      exam.add_note(fmt::format("Aspect ratio {}: a bed failed: {}.", of.label, of.failure));
    has_all = has_all && !of.runs.empty();
  }
  if (!has_all || beds.size() < 4) {
    exam.not_run(
        "beds of aspect ratios 1 to 4", {"run", "-", "sec 5.2"}, "not all ran to their end");
    return;
  }
  examine_packing(exam, thesis, beds);
  examine_discharge(exam, thesis, beds);
  examine_motion(exam, beds);
  list_what_is_left(exam, thesis);
  int restless = 0;
  for (const Beds& of : beds) {
    restless += static_cast<int>(std::count_if(of.runs.begin(), of.runs.end(), [](const Json& run) {
      return !run.at("rested").get<bool>();
    }));
  }
  if (restless > 0)
    exam.add_note(fmt::format("{} beds had not come to rest when the orifice opened.", restless));
}

}  // namespace graintruth::app
