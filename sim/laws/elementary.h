// Mathematical functions that give the same bits on every processor. The C library picks other
// variants of its own where a processor lacks fused multiply-add, and those differ in the last bit
// now and then. These use additions, multiplications, divisions and square roots alone.
#pragma once

namespace graintruth::sim {

// In twice the precision of a double, rounded once in the end: correct to half a unit in the last
// place but for one value in some 10^13.
double exact_exp(double x);            // x in -690 .. 700
double exact_log(double x);            // x > 0
double exact_log1p(double x);          // x > -1
double exact_pow(double x, double y);  // x >= 0
double exact_cbrt(double x);
double exact_erf(double x);  // x in -5 .. 5

// In the precision of a double, for what is called by the million: within two units in the last
// place, the inverse ones within four.
struct SineAndCosine {
  double sine, cosine;
};
SineAndCosine steady_sine_and_cosine(double x);  // x in -1e6 .. 1e6
double steady_sin(double x);
double steady_cos(double x);
double steady_tan(double x);
double steady_atan2(double y, double x);  // -pi .. pi
double steady_asin(double x);
double steady_acos(double x);

}  // namespace graintruth::sim
