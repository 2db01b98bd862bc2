// Curves of quantities of the user's own: a table beside each replicate.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "datasets/experiment/recording.h"

namespace graintruth::datasets {

// Every column is a curve of its name, a column <name>_uncertainty its standard uncertainty. Times
// are those of a column time_s or time_ms, less the event's; without one the table has one row, of
// numbers that belong to no time. Values are taken as they are: the unit stands in the name. Throws
// InputError with file, line and column for what cannot be used. A column without any value is left
// out. `notes` gets sentences on what of the file was not taken as it stands.
std::map<std::string, Curve> read_curves(const std::filesystem::path& file,
                                         double event_time,
                                         std::vector<std::string>* notes = nullptr);

}  // namespace graintruth::datasets
