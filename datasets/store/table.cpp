#include "datasets/store/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "datasets/store/input_error.h"

namespace graintruth::datasets {

namespace {

std::string joined(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

}  // namespace

bool Table::has(std::string_view column) const {
  for (const std::string& name : columns_)
    if (name == column) return true;
  return false;
}

std::size_t Table::column_index(std::string_view column) const {
  for (std::size_t i = 0; i < columns_.size(); ++i)
    if (columns_[i] == column) return i;
  throw InputError(fmt::format("{}: column '{}' is missing; the columns are {}{}.",
                               file_.string(),
                               column,
                               joined(columns_),
                               header_words()));
}

const std::string& Table::text(std::size_t row, std::string_view column) const {
  return cells_.at(row).at(column_index(column));
}

double Table::number(std::size_t row, std::string_view column) const {
  const std::string& cell = text(row, column);
  if (const auto value = read_numeral(cell, style_)) return *value;
  const bool is_unclear = !style_.complaint.empty() && is_numeral(cell);
  throw InputError(fmt::format("{}:{}: column '{}' holds '{}', {}.",
                               file_.string(),
                               lines_.at(row),
                               column,
                               cell,
                               is_unclear ? style_.complaint : "but a number is needed"));
}

bool Table::is_number(std::size_t row, std::string_view column) const {
  const std::string& cell = text(row, column);
  return !is_missing(cell) && is_numeral(cell);
}

bool Table::is_blank(std::string_view column) const {
  const std::size_t index = column_index(column);
  return !cells_.empty() && std::all_of(cells_.begin(), cells_.end(), [&](const auto& row) {
    return is_missing(row[index]);
  });
}

std::string Table::header_words() const {
  return header_line_ > 0 ? fmt::format(" (line {} was taken for the header)", header_line_) : "";
}

Table Table::emptied(std::vector<std::string> columns) const {
  Table other(std::move(columns), file_);
  other.notes_ = notes_;
  other.header_line_ = header_line_;
  other.style_ = style_;
  return other;
}

int Table::integer(std::size_t row, std::string_view column) const {
  const double value = number(row, column);
  if (!(std::abs(value) < 2.0e9) || value != std::floor(value)) {
    throw InputError(fmt::format("{}:{}: column '{}' holds '{}', but a whole number is needed.",
                                 file_.string(),
                                 lines_.at(row),
                                 column,
                                 text(row, column)));
  }
  return static_cast<int>(value);
}

std::vector<double> Table::numbers(std::string_view column) const {
  std::vector<double> values(rows());
  for (std::size_t row = 0; row < rows(); ++row) values[row] = number(row, column);
  return values;
}

void Table::add(std::vector<std::string> cells) {
  add(std::move(cells), static_cast<int>(cells_.size()) + 2);
}

void Table::add(std::vector<std::string> cells, int line) {
  if (cells.size() != columns_.size()) {
    throw std::logic_error(
        fmt::format("a row of {} cells under {} columns", cells.size(), columns_.size()));
  }
  cells_.push_back(std::move(cells));
  lines_.push_back(line);
}

std::string number_text(double value) {
  if (std::isnan(value)) return "";
  return fmt::format("{}", value);
}

}  // namespace graintruth::datasets
