// Input that cannot be used: the one exception that the program turns into a sentence and exit
// status 2.
#pragma once

#include <stdexcept>
#include <string>

namespace graintruth::datasets {

// what() is one full sentence: where (file, line, key or column), what is wrong, and what would be
// right.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace graintruth::datasets
