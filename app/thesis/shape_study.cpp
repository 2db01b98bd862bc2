// Chapter 5 simulated again: beds of one volume a particle and aspect ratios from one to four
// consolidate and run out of a flat hopper. The thesis's claims, one a row.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "app/thesis/shape_figures.h"
#include "app/thesis/shape_runs.h"
#include "app/thesis/targets.h"

namespace graintruth::app {

namespace {

using Json = Studies::Json;

const std::string scalars = "ch5_scalars";

double separation(const Simulated& a, const Simulated& b) { return std::hypot(a.spread, b.spread); }

// Standard deviation over mean, %, of the solid fraction of squares while the bed runs out; not of
// the highest square of each column, which the surface cuts.
Simulated unevenness(const ShapeRuns& beds) {
  std::vector<double> of_beds;
  for (const Json& run : beds.runs) {
    if (run.at("squares_running").is_null()) continue;
    const Json& squares = run.at("squares_running");
    const auto x = squares.at("x").get<std::vector<double>>();
    const auto z = squares.at("z").get<std::vector<double>>();
    const auto fraction = squares.at("fraction").get<std::vector<double>>();
    std::map<double, double> highest;  // by column
    for (std::size_t i = 0; i < x.size(); ++i) highest[x[i]] = std::max(highest[x[i]], z[i]);
    std::vector<double> below;
    for (std::size_t i = 0; i < x.size(); ++i)
      if (z[i] < highest[x[i]]) below.push_back(fraction[i]);
    if (below.size() < 2) continue;
    const Simulated spread = over_seeds(below);
    of_beds.push_back(100.0 * spread.spread / spread.mean);
  }
  return of_beds.empty() ? Simulated{.seeds = 0} : over_seeds(of_beds);
}

// Rates over windows of a discharge, %/s, and the middles of the windows, s.
struct WindowRates {
  std::vector<double> time, percent, rate;
};

WindowRates window_rates(const ThesisData& thesis, const Json& run) {
  const double window = thesis.setting("shape_discharge", "window");
  const auto time = run.at("time").get<std::vector<double>>();
  const auto percent = run.at("percent").get<std::vector<double>>();
  WindowRates rates;
  for (std::size_t from = 0, to = 0; from < time.size(); ++from) {
    while (to < time.size() && time[to] < time[from] + window * (1.0 - 1e-6)) ++to;
    if (to == time.size()) break;
    rates.time.push_back(0.5 * (time[from] + time[to]));
    rates.percent.push_back(0.5 * (percent[from] + percent[to]));
    rates.rate.push_back((percent[to] - percent[from]) / (time[to] - time[from]));
  }
  return rates;
}

// Of the straight part, % of its own rate.
Simulated lowest_rate(const ThesisData& thesis, const ShapeRuns& beds) {
  const double from = 100.0 * thesis.setting("shape", "steady_from");
  const double to = 100.0 * thesis.setting("shape", "steady_to");
  std::vector<double> of_beds;
  for (const Json& run : beds.runs) {
    if (!run.at("rate").is_number()) continue;
    const WindowRates rates = window_rates(thesis, run);
    double lowest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < rates.rate.size(); ++i) {
      if (rates.percent[i] >= from && rates.percent[i] <= to)
        lowest = std::min(lowest, rates.rate[i]);
    }
    if (std::isfinite(lowest)) of_beds.push_back(100.0 * lowest / run.at("rate").get<double>());
  }
  return of_beds.empty() ? Simulated{.seeds = 0} : over_seeds(of_beds);
}

// Since the opening, s.
Simulated time_to_constant_rate(const ThesisData& thesis, const ShapeRuns& beds) {
  const double share = thesis.setting("shape_discharge", "constant_share");
  std::vector<double> of_beds;
  for (const Json& run : beds.runs) {
    if (!run.at("rate").is_number()) continue;
    const WindowRates rates = window_rates(thesis, run);
    const auto reached = std::find_if(rates.rate.begin(), rates.rate.end(), [&](double rate) {
      return rate >= share * run.at("rate").get<double>();
    });
    if (reached != rates.rate.end())
      of_beds.push_back(rates.time[static_cast<std::size_t>(reached - rates.rate.begin())]);
  }
  return of_beds.empty() ? Simulated{.seeds = 0} : over_seeds(of_beds);
}

// How far marked grains have turned in the end, degrees either way; mean over those of a bed.
Simulated turn_of_marked(const ShapeRuns& beds) {
  std::vector<double> of_beds;
  for (const Json& run : beds.runs) {
    double sum = 0.0;
    for (const Json& grain : run.at("marked"))
      sum += std::abs(grain.at("turned").back().get<double>());
    of_beds.push_back(sum / static_cast<double>(run.at("marked").size()));
  }
  return of_beds.empty() ? Simulated{.seeds = 0} : over_seeds(of_beds);
}

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
  const Simulated more{
      .mean = beds[1].of("floor_contacts").mean - beds[0].of("floor_contacts").mean,
      .spread = separation(beds[1].of("floor_contacts"), beds[0].of("floor_contacts")),
      .seeds = beds[0].of("floor_contacts").seeds};
  exam.claim_value("aspect ratio 2: more contacts with the bottom than spheres",
                   thesis.printed(scalars, "extra_bottom_contacts_AR2_over_AR1"),
                   more,
                   thesis.setting("shape", "contacts_tolerance"),
                   "element spheres that touch it");
  for (const char* ratio : {"1", "2"}) {
    exam.not_run(fmt::format("aspect ratio {}: largest damping force on the bottom", ratio),
                 thesis.printed(scalars, fmt::format("max_damping_force_AR{}", ratio)),
                 "our forces on walls are not split into spring and dashpot");
  }
  for (std::size_t i = 1; i < beds.size(); ++i) {
    const Simulated here = unevenness(beds[i]), spheres = unevenness(beds[0]);
    exam.claim(
        fmt::format("aspect ratio {}: a less even bed than that of spheres while it runs out",
                    beds[i].label),
        {"uneven", "percent", "sec 5.3.2.1"},
        here,
        no_number,
        here.mean > spheres.mean + separation(here, spheres),
        fmt::format("standard deviation over mean of solid fraction in squares below the "
                    "surface; of spheres {:.1f}",
                    spheres.mean));
  }
}

