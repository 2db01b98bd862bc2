// How much has left a bin by when: what a load cell writes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace graintruth::datasets {

struct DischargeCurve {
  std::vector<double> time;  // s from the start event, rising
  std::vector<double> mass;  // kg that have left since the event; never falls
};

struct DischargeSource {
  double event_time = 0.0;     // s, of the start event on the file's clock
  double full_mass = 0.0;      // kg, of all particles in the bin at first
  double particle_mass = 0.0;  // kg
  double gravity = 9.81;       // m/s2, of a cell that tells a weight in newtons
};

// Reads a table with a time and one of: the mass that has left, the mass still in the bin, the
// share that has left (column_names.h); a mass may be a weight.
//
// The tare is the median of the readings at rest up to the event, and a drift of them is taken out:
// of the whole curve where it is known well enough to its end, else up to the event.
// Readings that stand out or are stuck are left out (balance_readings.h). Noise is smoothed as
// little as it takes for the mass never to fall.
//
// Throws InputError with file, line and column where a cell is empty, times do not rise, or the
// curve begins after the event or ends before it; and, judged by medians of as many readings as
// make the noise small, where the mass falls back by more than 2 % of all (the straightness that a
// steady rate asks for) and a particle, where more leaves than was there, where nothing leaves, or
// where the column says the opposite of its name. `notes` gets sentences on what of the file was
// not taken as it stands.
DischargeCurve read_discharge_curve(const std::filesystem::path& file,
                                    const DischargeSource& source,
                                    std::vector<std::string>* notes = nullptr);

}  // namespace graintruth::datasets
