// What is measured of a bed that runs out of a bin, on film and in simulation alike: who left when,
// the steady rate, pauses, how densely the bed lies and how fast it sinks. Thesis section 4.3.2.
// x right, z up; the origin is the middle of the orifice in the floor.
#pragma once

#include <optional>
#include <vector>

#include "calibrate/flow/kinematic.h"
#include "datasets/experiment/experiment.h"
#include "datasets/imports/discharge_curve.h"
#include "datasets/imports/stagnant.h"
#include "datasets/store/trajectories.h"

namespace graintruth::calibrate {

struct BulkRig {
  double width = 0.0;              // m, of the bin
  double orifice = 0.0;            // m
  double particle_area = 0.0;      // m2, seen in the picture plane
  double particle_diameter = 0.0;  // m, of a disc of that area
  double particle_mass = 0.0;      // kg
  double gravity = 9.81;           // m/s2
  double exit_z = 0.0;             // m; grains whose centre is below have left
};

// When particles left, in order. A particle has left once its centre is below the floor; the time
// is interpolated. One that was last seen over the orifice within a diameter of the floor and never
// again left in the frame after.
struct Discharge {
  int particles = 0;          // in the bin at first
  int over_orifice = 0;       // that are in the bin in the last frame, above the opening itself
  double from = 0.0;          // s, first frame
  double to = 0.0;            // s, last frame
  std::vector<double> times;  // s
  // How many leave between two samples, where a curve was sampled: their times are only known
  // together, and say nothing of how regularly single particles left.
  int together = 1;
};
Discharge measure_discharge(const datasets::Trajectories& tracks, const BulkRig& rig);

// The same from the mass that has left, of a bin that held `particles` at first: particle n has
// left once the mass passes that of n - 1/2 particles. Whether particles still lie above the
// opening is not known, and taken for no; so a curve never tells a jam from a bin that has run out.
Discharge measure_discharge(const datasets::DischargeCurve& curve,
                            int particles,
                            const BulkRig& rig);

// How many have left by a time.
int discharged_by(const Discharge& discharge, double time);

// A stretch without any particle leaving, long enough that free fall does not explain it: more than
// twice the time in which a particle falls by its own diameter, 2 sqrt(2 d / g).
struct Pause {
  double from = 0.0, to = 0.0;  // s
};
// Between the first and the last particle that left. `jammed`: none has left for as long as ten
// such times at the end, and at least two particles still lie above the opening, held by an arch; a
// heap beside the opening is no jam.
struct Arching {
  std::vector<Pause> pauses;
  bool jammed = false;
};
Arching find_arching(const Discharge& discharge, const BulkRig& rig);

// The steady rate: over the longest stretch between 10 and 80 % discharged in which the count lies
// within 2 % of all particles from a straight line and nothing pauses (written rule in place of the
// thesis's eye). Of particles whose times are only known together, the last one counts for all. The
// standard error comes from the gaps between particles, which are not
// independent (Newey and West 1987).
struct SteadyRate {
  double from = 0.0, to = 0.0;  // s
  int particles = 0;            // that left in it
  double rate = 0.0;            // kg/s
  double standard_error = 0.0;  // kg/s
};
// None where no such stretch holds a tenth of the particles.
std::optional<SteadyRate> steady_rate(const Discharge& discharge, const BulkRig& rig);

// kg/s; the steady one, or the mean over the run where nothing was steady.
double rate_of(const Discharge& discharge, const BulkRig& rig);

// The bed at one moment, from ten upright strips: each as high as its highest particle.
struct BedShape {
  std::vector<double> surface;  // m, height of each strip; 0 where it is empty
  double area = 0.0;            // m2
  double solid_fraction = 0.0;  // share of the area that particles cover
  double areal_density = 0.0;   // kg/m2
};
BedShape measure_bed(const datasets::Trajectories& tracks, std::size_t frame, const BulkRig& rig);

// Bins across the bed: as many diameters as fit into its width.
std::size_t profile_bins(const BulkRig& rig);

// Downward velocity across the bed in a band a diameter thick, binned by diameters, averaged over
// time. Every particle counts once in each bin it passes.
struct VelocityProfile {
  double height = 0.0;                  // m, of the band's middle
  std::vector<VelocitySample> samples;  // bins that particles passed
  double areal_density = 0.0;           // kg/m2 in the band, averaged over time
  // integral of v rho dx, kg/s: what must equal the rate. The check of every profile.
  double flux = 0.0;
};
VelocityProfile measure_profile(const datasets::Trajectories& tracks,
                                const BulkRig& rig,
                                double height,
                                double from,
                                double to);

// What stood still between two frames (datasets/imports/stagnant.h). A place is that of the
// particle whose centre is nearest, or of none where that is more than 0.6 diameters away; a
// particle that is not seen in both frames moves. `height` (m) of the bin, as far as it is looked
// at.
datasets::StagnantMap measure_stagnant(const datasets::Trajectories& tracks,
                                       const BulkRig& rig,
                                       double height,
                                       std::size_t from,
                                       std::size_t to);

// All that is measured of one run, filmed, weighed or simulated.
struct BulkMeasurement {
  Discharge discharge;
  bool of_tracks = true;         // false: a discharge curve alone, and what follows is not known
  BedShape at_rest;              // at time 0
  double flowing_density = 0.0;  // kg/m2, mean over the steady stretch; 0 where nothing was steady
  VelocityProfile profile;       // without samples where nothing was steady
  // m, of the boundary of what stands still while the rest flows steadily, by columns half a
  // diameter wide: mean over moments of datasets::stagnant_heights. NaN over the orifice; empty
  // where nothing was steady.
  std::vector<double> stagnant_heights;
};

// `profile_height` (m) is where a velocity profile is taken; where it is not given, half way up the
// bed at rest. The profile is of the steady stretch, as long as a diameter of bed lies above it.
BulkMeasurement measure_bulk(const datasets::Trajectories& tracks,
                             const BulkRig& rig,
                             std::optional<double> profile_height = std::nullopt);

// Of a discharge curve: the discharge, and nothing else.
BulkMeasurement measure_bulk(const datasets::DischargeCurve& curve,
                             int particles,
                             const BulkRig& rig);

// What bulk measures need of a situation. Where no opening is stated, grains leave anywhere below
// the scene's exit height.
struct Situation;
BulkRig bulk_rig(const Situation& situation);

}  // namespace graintruth::calibrate
