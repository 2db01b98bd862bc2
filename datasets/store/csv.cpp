// CSV files in and out of Table. Lines and quotes are taken apart by fast-cpp-csv-parser; numbers
// are converted by Table, because that library reads 0.3 as 0.30000000000000004 and an empty field
// as 0.
#include <fmt/format.h>
#include <libfccp/csv.h>

#include <algorithm>
#include <limits>  // csv.h needs it and does not include it

#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"
#include "datasets/store/table.h"

namespace graintruth::datasets {

namespace {

using Blanks = io::trim_chars<' ', '\t'>;
using Skipped = io::single_and_empty_line_comment<'#'>;

template <char separator>
std::vector<std::string> split(char* line) {
  using Quotes = io::double_quote_escape<separator, '"'>;
  std::vector<std::string> cells;
  while (line != nullptr) {
    char* begin = nullptr;
    char* end = nullptr;
    io::detail::chop_next_column<Quotes>(line, begin, end);
    Blanks::trim(begin, end);
    Quotes::unescape(begin, end);
    cells.emplace_back(begin, end);
  }
  return cells;
}

// What parts the cells of a file whose header this is.
char separator_of(std::string_view header) {
  if (header.find('\t') != std::string_view::npos) return '\t';
  const auto semicolons = std::count(header.begin(), header.end(), ';');
  return semicolons > std::count(header.begin(), header.end(), ',') ? ';' : ',';
}

std::vector<std::string> split(char* line, char separator) {
  switch (separator) {
    case '\t':
      return split<'\t'>(line);
    case ';':
      return split<';'>(line);
    default:
      return split<','>(line);
  }
}

std::string quoted(const std::string& cell) {
  if (cell.find_first_of(",\"\n") == std::string::npos && !cell.starts_with('#')) return cell;
  std::string text = "\"";
  for (const char c : cell) {
    if (c == '"') text += '"';
    text += c;
  }
  text += '"';
  return text;
}

void append_row(const std::vector<std::string>& cells, std::string& text) {
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i > 0) text += ',';
    text += quoted(cells[i]);
  }
  text += '\n';
}

}  // namespace

Table read_csv(const std::filesystem::path& file) {
  Table table;
  table.file_ = file;
  int line_number = 0;
  char separator = ',';
  try {
    io::LineReader reader(file.string());
    while (char* line = reader.next_line()) {
      line_number = static_cast<int>(reader.get_file_line());
      if (Skipped::is_comment(line)) continue;
      if (table.columns_.empty()) separator = separator_of(line);
      std::vector<std::string> cells = split(line, separator);
      if (table.columns_.empty()) {
        table.columns_ = std::move(cells);
        continue;
      }
      if (cells.size() != table.columns_.size()) {
        throw InputError(fmt::format("{}:{}: the row has {} cells, but the header has {} columns.",
                                     file.string(),
                                     line_number,
                                     cells.size(),
                                     table.columns_.size()));
      }
      table.cells_.push_back(std::move(cells));
      table.lines_.push_back(line_number);
    }
  } catch (const io::error::can_not_open_file&) {
    throw InputError(fmt::format("{}: the file cannot be opened.", file.string()));
  } catch (const io::error::base& error) {
    throw InputError(fmt::format("{}:{}: {}", file.string(), line_number + 1, error.what()));
  }
  table.decimal_comma_ = separator != ',';
  if (table.columns_.empty()) {
    throw InputError(fmt::format("{}: the file is empty; a header row is needed.", file.string()));
  }
  return table;
}

std::string to_csv(const Table& table) {
  std::string text;
  append_row(table.columns(), text);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    std::vector<std::string> cells;
    for (const std::string& column : table.columns()) cells.push_back(table.text(row, column));
    append_row(cells, text);
  }
  return text;
}

void write_csv(const std::filesystem::path& file, const Table& table) {
  write_whole(file, to_csv(table));
}

}  // namespace graintruth::datasets
