#include "datasets/imports/quantity_column.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>

#include "datasets/store/input_error.h"

namespace graintruth::datasets {

namespace {

// Lower case, marks as single underscores, "/" and "per" left out: "Q (g/s)" and q_g_per_s both
// become q_g_s. The sign for micro, of which there are two, becomes u.
std::string plain_name(std::string_view name) {
  std::string result;
  for (std::size_t at = 0; at < name.size(); ++at) {
    auto byte = static_cast<unsigned char>(name[at]);
    const std::string_view two = name.substr(at, 2);
    if (two == "\u00b5" || two == "\u03bc") {
      byte = 'u';
      ++at;
    }
    if (std::isalnum(byte) != 0) {
      result += static_cast<char>(std::tolower(byte));
    } else if (!result.empty() && result.back() != '_') {
      result += '_';
    }
  }
  while (!result.empty() && result.back() == '_') result.pop_back();
  for (std::size_t at = result.find("_per_"); at != std::string::npos; at = result.find("_per_"))
    result.erase(at, 4);
  return result;
}

// "'x_m', 'x_cm' or 'x_mm'": how a column of this quantity may be called.
std::string spellings(const Quantity& quantity) {
  const std::string_view name =
      quantity.names.empty() ? quantity.exact_names.front() : quantity.names.front();
  std::vector<std::string> wanted;
  for (const Unit& unit : quantity.units)
    wanted.push_back(unit.suffix.empty() ? fmt::format("'{}'", name)
                                         : fmt::format("'{}_{}'", name, unit.suffix));
  return fmt::format("{}", fmt::join(wanted, " or "));
}

// Names that this column may have: of exact ones those that it begins with, capital for capital.
std::vector<std::string_view> names_for(std::string_view column, const Quantity& quantity) {
  std::vector<std::string_view> names(quantity.names.begin(), quantity.names.end());
  const std::size_t first = std::min(column.find_first_not_of(" \t"), column.size());
  for (const std::string_view name : quantity.exact_names)
    if (column.substr(first).starts_with(name)) names.push_back(name);
  return names;
}

// The unit of a column that is called as this quantity is.
std::optional<Unit> unit_of(std::string_view column, const Quantity& quantity) {
  const std::string called = plain_name(column);
  for (const std::string_view name : names_for(column, quantity)) {
    for (const Unit& unit : quantity.units) {
      const std::string wanted =
          unit.suffix.empty() ? std::string(name) : fmt::format("{}_{}", name, unit.suffix);
      if (called == plain_name(wanted)) return unit;
    }
  }
  return std::nullopt;
}

// What is wrong with a column that nearly is it: it has no value, or no unit.
std::string near_miss(const Table& table, const Quantity& quantity) {
  for (const std::string& column : table.columns()) {
    if (unit_of(column, quantity)) return fmt::format(" Column '{}' holds no value.", column);
    const std::string called = plain_name(column);
    for (const std::string_view name : names_for(column, quantity)) {
      if (called == plain_name(name))
        return fmt::format(" Column '{}' has the name, but no unit.", column);
    }
  }
  return "";
}

// Throws where a column has the name, and a unit in brackets that nobody knows.
void refuse_unknown_unit(const Table& table, const Quantity& quantity) {
  for (const std::string& column : table.columns()) {
    const std::size_t bracket = column.find_first_of("([");
    if (bracket == std::string::npos || table.is_blank(column)) continue;
    const std::string wanted = plain_name(column.substr(0, bracket));
    for (const std::string_view name : names_for(column, quantity)) {
      if (wanted != plain_name(name)) continue;
      throw InputError(fmt::format("{}: column '{}' has a unit that is not known; call it {}{}.",
                                   table.file().string(),
                                   column,
                                   spellings(quantity),
                                   table.header_words()));
    }
  }
}

// Throws where a column has the name and no unit: an optional one would be passed over.
void refuse_missing_unit(const Table& table, const Quantity& quantity) {
  for (const std::string& column : table.columns()) {
    for (const std::string_view name : names_for(column, quantity)) {
      if (plain_name(column) != plain_name(name)) continue;
      throw InputError(fmt::format("{}: column '{}' has no unit; call it {}.",
                                   table.file().string(),
                                   column,
                                   spellings(quantity)));
    }
  }
}

std::vector<double> checked_quantity(const Table& table, const Quantity& quantity, bool positive) {
  required_column(table, quantity);
  const auto values = find_quantity(table, quantity);
  for (std::size_t row = 0; row < values->size(); ++row) {
    const double value = (*values)[row];
    if (std::isfinite(value) && (!positive || value > 0.0)) continue;
    throw InputError(fmt::format("{}:{}: {} is {}, but it must be {}.",
                                 table.file().string(),
                                 table.line(row),
                                 quantity.words,
                                 std::isnan(value) ? "missing" : number_text(value) + " in SI",
                                 positive ? "a number above 0" : "a number"));
  }
  return *values;
}

}  // namespace

std::optional<QuantityColumn> find_column(const Table& table, const Quantity& quantity) {
  std::optional<QuantityColumn> found;
  for (const std::string& column : table.columns()) {
    const auto unit = unit_of(column, quantity);
    if (!unit || table.is_blank(column)) continue;
    if (found) {
      throw InputError(fmt::format("{}: columns '{}' and '{}' could both be {}; leave one.",
                                   table.file().string(),
                                   found->column,
                                   column,
                                   quantity.words));
    }
    found = QuantityColumn{column, *unit};
  }
  if (!found) refuse_unknown_unit(table, quantity);
  return found;
}

QuantityColumn required_column(const Table& table, const Quantity& quantity) {
  if (auto found = find_column(table, quantity)) return *std::move(found);
  throw InputError(fmt::format(
      "{}: no column tells {}; call it {}{}.{} The columns are {}{}.",
      table.file().string(),
      quantity.words,
      spellings(quantity),
      quantity.names.size() > 1
          ? fmt::format(" (other names: {})", fmt::join(quantity.names.subspan(1), ", "))
          : std::string(),
      near_miss(table, quantity),
      fmt::join(table.columns(), ", "),
      table.header_words()));
}

std::optional<std::vector<double>> find_quantity(const Table& table, const Quantity& quantity) {
  const auto found = find_column(table, quantity);
  if (!found) return std::nullopt;
  std::vector<double> values = table.numbers(found->column);
  for (double& value : values) value *= found->unit.in_si;
  return values;
}

std::vector<double> positive_quantity(const Table& table, const Quantity& quantity) {
  return checked_quantity(table, quantity, true);
}

std::optional<std::vector<double>> find_uncertainty(const Table& table, const Quantity& quantity) {
  const auto found = find_column(table, quantity);
  if (!found) {
    refuse_missing_unit(table, quantity);
    return std::nullopt;
  }
  const auto values = find_quantity(table, quantity);
  for (std::size_t row = 0; row < values->size(); ++row) {
    if (std::isfinite((*values)[row]) && (*values)[row] > 0.0) continue;
    const std::string& cell = table.text(row, found->column);
    throw InputError(fmt::format(
        "{}:{}: column '{}', {}, is {}, but it must be a number above 0 in every row. Write it, or "
        "remove the row, or the whole column.",
        table.file().string(),
        table.line(row),
        found->column,
        quantity.words,
        std::isnan((*values)[row]) ? "missing" : cell));
  }
  return values;
}

std::vector<double> finite_quantity(const Table& table, const Quantity& quantity) {
  return checked_quantity(table, quantity, false);
}

}  // namespace graintruth::datasets
