#include "calibrate/observables/flow_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/beta.hpp>
#include <cmath>
#include <limits>

#include "calibrate/compare/hypothesis_tests.h"
#include "calibrate/compare/pooled_rule.h"
#include "calibrate/flow/flow_fits.h"
#include "calibrate/observables/discharge.h"
#include "datasets/imports/stagnant.h"

namespace graintruth::calibrate {

namespace {

using datasets::number_text;
using datasets::Table;

// --- Runs as bulk measures see them
// ---------------------------------------------------------------

BulkRun run_of(const std::string& name,
               const Situation& situation,
               const Observables& observables,
               const std::vector<Channel>& channels) {
  return {name, bulk_rig(situation), bulk_from([&](std::string_view observable) {
            const auto place = observables.find(observable);
            return place ? &channels[*place] : nullptr;
          })};
}

std::vector<BulkRun> replicates_of(const Problem& problem) {
  std::vector<BulkRun> runs;
  for (const Condition& condition : problem.conditions) {
    for (const std::size_t r : condition.replicates) {
      runs.push_back(run_of(problem.experiment.replicates[r].name,
                            problem.situations[r],
                            *problem.observables,
                            problem.measured[r]));
    }
  }
  return runs;
}

// The completed runs of an evaluation of every scene.
std::vector<BulkRun> simulations_of(const Problem& problem, std::span<const SimulatedRun> runs) {
  const std::size_t seeds = runs.size() / problem.scenes.size();
  std::vector<BulkRun> all;
  for (std::size_t run = 0; run < runs.size(); ++run) {
    if (runs[run].status != RunStatus::completed) continue;
    const std::size_t replicate = problem.scenes[run / seeds].replicate;
    all.push_back(run_of(problem.experiment.replicates[replicate].name,
                         problem.situations[replicate],
                         *problem.observables,
                         runs[run].channels));
  }
  return all;
}

// The rates of all runs through one orifice that did not jam, kg/s; how often they jam is told
// apart.
std::vector<double> rates_of(const std::vector<BulkRun>& bins, double orifice) {
  std::vector<double> rates;
  for (const BulkRun& bin : bins) {
    if (bin.rig.orifice != orifice || find_arching(bin.measured.discharge, bin.rig).jammed)
      continue;
    rates.push_back(rate_of(bin.measured.discharge, bin.rig));
  }
  return rates;
}

// NaN where there is none: an orifice at which everything jammed has no rate.
double mean_of(const std::vector<double>& values) {
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : summarise(values).mean;
}

Probability jams_of(const std::vector<BulkRun>& bins, double orifice) {
  int jams = 0, runs = 0;
  for (const BulkRun& bin : bins) {
    // A discharge curve cannot tell.
    if (bin.rig.orifice != orifice || !bin.measured.of_tracks) continue;
    ++runs;
    jams += find_arching(bin.measured.discharge, bin.rig).jammed ? 1 : 0;
  }
  return probability_of(jams, runs);
}

// Stagnant heights, mean over the runs through one orifice that flowed steadily.
std::vector<double> mean_boundary(const std::vector<BulkRun>& bins, double orifice) {
  std::vector<double> sum;
  double runs = 0.0;
  for (const BulkRun& bin : bins) {
    const std::vector<double>& heights = bin.measured.stagnant_heights;
    if (bin.rig.orifice != orifice || heights.empty()) continue;
    sum.resize(heights.size(), 0.0);
    for (std::size_t column = 0; column < heights.size(); ++column) sum[column] += heights[column];
    ++runs;
  }
  for (double& height : sum) height /= runs;
  return sum;
}

// Mean, lowest and highest count of discharged particles.
struct Counts {
  double mean = 0.0, lowest = 0.0, highest = 0.0;
  int runs = 0;
};
Counts counts_at(const std::vector<BulkRun>& bins, double orifice, double time) {
  Counts counts;
  for (const BulkRun& bin : bins) {
    if (bin.rig.orifice != orifice) continue;
    const double count = discharged_by(bin.measured.discharge, time);
    counts.lowest = counts.runs == 0 ? count : std::min(counts.lowest, count);
    counts.highest = counts.runs == 0 ? count : std::max(counts.highest, count);
    counts.mean += count;
    ++counts.runs;
  }
  if (counts.runs > 0) counts.mean /= counts.runs;
  return counts;
}

// --- One orifice, experiment and simulation
// -------------------------------------------------------

struct OrificeComparison {
  double orifice = 0.0;  // m
  bool held_out = false;
  // Means over those that did not jam, kg/s; NaN where all did
  double filmed = 0.0;     // over replicates
  double simulated = 0.0;  // over fresh runs
  // Standard uncertainties, kg/s: scatter of replicates and of runs, what the parameters'
  // uncertainty does, and the change from half the time step.
  double film_error = 0.0;
  double run_error = 0.0;
  double input_error = 0.0;
  double numerical_error = 0.0;
  Probability filmed_jams, simulated_jams;
  // Share of the duration in which the mean simulated discharge curve lies where a further
  // replicate would with 95 %.
  double curve_inside = 0.0;
  // m, by columns half a particle diameter wide (see BulkMeasurement): what stands still while the
  // rest flows, mean over replicates and over fresh runs. Empty where none flowed steadily.
  std::vector<double> filmed_stagnant, simulated_stagnant;
  double stagnant_overlap = std::numeric_limits<double>::quiet_NaN();  // of the two areas, 0 to 1

