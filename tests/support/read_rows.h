// A few rows of a comma-separated reference file, for tests.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace graintruth::tests {

using Row = std::map<std::string, std::string>;

// First line that does not start with '#' is the header. Empty when the file cannot be read.
inline std::vector<Row> read_rows(const std::filesystem::path& file) {
  const auto split = [](const std::string& line) {
    std::vector<std::string> cells(1);
    for (const char letter : line) {
      if (letter == ',') {
        cells.emplace_back();
      } else if (letter != '\r') {
        cells.back() += letter;
      }
    }
    return cells;
  };
  std::ifstream stream(file);
  std::vector<std::string> header;
  std::vector<Row> rows;
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line.front() == '#') continue;
    const std::vector<std::string> cells = split(line);
    if (header.empty()) {
      header = cells;
      continue;
    }
    Row row;
    for (std::size_t i = 0; i < header.size() && i < cells.size(); ++i) row[header[i]] = cells[i];
    rows.push_back(row);
  }
  return rows;
}

inline double number(const Row& row, const std::string& column) {
  return std::stod(row.at(column));
}

inline std::filesystem::path bundled_reference(const std::string& file) {
  return std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "datasets/references" / file;
}

// Reference curves of others, which are not part of the repository.
inline std::filesystem::path outside_reference(const std::string& file) {
  return std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "../shared/references" / file;
}

}  // namespace graintruth::tests
