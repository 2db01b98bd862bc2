#include "datasets/store/numerals.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

namespace graintruth::datasets {

namespace {

constexpr std::array<std::string_view, 7> words_for_nothing = {
    "NA", "N/A", "#N/A", "#NV", "null", "NULL", "None"};

// Marks between thousands that never are anything else: blanks (plain, no-break, thin, narrow) and
// apostrophes.
constexpr std::array<std::string_view, 6> quiet_marks = {
    " ", "\u00a0", "\u2009", "\u202f", "'", "\u2019"};
constexpr std::string_view minus_sign = "\u2212";

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

bool is_digit(char letter) { return letter >= '0' && letter <= '9'; }

bool is_all_digits(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), is_digit);
}

// Whether thousands are marked as they are: 1 to 3 digits, of which the first is no 0, then threes.
bool is_grouped(std::string_view digits, char mark) {
  std::size_t begin = 0;
  for (bool is_first = true;; is_first = false) {
    const std::size_t end = std::min(digits.find(mark, begin), digits.size());
    const std::string_view group = digits.substr(begin, end - begin);
    if (!is_all_digits(group) || group.size() > 3 || (!is_first && group.size() != 3) ||
        (is_first && group.front() == '0'))
      return false;
    if (end == digits.size()) return !is_first;
    begin = end + 1;
  }
}

// A number taken apart, its quiet marks gone.
struct Shape {
  bool is_negative = false;
  std::string digits;    // with commas and points
  std::string exponent;  // "e-5", or nothing
  std::size_t commas = 0, points = 0;
  bool has_no_marked_thousands = false;  // a single comma or point is a decimal one

  bool is_plain() const { return commas == 0 && points == 0; }
};

std::optional<Shape> shape_of(std::string_view cell) {
  Shape shape;
  // 1. Sign and exponent
  if (cell.starts_with(minus_sign)) {
    shape.is_negative = true;
    cell.remove_prefix(minus_sign.size());
  } else if (cell.starts_with('-') || cell.starts_with('+')) {
    shape.is_negative = cell.front() == '-';
    cell.remove_prefix(1);
  }
  if (const std::size_t e = cell.find_first_of("eE"); e != std::string_view::npos) {
    std::string_view power = cell.substr(e + 1);
    const bool is_below_one = power.starts_with('-') || power.starts_with(minus_sign);
    if (is_below_one || power.starts_with('+'))
      power.remove_prefix(power.starts_with(minus_sign) ? minus_sign.size() : 1);
    if (!is_all_digits(power)) return std::nullopt;
    shape.exponent = fmt::format("e{}{}", is_below_one ? "-" : "", power);
    shape.has_no_marked_thousands = true;
    cell = cell.substr(0, e);
  }
  // 2. Digits and marks; every quiet mark becomes a blank
  bool is_quietly_grouped = false;
  while (!cell.empty()) {
    const char letter = cell.front();
    std::size_t length = 1;
    if (is_digit(letter) || letter == ',' || letter == '.') {
      shape.digits += letter;
      shape.commas += letter == ',';
      shape.points += letter == '.';
    } else {
      const auto mark = std::find_if(quiet_marks.begin(),
                                     quiet_marks.end(),
                                     [&](std::string_view each) { return cell.starts_with(each); });
      if (mark == quiet_marks.end()) return std::nullopt;
      shape.digits += ' ';
      is_quietly_grouped = true;
      length = mark->size();
    }
    cell.remove_prefix(length);
  }
  if (std::none_of(shape.digits.begin(), shape.digits.end(), is_digit)) return std::nullopt;
  // 3. Quiet marks stand between thousands, and one comma or point at most is behind them.
  if (is_quietly_grouped) {
    const std::size_t end = std::min(shape.digits.find_first_of(",."), shape.digits.size());
    if (shape.commas + shape.points > 1 ||
        !is_grouped(std::string_view(shape.digits).substr(0, end), ' ') ||
        shape.digits.find(' ', end) != std::string::npos)
      return std::nullopt;
    shape.digits.erase(std::remove(shape.digits.begin(), shape.digits.end(), ' '),
                       shape.digits.end());
    shape.has_no_marked_thousands = true;  // by commas or points, as a blank does it
  }
  return shape;
}

// What a cell says about one of the two marks.
enum class Meaning { none, decimal, thousands, open, impossible };

