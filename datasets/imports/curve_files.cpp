#include "datasets/imports/curve_files.h"

#include <fmt/format.h>

#include <cmath>

#include "datasets/imports/column_names.h"
#include "datasets/store/input_error.h"
#include "datasets/store/table.h"

namespace graintruth::datasets {

namespace {

constexpr std::string_view uncertainty = "_uncertainty";

std::vector<double> finite_column(const Table& table, const std::string& name) {
  std::vector<double> values = table.numbers(name);
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (std::isfinite(values[row])) continue;
    throw InputError(fmt::format("{}:{}: column '{}' has no number here; every row needs one.",
                                 table.file().string(),
                                 table.line(row),
                                 name));
  }
  return values;
}

}  // namespace

std::map<std::string, Curve> read_curves(const std::filesystem::path& file,
                                         double event_time,
                                         std::vector<std::string>* notes) {
  const Table table = read_csv(file);
  if (notes) notes->insert(notes->end(), table.notes().begin(), table.notes().end());
  // 1. Times
  std::vector<double> times;
  std::string time_column;
  if (const auto column = find_column(table, columns::time)) {
    time_column = column->column;
    for (const double time : finite_column(table, time_column))
      times.push_back(time * column->unit.in_si - event_time);
    for (std::size_t row = 1; row < times.size(); ++row) {
      if (times[row] > times[row - 1]) continue;
      throw InputError(
          fmt::format("{}:{}: column '{}' does not rise: {} after {}; rows are in order of time.",
                      file.string(),
                      table.line(row),
                      time_column,
                      table.text(row, time_column),
                      table.text(row - 1, time_column)));
    }
  } else if (table.rows() != 1) {
    throw InputError(fmt::format(
        "{}: has {} rows and no column of time; give a column time_s, or one row of numbers{}.",
        file.string(),
        table.rows(),
        table.header_words()));
  }
  // 2. Every other column
  std::map<std::string, Curve> curves;
  for (const std::string& name : table.columns()) {
    if (name == time_column || name.ends_with(uncertainty) || table.is_blank(name)) continue;
    Curve& curve = curves[name];
    curve.time = times;
    curve.value = finite_column(table, name);
    const std::string of_it = fmt::format("{}{}", name, uncertainty);
    if (!table.has(of_it) || table.is_blank(of_it)) continue;
    curve.sigma = finite_column(table, of_it);
    for (std::size_t row = 0; row < curve.sigma.size(); ++row) {
      if (curve.sigma[row] > 0.0) continue;
      throw InputError(
          fmt::format("{}:{}: column '{}' is {}, but an uncertainty above 0 is needed.",
                      file.string(),
                      table.line(row),
                      of_it,
                      curve.sigma[row]));
    }
  }
  if (curves.empty())
    throw InputError(fmt::format("{}: has no column with values beside that of time{}.",
                                 file.string(),
                                 table.header_words()));
  return curves;
}

}  // namespace graintruth::datasets
