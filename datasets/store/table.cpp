#include "datasets/store/table.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>

#include "datasets/store/input_error.h"

namespace graintruth::datasets {

namespace {

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

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
  throw InputError(fmt::format(
      "{}: column '{}' is missing; the columns are {}.", file_.string(), column, joined(columns_)));
}

const std::string& Table::text(std::size_t row, std::string_view column) const {
  return cells_.at(row).at(column_index(column));
}

double Table::number(std::size_t row, std::string_view column) const {
  const std::string_view cell = trimmed(text(row, column));
  if (cell.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::string digits(cell.front() == '+' ? cell.substr(1) : cell);
  if (decimal_comma_ && digits.find('.') == std::string::npos) {
    const std::size_t comma = digits.find(',');
    if (comma != std::string::npos) digits[comma] = '.';
  }
  double value = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size()) {
    throw InputError(fmt::format("{}:{}: column '{}' holds '{}', but a number is needed.",
                                 file_.string(),
                                 lines_.at(row),
                                 column,
                                 cell));
  }
  return value;
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
