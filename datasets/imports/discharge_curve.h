// How much has left a bin by when: what a load cell writes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace graintruth::datasets {

struct DischargeCurve {
  std::vector<double> time;  // s from the start event, rising
  std::vector<double> mass;  // kg that have left since the first row; never falls
};

struct DischargeSource {
  double event_time = 0.0;     // s, of the start event on the file's clock
  double full_mass = 0.0;      // kg, of all particles in the bin at first
  double particle_mass = 0.0;  // kg
};

// Reads a table with a time and one of: the mass that has left, the mass still in the bin, the
// share that has left (column_names.h). The first row is the tare. A cell's noise is smoothed as
// little as it takes for the mass never to fall. Throws InputError with file, line and column where
// times do not rise, where the mass falls back by more than 2 % of all (the straightness that a
// steady rate asks for) and a particle, where more leaves than was there, where nothing leaves, or
// where the curve begins after the event. `notes` gets sentences on what of the file was not taken
// as it stands.
DischargeCurve read_discharge_curve(const std::filesystem::path& file,
                                    const DischargeSource& source,
                                    std::vector<std::string>* notes = nullptr);

}  // namespace graintruth::datasets
