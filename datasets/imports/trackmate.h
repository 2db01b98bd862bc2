// What TrackMate (Tinevez et al. 2017) exports, as tables that need no further knowledge of it.
#pragma once

#include <filesystem>

#include "datasets/store/table.h"

namespace graintruth::datasets {

// TrackMate's table of spots has three further header rows, the last of them with the units; they
// go into the names of the columns. Spots that belong to no track are left out. Any other table
// comes back as it is. Throws InputError where a table of TrackMate holds no tracks.
Table without_trackmate_headers(Table table);

// Whether a file is XML, by its name or by what it begins with.
bool is_xml(const std::filesystem::path& file);

// "Export tracks to XML file": <Tracks> with attributes spaceUnits, frameInterval, timeUnits, and
// <particle><detection t x y z/></particle>, t counted in frames. Throws InputError with file and
// line for anything else.
Table read_trackmate_xml(const std::filesystem::path& file);

}  // namespace graintruth::datasets
