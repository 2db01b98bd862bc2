#include "app/bulk_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "calibrate/beverloo.h"
#include "calibrate/bulk_measure.h"
#include "calibrate/hypothesis_tests.h"
#include "datasets/table.h"

namespace graintruth::app {

namespace {

using Json = nlohmann::ordered_json;
using datasets::number_text;
using datasets::Table;

calibrate::BulkRig rig_of(const datasets::Experiment& experiment,
                          const datasets::Replicate& replicate) {
  const datasets::Experiment filmed = datasets::as_filmed(experiment, replicate);
  const datasets::EllipticalPlate& plate = *filmed.particle.plate;
  return {.width = filmed.rig.bin->width,
          .orifice = filmed.rig.bin->orifice_width,
          .particle_area = std::numbers::pi * plate.semi_major * plate.semi_minor,
          .particle_diameter = 2.0 * std::sqrt(plate.semi_major * plate.semi_minor),
          .particle_mass = filmed.particle.mass,
          .gravity = filmed.rig.gravity};
}

// One replicate, measured.
struct Measured {
  std::string name;
  calibrate::BulkRig rig;
  calibrate::Discharge discharge;
  calibrate::Arching arching;
  std::optional<calibrate::SteadyRate> steady;
  calibrate::BedShape at_rest;
  double flowing_density = 0.0;  // kg/m2, mean over the steady stretch
  std::optional<calibrate::VelocityProfile> profile;
};

std::size_t frame_at(const datasets::Trajectories& tracks, double time) {
  const auto later = std::lower_bound(tracks.time.begin(), tracks.time.end(), time);
  return std::min(tracks.frames() - 1, static_cast<std::size_t>(later - tracks.time.begin()));
}

// Half way up the bed at rest, as long as a diameter of bed lies above the band.
std::optional<calibrate::VelocityProfile> profile_of(const datasets::Trajectories& tracks,
                                                     const Measured& measured) {
  const auto& surface = measured.at_rest.surface;
  double height = 0.0;
  for (double strip : surface) height += 0.5 * strip / static_cast<double>(surface.size());
  double until = measured.steady->from;
  for (std::size_t frame = frame_at(tracks, until); frame < tracks.frames(); ++frame) {
    const calibrate::BedShape bed = calibrate::measure_bed(tracks, frame, measured.rig);
    const double lowest = *std::min_element(bed.surface.begin(), bed.surface.end());
    if (lowest < height + measured.rig.particle_diameter ||
        tracks.time[frame] > measured.steady->to)
      break;
    until = tracks.time[frame];
  }
  const auto profile =
      calibrate::measure_profile(tracks, measured.rig, height, measured.steady->from, until);
  if (profile.samples.size() < 4) return std::nullopt;
  return profile;
}

Measured measure(const datasets::Experiment& experiment,
                 const datasets::Replicate& replicate,
                 const datasets::Trajectories& tracks) {
  Measured measured;
  measured.name = replicate.name;
  measured.rig = rig_of(experiment, replicate);
  measured.discharge = calibrate::measure_discharge(tracks, measured.rig);
  measured.arching = calibrate::find_arching(measured.discharge, measured.rig);
  measured.steady = calibrate::steady_rate(measured.discharge, measured.rig);
  measured.at_rest = calibrate::measure_bed(tracks, frame_at(tracks, 0.0), measured.rig);
  if (!measured.steady) return measured;
  constexpr int moments = 10;
  for (int i = 0; i < moments; ++i) {
    const double time =
        measured.steady->from + (measured.steady->to - measured.steady->from) * (i + 0.5) / moments;
    measured.flowing_density +=
        calibrate::measure_bed(tracks, frame_at(tracks, time), measured.rig).areal_density /
        moments;
  }
  measured.profile = profile_of(tracks, measured);
  return measured;
}

// Rates of one orifice.
struct OrificeRate {
  double orifice = 0.0, rate = 0.0, density = 0.0;
  int replicates = 0;
};

// Relative scatter of replicates about the mean of their orifice, pooled over orifices; and its
// degrees of freedom.
struct Scatter {
  double relative = 0.0;
  int freedom = 0;
};

std::vector<OrificeRate> rates_by_orifice(const std::vector<Measured>& all, Scatter& scatter) {
  std::vector<OrificeRate> rates;
  for (const Measured& one : all) {
    if (!one.steady) continue;
    auto at = std::find_if(rates.begin(), rates.end(), [&](const OrificeRate& rate) {
      return rate.orifice == one.rig.orifice;
    });
    if (at == rates.end()) at = rates.insert(rates.end(), OrificeRate{.orifice = one.rig.orifice});
    at->rate += one.steady->rate;
    at->density += one.flowing_density;
    ++at->replicates;
  }
  for (OrificeRate& rate : rates) {
    rate.rate /= rate.replicates;
    rate.density /= rate.replicates;
    scatter.freedom += rate.replicates - 1;
  }
  double square = 0.0;
  for (const Measured& one : all) {
    if (!one.steady) continue;
    for (const OrificeRate& rate : rates)
      if (rate.orifice == one.rig.orifice)
        square += std::pow(one.steady->rate / rate.rate - 1.0, 2);
  }
  if (scatter.freedom > 0) scatter.relative = std::sqrt(square / scatter.freedom);
  std::sort(rates.begin(), rates.end(), [](const OrificeRate& a, const OrificeRate& b) {
    return a.orifice < b.orifice;
  });
  return rates;
}

Json json_of(const Measured& measured) {
  Json json = {{"name", measured.name},
               {"orifice_m", measured.rig.orifice},
               {"particles", measured.discharge.particles},
               {"discharged", measured.discharge.times.size()},
               {"jammed", measured.arching.jammed},
               {"solid_fraction_at_rest", measured.at_rest.solid_fraction},
               {"areal_density_at_rest_kg_per_m2", measured.at_rest.areal_density}};
  for (const calibrate::Pause& pause : measured.arching.pauses)
    json["pauses"].push_back({{"from_s", pause.from}, {"to_s", pause.to}});
  if (!measured.steady) return json;
  json["steady"] = {{"from_s", measured.steady->from},
                    {"to_s", measured.steady->to},
                    {"particles", measured.steady->particles},
                    {"rate_kg_per_s", measured.steady->rate},
                    {"rate_standard_error_kg_per_s", measured.steady->standard_error},
                    {"areal_density_kg_per_m2", measured.flowing_density}};
  return json;
}

void write_tables(const std::vector<Measured>& all,
                  const std::vector<datasets::Trajectories>& tracks,
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
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Measured& one = all[i];
    const std::string orifice = number_text(one.rig.orifice);
    for (const double time : tracks[i].time) {
      const int count = calibrate::discharged_by(one.discharge, time);
      curves.add({one.name,
                  orifice,
                  number_text(time),
                  std::to_string(count),
                  number_text(count * one.rig.particle_mass)});
    }
    if (one.steady) {
      rates.add({one.name,
                 orifice,
                 number_text(one.steady->rate),
                 number_text(one.steady->standard_error),
                 number_text(one.flowing_density),
                 number_text(one.rig.particle_diameter),
                 number_text(one.steady->from),
                 number_text(one.steady->to),
                 std::to_string(one.arching.pauses.size()),
                 one.arching.jammed ? "yes" : "no"});
    }
    if (!one.profile) continue;
    for (const calibrate::VelocitySample& sample : one.profile->samples)
      profiles.add({one.name,
                    orifice,
                    number_text(one.profile->height),
                    number_text(sample.x),
                    number_text(sample.velocity),
                    number_text(sample.standard_uncertainty)});
  }
  datasets::write_csv(folder.table("discharge"), curves);
  datasets::write_csv(folder.table("flow_rates"), rates);
  datasets::write_csv(folder.table("velocity_profiles"), profiles);
}

// B of one orifice from the profiles of all its replicates.
std::optional<calibrate::KinematicFit> fit_orifice(const std::vector<Measured>& all,
                                                   double orifice,
                                                   double& height,
                                                   double& balance) {
  std::vector<calibrate::VelocitySample> samples;
  int profiles = 0;
  height = balance = 0.0;
  for (const Measured& one : all) {
    if (!one.profile || one.rig.orifice != orifice) continue;
    for (calibrate::VelocitySample sample : one.profile->samples) {
      sample.standard_uncertainty = 0.0;  // what the profiles scatter, not single bins, tells
      samples.push_back(sample);
    }
    height += one.profile->height;
    balance += one.profile->flux / one.steady->rate;
    ++profiles;
  }
  if (profiles == 0) return std::nullopt;
  height /= profiles;
  balance /= profiles;
  return calibrate::fit_kinematic(samples, {.height = height, .orifice = orifice});
}

}  // namespace

