// A table of named columns: what CSV files are read into, and what every table of a run is written
// from.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/store/numerals.h"

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
  // Sentences on what of the file was left out, or not taken as it stands
  const std::vector<std::string>& notes() const { return notes_; }
  // " (line 3 was taken for the header)", for sentences about columns; empty where no line was.
  std::string header_words() const;
  int line(std::size_t row) const { return lines_.at(row); }
  bool has(std::string_view column) const;
  const std::string& text(std::size_t row, std::string_view column) const;
  // Throws InputError with file, line and column when the cell is not a number. An empty cell,
  // "nan" or another word of is_missing() is NaN. What commas and points mean is decided for the
  // whole file (NumberVote).
  double number(std::size_t row, std::string_view column) const;
  // Whether the cell holds a number, in whatever style.
  bool is_number(std::size_t row, std::string_view column) const;
  // Whether there are rows, and no cell of the column has a value.
  bool is_blank(std::string_view column) const;
  // As number(), but the cell must hold a whole number.
  int integer(std::size_t row, std::string_view column) const;
  std::vector<double> numbers(std::string_view column) const;

  // Appends a row; as many cells as columns. `line` is where in the file it stands.
  void add(std::vector<std::string> cells);
  void add(std::vector<std::string> cells, int line);

  // A table without rows under other columns: of the same file, with its notes and its style of
  // numbers.
  Table emptied(std::vector<std::string> columns) const;

 private:
  friend class CsvReader;
  std::size_t column_index(std::string_view column) const;

  std::filesystem::path file_;
  std::vector<std::string> columns_;
  std::vector<std::vector<std::string>> cells_;
  std::vector<int> lines_;  // where in the file each row stood
  std::vector<std::string> notes_;
  int header_line_ = 0;  // 0: none
  NumberStyle style_;
};

// Text as read_text() takes it; quotes as in RFC 4180. Lines that are empty or start with '#' or
// '%' are skipped, and so are rows of empty cells and columns without a name and without a value.
//
// Header: the first row. If that holds nothing but numbers, the nearest line above it that starts
// with one of these and has as many cells. If what follows the first row does not fit under it, the
// first row of names under which two rows of numbers fit. A second row of units goes into the
// names: "Time", "s" become "Time (s)". LabVIEW's .lvm states header, separator and decimal mark
// itself.
//
// Cells are parted by what a first line `sep=;` says; else by tabs where the header has one, else
// by semicolons or commas, of which it has more, else by blanks where the rows have some.
//
// Throws InputError with file and line for anything else.
Table read_csv(const std::filesystem::path& file);
std::string to_csv(const Table& table);
void write_csv(const std::filesystem::path& file, const Table& table);

// The shortest text that reads back to the same double; "" for NaN.
std::string number_text(double value);

}  // namespace graintruth::datasets
