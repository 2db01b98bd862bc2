// What a run folder holds, read tolerantly: absent files and absent or null numbers are facts that
// a page can state.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/store/json_values.h"
#include "datasets/store/run_folder.h"
#include "datasets/store/table.h"

namespace graintruth::reports {

using datasets::at;
using datasets::Json;
using datasets::list;
using datasets::number;
using datasets::numbers;
using datasets::text;

struct RunData {
  datasets::RunFolder folder;
  Json run;       // run.json; null where the file is absent or damaged, as are the next three
  Json result;    // result.json
  Json measured;  // measured.json
  Json tracking;  // tracking.json
  Json progress;  // progress.json; only while the run is under way, and then result is null: what
                  // there may be is of an earlier run
  std::vector<std::string> damage;  // a sentence for each of these that is there but unreadable

  bool is_under_way() const { return !progress.is_null(); }
  bool is_calibration() const;  // false: a comparison at given parameters
  bool is_of_several() const;   // experiments, each with a page of its own
  bool is_part() const;         // of a calibration of several experiments, which has the journal
  bool has_held_out() const;    // something was predicted that the search never saw
  // tables/<name>.csv; nothing when it is absent or has no rows.
  std::optional<datasets::Table> table(std::string_view name) const;
};

RunData read_run_data(const datasets::RunFolder& folder);

// The quantities that the agreement compares: x, z, angle, or fewer where tracks tell no angles.
std::vector<std::string> compared_quantities(const RunData& data);
// What a condition of the experiment served for: "calibration", "prediction" or "comparison".
std::string use_of(const RunData& data, const Json& condition);

// A column of numbers; all NaN (or all "") where the table lacks the column.
std::vector<double> column(const datasets::Table& table, std::string_view name);
std::vector<std::string> text_column(const datasets::Table& table, std::string_view name);
// The columns of parameters: those that stand between these two.
std::vector<std::string> columns_between(const datasets::Table& table,
                                         std::string_view first,
                                         std::string_view last);

// Appends a text that is not there yet.
void add_once(std::vector<std::string>& all, const std::string& text);
// The element whose member has this value; appended where there is none.
template <class Element>
Element& with_key(std::vector<Element>& all, std::string Element::*key, const std::string& value) {
  for (Element& one : all)
    if (one.*key == value) return one;
  all.emplace_back().*key = value;
  return all.back();
}

}  // namespace graintruth::reports