std::string write_bulk_measurements(const datasets::Experiment& experiment,
                                    const std::vector<datasets::Trajectories>& tracks,
                                    const datasets::RunFolder& folder) {
  std::vector<Measured> all;
  for (std::size_t i = 0; i < tracks.size(); ++i)
    all.push_back(measure(experiment, experiment.replicates[i], tracks[i]));
  write_tables(all, tracks, folder);

  Json json;
  json["experiment"] = experiment.name;
  if (!experiment.note.empty()) json["note"] = experiment.note;
  std::string words;
  for (const Measured& one : all) {
    json["replicates"].push_back(json_of(one));
    words += fmt::format(
        "{}: {} of {} left", one.name, one.discharge.times.size(), one.discharge.particles);
    words += one.steady ? fmt::format(", {:.2f} +- {:.2f} g/s from {:.2f} to {:.2f} s",
                                      1e3 * one.steady->rate,
                                      1e3 * one.steady->standard_error,
                                      one.steady->from,
                                      one.steady->to)
                        : std::string(", no steady stretch: no rate");
    if (!one.arching.pauses.empty()) words += fmt::format(", {} pauses", one.arching.pauses.size());
    if (one.arching.jammed) words += ", jammed";
    words += fmt::format(", solid fraction {:.3f} at rest\n", one.at_rest.solid_fraction);
  }
  // 1. Rates of the orifices, with the scatter of replicates
  Scatter scatter;
  const std::vector<OrificeRate> rates = rates_by_orifice(all, scatter);
  const double diameter = all.empty() ? 0.0 : all.front().rig.particle_diameter;
  std::vector<calibrate::DischargeRate> fitted;
  for (const OrificeRate& rate : rates) {
    const double standard_error = scatter.relative * rate.rate / std::sqrt(rate.replicates);
    const double reach =
        scatter.freedom > 0 ? calibrate::student_t_quantile(0.975, scatter.freedom) * standard_error
                            : std::numeric_limits<double>::quiet_NaN();
    Json entry = {{"orifice_m", rate.orifice},
                  {"rate_kg_per_s", rate.rate},
                  {"lower", rate.rate - reach},
                  {"upper", rate.rate + reach},
                  {"replicates", rate.replicates}};
    json["discharge"].push_back(entry);
    fitted.push_back({.orifice = rate.orifice,
                      .rate = rate.rate,
                      .density = rate.density,
                      .particle_diameter = diameter,
                      .standard_uncertainty = standard_error});
  }
  // 2. Beverloo
  if (fitted.size() >= 3) {
    const auto fit =
        calibrate::fit_beverloo(calibrate::BeverlooLaw::slot, fitted, experiment.rig.gravity);
    if (fit.converged) {
      json["beverloo"] = {{"C", fit.parameters[0]},
                          {"k", fit.parameters[1]},
                          {"covariance",
                           {{fit.covariance(0, 0), fit.covariance(0, 1)},
                            {fit.covariance(1, 0), fit.covariance(1, 1)}}},
                          {"form", "joint"}};
      words += fmt::format(
          "Beverloo (joint fit, {} orifices): C {:.3f} +- {:.3f}, k {:.3f} +- "
          "{:.3f} (95 %), d = {:.2f} mm\n",
          fitted.size(),
          fit.parameters[0],
          fit.half_width_95(0),
          fit.parameters[1],
          fit.half_width_95(1),
          1e3 * diameter);
    }
  }
  // 3. Kinematic B
  for (const OrificeRate& rate : rates) {
    double height = 0.0, balance = 0.0;
    const auto fit = fit_orifice(all, rate.orifice, height, balance);
    if (!fit) continue;
    Json entry = {{"orifice_m", rate.orifice},
                  {"height_m", height},
                  {"B_over_d", fit->B / diameter},
                  {"lower", fit->lower / diameter},
                  {"upper", std::isfinite(fit->upper) ? Json(fit->upper / diameter) : Json()},
                  {"flux_over_rate", balance}};
    json["kinematic"].push_back(entry);
    words += fmt::format(
        "Orifice {:.0f} mm: B {:.2f} d ({:.2f} to {}), at {:.0f} mm; v rho W over the rate "
        "{:.2f}{}\n",
        1e3 * rate.orifice,
        fit->B / diameter,
        fit->lower / diameter,
        std::isfinite(fit->upper) ? fmt::format("{:.2f}", fit->upper / diameter)
                                  : std::string("not bounded"),
        1e3 * height,
        balance,
        std::abs(balance - 1.0) > 0.1 ? " (should be 1: distrust this profile)" : "");
  }
  datasets::write_whole(folder.measured(), json.dump(2) + "\n");
  return words;
}

}  // namespace graintruth::app
