#include "bench/calibrate/twin_rows.h"

#include <fmt/format.h>

#include <algorithm>

namespace graintruth::bench {

using datasets::number_text;

std::vector<std::string> parameter_columns(const datasets::Experiment& experiment) {
  std::vector<std::string> names;
  for (const datasets::TunedParameter& parameter : experiment.tuned) {
    for (const char* what : {"truth", "value", "lower", "upper", "status"})
      names.push_back(fmt::format("{}_{}", parameter.name, what));
  }
  return names;
}

std::vector<std::string> parameter_cells(const datasets::Experiment& experiment,
                                         const datasets::ParameterSet& truth,
                                         std::span<const calibrate::CalibratedParameter> found) {
  std::vector<std::string> cells;
  for (const datasets::TunedParameter& tuned : experiment.tuned) {
    const calibrate::CalibratedParameter& parameter = *std::find_if(
        found.begin(), found.end(), [&](const auto& one) { return one.name == tuned.name; });
    // An interval of which the search found no end tells nothing
    const auto interval = is_unfinished(parameter) ? std::nullopt : parameter.interval;
    cells.insert(cells.end(),
                 {number_text(truth.of(parameter.name)),
                  number_text(parameter.value),
                  interval ? number_text(interval->lower) : "",
                  interval ? number_text(interval->upper) : "",
                  std::string(name_of(parameter.status))});
  }
  return cells;
}

ToldParameter told_parameter(const datasets::Table& table, std::size_t row, std::string_view name) {
  const auto column = [&](const char* what) { return fmt::format("{}_{}", name, what); };
  ToldParameter told{.truth = table.number(row, column("truth")),
                     .value = table.number(row, column("value")),
                     .has_interval = !table.text(row, column("lower")).empty(),
                     .status = table.text(row, column("status"))};
  if (told.has_interval)
    told.interval = {table.number(row, column("lower")), table.number(row, column("upper"))};
  return told;
}

TwinRows::TwinRows(std::filesystem::path file, std::vector<std::string> columns, int twins)
    : file_(std::move(file)), columns_(std::move(columns)), rows_(static_cast<std::size_t>(twins)) {
  if (!std::filesystem::exists(file_)) return;
  const datasets::Table kept = datasets::read_csv(file_);
  for (std::size_t row = 0; row < kept.rows(); ++row) {
    const int number = kept.integer(row, columns_.front());
    if (number >= twins) continue;
    for (const std::string& name : columns_)
      rows_[static_cast<std::size_t>(number)].push_back(kept.text(row, name));
  }
}

bool TwinRows::has(int number) {
  const std::lock_guard lock(mutex_);
  return !rows_[static_cast<std::size_t>(number)].empty();
}

void TwinRows::keep(int number, std::vector<std::string> cells) {
  const std::lock_guard lock(mutex_);
  rows_[static_cast<std::size_t>(number)] = std::move(cells);
  datasets::write_csv(file_, whole());
}

datasets::Table TwinRows::table() {
  const std::lock_guard lock(mutex_);
  return whole();
}

datasets::Table TwinRows::whole() const {
  datasets::Table done(columns_);
  for (const auto& row : rows_) {
    if (!row.empty()) done.add(row);
  }
  return done;
}

}  // namespace graintruth::bench
