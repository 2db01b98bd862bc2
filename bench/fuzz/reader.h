// What is read of files, as a fuzzer sees it: a name, files to begin with, and a way to read one.
#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "datasets/store/input_error.h"

namespace graintruth::fuzz {

struct Reader {
  std::string name;
  std::string extension;           // of the file that is read
  std::vector<std::string> seeds;  // files to begin with
  // Reads the file; datasets::InputError is what a file that cannot be used ends in; anything else
  // that is thrown is a fault.
  std::function<void(const std::filesystem::path& file)> read;
};

// Of the program that is built: inputs.cpp or runs.cpp.
std::vector<Reader> readers();

inline const std::filesystem::path bundled =
    std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "datasets";

inline std::string content_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream content;
  content << stream.rdbuf();
  return std::move(content).str();
}

// Each in turn, whether the one before refuses or not.
template <class... Reads>
void each(const Reads&... reads) {
  const auto one = [](const auto& read) {
    try {
      read();
    } catch (const datasets::InputError&) {
      // As it should
    }
  };
  (one(reads), ...);
}

}  // namespace graintruth::fuzz
