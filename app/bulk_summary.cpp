#include "app/bulk_summary.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "calibrate/bin_result_files.h"

namespace graintruth::app {

namespace {

std::string words_on(const calibrate::FilmedBin& film) {
  const calibrate::Discharge& discharge = film.measured.discharge;
  const auto steady = calibrate::steady_rate(discharge, film.rig);
  const calibrate::Arching arching = calibrate::find_arching(discharge, film.rig);
  std::string words =
      fmt::format("{}: {} of {} left", film.name, discharge.times.size(), discharge.particles);
  words += steady ? fmt::format(", {:.2f} +- {:.2f} g/s from {:.2f} to {:.2f} s",
                                1e3 * steady->rate,
                                1e3 * steady->standard_error,
                                steady->from,
                                steady->to)
                  : std::string(", no steady stretch: no rate");
  if (!arching.pauses.empty()) words += fmt::format(", {} pauses", arching.pauses.size());
  if (arching.jammed) words += ", jammed";
  if (film.measured.of_tracks)
    words += fmt::format(", solid fraction {:.3f} at rest", film.measured.at_rest.solid_fraction);
  return words + "\n";
}

std::string words_on(const calibrate::BinFits& fits) {
  std::string words;
  const double diameter = fits.particle_diameter;
  if (const auto& fit = fits.beverloo) {
    words += fmt::format(
        "Beverloo (joint fit, {} orifices): C {:.3f} +- {:.3f}, k {:.3f} +- {:.3f} (95 %), d = "
        "{:.2f} mm\n",
        fits.orifices.size(),
        fit->parameters[0],
        fit->half_width_95(0),
        fit->parameters[1],
        fit->half_width_95(1),
        1e3 * diameter);
  }
  for (const calibrate::OrificeFlow& flow : fits.orifices) {
    if (!flow.kinematic) continue;
    const double upper = flow.kinematic->upper / diameter;
    const bool balances = std::abs(flow.flux_over_rate - 1.0) <= 0.1;
    words += fmt::format(
        "Orifice {:.0f} mm: B {:.2f} d ({:.2f} to {}), at {:.0f} mm; v rho W over the rate "
        "{:.2f}{}\n",
        1e3 * flow.orifice,
        flow.kinematic->B / diameter,
        flow.kinematic->lower / diameter,
        std::isfinite(upper) ? fmt::format("{:.2f}", upper) : std::string("not bounded"),
        1e3 * flow.height,
        flow.flux_over_rate,
        balances ? "" : " (should be 1: distrust this profile)");
  }
  return words;
}

}  // namespace

bool runs_out(const datasets::Experiment& experiment) { return experiment.rig.bin.has_value(); }

bool measures_flow(const datasets::Experiment& experiment) {
  return runs_out(experiment) && experiment.particle.plate;
}

BinFilms measurable_films(const datasets::Experiment& experiment,
                          const TrackedFilms& films,
                          const datasets::RunFolder& folder) {
  const auto tracking = nlohmann::json::parse(datasets::read_whole(folder.tracking()));
  BinFilms measurable{.experiment = experiment};
  measurable.experiment.replicates.clear();
  for (std::size_t i = 0; i < experiment.replicates.size(); ++i) {
    const datasets::Replicate& replicate = experiment.replicates[i];
    bool smeared = false;
    for (const auto& film : tracking["replicates"]) {
      if (film["name"] != replicate.name || !film.contains("bed")) continue;
      const auto& bed = film["bed"];
      smeared = bed["discharged"].get<int>() + bed["remaining"].get<int>() == 0;
    }
    if (smeared) {
      measurable.left_out.push_back(replicate.name);
      continue;
    }
    measurable.experiment.replicates.push_back(replicate);
    measurable.records.push_back({films.tracks[i], films.curves[i]});
  }
  return measurable;
}

std::string write_bulk_measurements(const BinFilms& films, const datasets::RunFolder& folder) {
  std::vector<calibrate::FilmedBin> measured;
  for (std::size_t i = 0; i < films.records.size(); ++i) {
    const datasets::Replicate& replicate = films.experiment.replicates[i];
    measured.push_back(
        {.name = replicate.name,
         .rig = calibrate::bulk_rig(films.experiment, replicate),
         .measured = calibrate::measure_bin(films.records[i], films.experiment, replicate)});
  }
  const calibrate::BinFits fits = calibrate::fit_bins(measured, films.experiment.rig.gravity);
  calibrate::write_bin_measurements(folder, films.experiment, measured, films.records, fits);
  std::string words;
  for (const calibrate::FilmedBin& film : measured) words += words_on(film);
  return words + words_on(fits);
}

std::string words_on(const calibrate::BinScore& score) {
  std::string words;
  for (const calibrate::OrificeComparison& row : score.orifices) {
    if (std::isnan(row.error())) {
      words += fmt::format(
          "Orifice {:4.0f} mm{:12} {} of {} films and {} of {} simulations jammed: no rates to "
          "compare\n",
          1e3 * row.orifice,
          row.held_out ? ", held out" : "",
          row.filmed_jams.happened,
          row.filmed_jams.runs,
          row.simulated_jams.happened,
          row.simulated_jams.runs);
      continue;
    }
    words += fmt::format(
        "Orifice {:4.0f} mm{:12} {:7.2f} g/s filmed, {:7.2f} simulated: E {:+6.2f}, u_val {:5.2f} "
        "g/s; curve inside the films' band {:3.0f} % of the time\n",
        1e3 * row.orifice,
        row.held_out ? ", held out" : "",
        1e3 * row.filmed,
        1e3 * row.simulated,
        1e3 * row.error(),
        1e3 * row.validation_uncertainty(),
        100.0 * row.curve_inside);
  }
  return words;
}

}  // namespace graintruth::app
