// A page printed to PDF by the Chromium that is installed.
#pragma once

#include <filesystem>

namespace graintruth::app {

// Prints a page of ours; the PDF appears whole or not at all. Throws datasets::InputError with one
// sentence when there is no Chromium, or when it fails or hangs.
void print_pdf(const std::filesystem::path& page, const std::filesystem::path& pdf);

}  // namespace graintruth::app