  double error() const { return simulated - filmed; }
  double validation_uncertainty() const {
    return std::sqrt(film_error * film_error + run_error * run_error + input_error * input_error +
                     numerical_error * numerical_error);
  }
};

struct CurvePoint {
  double time = 0.0;                              // s
  double filmed = 0.0, lower = 0.0, upper = 0.0;  // particles; mean, and band of a further one
  double simulated = 0.0;                         // particles; mean
  double simulated_lower = 0.0, simulated_upper = 0.0;  // lowest and highest run
};

class FlowScorer {
 public:
  FlowScorer(const Problem& problem, const Confirmed& confirmed)
      : problem_(problem),
        rate_(static_cast<const PooledRule*>(problem.all->rule_of("discharge_rate"))),
        filmed_(replicates_of(problem)),
        simulated_(simulations_of(problem, confirmed.runs.runs)) {
    if (confirmed.halved) halved_ = simulations_of(problem, confirmed.halved->runs);
    for (const Evaluation& evaluation : confirmed.alternatives)
      inputs_.push_back(simulations_of(problem, evaluation.runs));
    for (const Condition& condition : problem_.conditions) compare(condition);
  }

  const std::vector<OrificeComparison>& rows() const { return rows_; }
  const std::vector<std::vector<CurvePoint>>& curves() const { return curves_; }
  const std::vector<BulkRun>& filmed() const { return filmed_; }
  const std::vector<BulkRun>& simulated() const { return simulated_; }

  // Mean of E/D over orifices that are not held out.
  double mean_signed_error() const {
    double sum = 0.0;
    int count = 0;
    for (const OrificeComparison& row : rows_) {
      if (row.held_out || !(row.filmed > 0.0) || std::isnan(row.error())) continue;
      sum += row.error() / row.filmed;
      ++count;
    }
    return sum / std::max(1, count);
  }

 private:
  int freedom() const { return rate_ ? rate_->freedom() : 0; }

  void compare(const Condition& condition) {
    const Situation& situation = problem_.situations[condition.replicates.front()];
    OrificeComparison row{.orifice = bulk_rig(situation).orifice, .held_out = condition.held_out};
    const std::vector<double> filmed_rates = rates_of(filmed_, row.orifice);
    row.filmed = mean_of(filmed_rates);
    row.film_error = (rate_ ? rate_->scatter().standard_deviation : 0.0) * row.filmed /
                     std::sqrt(static_cast<double>(filmed_rates.size()));
    const std::vector<double> rates = rates_of(simulated_, row.orifice);
    row.simulated = mean_of(rates);
    if (rates.size() > 1)
      row.run_error =
          summarise(rates).standard_deviation / std::sqrt(static_cast<double>(rates.size()));
    row.numerical_error = numerical_error() * row.simulated;
    // The scatter of single runs is in it too, which makes it rather too large than too small.
    std::vector<double> means;
    for (const std::vector<BulkRun>& input : inputs_) {
      const std::vector<double> of_input = rates_of(input, row.orifice);
      if (!of_input.empty()) means.push_back(mean_of(of_input));
    }
    if (means.size() > 1) row.input_error = summarise(means).standard_deviation;
    row.filmed_stagnant = mean_boundary(filmed_, row.orifice);
    row.simulated_stagnant = mean_boundary(simulated_, row.orifice);
    row.stagnant_overlap = datasets::stagnant_overlap(row.filmed_stagnant, row.simulated_stagnant);
    row.filmed_jams = jams_of(filmed_, row.orifice);
    row.simulated_jams = jams_of(simulated_, row.orifice);
    curves_.push_back(curve_of(row));
    rows_.push_back(row);
  }

