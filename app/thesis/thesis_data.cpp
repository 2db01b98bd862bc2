#include "app/thesis/thesis_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "datasets/store/input_error.h"
#include "datasets/store/units.h"

namespace graintruth::app {

namespace {

using datasets::InputError;
using datasets::Table;
using datasets::Unit;

constexpr std::array units = {Unit{"", 1.0},         Unit{"-", 1.0},
                              Unit{"m", 1.0},        Unit{"cm", 1e-2},
                              Unit{"mm", 1e-3},      Unit{"kg", 1.0},
                              Unit{"g", 1e-3},       Unit{"g/cm3", 1e3},
                              Unit{"kg/m3", 1.0},    Unit{"g/cm2", 10.0},
                              Unit{"GPa", 1e9},      Unit{"s", 1.0},
                              Unit{"N", 1.0},        Unit{"m/s", 1.0},
                              Unit{"cm/s", 1e-2},    Unit{"m/s2", 1.0},
                              Unit{"rad/s", 1.0},    Unit{"rad/s2", 1.0},
                              Unit{"kg m2", 1.0},    Unit{"deg", datasets::radians_per_degree},
                              Unit{"percent", 1e-2}, Unit{"frames/s", 1.0}};

std::optional<double> as_number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

int decimals_of(std::string_view mantissa) {
  const auto point = mantissa.find('.');
  return point == std::string_view::npos ? 0 : static_cast<int>(mantissa.size() - point - 1);
}

}  // namespace

double unit_in_si(std::string_view unit) {
  for (const Unit& known : units) {
    if (known.suffix == unit) return known.in_si;
  }
  throw InputError(fmt::format("The unit '{}' in datasets/thesis is not known.", unit));
}

double Printed::value() const { return as_number(text).value_or(std::nan("")); }

// 82.13 -> 0.005, 1.044e-05 -> 0.0005e-5, 8843 -> 0.5
double Printed::rounding() const {
  if (decimals >= 0) return 0.5 * std::pow(10.0, -decimals);
  const auto exponent_at = text.find_first_of("eE");
  const int exponent = exponent_at == std::string::npos || !as_number(text)
                           ? 0
                           : std::stoi(text.substr(exponent_at + 1));
  return 0.5 * std::pow(10.0, exponent - decimals_of(text.substr(0, exponent_at)));
}

const Table& ThesisData::table(const std::string& name) const {
  const auto known = tables_.find(name);
  if (known != tables_.end()) return known->second;
  return tables_.emplace(name, datasets::read_csv(folder_ / (name + ".csv"))).first->second;
}

std::size_t ThesisData::row_of(const Table& table, const std::string& quantity) const {
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (table.text(row, table.columns().front()) == quantity) return row;
  }
  throw InputError(fmt::format("{}: there is no row '{}'.", table.file().string(), quantity));
}

Printed ThesisData::printed(const std::string& name, const std::string& quantity) const {
  const Table& from = table(name);
  const std::size_t row = row_of(from, quantity);
  return {from.text(row, from.has("value") ? "value" : "printed"),
          from.has("unit") ? from.text(row, "unit") : "",
          from.text(row, "source")};
}

double ThesisData::number(const std::string& name, const std::string& quantity) const {
  const Table& from = table(name);
  return from.number(row_of(from, quantity), from.has("value") ? "value" : "printed");
}

double ThesisData::si(const std::string& name, const std::string& quantity) const {
  const Table& from = table(name);
  return number(name, quantity) * unit_in_si(from.text(row_of(from, quantity), "unit"));
}

Printed ThesisData::cell(const std::string& name,
                         std::size_t row,
                         const std::string& column,
                         const std::string& unit) const {
  const Table& from = table(name);
  return {from.text(row, column), unit, from.has("source") ? from.text(row, "source") : ""};
}

Printed ThesisData::column_cell(const std::string& name,
                                std::size_t row,
                                const std::string& column,
                                const std::string& unit) const {
  Printed printed = cell(name, row, column, unit);
  const Table& from = table(name);
  for (std::size_t other = 0; other < from.rows(); ++other)
    printed.decimals = std::max(printed.decimals, decimals_of(from.text(other, column)));
  return printed;
}

Printed ThesisData::worded(const std::string& target, const std::string& where) const {
  const Table& from = table("worded_numbers");
  for (std::size_t row = 0; row < from.rows(); ++row) {
    if (from.text(row, "target") == target && from.text(row, "where") == where) {
      return {from.text(row, "printed"), from.text(row, "unit"), from.text(row, "source")};
    }
  }
  throw InputError(
      fmt::format("{}: there is no row '{}' of {}.", from.file().string(), where, target));
}

std::vector<double> ThesisData::settings(const std::string& study,
                                         const std::string& quantity) const {
  const Table& from = table("resimulation");
  for (std::size_t row = 0; row < from.rows(); ++row) {
    if (from.text(row, "study") != study || from.text(row, "quantity") != quantity) continue;
    const double unit = unit_in_si(from.text(row, "unit"));
    std::vector<double> values;
    std::string_view rest = from.text(row, "value");
    while (true) {
      const auto end = rest.find(';');
      const auto value = as_number(rest.substr(0, end));
      if (!value) {
        throw InputError(fmt::format("{}:{}: '{}' is no number.",
                                     from.file().string(),
                                     from.line(row),
                                     rest.substr(0, end)));
      }
      values.push_back(*value * unit);
      if (end == std::string_view::npos) return values;
      rest.remove_prefix(end + 1);
    }
  }
  throw InputError(
      fmt::format("{}: there is no row '{}' of {}.", from.file().string(), quantity, study));
}

double ThesisData::setting(const std::string& study, const std::string& quantity) const {
  return settings(study, quantity).front();
}

int ThesisData::count(const std::string& study, const std::string& quantity) const {
  return static_cast<int>(std::lround(setting(study, quantity)));
}

std::string ThesisData::settings_text(const std::string& study) const {
  return settings_text(study, [](const std::string&) { return true; });
}

std::string ThesisData::settings_text_of_a_run(const std::string& study) const {
  return settings_text(study, [](const std::string& quantity) {
    return quantity != "seeds" && !quantity.ends_with("_tolerance");
  });
}

std::string ThesisData::settings_text(
    const std::string& study, const std::function<bool(const std::string&)>& is_told) const {
  const Table& from = table("resimulation");
  std::string text;
  for (std::size_t row = 0; row < from.rows(); ++row) {
    if (from.text(row, "study") != study || !is_told(from.text(row, "quantity"))) continue;
    text += fmt::format(
        "{}={} {};", from.text(row, "quantity"), from.text(row, "value"), from.text(row, "unit"));
  }
  return text;
}

std::vector<Erratum> ThesisData::errata() const {
  const Table& from = table("errata");
  std::vector<Erratum> all;
  for (std::size_t row = 0; row < from.rows(); ++row) {
    all.push_back({.number = from.integer(row, "errata"),
                   .tag = from.text(row, "tag"),
                   .target = from.text(row, "target"),
                   .where = from.text(row, "where"),
                   .printed = from.text(row, "printed"),
                   .correct = from.text(row, "correct"),
                   .evidence = from.text(row, "evidence")});
  }
  return all;
}

}  // namespace graintruth::app
