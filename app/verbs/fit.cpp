// graintruth fit: the fits of discharge rates and velocity profiles alone, on the user's own table.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "app/verbs/commands.h"
#include "calibrate/flow/beverloo.h"
#include "calibrate/flow/kinematic.h"
#include "calibrate/flow/published_constants.h"
#include "datasets/imports/column_names.h"
#include "datasets/store/input_error.h"
#include "datasets/store/plausible.h"
#include "datasets/store/run_folder.h"

namespace graintruth::app {

namespace {

using datasets::InputError;
namespace columns = datasets::columns;

// Warnings stand first, before any number that they question.
void finish(const FitCommand& command,
            nlohmann::json result,
            const std::string& words,
            const std::vector<std::string>& warnings) {
  result["warnings"] = warnings;
  if (!command.common.out.empty()) {
    std::filesystem::create_directories(command.common.out);
    datasets::write_whole(command.common.out / "result.json", result.dump(2) + "\n");
  }
  for (const std::string& warning : warnings)
    fmt::print(command.common.json ? stderr : stdout, "warning: {}\n", warning);
  if (command.common.json)
    fmt::print("{}\n", result.dump(2));
  else
    fmt::print("{}", words);
}

[[noreturn]] void fail(const datasets::Table& table, const std::string& complaint) {
  throw InputError(fmt::format("{}: {}.", table.file().string(), complaint));
}
[[noreturn]] void fail(const datasets::Table& table,
                       std::size_t row,
                       const std::string& complaint) {
  throw InputError(fmt::format("{}:{}: {}.", table.file().string(), table.line(row), complaint));
}

void need_rows(const datasets::Table& table, std::size_t least, std::string_view what) {
  if (table.rows() >= least) return;
  throw InputError(fmt::format("{}: {} needs at least {} rows, this table has {}.",
                               table.file().string(),
                               what,
                               least,
                               table.rows()));
}

// Papers write D for the orifice, or D0 for it and D for the silo, and d for the particles.
struct Widths {
  std::vector<double> orifices;
  std::optional<std::vector<double>> silos;
  std::string capital;  // the column D where it is the silo's
};

Widths read_widths(const datasets::Table& table) {
  Widths widths;
  const auto capital = datasets::find_column(table, columns::capital_diameter);
  const bool is_named = datasets::find_column(table, columns::orifice).has_value();
  widths.orifices = datasets::positive_quantity(
      table, capital && !is_named ? columns::capital_diameter : columns::orifice);
  widths.silos = datasets::find_quantity(table, columns::silo);
  if (capital && is_named) {
    widths.capital = capital->column;
    if (!widths.silos) widths.silos = datasets::find_quantity(table, columns::capital_diameter);
  }
  return widths;
}

std::vector<double> read_diameters(const FitCommand& command,
                                   const datasets::Table& table,
                                   const Widths& widths) {
  if (command.diameter > 0.0) return std::vector<double>(table.rows(), command.diameter);
  if (datasets::find_column(table, columns::particle_diameter))
    return datasets::positive_quantity(table, columns::particle_diameter);
  fail(table,
       fmt::format("no column tells the particles' diameter{}; add 'particle_diameter_mm' or give "
                   "--diameter-mm",
                   widths.capital.empty()
                       ? std::string()
                       : fmt::format(" ('{}' is taken for the silo's, beside the orifice's)",
                                     widths.capital)));
}

// Widths that nothing can flow through.
void require_room(const datasets::Table& table,
                  const Widths& widths,
                  const std::vector<double>& diameters) {
  constexpr double mm = 1e3;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double orifice = widths.orifices[row];
    if (diameters[row] >= orifice) {
      fail(
          table,
          row,
          fmt::format("a particle of {:.4g} mm is as wide as its orifice of {:.4g} mm or wider, so "
                      "none can flow out; look at the columns and units of both",
                      mm * diameters[row],
                      mm * orifice));
    }
    if (widths.silos && (*widths.silos)[row] < orifice) {
      fail(table,
           row,
           fmt::format("the orifice of {:.4g} mm is wider than its silo of {:.4g} mm; look at the "
                       "columns and units of both",
                       mm * orifice,
                       mm * (*widths.silos)[row]));
    }
  }
}

// kg/m3. No bed is denser than its grains, or than any solid.
std::vector<double> read_bulk_densities(const datasets::Table& table,
                                        std::vector<std::string>& warnings) {
  auto densities = datasets::positive_quantity(table, columns::bulk_density);
  const auto solids = datasets::find_quantity(table, columns::particle_density);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double density = densities[row];
    if (solids && density >= (*solids)[row]) {
      fail(
          table,
          row,
          fmt::format("the bulk density of {:.4g} kg/m3 is not below that of the particles, {:.4g} "
                      "kg/m3; look at the columns and units of both",
                      density,
                      (*solids)[row]));
    }
    const auto doubt = datasets::doubt_about_bed(density, "the bulk density");
    if (!doubt) continue;
    if (density > datasets::densest_solid) fail(table, row, *doubt);
    if (warnings.empty())
      warnings.push_back(fmt::format("{}:{}: {}.", table.file().string(), table.line(row), *doubt));
  }
  return densities;
}

