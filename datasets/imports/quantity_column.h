// Columns of other people's tables: found under any usual name, with the unit in the name, and
// turned into SI.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/store/table.h"
#include "datasets/store/units.h"

namespace graintruth::datasets {

// What is looked for. A column is taken when it is called one of the names followed by one of the
// units, whatever its capitals and marks: q_g_per_s, "Q (g/s)" and Q_g_s are one column. The names
// that are known stand in column_names.h.
struct Quantity {
  std::string_view words;                   // for sentences: "the orifice's width"
  std::span<const std::string_view> names;  // lower case; the first is ours
  Units units;
  // Further names of which the capitals matter, as papers write D for one width and d for another
  std::span<const std::string_view> exact_names = {};
};

struct QuantityColumn {
  std::string column;  // as the table calls it
  Unit unit;
};

// Empty where there is no such column, or none with a value in it. Throws InputError where two
// columns would do, or where one has the name and a unit that is not among the units.
std::optional<QuantityColumn> find_column(const Table& table, const Quantity& quantity);

// As above, but the column must be there and have a value.
QuantityColumn required_column(const Table& table, const Quantity& quantity);

// In SI, one value a row; empty where there is no such column. Throws InputError where two columns
// would do, or a cell is no number.
std::optional<std::vector<double>> find_quantity(const Table& table, const Quantity& quantity);

// As above, but the column must be there and every value be finite and above 0.
std::vector<double> positive_quantity(const Table& table, const Quantity& quantity);

// As find_quantity, but every value must be a standard uncertainty: finite and above 0. One that is
// not would make all others count for nothing.
std::optional<std::vector<double>> find_uncertainty(const Table& table, const Quantity& quantity);

// As find_quantity, but the column must be there and every value be finite.
std::vector<double> finite_quantity(const Table& table, const Quantity& quantity);

}  // namespace graintruth::datasets
