// A table of named columns: what CSV files are read into, and what every table of a run is written
// from.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace graintruth::datasets {

// Rows of text cells under a header. Numbers are converted when asked for, so that the sentence
// about a bad cell can name file, line and column.
class Table {
 public:
  Table() = default;
  // `file` is named in sentences about cells; empty for a table that was never read.
  explicit Table(std::vector<std::string> columns, std::filesystem::path file = {})
      : file_(std::move(file)), columns_(std::move(columns)) {}

  const std::vector<std::string>& columns() const { return columns_; }
  std::size_t rows() const { return cells_.size(); }
  const std::filesystem::path& file() const { return file_; }  // empty unless read from one
  int line(std::size_t row) const { return lines_.at(row); }
  bool has(std::string_view column) const;
  const std::string& text(std::size_t row, std::string_view column) const;
  // Throws InputError with file, line and column when the cell is not a number. An empty cell or
  // "nan" is NaN. Where cells are not parted by commas, a decimal comma is as good as a point.
  double number(std::size_t row, std::string_view column) const;
  // As number(), but the cell must hold a whole number.
  int integer(std::size_t row, std::string_view column) const;
  std::vector<double> numbers(std::string_view column) const;

  // Appends a row; as many cells as columns. `line` is where in the file it stands.
  void add(std::vector<std::string> cells);
  void add(std::vector<std::string> cells, int line);

 private:
  friend Table read_csv(const std::filesystem::path& file);
  std::size_t column_index(std::string_view column) const;

  std::filesystem::path file_;
  std::vector<std::string> columns_;
  std::vector<std::vector<std::string>> cells_;
  std::vector<int> lines_;  // where in the file each row stood
  bool decimal_comma_ = false;
};

// First row the header, lines that start with '#' skipped, quotes as in RFC 4180. Cells are parted
// by tabs where the header has one, else by semicolons or commas, of which it has more.
Table read_csv(const std::filesystem::path& file);
std::string to_csv(const Table& table);
void write_csv(const std::filesystem::path& file, const Table& table);

// The shortest text that reads back to the same double; "" for NaN.
std::string number_text(double value);

}  // namespace graintruth::datasets
