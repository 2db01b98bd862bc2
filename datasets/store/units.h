// Units that names of keys and columns may end in, and what one of each is in SI.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace graintruth::datasets {

struct Unit {
  std::string_view suffix;
  double in_si;
};

// The units in which a kind of quantity may be given; the first is SI.
using Units = std::span<const Unit>;
inline constexpr double radians_per_degree = 3.14159265358979323846 / 180.0;
inline constexpr std::array length_units{Unit{"m", 1.0}, Unit{"cm", 1e-2}, Unit{"mm", 1e-3}};
inline constexpr std::array speed_units{
    Unit{"m_per_s", 1.0}, Unit{"cm_per_s", 1e-2}, Unit{"mm_per_s", 1e-3}};
inline constexpr std::array acceleration_units{Unit{"m_per_s2", 1.0}};
inline constexpr std::array angle_units{Unit{"rad", 1.0}, Unit{"deg", radians_per_degree}};
inline constexpr std::array mass_units{Unit{"kg", 1.0}, Unit{"g", 1e-3}};
inline constexpr std::array pressure_units{
    Unit{"pa", 1.0}, Unit{"kpa", 1e3}, Unit{"mpa", 1e6}, Unit{"gpa", 1e9}};
inline constexpr std::array time_units{Unit{"s", 1.0}, Unit{"ms", 1e-3}};
inline constexpr std::array time_limit_units{Unit{"s", 1.0}, Unit{"min", 60.0}, Unit{"h", 3600.0}};
inline constexpr std::array scale_units{
    Unit{"px_per_m", 1.0}, Unit{"px_per_cm", 1e2}, Unit{"px_per_mm", 1e3}};
inline constexpr std::array pixel_units{Unit{"px", 1.0}};
inline constexpr std::array rate_units{Unit{"hz", 1.0}};
inline constexpr std::array mass_rate_units{Unit{"kg_per_s", 1.0},
                                            Unit{"g_per_s", 1e-3},
                                            Unit{"g_per_min", 1e-3 / 60.0},
                                            Unit{"kg_per_h", 1.0 / 3600.0}};
inline constexpr std::array areal_density_units{Unit{"kg_per_m2", 1.0}, Unit{"g_per_cm2", 10.0}};
inline constexpr std::array density_units{Unit{"kg_per_m3", 1.0}, Unit{"g_per_cm3", 1000.0}};
inline constexpr std::array inertia_units{
    Unit{"kg_m2", 1.0}, Unit{"g_cm2", 1e-7}, Unit{"g_mm2", 1e-9}};
inline constexpr std::array turning_units{Unit{"rad_per_s", 1.0},
                                          Unit{"deg_per_s", radians_per_degree},
                                          Unit{"rpm", 6.0 * radians_per_degree}};
inline constexpr std::array stiffness_units{Unit{"n_per_m", 1.0}, Unit{"n_per_mm", 1e3}};
inline constexpr std::array plain{Unit{"", 1.0}};

// What values are allowed; the words go into the sentence when one is not.
struct Range {
  double lower;
  double upper;
  bool includes_lower;
  std::string_view words;
};
inline constexpr Range any_number{-1e300, 1e300, true, "a number"};
inline constexpr Range positive{0.0, 1e300, false, "a number above 0"};
inline constexpr Range not_negative{0.0, 1e300, true, "a number not below 0"};
// Of a time step: a longer one than Rayleigh's is unstable.
inline constexpr Range step_fraction{0.0, 1.0, false, "a share above 0 and at most 1"};

// "is -0.1, but a friction from 0 to 5 is needed": what is said of a number, as it is written,
// whose value in SI is not allowed; none where it is.
std::optional<std::string> complaint_about(double written, double in_si, const Range& range);

}  // namespace graintruth::datasets