Meaning meaning_of(const Shape& shape, char mark) {
  const char other = mark == ',' ? '.' : ',';
  const std::size_t marks = mark == ',' ? shape.commas : shape.points;
  const std::size_t others = mark == ',' ? shape.points : shape.commas;
  if (marks == 0) return Meaning::none;
  const std::string_view digits = shape.digits;
  const std::size_t first = digits.find(mark);
  if (others > 0) {
    // The one that comes last is decimal, the other groups what is before it.
    const bool is_last = digits.rfind(other) < first;
    const std::size_t split = is_last ? first : digits.find(other);
    if ((is_last ? marks : others) != 1 ||
        !is_grouped(digits.substr(0, split), is_last ? other : mark))
      return Meaning::impossible;
    return is_last ? Meaning::decimal : Meaning::thousands;
  }
  if (marks > 1) return is_grouped(digits, mark) ? Meaning::thousands : Meaning::impossible;
  const bool may_be_thousands = !shape.has_no_marked_thousands && is_grouped(digits, mark);
  return may_be_thousands ? Meaning::open : Meaning::decimal;
}

bool is_possible(const Shape& shape) {
  return meaning_of(shape, ',') != Meaning::impossible &&
         meaning_of(shape, '.') != Meaning::impossible;
}

std::optional<double> from_text(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// The number with its marks taken as said: the decimal one, and the one that is left out.
std::optional<double> value_of(const Shape& shape, char decimal, char thousands) {
  std::string text = shape.is_negative ? "-" : "";
  for (const char letter : shape.digits) {
    if (letter == thousands) continue;
    text += letter == decimal ? '.' : letter;
  }
  return from_text(text + shape.exponent);
}

}  // namespace

bool is_missing(std::string_view cell) {
  cell = trimmed(cell);
  if (cell.empty() || std::find(words_for_nothing.begin(), words_for_nothing.end(), cell) !=
                          words_for_nothing.end())
    return true;
  if (is_digit(cell.front())) return false;
  const auto value = from_text(cell);
  return value && std::isnan(*value);
}

bool is_numeral(std::string_view cell) {
  cell = trimmed(cell);
  if (is_missing(cell)) return true;
  const auto shape = shape_of(cell);
  return (shape && is_possible(*shape)) || from_text(cell);  // "inf"
}

std::optional<double> read_numeral(std::string_view cell, const NumberStyle& style) {
  cell = trimmed(cell);
  if (is_missing(cell)) return std::numeric_limits<double>::quiet_NaN();
  // As nearly every cell is written
  if (style.point == MarkRole::decimal) {
    if (const auto value = from_text(cell.front() == '+' ? cell.substr(1) : cell)) return value;
  }
  const auto shape = shape_of(cell);
  if (!shape)
    return from_text(cell.find_first_of("0123456789") == std::string_view::npos
                         ? cell
                         : std::string_view());  // "inf"
  char decimal = '\0', thousands = '\0';
  for (const auto& [mark, role] : {std::pair(',', style.comma), std::pair('.', style.point)}) {
    const Meaning meaning = meaning_of(*shape, mark);
    if (meaning == Meaning::none) continue;
    if (role == MarkRole::decimal && (meaning == Meaning::decimal || meaning == Meaning::open)) {
      decimal = mark;
    } else if (role == MarkRole::thousands &&
               (meaning == Meaning::thousands || meaning == Meaning::open)) {
      thousands = mark;
    } else {
      return std::nullopt;
    }
  }
  return value_of(*shape, decimal, thousands);
}

void NumberVote::hear(std::string_view cell, std::size_t column, int line) {
  cell = trimmed(cell);
  if (is_missing(cell)) return;
  // Most cells say once more what the first of them said.
  if (point_.decimal && std::count(cell.begin(), cell.end(), '.') == 1 &&
      cell.find_first_not_of("0123456789.-") == std::string_view::npos)
    return;
  const auto shape = shape_of(cell);
  if (!shape || !is_possible(*shape)) return;
  Column& numbers = columns_[column];
  if (shape->commas + shape->points == 0) {
    numbers.plain.push_back(std::abs(value_of(*shape, '\0', '\0').value_or(0.0)));
    return;
  }
  const auto consider = [&](char letter, Mark& mark, OpenMarks& open) {
    const Meaning meaning = meaning_of(*shape, letter);
    const Witness witness{std::string(cell), column, line};
    if (meaning == Meaning::decimal && !mark.decimal) mark.decimal = witness;
    if (meaning == Meaning::thousands && !mark.thousands) mark.thousands = witness;
    if (meaning != Meaning::open) return;
    const double value = std::abs(*value_of(*shape, letter, '\0'));
    open.least = open.count == 0 ? value : std::min(open.least, value);
    open.most = std::max(open.most, value);
    ++open.count;
  };
  consider(',', comma_, numbers.comma);
  consider('.', point_, numbers.point);
}

