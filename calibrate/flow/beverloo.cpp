#include "calibrate/flow/beverloo.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "datasets/statistics/linear_least_squares.h"

namespace graintruth::calibrate {

namespace {

double exponent_of(BeverlooLaw law) { return law == BeverlooLaw::slot ? 1.5 : 2.5; }

// What stands before C rho sqrt(g): 4 sqrt2 / pi for the slot (thesis eq 4.5).
double factor_of(BeverlooLaw law) {
  return law == BeverlooLaw::slot ? 4.0 * std::numbers::sqrt2 / std::numbers::pi : 1.0;
}

// Rate over C
double unit_rate(BeverlooLaw law, const DischargeRate& at, double k, double gravity) {
  const double free_width = std::max(0.0, at.orifice - k * at.particle_diameter);
  return factor_of(law) * at.density * std::sqrt(gravity) * std::pow(free_width, exponent_of(law));
}

}  // namespace

double beverloo_rate(BeverlooLaw law, const DischargeRate& at, double C, double k, double gravity) {
  return C * unit_rate(law, at, k, gravity);
}

double beverloo_coefficient(BeverlooLaw law, const DischargeRate& at, double k, double gravity) {
  return at.rate / unit_rate(law, at, k, gravity);
}

double thesis_coefficient(const DischargeRate& at, double k, double gravity) {
  constexpr double centimetre = 0.01;
  return beverloo_coefficient(BeverlooLaw::slot, at, k, gravity) /
         (at.particle_diameter / centimetre);
}

LeastSquaresFit fit_beverloo(BeverlooLaw law,
                             std::span<const DischargeRate> rates,
                             double gravity) {
  const auto certain = std::count_if(rates.begin(), rates.end(), [](const DischargeRate& rate) {
    return rate.standard_uncertainty > 0.0;
  });
  const bool weighted = certain > 0;
  if (weighted && certain != static_cast<std::ptrdiff_t>(rates.size()))
    throw std::invalid_argument("only some rates have an uncertainty");
  const auto residuals = [&](const Eigen::VectorXd& parameters) {
    Eigen::VectorXd result(static_cast<Eigen::Index>(rates.size()));
    for (std::size_t i = 0; i < rates.size(); ++i) {
      const DischargeRate& at = rates[i];
      const double miss = at.rate - beverloo_rate(law, at, parameters[0], parameters[1], gravity);
      result[static_cast<Eigen::Index>(i)] =
          miss / (weighted ? at.standard_uncertainty : at.density);
    }
    return result;
  };
  // From the straight line, whose zero may lie beyond the narrowest orifice
  const BeverlooLine line = fit_beverloo_line(law, rates);
  double narrowest = 1e300;
  double diameter = 0.0;
  for (const DischargeRate& at : rates) {
    narrowest = std::min(narrowest, at.orifice / at.particle_diameter);
    diameter += at.particle_diameter / static_cast<double>(rates.size());
  }
  const double k = std::min(line.zero / diameter, 0.9 * narrowest);
  double C = 0.0;
  for (const DischargeRate& at : rates)
    C += beverloo_coefficient(law, at, k, gravity) / static_cast<double>(rates.size());
  return fit_least_squares(
      residuals, Eigen::Vector2d(C, k), weighted ? ResidualScale::known : ResidualScale::estimated);
}

BeverlooLine fit_beverloo_line(BeverlooLaw law, std::span<const DischargeRate> rates) {
  std::vector<double> orifices, roots;
  for (const DischargeRate& at : rates) {
    orifices.push_back(at.orifice);
    roots.push_back(std::pow(at.rate, 1.0 / exponent_of(law)));
  }
  const datasets::StraightLine fitted = datasets::straight_line(orifices, roots);
  BeverlooLine line{.slope = fitted.slope, .intercept = fitted.intercept};
  line.zero = -line.intercept / line.slope;
  // First order in the errors of both coefficients: var(x0) = s^2/b^2 (1/n + (x0 - mean)^2 / Sxx)
  const auto count = static_cast<double>(rates.size());
  const double variance = fitted.sum_of_squares / (count - 2.0);
  line.zero_standard_error =
      std::sqrt(variance *
                (1.0 / count + std::pow(line.zero - fitted.mean_x, 2) / fitted.spread_x)) /
      std::abs(line.slope);
  return line;
}

}  // namespace graintruth::calibrate
