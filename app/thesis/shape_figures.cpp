// Figures 5.3 to 5.19 of the thesis, as far as they show numbers, of our beds.
#include "app/thesis/shape_figures.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>

namespace graintruth::app {

namespace {

using Json = Studies::Json;
using Numbers = std::vector<double>;

Numbers numbers(const Json& run, const char* key) { return run.at(key).get<Numbers>(); }

// A figure with a menu of aspect ratios; the menus of a page move together.
Curve by_ratio(std::string id, std::string caption, std::string x_title, std::string y_title) {
  return {.id = std::move(id),
          .caption = std::move(caption),
          .x_title = std::move(x_title),
          .y_title = std::move(y_title),
          .menu = "Aspect ratio"};
}

// Figure 5.5, and 5.7b: a mean over beds against the aspect ratio.
Curve averages(const std::vector<ShapeRuns>& beds,
               const char* key,
               std::string id,
               std::string caption,
               std::string title) {
  Series series{.name = "mean and standard deviation over beds", .is_ours = true};
  for (const ShapeRuns& of : beds) {
    const Simulated found = of.of(key);
    series.x.push_back(std::stod(of.label));
    series.y.push_back(found.mean);
    series.spread.push_back(found.spread);
  }
  return {.id = std::move(id),
          .caption = std::move(caption),
          .x_title = "Aspect ratio",
          .y_title = std::move(title),
          .series = {series}};
}

// Figures 5.3 and 5.9: where the bed is dense.
Curve map_of_squares(const std::vector<ShapeRuns>& beds,
                     const char* key,
                     std::string id,
                     std::string caption) {
  Curve map = by_ratio(std::move(id), std::move(caption), "x (m)", "z (m)");
  map.is_picture = true;
  for (const ShapeRuns& of : beds) {
    const Json& squares = of.runs.front().at(key);
    if (squares.is_null()) continue;
    map.series.push_back({.name = "Solid fraction",
                          .x = numbers(squares, "x"),
                          .y = numbers(squares, "z"),
                          .is_ours = true,
                          .colour = numbers(squares, "fraction"),
                          .choice = of.label});
  }
  return map;
}

// Figure 5.4: how often a square is how dense, all beds of a shape together.
Curve frequency(const ThesisData& thesis, const std::vector<ShapeRuns>& beds) {
  const double width = thesis.setting("table_5_2", "class_width");
  Curve curve{.id = "shape-frequency",
              .caption =
                  "How often a square of the mesh is how dense at rest, all beds of a shape "
                  "together; Table 5.2 holds skewness and kurtosis of each bed.",
              .x_title = "Solid fraction",
              .y_title = "Squares (%)"};
  for (const ShapeRuns& of : beds) {
    std::map<int, double> counts;
    double all = 0.0;
    for (const Json& run : of.runs) {
      for (const double fraction : numbers(run.at("squares"), "fraction")) {
        ++counts[static_cast<int>(std::floor(fraction / width))];
        ++all;
      }
    }
    Series series{.name = "aspect ratio " + of.label, .is_ours = true, .is_line = true};
    for (int bin = 0; bin <= counts.rbegin()->first; ++bin) {
      series.x.push_back((bin + 0.5) * width);
      series.y.push_back(100.0 * counts[bin] / all);
    }
    curve.series.push_back(std::move(series));
  }
  return curve;
}

// Figure 5.15.
Curve discharge(const std::vector<ShapeRuns>& beds) {
  Curve curve{.id = "shape-discharge",
              .caption = "Grains that have left against time, first bed of each aspect ratio.",
              .x_title = "Time since the opening (s)",
              .y_title = "Discharged (%)"};
  for (const ShapeRuns& of : beds) {
    curve.series.push_back({.name = "aspect ratio " + of.label,
                            .x = numbers(of.runs.front(), "time"),
                            .y = numbers(of.runs.front(), "percent"),
                            .is_ours = true,
                            .is_line = true});
  }
  return curve;
}

// Figure 5.14.
Curve energy_ratios(const std::vector<ShapeRuns>& beds) {
  Curve curve = by_ratio("shape-energy",
                         "Energy of rotation over that of translation (5.2) in the three thirds of "
                         "the hopper, first bed.",
                         "Time since the opening (s)",
                         "Energy ratio");
  curve.log_y = true;
  for (const ShapeRuns& of : beds) {
    const Json& run = of.runs.front();
    for (const char* third : {"left", "centre", "right"}) {
      Numbers time = numbers(run, "time"), ratio;
      for (const Json& value : run.at("energy_ratios_in_time").at(third))
        ratio.push_back(value.is_number() ? value.get<double>() : no_number);
      // At rest both energies are next to nothing
      time.erase(time.begin());
      ratio.erase(ratio.begin());
      curve.series.push_back({.name = third,
                              .x = time,
                              .y = ratio,
                              .is_ours = true,
                              .is_line = true,
                              .choice = of.label});
    }
  }
  return curve;
}

// Figures 5.11 to 5.13: what marked grains do.
Curve of_marked(const std::vector<ShapeRuns>& beds, const char* x, const char* y, Curve curve) {
  constexpr std::array heights = {"low", "middle", "high"};
  constexpr std::array sides = {"left", "centre", "right"};
  for (const ShapeRuns& of : beds) {
    const Json& marked = of.runs.front().at("marked");
    for (std::size_t grain = 0; grain < marked.size(); ++grain) {
      const bool has_words = marked.size() == heights.size() * sides.size();
      curve.series.push_back(
          {.name = has_words ? fmt::format("{} {}", heights[grain / 3], sides[grain % 3])
                             : fmt::format("grain {}", grain + 1),
           .x = numbers(marked[grain], x),
           .y = numbers(marked[grain], y),
           .is_ours = true,
           .is_line = true,
           .choice = of.label});
    }
  }
  return curve;
}

// Figure 5.18.
Curve classes_of_speed(const ThesisData& thesis, const std::vector<ShapeRuns>& beds) {
  const double slow = thesis.number("ch5_scalars", "velocity_class_slow");
  const double fast = thesis.number("ch5_scalars", "velocity_class_fast");
  Curve curve = by_ratio(
      "shape-bands",
      fmt::format("Where bands of shear are looked for: grains in the lower part of the hopper by "
                  "their share of the largest speed there, {} s after the opening, first bed.",
                  thesis.setting("shape", "band_to")),
      "x (m)",
      "z (m)");
  curve.is_picture = true;
  const std::array names = {fmt::format("below {} %", slow),
                            fmt::format("{} to {} %", slow, fast),
                            fmt::format("above {} %", fast)};
  for (const ShapeRuns& of : beds) {
    const Json& grains = of.runs.front().at("speed_classes");
    if (grains.empty()) continue;
    std::array<Series, 3> series;
    for (std::size_t i = 0; i < grains.at("x").size(); ++i) {
      Series& one = series[grains.at("class")[i].get<std::size_t>()];
      one.x.push_back(grains.at("x")[i].get<double>());
      one.y.push_back(grains.at("z")[i].get<double>());
    }
    for (std::size_t i = 0; i < series.size(); ++i) {
      series[i].name = names[i];
      series[i].is_ours = true;
      series[i].choice = of.label;
      curve.series.push_back(std::move(series[i]));
    }
  }
  return curve;
}

// Figure 5.20.
Curve wall_forces(const std::vector<ShapeRuns>& beds) {
  Curve curve{.id = "shape-wall-force",
              .caption =
                  "Normal force on a side wall by tenths of the height of the bed, just "
                  "after the opening; mean over beds and both walls.",
              .x_title = "Height (tenths)",
              .y_title = "Force on a tenth (N)"};
  for (const ShapeRuns& of : beds) {
    Numbers tenths, force;
    for (const Json& run : of.runs) {
      const Numbers of_run = numbers(run, "wall_strips");
      force.resize(of_run.size());
      for (std::size_t strip = 0; strip < of_run.size(); ++strip)
        force[strip] += of_run[strip] / static_cast<double>(of.runs.size());
    }
    for (std::size_t strip = 0; strip < force.size(); ++strip)
      tenths.push_back(static_cast<double>(strip) + 0.5);
    curve.series.push_back({.name = "aspect ratio " + of.label,
                            .x = tenths,
                            .y = force,
                            .is_ours = true,
                            .is_line = true});
  }
  return curve;
}

// Figure 5.19.
Curve wall_histories(const std::vector<ShapeRuns>& beds) {
  Curve curve = by_ratio("shape-wall-history",
                         "Normal force on every other tenth of the left wall from the opening on, "
                         "first bed; tenth 1 is the lowest.",
                         "Time since the opening (s)",
                         "Force on a tenth (N)");
  for (const ShapeRuns& of : beds) {
    const Json& history = of.runs.front().at("wall_history");
    for (std::size_t tenth = 0; tenth < history.at("tenths").size(); tenth += 2) {
      curve.series.push_back({.name = fmt::format("tenth {}", tenth + 1),
                              .x = numbers(history, "time"),
                              .y = history.at("tenths")[tenth].get<Numbers>(),
                              .is_ours = true,
                              .is_line = true,
                              .choice = of.label});
    }
  }
  return curve;
}

}  // namespace

void draw_beds(Examination& exam, const ThesisData& thesis, const std::vector<ShapeRuns>& beds) {
  exam.add_curve(map_of_squares(
      beds,
      "squares",
      "shape-map",
      "Solid fraction at rest in squares of 10 cm that hold a grain's centre, first bed."));
  exam.add_curve(frequency(thesis, beds));
  exam.add_curve(averages(beds,
                          "fraction",
                          "shape-fraction",
                          "Solid fraction of the lower nine tenths of the bed at rest.",
                          "Solid fraction"));
  exam.add_curve(averages(beds,
                          "coordination",
                          "shape-coordination",
                          "Coordination number at rest; contacts of two particles count once.",
                          "Coordination number"));
  exam.add_curve(
      map_of_squares(beds,
                     "squares_running",
                     "shape-map-running",
                     "Solid fraction in the same squares in the middle of the straight part of "
                     "the discharge, first bed."));
  Curve paths =
      by_ratio("shape-paths", "Paths of nine marked grains, first bed.", "x (m)", "z (m)");
  paths.is_picture = true;
  exam.add_curve(of_marked(beds, "x", "z", std::move(paths)));
  exam.add_curve(of_marked(beds,
                           "time",
                           "turned",
                           by_ratio("shape-turns",
                                    "How far the marked grains have turned since rest.",
                                    "Time since the opening (s)",
                                    "Turned (°)")));
  exam.add_curve(of_marked(beds,
                           "time",
                           "sideways",
                           by_ratio("shape-sideways",
                                    "Sideways speed of the marked grains, to the right positive.",
                                    "Time since the opening (s)",
                                    "Sideways speed (m/s)")));
  exam.add_curve(energy_ratios(beds));
  exam.add_curve(discharge(beds));
  exam.add_curve(classes_of_speed(thesis, beds));
  exam.add_curve(wall_forces(beds));
  exam.add_curve(wall_histories(beds));
}

}  // namespace graintruth::app
