// Chapter 5 simulated again: beds of one volume a particle and aspect ratios from one to four
// consolidate and run out of a flat hopper. The thesis's claims, one a row.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/reproduce/shape_beds.h"
#include "app/reproduce/targets.h"
#include "calibrate/ensemble.h"
#include "datasets/run_folder.h"

namespace graintruth::app {

namespace {

using Json = Studies::Json;

const std::string parameters = "table_5_1_parameters";
const std::string scalars = "ch5_scalars";
const std::string shapes = "table_5_2_solid_fraction_shape";

// One run of many: a bed or a heap.
struct ShapeRun {
  int aspect_ratio = 1;
  std::uint64_t seed = 0;
  std::string name;
};

// How far all runs of a kind are. A run costs as its spheres do; its filling, or consolidation, is
// a half of it.
class ShapeProgress {
 public:
  ShapeProgress(std::string job, const std::vector<ShapeRun>& runs, ProgressLine& line)
      : job_(std::move(job)), runs_(runs), shares_(runs.size()), line_(line) {}

  // For one run, on any thread.
  PhaseProgress of(std::size_t run) {
    return [this, run, first = std::string()](
               const std::string& phase, double share, const std::string& detail) mutable {
      if (first.empty()) first = phase;
      shares_[run] = (phase == first ? 0.0 : 0.5) + 0.5 * share;
      show(runs_[run].name + " " + phase + " " + detail);
    };
  }
  void finish(std::size_t run) { shares_[run] = 1.0; }

 private:
  void show(const std::string& detail) {
    double done = 0.0, all = 0.0;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      done += runs_[i].aspect_ratio * shares_[i];
      all += runs_[i].aspect_ratio;
    }
    line_.show(job_, done / all, detail);
  }

