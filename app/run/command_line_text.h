// The command line told to others than CLI11: to man and to the shell. Both are made from the same
// definition as --help.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace graintruth::app {

// graintruth.1, in the macros of man(7).
std::string man_page(const CLI::App& program, const std::string& version);

// A completion script for bash: verbs, options, the values that an option takes, files.
std::string bash_completion(const CLI::App& program);

}  // namespace graintruth::app
