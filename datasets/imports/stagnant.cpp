#include "datasets/imports/stagnant.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace graintruth::datasets {

namespace {

constexpr double rows_a_diameter = 8.0;
constexpr std::size_t hole_rows = 4;  // half a diameter: holes between neighbours are smaller

}  // namespace

double stagnant_speed(double diameter, double gravity) {
  return 0.1 * diameter / std::sqrt(2.0 * diameter / gravity);
}

StagnantMap make_stagnant_map(double width, double height, double diameter) {
  const auto count = [](double length, double step) {
    return static_cast<std::size_t>(std::max(1.0, std::round(length / step)));
  };
  StagnantMap map;
  const std::size_t columns = count(width, 0.5 * diameter),
                    rows = count(height, diameter / rows_a_diameter);
  for (std::size_t i = 0; i < columns; ++i)
    map.x.push_back(width * ((static_cast<double>(i) + 0.5) / static_cast<double>(columns) - 0.5));
  for (std::size_t i = 0; i < rows; ++i)
    map.z.push_back(height * (static_cast<double>(i) + 0.5) / static_cast<double>(rows));
  map.ground.assign(columns * rows, Ground::empty);
  return map;
}

std::vector<double> stagnant_heights(const StagnantMap& map, double orifice_width) {
  std::vector<double> heights;
  const double row_height = map.z.empty() ? 0.0 : 2.0 * map.z.front();
  for (std::size_t column = 0; column < map.x.size(); ++column) {
    if (std::abs(map.x[column]) < 0.5 * orifice_width) {
      heights.push_back(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    std::size_t top = 0;  // rows below the boundary
    for (std::size_t row = 0; row < map.z.size() && row <= top + hole_rows; ++row) {
      if (map.at(column, row) == Ground::moving) break;
      if (map.at(column, row) == Ground::still) top = row + 1;
    }
    heights.push_back(static_cast<double>(top) * row_height);
  }
  return heights;
}

double stagnant_overlap(const StagnantMap& a, const StagnantMap& b) {
  long both = 0, either = 0;
  for (std::size_t i = 0; i < a.ground.size(); ++i) {
    const bool in_a = a.ground[i] == Ground::still, in_b = b.ground[i] == Ground::still;
    both += in_a && in_b;
    either += in_a || in_b;
  }
  return either > 0 ? static_cast<double>(both) / static_cast<double>(either) : 1.0;
}

double stagnant_overlap(std::span<const double> a, std::span<const double> b) {
  double both = 0.0, either = 0.0;
  bool is_known = false;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (std::isnan(a[i]) || std::isnan(b[i])) continue;
    is_known = true;
    both += std::min(a[i], b[i]);
    either += std::max(a[i], b[i]);
  }
  if (!is_known) return std::numeric_limits<double>::quiet_NaN();
  return either > 0.0 ? both / either : 1.0;
}

}  // namespace graintruth::datasets
