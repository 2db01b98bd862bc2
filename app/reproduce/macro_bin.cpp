// Section 4.3 simulated again: 200 buttons through five orifices, filled with and without friction.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/data_folder.h"
#include "app/interrupt.h"
#include "app/reproduce/button.h"
#include "app/reproduce/targets.h"
#include "app/scene_files.h"
#include "app/scene_run.h"
#include "calibrate/beverloo.h"
#include "calibrate/bulk_measure.h"
#include "calibrate/ensemble.h"
#include "datasets/run_folder.h"

namespace graintruth::app {

namespace {

using Json = Studies::Json;

const std::string properties = "table_4_3_macro_properties";
const std::string experiment = "table_4_4_beverloo_experiment";
const std::string simulation = "table_4_5_beverloo_simulation";

std::filesystem::path scene_of_bin() { return data_folder() / "scenes" / "macro_bin.toml"; }

// The bundled bin with another orifice, and without friction while it fills where so asked.
datasets::SceneFile bin_with(double orifice, bool frictionless, double duration) {
  datasets::SceneFile file = datasets::load_scene(scene_of_bin());
  for (datasets::SceneWall& wall : file.walls) {
    if (wall.name == "floor_left") wall.points[1].x() = -0.5 * orifice;
    if (wall.name == "floor_right") wall.points[0].x() = 0.5 * orifice;
    if (wall.name != "orifice_panel") continue;
    wall.points[0].x() = -0.5 * orifice;
    wall.points[1].x() = 0.5 * orifice;
  }
  if (frictionless) {
    file.phases.front().friction_between_particles = 0.0;
    file.phases.front().friction_with_walls = 0.0;
  }
  file.phases.back().duration = duration;
  return file;
}

struct Emptied {
  double rate = no_number;      // kg/s
  double density = no_number;   // kg/m2, of the bed in the steady stretch
  double fraction = no_number;  // solid fraction at rest
  int pauses = 0;
  bool completed = false;
};

Emptied empty_bin(const datasets::SceneFile& file,
                  const calibrate::BulkRig& rig,
                  std::uint64_t seed) {
  const SceneRun run = run_scene(file, {.seed = seed, .stop = is_interrupted});
  Emptied result;
  result.completed = run.status == sim::RunStatus::completed && run.reached_event;
  if (!result.completed) return result;
  const datasets::Trajectories tracks = planar_tracks(run);
  const calibrate::BinMeasurement bin = calibrate::measure_bin(tracks, rig);
  result.fraction = bin.at_rest.solid_fraction;
  result.pauses = static_cast<int>(calibrate::find_arching(bin.discharge, rig).pauses.size());
  const auto steady = calibrate::steady_rate(bin.discharge, rig);
  if (!steady) return result;
  result.rate = steady->rate;
  result.density = bin.flowing_density;
  return result;
}

// The finite ones of a quantity over the seeds.
std::vector<double> values_of(const Json& runs, const char* key) {
  std::vector<double> values;
  for (const Json& run : runs) {
    if (run.at(key).is_number()) values.push_back(run.at(key).get<double>());
  }
  return values;
}

Json run_bin(const ThesisData& thesis, Studies& studies, double orifice, bool frictionless) {
  const Ellipse ellipse = button_ellipse(thesis);
  const double diameter = button_diameter(thesis);
  const calibrate::BulkRig rig{.width = thesis.si(properties, "hopper_width"),
                               .orifice = orifice,
                               .particle_area = std::numbers::pi * ellipse.along * ellipse.across,
                               .particle_diameter = diameter,
                               .particle_mass = thesis.si(properties, "mass")};
  const datasets::SceneFile file =
      bin_with(orifice, frictionless, thesis.setting("macro", "duration"));
  const int seeds = thesis.count("macro", "seeds");
  const auto drawn = calibrate::make_seeds(studies.seed(), "macro", seeds);
  std::vector<Emptied> found(drawn.size());
  studies.in_parallel(seeds, [&](int i) {
    const auto which = static_cast<std::size_t>(i);
    found[which] = empty_bin(file, rig, drawn[which]);
  });
  Json runs = Json::array();
  for (const Emptied& one : found) {
    runs.push_back({{"rate", one.rate},
                    {"density", one.density},
                    {"fraction", one.fraction},
                    {"pauses", one.pauses},
                    {"completed", one.completed}});
  }
  return runs;
}

// All orifices with one way of filling.
std::vector<Json> run_bins(const ThesisData& thesis, Studies& studies, bool frictionless) {
  const datasets::Table& table = thesis.table(experiment);
  const std::string inputs =
      thesis.settings_text("macro") + " " + datasets::file_hash(scene_of_bin());
  std::vector<Json> all;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string orifice = table.text(row, "orifice_D_cm");
    const std::string name =
        fmt::format("study-macro-{}-{}cm", frictionless ? "frictionless" : "friction", orifice);
    const double width = table.number(row, "orifice_D_cm") * unit_in_si("cm");
    all.push_back(studies.result(
        name, inputs, [&] { return run_bin(thesis, studies, width, frictionless); }));
  }
  return all;
}

Simulated in_grams(const std::vector<double>& rates) {
  if (rates.empty()) return {};
  Simulated simulated = over_seeds(rates);
  simulated.mean /= unit_in_si("g");
  simulated.spread /= unit_in_si("g");
  return simulated;
}

void examine_rates(Examination& exam,
                   const ThesisData& thesis,
                   const std::vector<Json>& runs,
                   const std::string& filling) {
  const datasets::Table& table = thesis.table(experiment);
  const double tolerance = thesis.setting("macro", "rate_tolerance");
  const double wide = thesis.worded("fig-4.17", "narrowest orifice without arches").value();
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double orifice = table.number(row, "orifice_D_cm");
    const Printed measured = thesis.cell(experiment, row, "flow_rate_q_g_per_s", "g/s");
    const Simulated rate = in_grams(values_of(runs[row], "rate"));
    double pauses = 0.0;
    for (const double count : values_of(runs[row], "pauses")) pauses += count;
    const std::string note = fmt::format(
        "the thesis simulated {} g/s; {} pauses in {} discharges, {} with a steady rate",
        thesis.table(simulation).text(row, "flow_rate_q_g_per_s"),
        pauses,
        runs[row].size(),
        values_of(runs[row], "rate").size());
    const std::string where =
        fmt::format("{}, D = {} cm: rate of the experiment", filling, orifice);
    if (orifice >= wide) {
      exam.claim_value(where, measured, rate, tolerance * measured.value(), note);
    } else {
      exam.claim(
          fmt::format("{}, D = {} cm: simulation slower than the experiment", filling, orifice),
          measured,
          rate,
          no_number,
          rate.mean < measured.value(),
          note);
    }
  }
}

