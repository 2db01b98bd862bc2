#include "calibrate/flow/flow_fits.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/compare/hypothesis_tests.h"
#include "calibrate/flow/beverloo.h"

namespace graintruth::calibrate {

namespace {

struct SteadyRun {
  const BulkRun* run;
  SteadyRate steady;
};

// B from the profiles of all runs through one orifice: what they scatter, not what single bins say
// of themselves, tells its uncertainty.
void fit_profiles(std::span<const SteadyRun> runs, OrificeFlow& flow) {
  std::vector<VelocitySample> samples;
  int profiles = 0;
  for (const SteadyRun& one : runs) {
    const VelocityProfile& profile = one.run->measured.profile;
    if (profile.samples.empty() || one.run->rig.orifice != flow.orifice) continue;
    for (VelocitySample sample : profile.samples) {
      sample.standard_uncertainty = 0.0;
      samples.push_back(sample);
    }
    flow.height += profile.height;
    flow.flux_over_rate += profile.flux / one.steady.rate;
    ++profiles;
  }
  if (profiles == 0) return;
  flow.height /= profiles;
  flow.flux_over_rate /= profiles;
  flow.kinematic = fit_kinematic(samples, {.height = flow.height, .orifice = flow.orifice});
}

}  // namespace

FlowFits fit_flow(std::span<const BulkRun> runs, double gravity) {
  FlowFits fits;
  if (runs.empty()) return fits;
  fits.particle_diameter = runs.front().rig.particle_diameter;

  // 1. Mean rates, and the scatter about them
  std::vector<SteadyRun> steady_runs;
  for (const BulkRun& run : runs) {
    if (const auto steady = steady_rate(run.measured.discharge, run.rig))
      steady_runs.push_back({&run, *steady});
  }
  for (const SteadyRun& one : steady_runs) {
    const double orifice = one.run->rig.orifice;
    auto at = std::find_if(fits.orifices.begin(), fits.orifices.end(), [&](const auto& flow) {
      return flow.orifice == orifice;
    });
    if (at == fits.orifices.end()) at = fits.orifices.insert(at, OrificeFlow{.orifice = orifice});
    at->rate += one.steady.rate;
    ++at->runs;
  }
  std::sort(fits.orifices.begin(), fits.orifices.end(), [](const auto& a, const auto& b) {
    return a.orifice < b.orifice;
  });
  double squares = 0.0;
  for (OrificeFlow& flow : fits.orifices) {
    flow.rate /= flow.runs;
    int tracked = 0;
    for (const SteadyRun& one : steady_runs) {
      if (one.run->rig.orifice != flow.orifice || !one.run->measured.of_tracks) continue;
      flow.density += one.run->measured.flowing_density;
      ++tracked;
    }
    flow.density /= tracked;
    fits.freedom += flow.runs - 1;
    for (const SteadyRun& one : steady_runs) {
      if (one.run->rig.orifice == flow.orifice)
        squares += std::pow(one.steady.rate / flow.rate - 1.0, 2);
    }
  }
  if (fits.freedom > 0) fits.relative_scatter = std::sqrt(squares / fits.freedom);
  for (OrificeFlow& flow : fits.orifices) {
    flow.standard_error = fits.relative_scatter * flow.rate / std::sqrt(flow.runs);
    flow.half_width = fits.freedom > 0
                          ? student_t_quantile(0.975, fits.freedom) * flow.standard_error
                          : std::numeric_limits<double>::quiet_NaN();
  }

  // 2. Beverloo's law through them
  std::vector<DischargeRate> rates;
  for (const OrificeFlow& flow : fits.orifices) {
    if (std::isnan(flow.density)) continue;
    rates.push_back({.orifice = flow.orifice,
                     .rate = flow.rate,
                     .density = flow.density,
                     .particle_diameter = fits.particle_diameter,
                     .standard_uncertainty = flow.standard_error});
  }
  if (rates.size() >= 3) {
    LeastSquaresFit fit = fit_beverloo(BeverlooLaw::slot, rates, gravity);
    if (fit.converged) fits.beverloo = std::move(fit);
  }

  // 3. The kinematic model through the profiles
  for (OrificeFlow& flow : fits.orifices) fit_profiles(steady_runs, flow);
  return fits;
}

}  // namespace graintruth::calibrate
