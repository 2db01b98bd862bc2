#include "calibrate/bin_result_files.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "calibrate/result_json.h"
#include "datasets/table.h"

namespace graintruth::calibrate {

namespace {

using datasets::number_text;
using datasets::Table;

Json film_json(const FilmedBin& film) {
  const BinMeasurement& measured = film.measured;
  const auto steady = steady_rate(measured.discharge, film.rig);
  const Arching arching = find_arching(measured.discharge, film.rig);
  Json json = {{"name", film.name},
               {"orifice_m", film.rig.orifice},
               {"particles", measured.discharge.particles},
               {"discharged", measured.discharge.times.size()}};
  if (measured.of_tracks) {
    json["jammed"] = arching.jammed;
    json["solid_fraction_at_rest"] = measured.at_rest.solid_fraction;
    json["areal_density_at_rest_kg_per_m2"] = measured.at_rest.areal_density;
  }
  for (const Pause& pause : arching.pauses)
    json["pauses"].push_back({{"from_s", pause.from}, {"to_s", pause.to}});
  if (!steady) return json;
  json["steady"] = {{"from_s", steady->from},
                    {"to_s", steady->to},
                    {"particles", steady->particles},
                    {"rate_kg_per_s", steady->rate},
                    {"rate_standard_error_kg_per_s", steady->standard_error}};
  if (measured.of_tracks) json["steady"]["areal_density_kg_per_m2"] = measured.flowing_density;
  return json;
}

void write_tables(std::span<const FilmedBin> films,
                  std::span<const BinRecord> records,
                  const datasets::RunFolder& folder) {
  Table curves({"replicate", "orifice_m", "time_s", "discharged_count", "discharged_mass_kg"});
  Table rates({"replicate",
               "orifice_m",
               "flow_rate_kg_per_s",
               "flow_rate_standard_uncertainty_kg_per_s",
               "areal_density_kg_per_m2",
               "particle_diameter_m",
               "steady_from_s",
               "steady_to_s",
               "pauses",
               "jammed"});
  Table profiles({"replicate",
                  "orifice_m",
                  "height_m",
                  "x_m",
                  "velocity_m_per_s",
                  "velocity_standard_uncertainty_m_per_s"});
  for (std::size_t i = 0; i < films.size(); ++i) {
    const FilmedBin& one = films[i];
    const auto steady = steady_rate(one.measured.discharge, one.rig);
    const Arching arching = find_arching(one.measured.discharge, one.rig);
    const std::string orifice = number_text(one.rig.orifice);
    const BinRecord& record = records[i];
    for (const double time : record.curve ? record.curve->time : record.tracks.time) {
      const int count = discharged_by(one.measured.discharge, time);
      curves.add({one.name,
                  orifice,
                  number_text(time),
                  std::to_string(count),
                  number_text(count * one.rig.particle_mass)});
    }
    if (steady) {
      rates.add({one.name,
                 orifice,
                 number_text(steady->rate),
                 number_text(steady->standard_error),
                 one.measured.of_tracks ? number_text(one.measured.flowing_density) : "",
                 number_text(one.rig.particle_diameter),
                 number_text(steady->from),
                 number_text(steady->to),
                 std::to_string(arching.pauses.size()),
                 !one.measured.of_tracks ? ""
                 : arching.jammed        ? "yes"
                                         : "no"});
    }
    for (const VelocitySample& sample : one.measured.profile.samples)
      profiles.add({one.name,
                    orifice,
                    number_text(one.measured.profile.height),
                    number_text(sample.x),
                    number_text(sample.velocity),
                    number_text(sample.standard_uncertainty)});
  }
  datasets::write_csv(folder.table("discharge"), curves);
  datasets::write_csv(folder.table("flow_rates"), rates);
  datasets::write_csv(folder.table("velocity_profiles"), profiles);
}

// Rates of the orifices, Beverloo and B of one set of runs.
Json flow_json(const OrificeFlow& flow) {
  return {{"orifice_m", flow.orifice},
          {"rate_kg_per_s", flow.rate},
          {"lower", flow.rate - flow.half_width},
          {"upper", flow.rate + flow.half_width},
          {"runs", flow.runs}};
}

Json beverloo_json(const BinFits& fits) {
  const LeastSquaresFit& fit = *fits.beverloo;
  return {{"C", fit.parameters[0]},
          {"k", fit.parameters[1]},
          {"covariance",
           {{fit.covariance(0, 0), fit.covariance(0, 1)},
            {fit.covariance(1, 0), fit.covariance(1, 1)}}},
          {"form", "joint"}};
}

Json kinematic_json(const OrificeFlow& flow, double diameter) {
  const KinematicFit& fit = *flow.kinematic;
  return {{"orifice_m", flow.orifice},
          {"height_m", flow.height},
          {"B_over_d", fit.B / diameter},
          {"lower", fit.lower / diameter},
          {"upper", std::isfinite(fit.upper) ? Json(fit.upper / diameter) : Json()},
          {"flux_over_rate", flow.flux_over_rate}};
}

// What fits say, appended to what `json` holds of other sources.
void add_fits(const BinFits& fits, const char* source, Json& json) {
  for (const OrificeFlow& flow : fits.orifices) {
    Json entry = flow_json(flow);
    entry["source"] = source;
    json["discharge"].push_back(entry);
    if (!flow.kinematic) continue;
    entry = kinematic_json(flow, fits.particle_diameter);
    entry["source"] = source;
    json["kinematic"].push_back(entry);
  }
  if (fits.beverloo) json["beverloo"][source] = beverloo_json(fits);
}

Json probability_json(const Probability& probability) {
  return {{"jams", probability.happened},
          {"runs", probability.runs},
          {"lower", probability.lower},
          {"upper", probability.upper}};
}

Json comparison_json(const OrificeComparison& row) {
  return {{"orifice_m", row.orifice},
          {"held_out", row.held_out},
          {"filmed_kg_per_s", row.filmed},
          {"simulated_kg_per_s", row.simulated},
          {"error_kg_per_s", row.error()},
          {"validation_uncertainty_kg_per_s", row.validation_uncertainty()},
          {"film_uncertainty_kg_per_s", row.film_error},
          {"run_uncertainty_kg_per_s", row.run_error},
          {"input_uncertainty_kg_per_s", row.input_error},
          {"numerical_uncertainty_kg_per_s", row.numerical_error},
          {"filmed_jams", probability_json(row.filmed_jams)},
          {"simulated_jams", probability_json(row.simulated_jams)},
          {"curve_inside", row.curve_inside},
          {"stagnant_overlap", row.stagnant_overlap}};
}

void write_curves(const datasets::RunFolder& folder, const BinScore& result) {
  Table table({"orifice_m",
               "time_s",
               "filmed_count",
               "filmed_lower",
               "filmed_upper",
               "simulated_count",
               "simulated_lower",
               "simulated_upper"});
  for (std::size_t i = 0; i < result.curves.size(); ++i) {
    for (const BinCurvePoint& point : result.curves[i]) {
      table.add({number_text(result.orifices[i].orifice),
                 number_text(point.time),
                 number_text(point.filmed),
                 number_text(point.lower),
                 number_text(point.upper),
                 number_text(point.simulated),
                 number_text(point.simulated_lower),
                 number_text(point.simulated_upper)});
    }
  }
  datasets::write_csv(folder.table("discharge_curves"), table);
}

// Of each orifice: velocities of films and of simulations, mean over runs, bin by bin.
void write_profile_comparison(const datasets::RunFolder& folder,
                              const BinProblem& problem,
                              const BinScore& result) {
  Table table({"orifice_m", "x_m", "source", "velocity_m_per_s", "lowest", "highest"});
  const std::vector<SimulatedRun>& runs = result.evaluation.runs;
  const std::size_t seeds = runs.size() / problem.starts.size();
  for (const OrificeMean& orifice : problem.all->orifices()) {
    const BulkRig& rig = problem.all->films()[orifice.films.front()].rig;
    const std::size_t bins = profile_bins(rig);
    for (const bool simulated : {false, true}) {
      std::vector<std::vector<double>> velocities(bins);
      for (const std::size_t film : orifice.films) {
        for (std::size_t seed = 0; seed < (simulated ? seeds : 1); ++seed) {
          const BinMeasurement& measured =
              simulated ? runs[film * seeds + seed].bin : problem.all->films()[film].measured;
          const BinNumbers numbers = numbers_of(measured, rig);
          for (std::size_t bin = 0; bin < bins; ++bin) {
            if (!std::isnan(numbers.velocity[bin]))
              velocities[bin].push_back(numbers.velocity[bin]);
          }
        }
      }
      for (std::size_t bin = 0; bin < bins; ++bin) {
        const std::vector<double>& of_bin = velocities[bin];
        if (of_bin.empty()) continue;
        double mean = 0.0;
        for (const double velocity : of_bin) mean += velocity / static_cast<double>(of_bin.size());
        table.add(
            {number_text(orifice.orifice),
             number_text(((static_cast<double>(bin) + 0.5) / static_cast<double>(bins) - 0.5) *
                         rig.width),
             simulated ? "simulation" : "experiment",
             number_text(mean),
             number_text(*std::min_element(of_bin.begin(), of_bin.end())),
             number_text(*std::max_element(of_bin.begin(), of_bin.end()))});
      }
    }
  }
  datasets::write_csv(folder.table("velocity_comparison"), table);
}

// Of each orifice: up to where the bed stands still beside the flow, mean over films and runs.
void write_boundaries(const datasets::RunFolder& folder,
                      const BinProblem& problem,
                      const BinScore& result) {
  Table table({"orifice_m", "x_m", "filmed_height_m", "simulated_height_m"});
  for (const OrificeComparison& row : result.orifices) {
    const std::size_t columns = std::min(row.filmed_stagnant.size(), row.simulated_stagnant.size());
    const double width = problem.all->films().front().rig.width;
    for (std::size_t column = 0; column < columns; ++column) {
      const double share = (static_cast<double>(column) + 0.5) / static_cast<double>(columns);
      table.add({number_text(row.orifice),
                 number_text((share - 0.5) * width),
                 number_text(row.filmed_stagnant[column]),
                 number_text(row.simulated_stagnant[column])});
    }
  }
  datasets::write_csv(folder.table("stagnant_boundary"), table);
}

void write_rates(const datasets::RunFolder& folder, const BinScore& result) {
  Table table({"orifice_m",
               "held_out",
               "filmed_kg_per_s",
               "simulated_kg_per_s",
               "error_kg_per_s",
               "validation_uncertainty_kg_per_s",
               "curve_inside"});
  for (const OrificeComparison& row : result.orifices) {
    table.add({number_text(row.orifice),
               row.held_out ? "1" : "0",
               number_text(row.filmed),
               number_text(row.simulated),
               number_text(row.error()),
               number_text(row.validation_uncertainty()),
               number_text(row.curve_inside)});
  }
  datasets::write_csv(folder.table("rate_comparison"), table);
}

}  // namespace

void write_bin_measurements(const datasets::RunFolder& folder,
                            const datasets::Experiment& experiment,
                            std::span<const FilmedBin> films,
                            std::span<const BinRecord> records,
                            const BinFits& fits) {
  write_tables(films, records, folder);
  Json json;
  json["experiment"] = experiment.name;
  if (!experiment.note.empty()) json["note"] = experiment.note;
  for (const FilmedBin& film : films) json["replicates"].push_back(film_json(film));
  for (const OrificeFlow& flow : fits.orifices) json["discharge"].push_back(flow_json(flow));
  if (fits.beverloo) json["beverloo"] = beverloo_json(fits);
  for (const OrificeFlow& flow : fits.orifices) {
    if (flow.kinematic) json["kinematic"].push_back(kinematic_json(flow, fits.particle_diameter));
  }
  write_json(folder.measured(), json);
}

namespace {

// Tables, and what result.json says of the comparison.
void write_bin_score(const datasets::RunFolder& folder,
                     const BinProblem& problem,
                     const BinScore& score,
                     Json& json) {
  write_curves(folder, score);
  write_profile_comparison(folder, problem, score);
  write_boundaries(folder, problem, score);
  write_rates(folder, score);
  json["objective"]["best"] = problem.calibrated->objective(score.calibrated_runs);
  for (const auto& [kind, value] : score.shares)
    json["objective"]["shares"][std::string(kind)] = value;
  const BinScatter& scatter = problem.calibrated->scatter();
  json["replicate_scatter"] = {{"relative_rate", scatter.relative_rate},
                               {"remaining_particles", scatter.remaining},
                               {"relative_velocity", scatter.relative_velocity},
                               {"degrees_of_freedom", scatter.freedom}};
  json["simulated_elastic_modulus_pa"] = score.simulated_modulus;
  json["mean_signed_error"] = score.mean_signed_error;
  for (const OrificeComparison& row : score.orifices)
    json["comparison"].push_back(comparison_json(row));
  add_fits(score.filmed, "experiment", json);
  add_fits(score.simulated, "simulation", json);
}

}  // namespace

void write_bin_calibration(const datasets::RunFolder& folder,
                           const BinProblem& problem,
                           const CalibrationOptions& options,
                           const BinCalibrationResult& result,
                           double wall_time) {
  write_evaluations(folder.table("evaluations"), result.evaluations, {});
  write_profiles(folder, result);
  Json json = head_json(problem.experiment, "bin_calibration");
  add_search(result, options, json);
  write_bin_score(folder, problem, result.score, json);
  json["wall_time_s"] = wall_time;
  write_json(folder.result(), json);
}

void write_bin_validation(const datasets::RunFolder& folder,
                          const BinProblem& problem,
                          const BinValidationResult& result,
                          double wall_time) {
  Json json = head_json(problem.experiment, "bin_validation");
  add_given_parameters(problem.experiment, result.parameters, json);
  json["time_step"] = {{"fraction", result.time_step_fraction},
                       {"seconds", result.score.evaluation.runs.front().time_step},
                       {"discretisation_error", nullptr}};
  write_bin_score(folder, problem, result.score, json);
  json["objective"]["noise"] = problem.calibrated->noise(result.score.calibrated_runs);
  json["evaluations"] = 1;
  json["simulations"] = result.score.evaluation.runs.size();
  json["failed"] = result.score.evaluation.failed;
  json["wall_time_s"] = wall_time;
  json["warnings"] = result.warnings;
  write_json(folder.result(), json);
}

}  // namespace graintruth::calibrate