// Section 5.3.3: discharge.
void examine_discharge(Examination& exam,
                       const ThesisData& thesis,
                       const std::vector<ShapeRuns>& beds) {
  for (std::size_t i = 0; i < beds.size(); ++i) {
    const std::string ratio = "aspect ratio " + beds[i].label;
    exam.claim_value(ratio + ": delay of the discharge",
                     thesis.printed(scalars, "initial_discharge_delay"),
                     beds[i].of("delay"),
                     thesis.setting("shape", "delay_tolerance"));
    const Simulated pulse = beds[i].of("pulse"), of_spheres = beds[0].of("pulse");
    exam.claim(ratio + (i == 0 ? ": no pulse of the wall force at the opening"
                               : ": a pulse of the wall force at the opening, unlike spheres"),
               {i == 0 ? "almost constant" : "pulse", "-", "sec 5.3.3.1"},
               pulse,
               no_number,
               i == 0
                   ? pulse.mean + pulse.spread <= 1.0 + thesis.setting("shape", "pulse_tolerance")
                   : pulse.mean > of_spheres.mean + separation(pulse, of_spheres),
               fmt::format("largest force on the left wall in {} s after the opening, over that "
                           "at rest",
                           thesis.setting("shape", "pulse_time")));
    if (i == 0) continue;
    const std::string before = "aspect ratio " + beds[i - 1].label;
    const Simulated rate = beds[i].of("rate"), rate_before = beds[i - 1].of("rate");
    exam.claim(
        fmt::format("{}: slower than {}", ratio, before),
        {"slower", "percent/s", "sec 5.3.3"},
        rate,
        no_number,
        rate.mean < rate_before.mean - separation(rate, rate_before),
        fmt::format(
            "of all particles; aspect ratio {}: {:.1f}", beds[i - 1].label, rate_before.mean));
    const Simulated rough = beds[i].of("roughness"), smoother = beds[i - 1].of("roughness");
    exam.claim(fmt::format("{}: rougher discharge than {}", ratio, before),
               {"rougher", "percent", "sec 5.3.3"},
               rough,
               no_number,
               rough.mean > smoother.mean + separation(rough, smoother),
               fmt::format("rms distance from the straight line; aspect ratio {}: {:.2f}",
                           beds[i - 1].label,
                           smoother.mean));
    const Simulated held = lowest_rate(thesis, beds[i]),
                    less_held = lowest_rate(thesis, beds[i - 1]);
    exam.claim(
        fmt::format("{}: temporary arches hold the flow up more than at {}", ratio, before),
        {"more", "percent", "sec 5.3.3"},
        held,
        no_number,
        held.mean < less_held.mean - separation(held, less_held),
        fmt::format(
            "lowest rate over {} ms of the straight part, of its mean; aspect ratio {}: {:.0f}",
            1000.0 * thesis.setting("shape_discharge", "window"),
            beds[i - 1].label,
            less_held.mean));
    const Simulated later = time_to_constant_rate(thesis, beds[i]),
                    sooner = time_to_constant_rate(thesis, beds[i - 1]);
    exam.claim(fmt::format("{}: a constant rate is reached later than at {}", ratio, before),
               {"later", "s", "sec 5.3.3"},
               later,
               no_number,
               later.mean > sooner.mean + separation(later, sooner),
               fmt::format("{:.0f} % of that of the straight part; aspect ratio {}: {:.2f} s",
                           100.0 * thesis.setting("shape_discharge", "constant_share"),
                           beds[i - 1].label,
                           sooner.mean));
  }
}

