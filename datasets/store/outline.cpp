#include "datasets/store/outline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "datasets/store/input_error.h"
#include "datasets/store/table.h"

namespace graintruth::datasets {

namespace {

constexpr const char* time_column = "time_s";
constexpr const char* place_column = "column_m";
constexpr const char* height_column = "height_m";
constexpr const char* sigma_column = "sigma_m";

// A complaint about a row, at its line.
InputError bad_row(const Table& table, std::size_t row, const std::string& complaint) {
  return InputError(fmt::format("{}:{}: {}", table.file().string(), table.line(row), complaint));
}

// The places of columns of equal width, of which `some` are seen (m, rising).
std::vector<double> whole_grid(const Table& table, const std::vector<double>& some) {
  if (some.size() < 2) return some;
  double step = some[1] - some[0];
  for (std::size_t i = 1; i < some.size(); ++i) step = std::min(step, some[i] - some[i - 1]);
  const double count = (some.back() - some.front()) / step;
  // Many times more columns than are seen are none of equal width
  constexpr double most = 1.0e6;
  std::vector<double> grid;
  if (count < most) grid.resize(static_cast<std::size_t>(std::lround(count)) + 1);
  for (std::size_t i = 0; i < grid.size(); ++i)
    grid[i] = some.front() + static_cast<double>(i) * step;
  constexpr double rounding = 0.01;  // of a step
  for (const double place : some) {
    const auto index = static_cast<std::size_t>(std::lround((place - some.front()) / step));
    if (grid.empty() || std::abs(grid[std::min(index, grid.size() - 1)] - place) > rounding * step)
      throw InputError(
          fmt::format("{}: {} = {:.6g} does not stand a whole number of steps of {:.6g} m from "
                      "the first column; columns have equal widths",
                      table.file().string(),
                      place_column,
                      place,
                      step));
    grid[index] = place;  // with its own bits
  }
  return grid;
}

}  // namespace

void write_outline(const std::filesystem::path& file, const Outline& outline) {
  Table table({time_column, place_column, height_column, sigma_column});
  for (std::size_t moment = 0; moment < outline.time.size(); ++moment) {
    for (std::size_t place = 0; place < outline.column.size(); ++place) {
      const std::size_t i = outline.index(moment, place);
      if (!std::isfinite(outline.height[i])) continue;
      table.add({number_text(outline.time[moment]),
                 number_text(outline.column[place]),
                 number_text(outline.height[i]),
                 outline.sigma.empty() ? "" : number_text(outline.sigma[i])});
    }
  }
  write_csv(file, table);
}

Outline read_outline(const std::filesystem::path& file) {
  const Table table = read_csv(file);
  const std::vector<double> times = table.numbers(time_column);
  const std::vector<double> places = table.numbers(place_column);
  const std::vector<double> heights = table.numbers(height_column);
  const bool uncertain = table.has(sigma_column) && !table.is_blank(sigma_column);
  Outline outline;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (!std::isfinite(times[row]) || !std::isfinite(places[row]))
      throw bad_row(
          table, row, fmt::format("a row needs numbers in {} and {}", time_column, place_column));
    if (row > 0 && times[row] < times[row - 1])
      throw bad_row(
          table, row, fmt::format("{} goes back in time; rows stand in its order", time_column));
    if (outline.time.empty() || times[row] > outline.time.back())
      outline.time.push_back(times[row]);
  }
  std::vector<double> seen = places;
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  outline.column = whole_grid(table, seen);
  const std::size_t size = outline.time.size() * outline.column.size();
  constexpr double unseen = std::numeric_limits<double>::quiet_NaN();
  outline.height.assign(size, unseen);
  if (uncertain) outline.sigma.assign(size, unseen);
  std::size_t moment = 0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    while (outline.time[moment] < times[row]) ++moment;
    const auto place = std::lower_bound(outline.column.begin(), outline.column.end(), places[row]);
    const std::size_t i =
        outline.index(moment, static_cast<std::size_t>(place - outline.column.begin()));
    if (std::isfinite(outline.height[i]))
      throw bad_row(
          table,
          row,
          fmt::format("{} = {:.6g} stands twice at the same time", place_column, places[row]));
    outline.height[i] = heights[row];
    if (!uncertain) continue;
    outline.sigma[i] = table.number(row, sigma_column);
    if (std::isfinite(heights[row]) && !(outline.sigma[i] > 0.0))
      throw bad_row(table,
                    row,
                    fmt::format("{} is a standard uncertainty and must be above 0", sigma_column));
  }
  return outline;
}

}  // namespace graintruth::datasets