// How much the numbers with such a mark look like those of 1000 and more of a column of whole
// numbers. Two things must be so. The whole numbers have no hole where the mark begins: the least
// marked one is at most twice the largest plain one. And as decimals they could not be: all of them
// would lie below some of the plain ones, which chance does to n marked and k plain numbers once in
// n + k over k times.
NumberVote::Likeness NumberVote::likeness(OpenMarks Column::*marks) const {
  constexpr double surely_not_chance = 20.0;  // 5 %
  Likeness likeness = Likeness::none;
  for (const Column& column : columns_) {
    const OpenMarks& open = column.*marks;
    if (open.count == 0) continue;
    likeness = std::max(likeness, column.plain.empty() ? Likeness::only_marked : Likeness::unlike);
    if (column.plain.empty()) continue;
    const double largest = *std::max_element(column.plain.begin(), column.plain.end());
    if (1000.0 * open.least > 2.0 * largest) continue;
    const auto above = static_cast<std::size_t>(std::count_if(
        column.plain.begin(), column.plain.end(), [&](double plain) { return plain > open.most; }));
    double ways = 1.0;  // n + k over k
    for (std::size_t i = 1; i <= above && ways < surely_not_chance; ++i)
      ways *= static_cast<double>(open.count + i) / static_cast<double>(i);
    likeness = std::max(likeness, ways < surely_not_chance ? Likeness::perhaps : Likeness::surely);
  }
  return likeness;
}

std::string NumberVote::words(const Witness& witness) const {
  return fmt::format(
      "'{}' in line {}, column '{}'", witness.cell, witness.line, names_[witness.column]);
}

NumberStyle NumberVote::decide(char separator) const {
  const auto unclear = [](std::string complaint) {
    return NumberStyle{MarkRole::unclear, MarkRole::unclear, std::move(complaint)};
  };
  // 1. What allows one style alone
  for (const auto& [one, other] : {std::pair(&comma_.decimal, &point_.decimal),
                                   std::pair(&comma_.decimal, &comma_.thousands),
                                   std::pair(&point_.decimal, &point_.thousands),
                                   std::pair(&comma_.thousands, &point_.thousands)}) {
    if (!*one || !*other) continue;
    return unclear(
        fmt::format("but the numbers of the file contradict each other: {}, and {}; "
                    "write all with a decimal point and nothing between thousands",
                    words(**one),
                    words(**other)));
  }
  // Who marks thousands marks them in all numbers of a column.
  const auto stands_beside_unmarked_thousands = [&](OpenMarks Column::*marks) {
    return std::any_of(columns_.begin(), columns_.end(), [&](const Column& column) {
      return (column.*marks).count > 0 && std::any_of(column.plain.begin(),
                                                      column.plain.end(),
                                                      [](double plain) { return plain >= 1000.0; });
    });
  };
  const NumberStyle english{MarkRole::thousands, MarkRole::decimal, {}};
  const NumberStyle german{MarkRole::decimal, MarkRole::thousands, {}};
  if (comma_.decimal || point_.thousands) return german;
  if (point_.decimal || comma_.thousands) return english;
  const bool comma_is_decimal = stands_beside_unmarked_thousands(&Column::comma);
  const bool point_is_decimal = stands_beside_unmarked_thousands(&Column::point);
  if (comma_is_decimal != point_is_decimal) return comma_is_decimal ? german : english;
  // 2. Marks before three digits everywhere
  const Likeness commas = likeness(&Column::comma), points = likeness(&Column::point);
  if (commas == Likeness::surely && points != Likeness::surely) return english;
  if (points == Likeness::surely && commas != Likeness::surely && separator != ',') return german;
  const auto either = [&](std::string_view mark) {
    return unclear(fmt::format(
        "and its {0} may be a decimal one or stand between thousands: every {0} of the file stands "
        "before three digits; write all numbers with a decimal point and nothing between thousands",
        mark));
  };
  if (commas == Likeness::none) {
    if (points == Likeness::perhaps && separator != ',') return either("point");
    return english;
  }
  if (points == Likeness::none && commas == Likeness::only_marked && separator == ';')
    return german;
  return either("comma");
}

}  // namespace graintruth::datasets