  // Mean relative change of the rates of all orifices from the step to its half.
  double numerical_error() const {
    double change = 0.0;
    int orifices = 0;
    for (const Condition& condition : problem_.conditions) {
      const double orifice = bulk_rig(problem_.situations[condition.replicates.front()]).orifice;
      const double whole = mean_of(rates_of(simulated_, orifice));
      const double half = mean_of(rates_of(halved_, orifice));
      if (!(whole > 0.0 && half > 0.0)) continue;
      change += half / whole - 1.0;
      ++orifices;
    }
    return orifices == 0 ? 0.0 : std::abs(change) / orifices;
  }

  // Standard deviation of one replicate's count at a share of its duration, pooled over conditions.
  double scatter_of_counts(double share) const {
    double squares = 0.0;
    int freedom = 0;
    std::size_t next = 0;
    for (const Condition& condition : problem_.conditions) {
      std::vector<double> counts;
      for (std::size_t k = 0; k < condition.replicates.size(); ++k) {
        const Discharge& discharge = filmed_[next++].measured.discharge;
        counts.push_back(discharged_by(discharge, share * discharge.to));
      }
      if (counts.size() < 2) continue;
      const SampleSummary summary = summarise(counts);
      squares += std::pow(summary.standard_deviation, 2) * (summary.count - 1);
      freedom += summary.count - 1;
    }
    return freedom == 0 ? 0.0 : std::sqrt(squares / freedom);
  }

  // Counts at 100 moments, with the band of a further replicate: mean +- t s sqrt(1 + 1/n).
  std::vector<CurvePoint> curve_of(OrificeComparison& row) const {
    constexpr int moments = 100;
    double duration = 0.0;
    for (const BulkRun& run : filmed_) {
      if (run.rig.orifice == row.orifice) duration = std::max(duration, run.measured.discharge.to);
    }
    const double t = freedom() > 0 ? student_t_quantile(0.975, freedom()) : 0.0;
    std::vector<CurvePoint> curve;
    int inside = 0;
    for (int i = 0; i <= moments; ++i) {
      const double share = static_cast<double>(i) / moments;
      CurvePoint point{.time = share * duration};
      const Counts filmed = counts_at(filmed_, row.orifice, point.time);
      const Counts simulated = counts_at(simulated_, row.orifice, point.time);
      // No particle is counted in part.
      const double reach =
          std::max(1.0, t * scatter_of_counts(share) * std::sqrt(1.0 + 1.0 / filmed.runs));
      point.filmed = filmed.mean;
      point.lower = std::max(0.0, filmed.mean - reach);
      point.upper =
          std::min(filmed.mean + reach, static_cast<double>(problem_.experiment.particle.count));
      point.simulated = simulated.mean;
      point.simulated_lower = simulated.lowest;
      point.simulated_upper = simulated.highest;
      inside += point.lower <= point.simulated && point.simulated <= point.upper ? 1 : 0;
      curve.push_back(point);
    }
    row.curve_inside = static_cast<double>(inside) / (moments + 1);
    return curve;
  }