// C and k of our rates, fitted together; densities are those of our flowing beds.
std::string fit_sentence(const ThesisData& thesis,
                         const std::vector<Json>& runs,
                         const std::string& filling) {
  const datasets::Table& table = thesis.table(experiment);
  std::vector<calibrate::DischargeRate> rates;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::vector<double> found = values_of(runs[row], "rate");
    if (found.size() < 2) continue;
    const Simulated rate = over_seeds(found);
    rates.push_back({.orifice = table.number(row, "orifice_D_cm") * unit_in_si("cm"),
                     .rate = rate.mean,
                     .density = over_seeds(values_of(runs[row], "density")).mean,
                     .particle_diameter = button_diameter(thesis),
                     .standard_uncertainty = rate.spread / std::sqrt(rate.seeds)});
  }
  if (rates.size() < 3) return filling + ": too few steady rates for a fit of C and k.";
  const auto fit = calibrate::fit_beverloo(calibrate::BeverlooLaw::slot, rates, 9.81);
  const auto line = calibrate::fit_beverloo_line(calibrate::BeverlooLaw::slot, rates);
  return fmt::format(
      "{}: C and k fitted together to our rates: C = {:.3f} ± {:.3f}, k = {:.2f} ± {:.2f} (95 "
      "%); "
      "k of the straight line {:.2f}.",
      filling,
      fit.parameters[0],
      fit.half_width_95(0),
      fit.parameters[1],
      fit.half_width_95(1),
      line.zero / button_diameter(thesis));
}

Series series_of(const ThesisData& thesis, const std::vector<Json>& runs, const std::string& name) {
  Series series{.name = name, .is_ours = true};
  for (std::size_t row = 0; row < runs.size(); ++row) {
    const Simulated rate = in_grams(values_of(runs[row], "rate"));
    series.x.push_back(thesis.table(experiment).number(row, "orifice_D_cm"));
    series.y.push_back(rate.mean);
    series.spread.push_back(rate.spread);
  }
  return series;
}

}  // namespace

void simulate_macro(Examination& exam, const ThesisData& thesis, Studies& studies) {
  const std::vector<Json> loose = run_bins(thesis, studies, false);
  const std::vector<Json> dense = run_bins(thesis, studies, true);

  // 1. Solid fraction at rest, over all orifices: the bed does not know of them yet
  const auto fractions = [](const std::vector<Json>& runs) {
    std::vector<double> values;
    for (const Json& of_orifice : runs) {
      for (const double value : values_of(of_orifice, "fraction")) values.push_back(value);
    }
    return over_seeds(values);
  };
  const double tolerance = thesis.setting("macro", "fraction_tolerance");
  const std::string packing = "packing_and_flow";
  const Simulated with = fractions(loose), without = fractions(dense);
  exam.claim_value("solid fraction, filled with friction",
                   thesis.printed(packing, "solid_fraction_simulation_friction_filled"),
                   with,
                   tolerance);
  exam.claim_value("solid fraction, filled without friction",
                   thesis.printed(packing, "solid_fraction_simulation_frictionless_filled"),
                   without,
                   tolerance);
  exam.claim("a bed filled without friction is denser",
             {"denser", "-", "sec 4.3.2.1"},
             without,
             no_number,
             without.mean > with.mean + std::hypot(with.spread, without.spread),
             fmt::format("solid fraction; with friction {:.3f}", with.mean));

  // 2. Rates
  examine_rates(exam, thesis, loose, "friction");
  examine_rates(exam, thesis, dense, "frictionless");
  exam.add_note(fit_sentence(thesis, loose, "Filled with friction"));
  exam.add_note(fit_sentence(thesis, dense, "Filled without friction"));
  const auto orifices = thesis.table(experiment).numbers("orifice_D_cm");
  exam.add_curve(
      {.id = "macro-rates",
       .caption = "Flow rate against the orifice. Ours: mean and standard deviation over "
                  "fillings, at the thesis's friction of 0.2; nothing was tuned.",
       .x_title = "Orifice (cm)",
       .y_title = "Rate (g/s)",
       .series = {{"experiment", orifices, thesis.table(experiment).numbers("flow_rate_q_g_per_s")},
                  {"simulation of the thesis",
                   orifices,
                   thesis.table(simulation).numbers("flow_rate_q_g_per_s")},
                  series_of(thesis, loose, "simulated again, friction filling"),
                  series_of(thesis, dense, "simulated again, frictionless filling")}});
}

}  // namespace graintruth::app