std::vector<calibrate::DischargeRate> read_rates(const FitCommand& command,
                                                 const datasets::Table& table,
                                                 std::vector<std::string>& warnings) {
  need_rows(table, 3, "a fit of C and k");
  const bool slot = command.law == "slot";
  const Widths widths = read_widths(table);
  const auto rates = datasets::positive_quantity(table, columns::rate);
  const auto densities = slot ? datasets::positive_quantity(table, columns::areal_density)
                              : read_bulk_densities(table, warnings);
  const auto errors = datasets::find_uncertainty(table, columns::rate_error);
  const auto diameters = read_diameters(command, table, widths);
  require_room(table, widths, diameters);
  std::vector<calibrate::DischargeRate> result;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    result.push_back({.orifice = widths.orifices[row],
                      .rate = rates[row],
                      .density = densities[row],
                      .particle_diameter = diameters[row],
                      .standard_uncertainty = errors ? (*errors)[row] : 0.0});
  }
  const bool one_width =
      std::all_of(widths.orifices.begin(), widths.orifices.end(), [&](double width) {
        return width == widths.orifices.front();
      });
  if (one_width)
    fail(table, "all rows have the same orifice; C and k need rates at different widths");
  return result;
}

// The orifice lies in the middle of the bin.
void require_inside(const datasets::Table& table,
                    const std::vector<calibrate::VelocitySample>& samples,
                    const FitCommand& command) {
  constexpr double mm = 1e3;
  if (!(command.bin_width > 0.0)) return;
  if (command.orifice > command.bin_width) {
    fail(table,
         fmt::format("the orifice of {:.4g} mm is wider than the bin of {:.4g} mm",
                     mm * command.orifice,
                     mm * command.bin_width));
  }
  for (std::size_t row = 0; row < samples.size(); ++row) {
    if (std::abs(samples[row].x) <= 0.5 * command.bin_width) continue;
    fail(table,
         row,
         fmt::format("the place {:.4g} mm lies outside the bin, which reaches {:.4g} mm to either "
                     "side; places count from the middle of the orifice",
                     mm * samples[row].x,
                     mm * 0.5 * command.bin_width));
  }
}

// Mean velocities of the places above the orifice and of those beside it. The bed sinks fastest
// above the orifice, or the places are counted from elsewhere.
void require_centred(const datasets::Table& table,
                     const std::vector<calibrate::VelocitySample>& samples,
                     double orifice) {
  constexpr double mm = 1e3;
  double above = 0.0, beside = 0.0, nearest = std::numeric_limits<double>::infinity();
  int number_above = 0, number_beside = 0;
  for (const calibrate::VelocitySample& sample : samples) {
    nearest = std::min(nearest, std::abs(sample.x));
    const bool is_above = std::abs(sample.x) <= 0.5 * orifice;
    (is_above ? above : beside) += sample.velocity;
    ++(is_above ? number_above : number_beside);
  }
  constexpr const char* right = "places count from the middle of the orifice";
  if (number_above == 0) {
    fail(table,
         fmt::format("every place lies beside the orifice, which is {:.4g} mm wide: the nearest is "
                     "{:.4g} mm from its middle; {}",
                     mm * orifice,
                     mm * nearest,
                     right));
  }
  if (number_beside == 0 || above / number_above >= beside / number_beside) return;
  fail(table,
       fmt::format(
           "the bed sinks at {:.4g} mm/s above the orifice, but at {:.4g} mm/s beside it, in "
           "the mean; {}",
           mm * above / number_above,
           mm * beside / number_beside,
           right));
}

}  // namespace

