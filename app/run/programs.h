// The two programs of one command line: graintruth, which starts at once, and graintruth-whole,
// which has all verbs. They lie in one folder, or in bin/ and libexec/graintruth/.
#pragma once

#include <filesystem>

namespace graintruth::app {

// Throws datasets::InputError where it is not there.
std::filesystem::path whole_program();
// That a batch system starts: the light one where it is there.
std::filesystem::path light_program();

}  // namespace graintruth::app
