// What a balance writes beside the mass: noise, spikes, readings that are stuck, a level of its own
// and a drift of that. Rules that take nothing but the readings themselves and the mass of a grain,
// so that they hold for any balance.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace graintruth::datasets {

// One reading of a balance.
struct Reading {
  double time = 0.0;    // s, from the start event
  double mass = 0.0;    // kg, in the sense of mass that has left; the level is the balance's own
  std::size_t row = 0;  // of the file's table
};
using Readings = std::vector<Reading>;

// Standard deviation (kg) of a reading about the line through its neighbours, from the median of
// such differences. A steady flow and a drift make none. 0 of fewer than twelve readings, which
// tell too little.
double noise_of(std::span<const Reading> readings);

// A reading that stands out from both sides.
struct Spike {
  std::size_t place = 0;
  double off = 0.0;  // kg, from the median of the readings about it
};
// Those that lie off the median of the seven readings about them, by more than eight times the
// noise and more than a grain's mass. So up to three in a row are found, and a curve that only
// rises or only falls has none. The last of at least twenty readings stands out where it also lies
// off the reading before by three times the largest step of the six before that.
std::vector<Spike> find_spikes(std::span<const Reading> readings, double particle_mass);

// Readings that repeat one value although the mass moved on: `first` is true, those after it up to
// `last` are not.
struct Stuck {
  std::size_t first = 0, last = 0;
  double jump = 0.0;  // kg, to the reading after the last; 0 at the end
};
// After `rest` readings at rest. Five or more equal readings are stuck
// - where the next one makes up for them: by a step more than six times as large as three of four
//   other steps, and at least a third of what the usual step makes in so many readings; or
// - where readings at rest show that so many equal ones happen in fewer than one curve in a
// million. A bed that stands still under an arch is neither: it goes on at its own pace.
std::vector<Stuck> find_stuck(std::span<const Reading> readings,
                              std::size_t rest,
                              double particle_mass);

// How fast the mass moves at most, kg/s: of stretches of a tenth of the readings. 0 of a single
// one.
double fastest_rate(std::span<const Reading> readings);

// The level of the balance before anything has left.
struct Tare {
  double level = 0.0;                 // kg, at the start event
  double drift = 0.0;                 // kg/s; 0 where none is told from noise
  double drift_standard_error = 0.0;  // kg/s
};
// The median of the readings at rest. A drift is the slope of the line through the medians of eight
// equal parts of the rest, where the scatter of the parts about the line says that it is none of
// chance (Student's t, 1 in 1000), and it is larger than `least_drift` and smaller than
// `least_flow` (kg/s): what moves as fast as that is flow. It needs sixteen readings. Then the
// level is the median of what is left when the drift is taken out.
Tare find_tare(std::span<const Reading> at_rest, double least_drift, double least_flow);

// The never falling values nearest to these in the least-squares sense: neighbours that fall are
// pooled (Ayer et al. 1955). A running maximum would follow the highest of the noise.
std::vector<double> never_falling(std::span<const double> values);

}  // namespace graintruth::datasets