  std::string job_;
  const std::vector<ShapeRun>& runs_;
  std::vector<std::atomic<double>> shares_;
  ProgressLine& line_;
};

// The runs of one aspect ratio, and what is said of those that failed.
struct ShapeRuns {
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

using RunOfShape = Json (*)(const ThesisData&,
                            int aspect_ratio,
                            std::uint64_t seed,
                            const PhaseProgress&);

// All aspect ratios and seeds of one kind of run, each stored by itself.
std::vector<ShapeRuns> run_all(const ThesisData& thesis,
                               Studies& studies,
                               const std::string& kind,
                               const std::string& settings,
                               RunOfShape run) {
  const auto seeds =
      calibrate::make_seeds(studies.seed(), settings, thesis.count(settings, "seeds"));
  std::vector<ShapeRun> runs;
  for (const double ratio : thesis.settings(settings, "aspect_ratios")) {
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      const int aspect_ratio = static_cast<int>(std::lround(ratio));
      runs.push_back({aspect_ratio,
                      seeds[i],
                      fmt::format("study-shape-aspect-ratio-{}-{}-{}", aspect_ratio, kind, i + 1)});
    }
  }
  const std::string inputs = fmt::format("{} {} {} particles in {} m",
                                         thesis.settings_text(settings),
                                         datasets::file_hash(scene_of_hopper()),
                                         thesis.number(parameters, "particles"),
                                         thesis.si(parameters, "hopper_width"));
  std::vector<Json> found(runs.size());
  ShapeProgress progress("study-shape, " + kind + "s", runs, studies.progress());
  // The longest first, so that none is left to run alone at the end
  studies.in_parallel(static_cast<int>(runs.size()), [&](int turn) {
    const std::size_t i = runs.size() - 1 - static_cast<std::size_t>(turn);
    found[i] = studies.result(runs[i].name, inputs, [&] {
      return run(thesis, runs[i].aspect_ratio, runs[i].seed, progress.of(i));
    });
    progress.finish(i);
  });
  std::vector<ShapeRuns> all;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::string label = std::to_string(runs[i].aspect_ratio);
    if (all.empty() || all.back().label != label) all.push_back({label, {}, {}});
    if (found[i].contains("failed")) {
      all.back().failure = found[i].at("failed").get<std::string>();
    } else {
      all.back().runs.push_back(std::move(found[i]));
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
void examine_packing(Examination& exam,
                     const ThesisData& thesis,
                     const std::vector<ShapeRuns>& beds) {
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
void examine_discharge(Examination& exam,
                       const ThesisData& thesis,
                       const std::vector<ShapeRuns>& beds) {
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
void examine_motion(Examination& exam, const std::vector<ShapeRuns>& beds) {
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

// Sections 5.3.1.1 and 5.3.3.1: coming to rest, bands of shear, pressure on the walls.
void examine_bands_and_walls(Examination& exam,
                             const ThesisData& thesis,
                             const std::vector<ShapeRuns>& beds) {
  Curve pressure{.id = "shape-wall-force",
                 .caption =
                     "Normal force on a side wall by tenths of the height of the bed, just "
                     "after the opening; mean over beds and both walls.",
                 .x_title = "Height (tenths)",
                 .y_title = "Force on a tenth (N)"};
  for (std::size_t i = 0; i < beds.size(); ++i) {
    const std::string ratio = "aspect ratio " + beds[i].label;
    exam.claim_value(ratio + ": bed comes to rest after",
                     thesis.printed(scalars, "consolidation_stable_time"),
                     beds[i].of("rest_time"),
                     thesis.setting("shape", "rest_tolerance"),
                     "ours is damped while it falls, from a lattice of its own");
    const Simulated band = beds[i].of("band_angle");
    exam.claim_value(
        ratio + ": angle of the shear band",
        thesis.printed(scalars,
                       i == 0 ? "shear_band_angle_spheres" : "shear_band_angle_nonspherical"),
        band,
        thesis.setting("shape", "band_tolerance") / unit_in_si("deg"),
        fmt::format("found in {} of {} beds", band.seeds, beds[i].runs.size()));
    if (i > 0) {
      const Simulated here = beds[i].of("wall_force_per_height"),
                      before = beds[i - 1].of("wall_force_per_height");
      exam.claim(
          fmt::format(
              "{}: more pressure on the walls than aspect ratio {}", ratio, beds[i - 1].label),
          {"rises", "N/m", "sec 5.3.3.1"},
          here,
          no_number,
          here.mean > before.mean + separation(here, before),
          fmt::format("force on a side wall over the height of the bed, at rest and without "
                      "friction; at {} {:.1f}",
                      beds[i - 1].label,
                      before.mean));
    }
    std::vector<double> tenths, force;
    for (const Json& run : beds[i].runs) {
      const auto of_run = run.at("wall_strips").get<std::vector<double>>();
      force.resize(of_run.size());
      for (std::size_t strip = 0; strip < of_run.size(); ++strip)
        force[strip] += of_run[strip] / static_cast<double>(beds[i].runs.size());
    }
    for (std::size_t strip = 0; strip < force.size(); ++strip)
      tenths.push_back(static_cast<double>(strip) + 0.5);
    pressure.series.push_back(
        {.name = ratio, .x = tenths, .y = force, .is_ours = true, .is_line = true});
  }
  exam.add_curve(pressure);
}

// Section 5.3.2.2: where marked grains of the first beds go.
void draw_paths(Examination& exam, const std::vector<ShapeRuns>& beds) {
  for (const ShapeRuns& of : beds) {
    Curve paths{.id = "shape-paths-" + of.label,
                .caption = fmt::format("Paths of marked grains, aspect ratio {}.", of.label),
                .x_title = "x (m)",
                .y_title = "z (m)"};
    for (const Json& path : of.runs.front().at("marked")) {
      paths.series.push_back({.name = fmt::format("grain {}", paths.series.size() + 1),
                              .x = path.at("x").get<std::vector<double>>(),
                              .y = path.at("z").get<std::vector<double>>(),
                              .is_ours = true,
                              .is_line = true});
    }
    exam.add_curve(paths);
  }
}

// Section 5.3.3: heaps at the thesis's speeds of impact.
void examine_heaps(Examination& exam, const std::vector<ShapeRuns>& heaps) {
  for (std::size_t i = 1; i < heaps.size(); ++i) {
    const std::string where =
        fmt::format("aspect ratio {}: a steeper heap than that of spheres", heaps[i].label);
    const Printed printed = {"steeper", "deg", "sec 5.3.3"};
    const Simulated slope = heaps[i].of("slope"), spheres = heaps[0].of("slope");
    if (slope.seeds == 0 || spheres.seeds == 0) {
      exam.not_run(where, printed, "no heap to measure");
      continue;
    }
    exam.claim(where,
               printed,
               slope,
               no_number,
               slope.mean > spheres.mean + separation(slope, spheres),
               fmt::format("of spheres {:.1f}; speeds of impact as printed", spheres.mean));
  }
}

// What keeps the runs of a kind from being held against the thesis; nothing where all is well.
void note_failures(Examination& exam, const std::vector<ShapeRuns>& all, const char* kind) {
  for (const ShapeRuns& of : all) {
    if (!of.failure.empty())
      exam.add_note(fmt::format("Aspect ratio {}: a {} failed: {}.", of.label, kind, of.failure));
  }
}

}  // namespace

void simulate_shapes(Examination& exam, const ThesisData& thesis, Studies& studies) {
  const std::vector<ShapeRuns> heaps = run_all(thesis, studies, "heap", "heap", run_heap);
  const std::vector<ShapeRuns> beds = run_all(thesis, studies, "bed", "shape", run_bed);
  note_failures(exam, beds, "bed");
  note_failures(exam, heaps, "heap");
  const bool has_all =
      beds.size() >= 4 &&
      std::none_of(beds.begin(), beds.end(), [](const auto& of) { return of.runs.empty(); });
  if (has_all) {
    examine_packing(exam, thesis, beds);
    examine_discharge(exam, thesis, beds);
    examine_motion(exam, beds);
    examine_bands_and_walls(exam, thesis, beds);
    draw_paths(exam, beds);
  } else {
    exam.not_run(
        "beds of aspect ratios 1 to 4", {"run", "-", "sec 5.2"}, "not all ran to their end");
  }
  examine_heaps(exam, heaps);
  int restless = 0;
  for (const ShapeRuns& of : beds) {
    restless += static_cast<int>(std::count_if(of.runs.begin(), of.runs.end(), [](const Json& run) {
      return !run.at("rested").get<bool>();
    }));
  }
  if (restless > 0)
    exam.add_note(fmt::format("{} beds had not come to rest when the orifice opened.", restless));
}

}  // namespace graintruth::app
