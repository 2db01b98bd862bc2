// Numbers and names as a reader wants them: as many digits as mean something, one spelling a thing.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace graintruth::reports {

inline constexpr std::string_view nothing = "–";  // in place of a number that is not there

// Fixed decimals with a typographic minus; `nothing` for NaN.
std::string decimal(double value, int decimals);
// Three significant digits; 1.2 × 10⁻⁵ where fixed notation would be long.
std::string significant(double value, int digits = 3);
// As a person would type it, at most four digits: 0.83, 50.
std::string plain(double value);
std::string percent(double value);  // "82.0 %", with a space that does not break
std::string count(double value);
std::string seconds(double value);  // "0.8 s", "4 min 10 s", "2 h 5 min"

// Decimals that show two digits of an interval's half-width; 3 where there is no interval.
int decimals_of_interval(double lower, double upper);
// A value to these decimals; three digits of it where there is no interval, or one so small or so
// large that decimals would be many or none.
std::string to_interval(double value, double lower, double upper);
// "0.10 to 0.14"; `nothing` where an end is not known.
std::string interval_text(double lower, double upper);

// Underscores become spaces.
std::string spaced(std::string_view name);
// The registry's title: "Friction, particle to particle"; a name that it does not know is spaced().
std::string parameter_name(std::string_view key);
// The registry's phrase for the middle of a sentence: "friction between particles".
std::string parameter_phrase(std::string_view key);
// Its unit, "" for pure numbers; and its name with that.
std::string parameter_unit(std::string_view key);
std::string parameter_axis(std::string_view key);
// "Value (Pa)", of an axis that parameters in one unit share.
std::string value_axis(std::string_view unit);

// A unit of the files as the reader expects it on an axis, and by what a value is multiplied for
// it: "m" is shown as mm, 1000 of them. A unit that is not known stays as it is.
struct ShownUnit {
  std::string text;  // "" for pure numbers
  double factor = 1.0;
};
ShownUnit shown_unit(std::string_view unit);
// "kg/m2" -> "kg/m²"; "" for "-".
std::string unit_text(std::string_view unit);
// "Height (mm)"; without the brackets where there is no unit.
std::string with_unit(std::string_view title, std::string_view unit);
// For the id of an element: all but letters and digits become hyphens.
std::string identifier(std::string_view text);
// 6 -> "sixth"; "13th" from the thirteenth on.
std::string ordinal(int number);
// {"a", "b", "c"} -> "a, b and c"
std::string joined(const std::vector<std::string>& parts);

}  // namespace graintruth::reports
