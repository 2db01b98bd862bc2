#include "reports/page/run_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "datasets/store/input_error.h"

namespace graintruth::reports {

namespace {

const Json absent;

// Nothing where the file is absent; nothing and a sentence in `damage` where it is not what a run
// writes.
Json read_json(const std::filesystem::path& file, std::vector<std::string>& damage) {
  if (!std::filesystem::is_regular_file(file)) return absent;
  std::string reason;
  try {
    Json json = Json::parse(datasets::read_whole(file));
    if (json.is_object()) return json;
    reason = "holds no JSON object";
  } catch (const Json::parse_error& error) {
    reason = fmt::format("is not valid JSON near byte {}", error.byte);
  } catch (const datasets::InputError&) {
    reason = "cannot be opened";
  }
  damage.push_back(
      fmt::format("{} {} and is left out; run the same command again to have it rewritten.",
                  file.filename().string(),
                  reason));
  return absent;
}

}  // namespace

bool RunData::is_calibration() const { return !text(result, {"kind"}).ends_with("validation"); }

bool RunData::is_of_several() const { return !list(result, {"experiments"}).empty(); }

bool RunData::is_part() const { return !text(result, {"part_of"}).empty(); }

bool RunData::has_held_out() const {
  for (const Json& experiment : list(result, {"experiments"}))
    if (number(experiment, {"held_out_orifices"}) > 0.0) return true;
  for (const char* key : {"channels", "comparison"})
    for (const Json& condition : list(result, {key}))
      if (at(condition, {"held_out"}) == true) return true;
  return false;
}

std::optional<datasets::Table> RunData::table(std::string_view name) const {
  const std::filesystem::path file =
      is_under_way() ? folder.unfinished_table(name) : folder.table(name);
  if (!std::filesystem::exists(file)) return std::nullopt;
  datasets::Table table = datasets::read_csv(file);
  if (table.rows() == 0) return std::nullopt;
  return table;
}

RunData read_run_data(const datasets::RunFolder& folder) {
  if (!std::filesystem::exists(folder.run()) && !std::filesystem::exists(folder.result())) {
    throw datasets::InputError(
        fmt::format("{}: holds neither run.json nor result.json; give the folder of a run (the "
                    "--out of calibrate or validate).",
                    folder.root.string()));
  }
  RunData data{.folder = folder};
  data.run = read_json(folder.run(), data.damage);
  data.progress = read_json(folder.progress(), data.damage);
  if (!data.is_under_way()) data.result = read_json(folder.result(), data.damage);
  data.measured = read_json(folder.measured(), data.damage);
  data.tracking = read_json(folder.tracking(), data.damage);
  return data;
}

std::string use_of(const RunData& data, const Json& condition) {
  if (!data.is_calibration()) return "comparison";
  return at(condition, {"held_out"}) == true ? "prediction" : "calibration";
}

std::vector<double> column(const datasets::Table& table, std::string_view name) {
  if (table.has(name)) return table.numbers(name);
  return std::vector<double>(table.rows(), std::numeric_limits<double>::quiet_NaN());
}

std::vector<std::string> text_column(const datasets::Table& table, std::string_view name) {
  std::vector<std::string> cells(table.rows());
  if (!table.has(name)) return cells;
  for (std::size_t row = 0; row < table.rows(); ++row) cells[row] = table.text(row, name);
  return cells;
}

void add_once(std::vector<std::string>& all, const std::string& text) {
  if (std::find(all.begin(), all.end(), text) == all.end()) all.push_back(text);
}

std::vector<std::string> columns_between(const datasets::Table& table,
                                         std::string_view first,
                                         std::string_view last) {
  const std::vector<std::string>& names = table.columns();
  const auto begin = std::find(names.begin(), names.end(), first);
  if (begin == names.end()) return {};
  return {begin + 1, std::find(begin + 1, names.end(), last)};
}

std::vector<std::string> compared_quantities(const RunData& data) {
  std::vector<std::string> names;
  for (const Json& name : list(data.result, {"agreement", "quantities"}))
    names.push_back(name.get<std::string>());
  if (names.empty()) names = {"x", "z", "angle"};  // of runs that do not tell
  return names;
}

}  // namespace graintruth::reports
