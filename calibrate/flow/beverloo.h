// Beverloo's law of discharge and its two constants (Beverloo, Leniger and van de Velde 1961;
// thesis eq 4.5): how the rate through an orifice grows with its width.
//   slot      q = (4 sqrt2 / pi) C rho_A sqrt(g) (D - k d)^(3/2)   one layer, areal density rho_A
//   circular  W = C rho_b sqrt(g) (D - k d)^(5/2)                   round orifice, bulk density
//   rho_b
// The thesis multiplies the slot form by d as well, which leaves C with the dimension of 1/length
// (errata 9); its C is that of the slot form over d in centimetres.
#pragma once

#include <Eigen/Dense>
#include <span>
#include <vector>

#include "calibrate/search/least_squares.h"

namespace graintruth::calibrate {

enum class BeverlooLaw { slot, circular };

struct DischargeRate {
  double orifice = 0.0;               // m; width of the slot or diameter
  double rate = 0.0;                  // kg/s
  double density = 0.0;               // kg/m2 (slot) or kg/m3 (circular), of the flowing bed
  double particle_diameter = 0.0;     // m
  double standard_uncertainty = 0.0;  // kg/s, of the rate; 0 where unknown
};

// Rate (kg/s) that the law gives; 0 where the orifice is narrower than k d.
double beverloo_rate(BeverlooLaw law, const DischargeRate& at, double C, double k, double gravity);

// C (-) of one rate at a given k.
double beverloo_coefficient(BeverlooLaw law, const DischargeRate& at, double k, double gravity);

// The thesis's C of the slot form, eq 4.5 as printed: per centimetre.
double thesis_coefficient(const DischargeRate& at, double k, double gravity);

// C and k fitted together to rate / density: parameters (C, k). Weighted where the rates have
// uncertainties: all of them, or none, else std::invalid_argument is thrown. Needs two different
// orifices. C and k are strongly correlated: read the covariance.
LeastSquaresFit fit_beverloo(BeverlooLaw law, std::span<const DischargeRate> rates, double gravity);

// The thesis's way (figure 4.17): rate^(2/3) (slot) or rate^(2/5) (circular) against the orifice by
// a straight line, whose zero is k d.
struct BeverlooLine {
  double slope = 0.0, intercept = 0.0;  // of rate^(1/exponent) in SI against orifice in m
  double zero = 0.0;                    // m; -intercept / slope = k d
  double zero_standard_error = 0.0;     // m; NaN with two rates
};
BeverlooLine fit_beverloo_line(BeverlooLaw law, std::span<const DischargeRate> rates);

}  // namespace graintruth::calibrate