// Section 5.3.2.2: rotation and sideways motion while it runs out.
void examine_motion(Examination& exam,
                    const ThesisData& thesis,
                    const std::vector<ShapeRuns>& beds) {
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
    const Simulated left = beds[i].of("energy_ratio_left"),
                    right = beds[i].of("energy_ratio_right");
    exam.claim(ratio + ": grains rotate alike on both sides",
               {"almost the same", "-", "sec 5.3.2.2"},
               left,
               no_number,
               std::abs(left.mean - right.mean) <=
                   thesis.setting("shape", "sides_tolerance") * 0.5 * (left.mean + right.mean),
               fmt::format("energy ratio (5.2) on the left; on the right {:.3g}", right.mean));
    const Printed bound = thesis.worded("study-shape", "Log Er/Et below");
    const double largest = std::max({left.mean, centre.mean, right.mean});
    exam.claim(ratio + ": less energy of rotation than of translation",
               bound,
               {.mean = largest, .seeds = left.seeds},
               no_number,
               largest < bound.value(),
               "claimed: below what is printed, which bounds Er/Et, not its logarithm (errata 58); "
               "energy ratio (5.2) of the third with the largest");
    if (i == 0) continue;
    const Simulated turned = turn_of_marked(beds[i]), rolled = turn_of_marked(beds[0]);
    exam.claim(ratio + ": marked grains turn less than spheres",
               {"less", "deg", "sec 5.3.2.2"},
               turned,
               no_number,
               turned.mean < rolled.mean - separation(turned, rolled),
               fmt::format("mean over nine, from rest until they leave or the run ends; of spheres "
                           "{:.0f}",
                           rolled.mean));
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
                      "friction; aspect ratio {}: {:.1f}",
                      beds[i - 1].label,
                      before.mean));
    }
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
  const std::vector<ShapeRuns> heaps = run_all(heap_kind, thesis, studies);
  const std::vector<ShapeRuns> beds = run_all(bed_kind, thesis, studies);
  note_failures(exam, beds, "bed");
  note_failures(exam, heaps, "heap");
  const bool has_all =
      beds.size() >= 4 &&
      std::none_of(beds.begin(), beds.end(), [](const auto& of) { return of.runs.empty(); });
  if (has_all) {
    examine_packing(exam, thesis, beds);
    examine_discharge(exam, thesis, beds);
    examine_motion(exam, thesis, beds);
    examine_bands_and_walls(exam, thesis, beds);
    draw_beds(exam, thesis, beds);
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

// Each shape's row beside what is stored of its beds; it stays as not run where there are none.
void simulate_table_5_2(Examination& exam, const ThesisData& thesis, Studies& studies) {
  const std::string name = "table_5_2_solid_fraction_shape";
  const datasets::Table& table = thesis.table(name);
  const double tolerance = thesis.setting("table_5_2", "shape_tolerance");
  const std::vector<ShapeRuns> beds = stored_of(bed_kind, thesis, studies);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string& ratio = table.text(row, "aspect_ratio");
    const auto of = std::find_if(
        beds.begin(), beds.end(), [&](const ShapeRuns& runs) { return runs.label == ratio; });
    if (of == beds.end() || of->runs.empty()) continue;
    for (const char* column : {"skewness", "kurtosis"}) {
      const Printed printed = thesis.cell(name, row, column, "-");
      exam.claim_value(fmt::format("aspect ratio {}: {}", ratio, column),
                       printed,
                       of->of(column),
                       tolerance * std::abs(printed.value()));
    }
  }
  exam.add_note(
      "Ours: mean and standard deviation over the beds of study-shape that are stored in this "
      "folder; kurtosis is that which is 3 for a normal distribution. The thesis's is one bed.");
}

}  // namespace graintruth::app
