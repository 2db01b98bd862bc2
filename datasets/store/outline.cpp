#include "datasets/store/outline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "datasets/store/input_error.h"
#include "datasets/store/table.h"

namespace graintruth::datasets {

namespace {

constexpr const char* surface_column = "surface";
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

// One surface, of these rows of a table.
Outline read_rows(const Table& table, const std::vector<std::size_t>& rows, std::string surface) {
  const bool uncertain = table.has(sigma_column) && !table.is_blank(sigma_column);
  Outline outline;
  outline.surface = std::move(surface);
  std::vector<double> times, places, heights;
  for (const std::size_t row : rows) {
    times.push_back(table.number(row, time_column));
    places.push_back(table.number(row, place_column));
    heights.push_back(table.number(row, height_column));
  }
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (!std::isfinite(times[k]) || !std::isfinite(places[k]))
      throw bad_row(table,
                    rows[k],
                    fmt::format("a row needs numbers in {} and {}", time_column, place_column));
    if (k > 0 && times[k] < times[k - 1])
      throw bad_row(table,
                    rows[k],
                    fmt::format("{} goes back in time; rows stand in its order", time_column));
    if (outline.time.empty() || times[k] > outline.time.back()) outline.time.push_back(times[k]);
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
  for (std::size_t k = 0; k < rows.size(); ++k) {
    while (outline.time[moment] < times[k]) ++moment;
    const auto place = std::lower_bound(outline.column.begin(), outline.column.end(), places[k]);
    const std::size_t i =
        outline.index(moment, static_cast<std::size_t>(place - outline.column.begin()));
    if (std::isfinite(outline.height[i]))
      throw bad_row(
          table,
          rows[k],
          fmt::format("{} = {:.6g} stands twice at the same time", place_column, places[k]));
    outline.height[i] = heights[k];
    if (!uncertain) continue;
    outline.sigma[i] = table.number(rows[k], sigma_column);
    if (std::isfinite(heights[k]) && !(outline.sigma[i] > 0.0))
      throw bad_row(table,
                    rows[k],
                    fmt::format("{} is a standard uncertainty and must be above 0", sigma_column));
  }
  return outline;
}

}  // namespace

void write_outlines(const std::filesystem::path& file, std::span<const Outline> outlines) {
  const bool have_names = std::any_of(
      outlines.begin(), outlines.end(), [](const Outline& one) { return !one.surface.empty(); });
  std::vector<std::string> columns = {time_column, place_column, height_column, sigma_column};
  if (have_names) columns.insert(columns.begin(), surface_column);
  Table table(columns);
  for (const Outline& outline : outlines) {
    for (std::size_t moment = 0; moment < outline.time.size(); ++moment) {
      for (std::size_t place = 0; place < outline.column.size(); ++place) {
        const std::size_t i = outline.index(moment, place);
        if (!std::isfinite(outline.height[i])) continue;
        std::vector<std::string> cells = {
            number_text(outline.time[moment]),
            number_text(outline.column[place]),
            number_text(outline.height[i]),
            outline.sigma.empty() ? "" : number_text(outline.sigma[i])};
        if (have_names) cells.insert(cells.begin(), outline.surface);
        table.add(std::move(cells));
      }
    }
  }
  write_csv(file, table);
}

std::vector<Outline> read_outlines(const std::filesystem::path& file) {
  const Table table = read_csv(file);
  const bool have_names = table.has(surface_column);
  // By the order in which they begin
  std::vector<std::pair<std::string, std::vector<std::size_t>>> surfaces;
  if (!have_names) surfaces.emplace_back();
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string name = have_names ? table.text(row, surface_column) : "";
    if (have_names && name.empty())
      throw bad_row(
          table, row, fmt::format("{} is empty; name the surface in every row", surface_column));
    auto own = std::find_if(
        surfaces.begin(), surfaces.end(), [&](const auto& one) { return one.first == name; });
    if (own == surfaces.end()) own = surfaces.insert(own, {name, {}});
    own->second.push_back(row);
  }
  // Columns that are not there are said even where there are no rows
  for (const char* column : {time_column, place_column, height_column}) table.numbers(column);
  std::vector<Outline> outlines;
  for (const auto& [name, rows] : surfaces) outlines.push_back(read_rows(table, rows, name));
  return outlines;
}

}  // namespace graintruth::datasets
