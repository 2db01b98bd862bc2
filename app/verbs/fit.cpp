// graintruth fit: the fits of discharge rates and velocity profiles alone, on the user's own table.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/verbs/commands.h"
#include "calibrate/flow/beverloo.h"
#include "calibrate/flow/kinematic.h"
#include "datasets/imports/column_names.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"

namespace graintruth::app {

namespace {

using datasets::InputError;
namespace columns = datasets::columns;

void finish(const FitCommand& command, const nlohmann::json& result, const std::string& words) {
  if (!command.common.out.empty()) {
    std::filesystem::create_directories(command.common.out);
    datasets::write_whole(command.common.out / "result.json", result.dump(2) + "\n");
  }
  if (command.common.json)
    fmt::print("{}\n", result.dump(2));
  else
    fmt::print("{}", words);
}

void need_rows(const datasets::Table& table, std::size_t least, std::string_view what) {
  if (table.rows() >= least) return;
  throw InputError(fmt::format("{}: {} needs at least {} rows, this table has {}.",
                               table.file().string(),
                               what,
                               least,
                               table.rows()));
}

std::vector<calibrate::DischargeRate> read_rates(const FitCommand& command,
                                                 const datasets::Table& table) {
  need_rows(table, 3, "a fit of C and k");
  const bool slot = command.law == "slot";
  const auto orifices = datasets::positive_quantity(table, columns::orifice);
  const auto rates = datasets::positive_quantity(table, columns::rate);
  const auto densities = slot ? datasets::positive_quantity(table, columns::areal_density)
                              : datasets::positive_quantity(table, columns::bulk_density);
  const auto errors = datasets::find_quantity(table, columns::rate_error);
  auto diameters = datasets::find_quantity(table, columns::particle_diameter);
  if (command.diameter > 0.0) diameters.emplace(table.rows(), command.diameter);
  if (!diameters) {
    throw InputError(
        fmt::format("{}: no column tells the particles' diameter; add 'particle_diameter_mm' or "
                    "give --diameter-mm",
                    table.file().string()));
  }
  std::vector<calibrate::DischargeRate> result;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    result.push_back({.orifice = orifices[row],
                      .rate = rates[row],
                      .density = densities[row],
                      .particle_diameter = (*diameters)[row],
                      .standard_uncertainty = errors ? (*errors)[row] : 0.0});
  }
  const bool one_width = std::all_of(
      orifices.begin(), orifices.end(), [&](double width) { return width == orifices.front(); });
  if (one_width) {
    throw InputError(
        fmt::format("{}: all rows have the same orifice; C and k need rates at different widths.",
                    table.file().string()));
  }
  return result;
}

}  // namespace

int run_fit_beverloo(const FitCommand& command) {
  const datasets::Table table = datasets::read_csv(command.data);
  const auto rates = read_rates(command, table);
  const bool slot = command.law == "slot";
  const auto law = slot ? calibrate::BeverlooLaw::slot : calibrate::BeverlooLaw::circular;
  const double gravity = command.gravity;
  const calibrate::LeastSquaresFit fit = calibrate::fit_beverloo(law, rates, gravity);
  const calibrate::BeverlooLine line = calibrate::fit_beverloo_line(law, rates);
  const double diameter = rates.front().particle_diameter;
  const bool one_diameter = std::all_of(rates.begin(), rates.end(), [&](const auto& rate) {
    return rate.particle_diameter == diameter;
  });
  const bool thesis = command.form == "thesis";
  // The thesis takes k from the line unless one is imposed; so do the rows of both forms.
  const double row_k = command.imposed_k ? *command.imposed_k
                       : thesis          ? line.zero / diameter
                                         : fit.parameters[1];
  if (thesis && (!slot || !one_diameter)) {
    throw InputError(
        fmt::format("{}: the thesis's form is that of a slot and one particle diameter",
                    command.data.string()));
  }
  nlohmann::json result;
  result["law"] = command.law;
  result["form"] = thesis ? "thesis" : "joint";
  result["gravity_m_per_s2"] = gravity;
  result["rows"] = rates.size();
  result["converged"] = fit.converged;
  if (one_diameter) result["particle_diameter_m"] = diameter;
  std::string words = fmt::format(
      "Beverloo's law, {}; {} rows, g = {} m/s2",
      slot ? "slot: q = (4 sqrt2/pi) C rho sqrt(g) (D - k d)^1.5, rho per area, no further d"
           : "circular orifice: W = C rho sqrt(g) (D - k d)^2.5",
      rates.size(),
      gravity);
  if (one_diameter) words += fmt::format(", d = {:.4f} mm", 1e3 * diameter);
  words += "\n\n";
  if (!fit.converged) {
    words += "Joint fit: did not converge; C and k are not determined by these rates.\n";
  } else {
    const double correlation =
        fit.covariance(0, 1) / (fit.standard_error(0) * fit.standard_error(1));
    words += fmt::format(
        "Joint fit of C and k ({})\n  C  {:.4f} +- {:.4f}\n  k  {:.4f} +- {:.4f}     95 % "
        "intervals; correlation of the two {:+.3f}\n",
        fit.scale == calibrate::ResidualScale::known ? "weighted by the stated uncertainties"
                                                     : "unweighted, to rate / density",
        fit.parameters[0],
        fit.half_width_95(0),
        fit.parameters[1],
        fit.half_width_95(1),
        correlation);
  }
  result["joint"] = {{"C", fit.parameters[0]},
                     {"k", fit.parameters[1]},
                     {"covariance",
                      {{fit.covariance(0, 0), fit.covariance(0, 1)},
                       {fit.covariance(1, 0), fit.covariance(1, 1)}}},
                     {"C_half_width_95", fit.half_width_95(0)},
                     {"k_half_width_95", fit.half_width_95(1)}};
  words += fmt::format("\nRegression of {} on D (the thesis's way, figure 4.17)\n  kd {:.3f} cm",
                       slot ? "q^(2/3)" : "W^(2/5)",
                       100.0 * line.zero);
  if (one_diameter) words += fmt::format(" = {:.3f} d", line.zero / diameter);
  words += fmt::format(", standard error {:.3f} cm\n", 100.0 * line.zero_standard_error);
  result["line"] = {{"kd_m", line.zero}, {"kd_standard_error_m", line.zero_standard_error}};
  if (one_diameter) result["line"]["k"] = line.zero / diameter;
  words += fmt::format("\nC of each row at k = {:.4f} ({})\n",
                       row_k,
                       command.imposed_k ? "imposed" : (thesis ? "regression" : "joint fit"));
  words += fmt::format("  {:>10} {:>12} {:>8}{}\n",
                       "D cm",
                       "rate g/s",
                       "C",
                       thesis ? "   C of the thesis, 1/cm (eq 4.5 as printed)" : "");
  double mean = 0.0, thesis_mean = 0.0;
  for (const calibrate::DischargeRate& rate : rates) {
    const double C = calibrate::beverloo_coefficient(law, rate, row_k, gravity);
    mean += C / static_cast<double>(rates.size());
    words +=
        fmt::format("  {:>10.3f} {:>12.3f} {:>8.4f}", 100.0 * rate.orifice, 1e3 * rate.rate, C);
    nlohmann::json row = {{"orifice_m", rate.orifice}, {"C", C}};
    if (thesis) {
      const double printed = calibrate::thesis_coefficient(rate, row_k, gravity);
      thesis_mean += printed / static_cast<double>(rates.size());
      words += fmt::format("   {:.4f}", printed);
      row["C_thesis_per_cm"] = printed;
    }
    words += '\n';
    result["coefficients"].push_back(row);
  }
  words += fmt::format("  {:>10} {:>12} {:>8.4f}", "mean", "", mean);
  if (thesis) words += fmt::format("   {:.4f}", thesis_mean);
  words += '\n';
  result["C"] = thesis ? thesis_mean : fit.parameters[0];
  result["k"] = thesis ? row_k : fit.parameters[1];
  finish(command, result, words);
  return fit.converged || thesis ? 0 : 1;
}

