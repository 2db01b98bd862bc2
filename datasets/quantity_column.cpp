#include "datasets/quantity_column.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cctype>
#include <cmath>
#include <string>

#include "datasets/input_error.h"

namespace graintruth::datasets {

namespace {

// Lower case, marks as single underscores, "/" and "per" left out: "Q (g/s)" and q_g_per_s both
// become q_g_s.
std::string plain_name(std::string_view name) {
  std::string result;
  for (const char letter : name) {
    const auto byte = static_cast<unsigned char>(letter);
    if (std::isalnum(byte) != 0) {
      result += static_cast<char>(std::tolower(byte));
    } else if (!result.empty() && result.back() != '_') {
      result += '_';
    }
  }
  while (!result.empty() && result.back() == '_') result.pop_back();
  for (std::size_t at = result.find("_per_"); at != std::string::npos; at = result.find("_per_"))
    result.replace(at, 5, "_");
  return result;
}

struct Found {
  std::string column;
  double in_si = 1.0;
};

std::optional<Found> find_column(const Table& table, const Quantity& quantity) {
  std::optional<Found> found;
  for (const std::string& column : table.columns()) {
    const std::string plain = plain_name(column);
    for (const std::string_view name : quantity.names) {
      for (const Unit& unit : quantity.units) {
        const std::string wanted =
            unit.suffix.empty() ? std::string(name) : fmt::format("{}_{}", name, unit.suffix);
        if (plain != plain_name(wanted)) continue;
        if (found) {
          throw InputError(fmt::format("{}: columns '{}' and '{}' could both be {}; leave one.",
                                       table.file().string(),
                                       found->column,
                                       column,
                                       quantity.words));
        }
        found = Found{column, unit.in_si};
      }
    }
  }
  return found;
}

std::vector<double> checked_quantity(const Table& table, const Quantity& quantity, bool positive) {
  const auto values = find_quantity(table, quantity);
  if (!values) {
    std::vector<std::string> wanted;
    for (const Unit& unit : quantity.units)
      wanted.push_back(fmt::format("'{}_{}'", quantity.names.front(), unit.suffix));
    throw InputError(
        fmt::format("{}: no column tells {}; call it {} (other names: {}). The columns "
                    "are {}.",
                    table.file().string(),
                    quantity.words,
                    fmt::join(wanted, " or "),
                    fmt::join(quantity.names.subspan(1), ", "),
                    fmt::join(table.columns(), ", ")));
  }
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

std::optional<std::vector<double>> find_quantity(const Table& table, const Quantity& quantity) {
  const auto found = find_column(table, quantity);
  if (!found) return std::nullopt;
  std::vector<double> values = table.numbers(found->column);
  for (double& value : values) value *= found->in_si;
  return values;
}

std::vector<double> positive_quantity(const Table& table, const Quantity& quantity) {
  return checked_quantity(table, quantity, true);
}

std::vector<double> finite_quantity(const Table& table, const Quantity& quantity) {
  return checked_quantity(table, quantity, false);
}

}  // namespace graintruth::datasets
