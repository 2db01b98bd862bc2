// The page of a run: one HTML file that opens offline, made from the run folder alone.
#pragma once

#include <string>

#include "datasets/store/run_folder.h"

namespace graintruth::reports {

// Reads run.json, result.json, measured.json, tracking.json, tables/*.csv and the annotated frames.
// What a run did not leave behind becomes a sentence on the page. The same folder gives the same
// bytes, and a file that cannot be understood becomes a sentence too. Throws datasets::InputError
// when the folder holds no run at all.
std::string build_report(const datasets::RunFolder& folder);

// Writes build_report() to folder.report(), whole or not at all.
void write_report(const datasets::RunFolder& folder);

}  // namespace graintruth::reports