int run_fit_beverloo(const FitCommand& command) {
  const datasets::Table table = datasets::read_csv(command.data);
  std::vector<std::string> warnings;
  const auto rates = read_rates(command, table, warnings);
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
  // A k that is stated, and the thesis's, need no joint fit
  if (!fit.converged && !thesis && !command.imposed_k) {
    fail(table,
         "the fit of C and k did not converge: these rates do not follow the law, or do not tell "
         "both constants. Look at widths and rates, or state k with --k");
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
  if (fit.converged) {
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
    result["joint"] = {{"C", fit.parameters[0]},
                       {"k", fit.parameters[1]},
                       {"covariance",
                        {{fit.covariance(0, 0), fit.covariance(0, 1)},
                         {fit.covariance(1, 0), fit.covariance(1, 1)}}},
                       {"C_half_width_95", fit.half_width_95(0)},
                       {"k_half_width_95", fit.half_width_95(1)}};
  } else {
    words += "Joint fit of C and k: left out, because these rates do not tell both.\n";
  }
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
  result["C"] = thesis ? thesis_mean : fit.converged ? fit.parameters[0] : mean;
  result["k"] = thesis || !fit.converged ? row_k : fit.parameters[1];
  const bool is_joint = fit.converged && !thesis && !command.imposed_k;
  for (const std::string& doubt : calibrate::doubts_about_beverloo(
           is_joint ? fit.parameters[0] : mean, is_joint ? fit.parameters[1] : row_k))
    warnings.push_back(doubt);
  finish(command, result, words, warnings);
  return 0;
}

int run_fit_kinematic(const FitCommand& command) {
  const datasets::Table table = datasets::read_csv(command.data);
  need_rows(table, 4, "a fit of B");
  const auto places = datasets::finite_quantity(table, columns::place);
  auto velocities = datasets::finite_quantity(table, columns::velocity);
  const auto errors = datasets::find_uncertainty(table, columns::velocity_error);
  // Downwards is what flows, whichever sign the table gives it.
  double sum = 0.0;
  for (double velocity : velocities) sum += velocity;
  std::vector<calibrate::VelocitySample> samples;
  for (std::size_t i = 0; i < places.size(); ++i)
    samples.push_back(
        {places[i], sum < 0.0 ? -velocities[i] : velocities[i], errors ? (*errors)[i] : 0.0});
  if (std::all_of(velocities.begin(), velocities.end(), [](double v) { return v == 0.0; }))
    fail(table, "no place moves: every velocity is 0");
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
  require_inside(table, samples, command);
  if (command.orifice > 0.0) require_centred(table, samples, command.orifice);
  const calibrate::KinematicFit fit = calibrate::fit_kinematic(samples, options);
  if (!fit.converged) {
    fail(
        table,
        fmt::format("the fit of B did not converge: the profile is {} for the kinematic model at a "
                    "height of {:.4g} mm. Look at places, velocities and --height-mm",
                    fit.is_too_flat ? "too flat" : "too narrow",
                    1e3 * command.height));
  }
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
  std::vector<std::string> warnings;
  if (command.diameter > 0.0) {
    result["B_over_d"] = fit.B / command.diameter;
    warnings = calibrate::doubts_about_kinematic(fit.B / command.diameter);
  }
  finish(command, result, words, warnings);
  return 0;
}

}  // namespace graintruth::app
