// The thesis's printed numbers, its errata and the settings of what is simulated again: all read
// from datasets/thesis.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/store/table.h"

namespace graintruth::app {

// A number as the thesis prints it.
struct Printed {
  std::string text;  // its digits
  std::string unit = {};
  std::string source = {};
  int decimals =
      -1;  // of its column, where some cells lack their last zeros; -1: those of the text

  double value() const;  // NaN where the text is no number
  // Half a unit of the last printed digit: what rounding may take away.
  double rounding() const;
};

// A line of errata.csv: where a row of a target prints something else than follows.
struct Erratum {
  int number = 0;
  std::string tag;     // ERR: an error, AMB: ambiguous, UNX: unexplained
  std::string target;  // empty: nothing can be computed of it
  std::string where;
  std::string printed, correct;  // digits; the correct ones tell how exactly they are known
  std::string evidence;
};

class ThesisData {
 public:
  // `folder` is datasets/thesis. Tables are read when they are first asked for.
  explicit ThesisData(std::filesystem::path folder) : folder_(std::move(folder)) {}

  // Throws datasets::InputError where the file is missing.
  const datasets::Table& table(const std::string& name) const;

  // Tables whose first column names quantities: a cell in the column value, its unit in the column
  // unit. Throw datasets::InputError where there is no such row, or it is no number.
  Printed printed(const std::string& table, const std::string& quantity) const;
  double number(const std::string& table, const std::string& quantity) const;
  double si(const std::string& table, const std::string& quantity) const;  // in SI units

  // A cell of any table; `unit` as it stands in the name of the column.
  Printed cell(const std::string& table,
               std::size_t row,
               const std::string& column,
               const std::string& unit) const;
  // The same, printed with as many decimals as the finest of its column.
  Printed column_cell(const std::string& table,
                      std::size_t row,
                      const std::string& column,
                      const std::string& unit) const;

  // A number in the running text (worded_numbers.csv).
  Printed worded(const std::string& target, const std::string& where) const;

  // What a study is run with (resimulation.csv), in SI units. `values`: several, separated by
  // semicolons.
  double setting(const std::string& study, const std::string& quantity) const;
  std::vector<double> settings(const std::string& study, const std::string& quantity) const;
  int count(const std::string& study, const std::string& quantity) const;
  // All settings of a study as text, for recognising a stored result.
  std::string settings_text(const std::string& study) const;
  // The same without what changes no single run: how many there are, and the tolerances.
  std::string settings_text_of_a_run(const std::string& study) const;

  std::vector<Erratum> errata() const;

 private:
  std::string settings_text(const std::string& study,
                            const std::function<bool(const std::string&)>& is_told) const;
  std::size_t row_of(const datasets::Table& table, const std::string& quantity) const;

  std::filesystem::path folder_;
  mutable std::map<std::string, datasets::Table> tables_;
};

// What one of a unit is in SI; throws datasets::InputError for a unit that is not known.
double unit_in_si(std::string_view unit);

}  // namespace graintruth::app