int run_fit_kinematic(const FitCommand& command) {
  const datasets::Table table = datasets::read_csv(command.data);
  need_rows(table, 4, "a fit of B");
  const auto places = datasets::finite_quantity(table, columns::place);
  auto velocities = datasets::finite_quantity(table, columns::velocity);
  const auto errors = datasets::find_quantity(table, columns::velocity_error);
  // Downwards is what flows, whichever sign the table gives it.
  double sum = 0.0;
  for (double velocity : velocities) sum += velocity;
  std::vector<calibrate::VelocitySample> samples;
  for (std::size_t i = 0; i < places.size(); ++i)
    samples.push_back(
        {places[i], sum < 0.0 ? -velocities[i] : velocities[i], errors ? (*errors)[i] : 0.0});
  const bool thesis = command.form == "thesis";
  calibrate::KinematicOptions options{.height = command.height};
  if (!thesis) options.orifice = command.orifice;
  if (thesis) {
    // v0 is the velocity nearest to the axis (section 4.3.2.6).
    const auto nearest =
        std::min_element(samples.begin(), samples.end(), [](const auto& a, const auto& b) {
          return std::abs(a.x) < std::abs(b.x);
        });
    options.pinned_velocity = nearest->velocity;
  }
  if (!thesis && !(command.orifice > 0.0)) {
    throw InputError(
        "fit kinematic: --orifice-mm is missing; the finite-orifice form needs it (or write --form "
        "thesis for the point orifice of the thesis)");
  }
  const calibrate::KinematicFit fit = calibrate::fit_kinematic(samples, options);
  const auto in_d = [&](double length) {
    return command.diameter > 0.0 ? fmt::format(" = {:.3f} d", length / command.diameter)
                                  : std::string();
  };
  std::string words = fmt::format(
      "Kinematic model, {}; {} samples at h = {:.1f} mm\n\n  B  {:.3f} mm{}\n     95 % interval by "
      "profile likelihood: {:.3f} mm{} to {}\n  v0 {:.4f} m/s{}\n  rms residual {:.4f} m/s\n",
      thesis ? "point orifice, v0 pinned to the centre (the thesis's form)"
             : fmt::format("orifice of {:.1f} mm, v0 free", 1e3 * command.orifice),
      samples.size(),
      1e3 * command.height,
      1e3 * fit.B,
      in_d(fit.B),
      1e3 * fit.lower,
      in_d(fit.lower),
      std::isfinite(fit.upper) ? fmt::format("{:.3f} mm{}", 1e3 * fit.upper, in_d(fit.upper))
                               : std::string("not bounded above by these data"),
      fit.velocity,
      thesis ? " on the axis" : " in the orifice",
      fit.rms);
  nlohmann::json result = {{"form", thesis ? "thesis" : "finite"},
                           {"height_m", command.height},
                           {"orifice_m", command.orifice},
                           {"B_m", fit.B},
                           {"lower_m", fit.lower},
                           {"upper_m", fit.upper},
                           {"velocity_m_per_s", fit.velocity},
                           {"rms_m_per_s", fit.rms}};
  if (!std::isfinite(fit.upper)) result["upper_m"] = nullptr;
  if (command.diameter > 0.0) result["B_over_d"] = fit.B / command.diameter;
  finish(command, result, words);
  return 0;
}

}  // namespace graintruth::app
