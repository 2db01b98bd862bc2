#include "reports/page/words.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numbers>

#include "datasets/parameters/parameter.h"

namespace graintruth::reports {

namespace {

std::string with_minus(std::string digits) {
  if (!digits.empty() && digits.front() == '-') digits.replace(0, 1, "−");
  return digits;
}

std::string power_of_ten(int exponent) {
  static constexpr std::array<std::string_view, 10> raised = {
      "⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = exponent < 0 ? "10⁻" : "10";
  for (const char digit : std::to_string(std::abs(exponent)))
    text += raised.at(static_cast<std::size_t>(digit - '0'));
  return text;
}

}  // namespace

std::string decimal(double value, int decimals) {
  if (!std::isfinite(value)) return std::string(nothing);
  std::string digits = fmt::format("{:.{}f}", value, decimals);
  if (digits.find_first_not_of("-0.") == std::string::npos && digits.front() == '-')
    digits.erase(0, 1);  // no "-0.00"
  return with_minus(digits);
}

std::string significant(double value, int digits) {
  if (!std::isfinite(value)) return std::string(nothing);
  if (value == 0.0) return "0";
  const int exponent = static_cast<int>(std::floor(std::log10(std::abs(value))));
  if (exponent < -4 || exponent > 6) {
    return fmt::format(
        "{} × {}", decimal(value / std::pow(10.0, exponent), digits - 1), power_of_ten(exponent));
  }
  return decimal(value, std::max(0, digits - 1 - exponent));
}

std::string plain(double value) {
  if (!std::isfinite(value)) return std::string(nothing);
  return with_minus(fmt::format("{:.4g}", value));
}

std::string percent(double value) {
  return std::isfinite(value) ? decimal(value, 1) + "\u00a0%" : std::string(nothing);
}

std::string count(double value) { return decimal(value, 0); }

std::string seconds(double value) {
  if (!std::isfinite(value)) return std::string(nothing);
  if (value < 10.0) return decimal(value, value < 0.1 ? 3 : 1) + " s";
  const long whole = std::lround(value);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

int decimals_of_interval(double lower, double upper) {
  const double half_width = (upper - lower) / 2.0;
  if (!std::isfinite(half_width) || half_width <= 0.0) return 3;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(half_width))), 0, 6);
}

std::string to_interval(double value, double lower, double upper) {
  const double half_width = (upper - lower) / 2.0;
  const bool shows = half_width >= 1.0e-5 && half_width < 1.0e5;
  return shows ? decimal(value, decimals_of_interval(lower, upper)) : significant(value);
}

std::string interval_text(double lower, double upper) {
  if (!std::isfinite(lower) || !std::isfinite(upper)) return std::string(nothing);
  return to_interval(lower, lower, upper) + " to " + to_interval(upper, lower, upper);
}

std::string spaced(std::string_view name) {
  std::string words(name);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

std::string parameter_name(std::string_view key) {
  const auto parameter = datasets::find_parameter(key);
  return parameter ? parameter->title() : spaced(key);
}

std::string parameter_phrase(std::string_view key) {
  const auto parameter = datasets::find_parameter(key);
  return parameter ? parameter->phrase() : spaced(key);
}

std::string parameter_unit(std::string_view key) {
  const auto parameter = datasets::find_parameter(key);
  return parameter ? unit_text(parameter->unit()) : "";
}

std::string parameter_axis(std::string_view key) {
  return with_unit(parameter_name(key), parameter_unit(key));
}

std::string value_axis(std::string_view unit) {
  return with_unit("Value", unit.empty() ? "dimensionless" : unit);
}

ShownUnit shown_unit(std::string_view unit) {
  struct Known {
    std::string_view unit, shown;
    double factor;
  };
  constexpr double degrees = 180.0 / std::numbers::pi;
  static constexpr Known known[] = {{"m", "mm", 1e3},
                                    {"m/s", "mm/s", 1e3},
                                    {"kg", "g", 1e3},
                                    {"kg/s", "g/s", 1e3},
                                    {"rad", "°", degrees},
                                    {"rad/s", "°/s", degrees}};
  for (const Known& one : known)
    if (one.unit == unit) return {std::string(one.shown), one.factor};
  return {unit_text(unit)};
}

std::string unit_text(std::string_view unit) {
  if (unit == "-" || unit == "1") return "";
  std::string text;
  for (std::size_t i = 0; i < unit.size(); ++i) {
    const bool is_power = i > 0 && std::isalpha(static_cast<unsigned char>(unit[i - 1]));
    if (is_power && unit[i] == '2') {
      text += "²";
    } else if (is_power && unit[i] == '3') {
      text += "³";
    } else {
      text += unit[i];
    }
  }
  return text;
}

std::string with_unit(std::string_view title, std::string_view unit) {
  return unit.empty() ? std::string(title) : fmt::format("{} ({})", title, unit);
}

std::string identifier(std::string_view text) {
  std::string id(text);
  for (char& letter : id) {
    if (!std::isalnum(static_cast<unsigned char>(letter))) letter = '-';
  }
  return id;
}

std::string ordinal(int number) {
  static constexpr std::array<std::string_view, 13> words = {"",
                                                             "first",
                                                             "second",
                                                             "third",
                                                             "fourth",
                                                             "fifth",
                                                             "sixth",
                                                             "seventh",
                                                             "eighth",
                                                             "ninth",
                                                             "tenth",
                                                             "eleventh",
                                                             "twelfth"};
  if (number >= 1 && number < static_cast<int>(words.size()))
    return std::string(words.at(static_cast<std::size_t>(number)));
  const int last = number % 10;
  const bool teen = number % 100 >= 11 && number % 100 <= 13;
  return fmt::format("{}{}",
                     number,
                     teen        ? "th"
                     : last == 1 ? "st"
                     : last == 2 ? "nd"
                     : last == 3 ? "rd"
                                 : "th");
}

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i > 0) text += i + 1 == parts.size() ? " and " : ", ";
    text += parts[i];
  }
  return text;
}

}  // namespace graintruth::reports
