#include "calibrate/flow/flow_laws.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/flow/beverloo.h"

namespace graintruth::calibrate {

namespace {

struct Beverloo {
  double C = 0.0, k = 0.0;
};

Beverloo beverloo_of(std::span<const MeanFlow> flows, double particle_diameter, double gravity) {
  std::vector<DischargeRate> rates;
  for (const MeanFlow& flow : flows) {
    if (!(flow.rate > 0.0)) return {};
    rates.push_back({.orifice = flow.orifice,
                     .rate = flow.rate,
                     .density = flow.density,
                     .particle_diameter = particle_diameter,
                     .standard_uncertainty = flow.standard_uncertainty});
  }
  const LeastSquaresFit fit = fit_beverloo(BeverlooLaw::slot, rates, gravity);
  if (!fit.converged || !fit.parameters.allFinite()) return {};
  return {fit.parameters[0], fit.parameters[1]};
}

}  // namespace

double kinematic_length(const MeanFlow& flow) {
  if (flow.profile.size() < 3) return std::numeric_limits<double>::quiet_NaN();
  const bool moves =
      std::any_of(flow.profile.begin(), flow.profile.end(), [](const VelocitySample& sample) {
        return sample.velocity > 0.0;
      });
  if (!moves) return 0.0;
  return fit_kinematic(flow.profile, {.height = flow.height, .orifice = flow.orifice}).B;
}

FlowLaws fit_flow_laws(std::span<const MeanFlow> flows, double particle_diameter, double gravity) {
  const Beverloo beverloo = beverloo_of(flows, particle_diameter, gravity);
  FlowLaws laws{.C = beverloo.C, .k = beverloo.k, .B = {}};
  for (const MeanFlow& flow : flows) laws.B.push_back(kinematic_length(flow));
  return laws;
}

BeverlooUncertainty beverloo_uncertainty(std::span<const MeanFlow> flows,
                                         double particle_diameter,
                                         double gravity) {
  constexpr double step = 0.01;  // of a rate, to either side
  BeverlooUncertainty uncertainty;
  std::vector<MeanFlow> changed(flows.begin(), flows.end());
  for (std::size_t i = 0; i < changed.size(); ++i) {
    changed[i].rate = flows[i].rate * (1.0 + step);
    const Beverloo more = beverloo_of(changed, particle_diameter, gravity);
    changed[i].rate = flows[i].rate * (1.0 - step);
    const Beverloo less = beverloo_of(changed, particle_diameter, gravity);
    changed[i].rate = flows[i].rate;
    const double uncertain = flows[i].standard_uncertainty / (2.0 * step * flows[i].rate);
    uncertainty.C = std::hypot(uncertainty.C, (more.C - less.C) * uncertain);
    uncertainty.k = std::hypot(uncertainty.k, (more.k - less.k) * uncertain);
  }
  return uncertainty;
}

}  // namespace graintruth::calibrate