  const Problem& problem_;
  const PooledRule* rate_;  // null where rates are not compared
  std::vector<BulkRun> filmed_, simulated_, halved_;
  std::vector<std::vector<BulkRun>> inputs_;
  std::vector<OrificeComparison> rows_;
  std::vector<std::vector<CurvePoint>> curves_;  // one an orifice
};

// Grains leave some rigs otherwise than through an orifice, which then is as wide as anything.
std::string orifice_cell(double orifice) {
  return std::isfinite(orifice) ? number_text(orifice) : "";
}
Json orifice_json(double orifice) { return std::isfinite(orifice) ? Json(orifice) : Json(); }
std::string exit_words(double orifice) {
  return std::isfinite(orifice) ? fmt::format("Orifice {:4.0f} mm", 1e3 * orifice) : "Exit";
}

// --- Files
// ----------------------------------------------------------------------------------------

Json film_json(const BulkRun& film) {
  const BulkMeasurement& measured = film.measured;
  const auto steady = steady_rate(measured.discharge, film.rig);
  const Arching arching = find_arching(measured.discharge, film.rig);
  Json json = {{"name", film.name},
               {"orifice_m", orifice_json(film.rig.orifice)},
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

void add_run_tables(std::span<const BulkRun> runs,
                    std::span<const datasets::Recording> recordings,
                    Results& results) {
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
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const BulkRun& one = runs[i];
    const auto steady = steady_rate(one.measured.discharge, one.rig);
    const Arching arching = find_arching(one.measured.discharge, one.rig);
    const std::string orifice = orifice_cell(one.rig.orifice);
    const datasets::Recording& recording = recordings[i];
    for (const double time :
         recording.tracks ? recording.tracks->time : recording.discharge->time) {
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
      profiles.add(
          {one.name,
           orifice,
           number_text(one.measured.profile.height),
           number_text(sample.x),
           number_text(sample.velocity),
           sample.standard_uncertainty > 0.0 ? number_text(sample.standard_uncertainty) : ""});
  }
  results.tables["discharge"] = std::move(curves);
  results.tables["flow_rates"] = std::move(rates);
  results.tables["velocity_profiles"] = std::move(profiles);
}

// Rates of the orifices, Beverloo and B of one set of runs.
Json flow_json(const OrificeFlow& flow) {
  return {{"orifice_m", orifice_json(flow.orifice)},
          {"rate_kg_per_s", flow.rate},
          {"lower", flow.rate - flow.half_width},
          {"upper", flow.rate + flow.half_width},
          {"runs", flow.runs}};
}

Json beverloo_json(const FlowFits& fits) {
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
  return {{"orifice_m", orifice_json(flow.orifice)},
          {"height_m", flow.height},
          {"B_over_d", fit.B / diameter},
          {"lower", fit.lower / diameter},
          {"upper", std::isfinite(fit.upper) ? Json(fit.upper / diameter) : Json()},
          {"flux_over_rate", flow.flux_over_rate}};
}

// What fits say, appended to what `json` holds of other sources.
void add_fits(const FlowFits& fits, const char* source, Json& json) {
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
  return {{"orifice_m", orifice_json(row.orifice)},
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

void add_curves(const FlowScorer& scorer, Results& results) {
  Table table({"orifice_m",
               "time_s",
               "filmed_count",
               "filmed_lower",
               "filmed_upper",
               "simulated_count",
               "simulated_lower",
               "simulated_upper"});
  for (std::size_t i = 0; i < scorer.curves().size(); ++i) {
    for (const CurvePoint& point : scorer.curves()[i]) {
      table.add({orifice_cell(scorer.rows()[i].orifice),
                 number_text(point.time),
                 number_text(point.filmed),
                 number_text(point.lower),
                 number_text(point.upper),
                 number_text(point.simulated),
                 number_text(point.simulated_lower),
                 number_text(point.simulated_upper)});
    }
  }
  results.tables["discharge_curves"] = std::move(table);
}

// Of each orifice: velocities of replicates and of simulations, mean over runs, bin by bin.
void add_profile_comparison(const Problem& problem, const Confirmed& confirmed, Results& results) {
  Table table({"orifice_m", "x_m", "source", "velocity_m_per_s", "lowest", "highest"});
  const auto place = problem.observables->find("velocity_profile");
  if (!place) return;
  const std::vector<SimulatedRun>& runs = confirmed.runs.runs;
  const std::size_t seeds = runs.size() / problem.scenes.size();
  for (const Condition& condition : problem.conditions) {
    const Situation& situation = problem.situations[condition.replicates.front()];
    const std::vector<double> middles = problem.observables->all()[*place]->axis(situation);
    for (const bool simulated : {false, true}) {
      std::vector<std::vector<double>> velocities(middles.size());
      const auto add = [&](const std::vector<double>& values) {
        for (std::size_t bin = 0; bin < values.size(); ++bin) {
          if (!std::isnan(values[bin])) velocities[bin].push_back(values[bin]);
        }
      };
      if (simulated) {
        for (const std::size_t scene : condition.scenes) {
          for (std::size_t seed = 0; seed < seeds; ++seed) {
            const SimulatedRun& run = runs[scene * seeds + seed];
            if (run.status == RunStatus::completed) add(run.channels[*place].values);
          }
        }
      } else {
        for (const std::size_t r : condition.replicates) add(problem.measured[r][*place].values);
      }
      for (std::size_t bin = 0; bin < middles.size(); ++bin) {
        const std::vector<double>& of_bin = velocities[bin];
        if (of_bin.empty()) continue;
        double mean = 0.0;
        for (const double velocity : of_bin) mean += velocity / static_cast<double>(of_bin.size());
        table.add({orifice_cell(bulk_rig(situation).orifice),
                   number_text(middles[bin]),
                   simulated ? "simulation" : "experiment",
                   number_text(mean),
                   number_text(*std::min_element(of_bin.begin(), of_bin.end())),
                   number_text(*std::max_element(of_bin.begin(), of_bin.end()))});
      }
    }
  }
  results.tables["velocity_comparison"] = std::move(table);
}

// Of each orifice: up to where the bed stands still beside the flow, mean over replicates and runs.
void add_boundaries(const FlowScorer& scorer, Results& results) {
  Table table({"orifice_m", "x_m", "filmed_height_m", "simulated_height_m"});
  const double width = scorer.filmed().front().rig.width;
  for (const OrificeComparison& row : scorer.rows()) {
    const std::size_t columns = std::min(row.filmed_stagnant.size(), row.simulated_stagnant.size());
    for (std::size_t column = 0; column < columns; ++column) {
      const double share = (static_cast<double>(column) + 0.5) / static_cast<double>(columns);
      table.add({orifice_cell(row.orifice),
                 number_text((share - 0.5) * width),
                 number_text(row.filmed_stagnant[column]),
                 number_text(row.simulated_stagnant[column])});
    }
  }
  results.tables["stagnant_boundary"] = std::move(table);
}

void add_rates(const FlowScorer& scorer, Results& results) {
  Table table({"orifice_m",
               "held_out",
               "filmed_kg_per_s",
               "simulated_kg_per_s",
               "error_kg_per_s",
               "validation_uncertainty_kg_per_s",
               "curve_inside"});
  for (const OrificeComparison& row : scorer.rows()) {
    table.add({orifice_cell(row.orifice),
               row.held_out ? "1" : "0",
               number_text(row.filmed),
               number_text(row.simulated),
               number_text(row.error()),
               number_text(row.validation_uncertainty()),
               number_text(row.curve_inside)});
  }
  results.tables["rate_comparison"] = std::move(table);
}

std::string words_on(const BulkRun& film) {
  const Discharge& discharge = film.measured.discharge;
  const auto steady = steady_rate(discharge, film.rig);
  const Arching arching = find_arching(discharge, film.rig);
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

std::string words_on(const FlowFits& fits) {
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
  for (const OrificeFlow& flow : fits.orifices) {
    if (!flow.kinematic) continue;
    const double upper = flow.kinematic->upper / diameter;
    const bool balances = std::abs(flow.flux_over_rate - 1.0) <= 0.1;
    words += fmt::format(
        "{}: B {:.2f} d ({:.2f} to {}), at {:.0f} mm; v rho W over the rate "
        "{:.2f}{}\n",
        exit_words(flow.orifice),
        flow.kinematic->B / diameter,
        flow.kinematic->lower / diameter,
        std::isfinite(upper) ? fmt::format("{:.2f}", upper) : std::string("not bounded"),
        1e3 * flow.height,
        flow.flux_over_rate,
        balances ? "" : " (should be 1: distrust this profile)");
  }
  return words;
}

std::string words_on(const OrificeComparison& row) {
  const std::string place = exit_words(row.orifice) + (row.held_out ? ", held out" : "");
  if (std::isnan(row.error()) && row.filmed_jams.runs == 0)
    return fmt::format("{:24} no steady flow in replicates or simulations: no rates to compare",
                       place);
  if (std::isnan(row.error())) {
    return fmt::format("{:24} {} of {} films and {} of {} simulations jammed: no rates to compare",
                       place,
                       row.filmed_jams.happened,
                       row.filmed_jams.runs,
                       row.simulated_jams.happened,
                       row.simulated_jams.runs);
  }
  return fmt::format(
      "{:24} {:7.2f} g/s measured, {:7.2f} simulated: E {:+6.2f}, u_val {:5.2f} g/s; curve inside "
      "the band of the replicates {:3.0f} % of the time",
      place,
      1e3 * row.filmed,
      1e3 * row.simulated,
      1e3 * row.error(),
      1e3 * row.validation_uncertainty(),
      100.0 * row.curve_inside);
}

double scatter_of(const ChannelComparison& comparison, const char* observable) {
  const Rule* rule = comparison.rule_of(observable);
  if (rule == nullptr || !rule->pools_conditions()) return 0.0;
  return static_cast<const PooledRule*>(rule)->scatter().standard_deviation;
}

}  // namespace

Probability probability_of(int happened, int runs) {
  Probability probability{.happened = happened, .runs = runs, .lower = 0.0, .upper = 1.0};
  if (runs == 0) return probability;
  const boost::math::beta_distribution<double> posterior(happened + 0.5, runs - happened + 0.5);
  if (happened > 0) probability.lower = boost::math::quantile(posterior, 0.025);
  if (happened < runs) probability.upper = boost::math::quantile(posterior, 0.975);
  return probability;
}

void tell_flow(const MeasuredExperiment& measured, Results& results) {
  std::vector<BulkRun> runs;
  for (std::size_t r = 0; r < measured.channels.size(); ++r) {
    runs.push_back(run_of(measured.experiment.replicates[r].name,
                          measured.situations[r],
                          measured.observables,
                          measured.channels[r]));
  }
  const FlowFits fits = fit_flow(runs, measured.situations.front().rig.gravity);
  add_run_tables(runs, measured.recordings, results);
  results.json["replicates"] = Json::array();
  for (const BulkRun& run : runs) {
    results.json["replicates"].push_back(film_json(run));
    results.lines.push_back(words_on(run));
  }
  for (const OrificeFlow& flow : fits.orifices)
    results.json["discharge"].push_back(flow_json(flow));
  if (fits.beverloo) results.json["beverloo"] = beverloo_json(fits);
  for (const OrificeFlow& flow : fits.orifices) {
    if (flow.kinematic)
      results.json["kinematic"].push_back(kinematic_json(flow, fits.particle_diameter));
  }
  if (const std::string words = words_on(fits); !words.empty()) results.lines.push_back(words);
}

void tell_rates(const Problem& problem, const Evaluation& evaluation, Results& results) {
  const Rule& rule = *problem.calibrated->rule_of("discharge_rate");
  const auto runs = rule.digest(evaluation.runs);
  std::size_t place = 0;
  for (const Condition& condition : problem.conditions) {
    if (condition.held_out) continue;
    results.json["orifices"].push_back(
        {{"orifice_m",
          orifice_json(bulk_rig(problem.situations[condition.replicates.front()]).orifice)},
         {"filmed_kg_per_s", rule.band(place).mean.front()},
         {"simulated_kg_per_s", rule.simulated_mean(*runs, place).front()}});
    ++place;
  }
}

void conclude_flow(const Problem& problem, const Confirmed& confirmed, Results& results) {
  const FlowScorer scorer(problem, confirmed);
  const double gravity = problem.experiment.rig.gravity;
  add_curves(scorer, results);
  add_profile_comparison(problem, confirmed, results);
  add_boundaries(scorer, results);
  add_rates(scorer, results);
  // Whatever form was searched by
  const ChannelComparison smooth(problem.calibrated->experiments());
  const Rule* rate = smooth.rule_of("discharge_rate");
  results.json["replicate_scatter"] = {
      {"relative_rate", scatter_of(smooth, "discharge_rate")},
      {"remaining_particles", scatter_of(smooth, "what_stays")},
      {"relative_velocity", scatter_of(smooth, "velocity_profile")},
      {"degrees_of_freedom", rate ? rate->freedom() : 0}};
  results.json["mean_signed_error"] = scorer.mean_signed_error();
  for (const OrificeComparison& row : scorer.rows()) {
    results.json["comparison"].push_back(comparison_json(row));
    results.lines.push_back(words_on(row));
  }
  add_fits(fit_flow(scorer.filmed(), gravity), "experiment", results.json);
  add_fits(fit_flow(scorer.simulated(), gravity), "simulation", results.json);
}

}  // namespace graintruth::calibrate
