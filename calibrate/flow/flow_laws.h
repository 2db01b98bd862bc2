// The constants of the two laws of a discharging bed from means over the runs through several
// orifices: what the thesis compares its films and simulations by (Tables 4.4 to 4.7).
#pragma once

#include <span>
#include <vector>

#include "calibrate/flow/kinematic.h"

namespace graintruth::calibrate {

// All runs through one orifice, averaged.
struct MeanFlow {
  double orifice = 0.0;                 // m
  double rate = 0.0;                    // kg/s
  double standard_uncertainty = 0.0;    // kg/s, of the mean rate
  double density = 0.0;                 // kg/m2, of the flowing bed
  double height = 0.0;                  // m, of the profile
  std::vector<VelocitySample> profile;  // empty where none is known
};

// B of one profile, m; NaN where it has too few samples, 0 where nothing in it moves downwards.
double kinematic_length(const MeanFlow& flow);

struct FlowLaws {
  double C = 0.0, k = 0.0;  // of Beverloo's law for a slot
  std::vector<double> B;    // m, of the kinematic model, one an orifice; NaN without a profile
};

// Needs two orifices. Where nothing flows through one of them, or no constants fit, C and k are 0.
FlowLaws fit_flow_laws(std::span<const MeanFlow> flows, double particle_diameter, double gravity);

// What the uncertainty of the rates makes of that of C and k, taken one by one:
//   u_C^2 = sum over orifices of (dC/dq u_q)^2
struct BeverlooUncertainty {
  double C = 0.0, k = 0.0;
};
BeverlooUncertainty beverloo_uncertainty(std::span<const MeanFlow> flows,
                                         double particle_diameter,
                                         double gravity);

}  // namespace graintruth::calibrate
