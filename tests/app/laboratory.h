// A laboratory's folder for tests of the whole program: the bundled experiment with its films or
// with tracks, and changes to its text.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "tests/support/temporary_folder.h"

namespace graintruth::tests {

std::filesystem::path bundled_micro();

// The text of the bundled experiment with full paths to its films.
std::string film_experiment();

// The text of a small, fast experiment: soft particles, seven compared frames, tracks as CSV with
// the names rep1.csv to rep5.csv.
std::string track_experiment();

// Writes rep1.csv to rep5.csv: the bundled truth as tracks, time from the start event.
void write_tracks_of_truth(const TemporaryFolder& folder);

// `text` with the first `from` replaced. Throws std::logic_error where there is none.
std::string with(std::string text, std::string_view from, std::string_view to);

std::string content_of(const std::filesystem::path& file);

}  // namespace graintruth::tests
