#include "datasets/imports/discharge_curve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "datasets/imports/column_names.h"
#include "datasets/store/input_error.h"

namespace graintruth::datasets {

namespace {

constexpr double tolerated_share = 0.02;  // of all mass; as straight as a steady stretch must be
constexpr std::size_t fewest_rows = 5;    // with fewer no stretch of a curve is a line

// Values of one column in SI, and what one must be multiplied with to be the mass that has left.
struct MassColumn {
  QuantityColumn column;
  double kilograms = 1.0;
};

MassColumn find_mass(const Table& table, const DischargeSource& source) {
  if (const auto share = find_column(table, columns::discharged_share))
    return {*share, source.full_mass};
  if (const auto remaining = find_column(table, columns::remaining_mass)) return {*remaining, -1.0};
  return {required_column(table, columns::discharged_mass), 1.0};
}

// The never falling values nearest to these in the least-squares sense: neighbours that fall are
// pooled (Ayer et al. 1955). A running maximum would follow the highest of the noise.
std::vector<double> never_falling(const std::vector<double>& values) {
  struct Pool {
    double mean;
    std::size_t count;
  };
  std::vector<Pool> pools;
  for (const double value : values) {
    pools.push_back({value, 1});
    while (pools.size() > 1 && pools[pools.size() - 2].mean > pools.back().mean) {
      const Pool last = pools.back();
      pools.pop_back();
      Pool& before = pools.back();
      const auto count = static_cast<double>(before.count), more = static_cast<double>(last.count);
      before.mean = (before.mean * count + last.mean * more) / (count + more);
      before.count += last.count;
    }
  }
  std::vector<double> result;
  for (const Pool& pool : pools) result.insert(result.end(), pool.count, pool.mean);
  return result;
}

}  // namespace

DischargeCurve read_discharge_curve(const std::filesystem::path& file,
                                    const DischargeSource& source,
                                    std::vector<std::string>* notes) {
  const Table table = read_csv(file);
  if (notes) notes->insert(notes->end(), table.notes().begin(), table.notes().end());
  const QuantityColumn time = required_column(table, columns::time);
  const MassColumn mass = find_mass(table, source);
  const auto fail = [&](std::size_t row, const std::string& complaint) {
    throw InputError(fmt::format("{}:{}: {}.", file.string(), table.line(row), complaint));
  };
  if (table.rows() < fewest_rows) {
    throw InputError(fmt::format("{}: a discharge curve needs at least {} rows, this has {}.",
                                 file.string(),
                                 fewest_rows,
                                 table.rows()));
  }
  DischargeCurve curve;
  const double tolerance = std::max(tolerated_share * source.full_mass, source.particle_mass);
  double tare = 0.0, highest = 0.0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double when = table.number(row, time.column) * time.unit.in_si - source.event_time;
    const double value =
        table.number(row, mass.column.column) * mass.column.unit.in_si * mass.kilograms;
    for (const auto& [number, column] :
         {std::pair(when, time.column), std::pair(value, mass.column.column)}) {
      if (!std::isfinite(number)) fail(row, fmt::format("a cell of column '{}' is empty", column));
    }
    if (row == 0) {
      tare = value;
      if (when > 0.0)
        fail(row,
             fmt::format(
                 "the curve begins {:.3g} s after the start event. The mass that left before "
                 "is not known. Start the recording before the event, or correct event_s",
                 when));
    } else if (!(when > curve.time.back())) {
      fail(row,
           fmt::format("column '{}' does not rise: {} after {}",
                       time.column,
                       table.text(row, time.column),
                       table.text(row - 1, time.column)));
    }
    const double left = value - tare;
    if (left < highest - tolerance) {
      fail(row,
           fmt::format("column '{}' says that {:.4g} g have left, but {:.4g} g had left before. "
                       "The mass that has left cannot fall. If the column is the mass still in the "
                       "bin, call it remaining_mass_g. Else remove the rows that follow",
                       mass.column.column,
                       1e3 * left,
                       1e3 * highest));
    }
    highest = std::max(highest, left);
    curve.time.push_back(when);
    curve.mass.push_back(left);
    if (highest > source.full_mass + tolerance) {
      fail(row,
           fmt::format("{:.4g} g have left, but all particles weigh {:.4g} g; look at the column's "
                       "unit, particle.count and particle.mass_g",
                       1e3 * highest,
                       1e3 * source.full_mass));
    }
  }
  if (highest < source.particle_mass) {
    throw InputError(
        fmt::format("{}: no mass leaves: column '{}' rises by {:.3g} g, less than one "
                    "particle weighs.",
                    file.string(),
                    mass.column.column,
                    1e3 * highest));
  }
  if (!(curve.time.back() > 0.0)) {
    throw InputError(
        fmt::format("{}: the curve ends before the start event at {} s of its clock; "
                    "correct event_s.",
                    file.string(),
                    source.event_time));
  }
  curve.mass = never_falling(curve.mass);
  return curve;
}

}  // namespace graintruth::datasets
