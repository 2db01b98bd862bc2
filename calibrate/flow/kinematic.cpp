#include "calibrate/flow/kinematic.h"

#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/tools/minima.hpp>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace graintruth::calibrate {

namespace {

// v at v0 = 1
double unit_velocity(const KinematicOptions& options, double B, double x) {
  const double square = 4.0 * B * options.height;
  if (options.orifice == 0.0) return std::exp(-x * x / square);
  const double width = std::sqrt(square), half = 0.5 * options.orifice;
  return 0.5 * (std::erf((half - x) / width) + std::erf((half + x) / width));
}

struct Profile {
  double sum_of_squares;  // weighted
  double velocity;
};

// The best v0 for a given B is linear: v0 = sum w u v / sum w u^2.
Profile profile_at(std::span<const VelocitySample> samples,
                   const KinematicOptions& options,
                   bool weighted,
                   double B) {
  const auto weight = [&](const VelocitySample& sample) {
    return weighted ? 1.0 / (sample.standard_uncertainty * sample.standard_uncertainty) : 1.0;
  };
  double velocity = options.pinned_velocity;
  if (velocity == 0.0) {
    double cross = 0.0, square = 0.0;
    for (const VelocitySample& sample : samples) {
      const double unit = unit_velocity(options, B, sample.x);
      cross += weight(sample) * unit * sample.velocity;
      square += weight(sample) * unit * unit;
    }
    velocity = square > 0.0 ? cross / square : 0.0;
  }
  double sum = 0.0;
  for (const VelocitySample& sample : samples) {
    const double miss = sample.velocity - velocity * unit_velocity(options, B, sample.x);
    sum += weight(sample) * miss * miss;
  }
  return {sum, velocity};
}

}  // namespace

double kinematic_velocity(const KinematicOptions& options, double B, double v0, double x) {
  return v0 * unit_velocity(options, B, x);
}

KinematicFit fit_kinematic(std::span<const VelocitySample> samples,
                           const KinematicOptions& options) {
  const auto certain =
      std::count_if(samples.begin(), samples.end(), [](const VelocitySample& sample) {
        return sample.standard_uncertainty > 0.0;
      });
  const bool weighted = certain > 0;
  if (weighted && certain != static_cast<std::ptrdiff_t>(samples.size()))
    throw std::invalid_argument("only some velocities have an uncertainty");
  double reach = 0.0;
  for (const VelocitySample& sample : samples) reach = std::max(reach, std::abs(sample.x));
  // B between profiles far narrower than the samples' spacing and far wider than the bed
  const double widest = 100.0 * reach * reach / options.height;
  const double narrowest =
      1e-4 * reach * reach / options.height / static_cast<double>(samples.size());
  const auto misfit = [&](double log_B) {
    return profile_at(samples, options, weighted, std::exp(log_B)).sum_of_squares;
  };
  // 1. The best B: the least of a scan, then Brent
  constexpr int scan = 200;
  const double from = std::log(narrowest), to = std::log(widest), stride = (to - from) / scan;
  int best = 0;
  for (int i = 1; i <= scan; ++i)
    if (misfit(from + i * stride) < misfit(from + best * stride)) best = i;
  const double centre = from + best * stride;
  constexpr int bits = std::numeric_limits<double>::digits / 2;
  const double log_B =
      boost::math::tools::brent_find_minima(
          misfit, std::max(from, centre - stride), std::min(to, centre + stride), bits)
          .first;
  KinematicFit fit;
  fit.B = std::exp(log_B);
  fit.converged = best > 0 && best < scan;
  fit.is_too_flat = best == scan;
  const Profile at_best = profile_at(samples, options, weighted, fit.B);
  fit.velocity = at_best.velocity;
  double square = 0.0;
  for (const VelocitySample& sample : samples)
    square +=
        std::pow(sample.velocity - kinematic_velocity(options, fit.B, fit.velocity, sample.x), 2);
  fit.rms = std::sqrt(square / static_cast<double>(samples.size()));
  const int free = options.pinned_velocity == 0.0 ? 2 : 1;
  fit.freedom = static_cast<int>(samples.size()) - free;
  // 2. Profile likelihood: where the misfit has grown by what 1 parameter in 20 repeats exceeds,
  //    S(B) = S_min (1 + F(0.95; 1, freedom) / freedom), or S_min + 3.84 in units of known errors
  fit.lower = 0.0;
  fit.upper = std::numeric_limits<double>::infinity();
  if (fit.freedom < 1) return fit;
  constexpr double chi_square_95 = 3.841458820694124;
  const double limit =
      weighted ? at_best.sum_of_squares + chi_square_95
               : at_best.sum_of_squares *
                     (1.0 + boost::math::quantile(boost::math::fisher_f(1.0, fit.freedom), 0.95) /
                                fit.freedom);
  const auto excess = [&](double at) { return misfit(at) - limit; };
  const auto end_towards = [&](double end) {
    std::uintmax_t most = 200;
    const double low = std::min(log_B, end), high = std::max(log_B, end);
    const auto bracket = boost::math::tools::toms748_solve(
        excess, low, high, boost::math::tools::eps_tolerance<double>(bits), most);
    return std::exp(0.5 * (bracket.first + bracket.second));
  };
  if (excess(log_B) < 0.0 && excess(from) > 0.0) fit.lower = end_towards(from);
  if (excess(log_B) < 0.0 && excess(to) > 0.0) fit.upper = end_towards(to);
  if (excess(log_B) >= 0.0) fit.lower = fit.upper = fit.B;  // samples without any error
  return fit;
}

}  // namespace graintruth::calibrate
