#include "app/thesis/results.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

namespace graintruth::app {

namespace {

using Json = nlohmann::ordered_json;
using datasets::number_text;

constexpr std::array verdicts = {Verdict::reproduced,
                                 Verdict::misprint,
                                 Verdict::input,
                                 Verdict::confirmed,
                                 Verdict::not_confirmed,
                                 Verdict::contradicted,
                                 Verdict::fail};

Json number_json(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json numbers_json(const std::vector<double>& values) {
  Json array = Json::array();
  for (const double value : values) array.push_back(number_json(value));
  return array;
}

Json row_json(const Row& row) {
  return {{"where", row.where},
          {"printed", row.printed},
          {"unit", row.unit},
          {"recomputed", number_json(row.recomputed)},
          {"simulated", number_json(row.simulated)},
          {"spread", number_json(row.spread)},
          {"seeds", row.seeds},
          {"tolerance", number_json(row.tolerance)},
          {"verdict", word_of(row.verdict)},
          {"errata", row.errata > 0 ? Json(row.errata) : Json()},
          {"note", row.note},
          {"source", row.source}};
}

Json curve_json(const Curve& curve) {
  Json series = Json::array();
  for (const Series& one : curve.series) {
    series.push_back({{"name", one.name},
                      {"x", numbers_json(one.x)},
                      {"y", numbers_json(one.y)},
                      {"spread", numbers_json(one.spread)},
                      {"ours", one.is_ours},
                      {"line", one.is_line},
                      {"belongs_to_last", one.belongs_to_last},
                      {"colour", numbers_json(one.colour)},
                      {"choice", one.choice}});
  }
  return {{"id", curve.id},
          {"caption", curve.caption},
          {"x_title", curve.x_title},
          {"y_title", curve.y_title},
          {"log_x", curve.log_x},
          {"log_y", curve.log_y},
          {"menu", curve.menu},
          {"picture", curve.is_picture},
          {"series", series}};
}

Json target_json(const TargetResult& target) {
  Json rows = Json::array(), curves = Json::array();
  for (const Row& row : target.rows) rows.push_back(row_json(row));
  for (const Curve& curve : target.curves) curves.push_back(curve_json(curve));
  return {{"name", target.name},
          {"what", target.what},
          {"rows", rows},
          {"curves", curves},
          {"notes", target.notes}};
}

std::string short_number(double value) {
  return std::isfinite(value) ? fmt::format("{:.5g}", value) : "";
}

}  // namespace

bool has_failed(const TargetResult& target) {
  return std::any_of(target.rows.begin(), target.rows.end(), [](const Row& row) {
    return row.verdict == Verdict::fail;
  });
}

void write_target_table(const datasets::RunFolder& folder, const TargetResult& target) {
  datasets::Table table({"where",
                         "printed",
                         "unit",
                         "recomputed",
                         "simulated",
                         "spread",
                         "seeds",
                         "tolerance",
                         "verdict",
                         "errata",
                         "note",
                         "source"});
  for (const Row& row : target.rows) {
    table.add({row.where,
               row.printed,
               row.unit,
               number_text(row.recomputed),
               number_text(row.simulated),
               number_text(row.spread),
               row.seeds > 0 ? std::to_string(row.seeds) : "",
               number_text(row.tolerance),
               std::string(word_of(row.verdict)),
               row.errata > 0 ? std::to_string(row.errata) : "",
               row.note,
               row.source});
  }
  datasets::write_csv(folder.table(target.name), table);
}

Json reproduction_result(std::span<const TargetResult> targets, std::span<const Erratum> errata) {
  Json counts = Json::object();
  bool failed = false;
  for (const Verdict verdict : verdicts) {
    int count = 0;
    for (const TargetResult& target : targets) {
      count += static_cast<int>(
          std::count_if(target.rows.begin(), target.rows.end(), [&](const Row& row) {
            return row.verdict == verdict;
          }));
    }
    counts[std::string(word_of(verdict))] = count;
  }
  Json all = Json::array();
  std::set<std::string> names;
  for (const TargetResult& target : targets) {
    all.push_back(target_json(target));
    names.insert(target.name);
    failed = failed || has_failed(target);
  }
  Json list = Json::array();
  for (const Erratum& erratum : errata) {
    list.push_back({{"number", erratum.number},
                    {"tag", erratum.tag},
                    {"target", erratum.target},
                    {"where", erratum.where},
                    {"printed", erratum.printed},
                    {"correct", erratum.correct},
                    {"evidence", erratum.evidence},
                    {"examined", names.contains(erratum.target) && !erratum.correct.empty()}});
  }
  return {{"kind", "reproduction"},
          {"status", failed ? "failed" : "done"},
          {"title", "The thesis, reproduced"},
          {"verdicts", counts},
          {"targets", all},
          {"errata", list}};
}

std::string target_text(const TargetResult& target) {
  std::string text = fmt::format("{}: {}\n", target.name, target.what);
  std::size_t widest = 5;
  for (const Row& row : target.rows) widest = std::max(widest, row.where.size());
  text += fmt::format("  {:{}}  {:>14} {:>12} {:>12}  {}\n",
                      "where",
                      widest,
                      "printed",
                      "recomputed",
                      "simulated",
                      "verdict");
  for (const Row& row : target.rows) {
    std::string verdict(word_of(row.verdict));
    if (row.errata > 0) verdict += fmt::format(" (errata {})", row.errata);
    text += fmt::format("  {:{}}  {:>14} {:>12} {:>12}  {}\n",
                        row.where,
                        widest,
                        row.printed,
                        short_number(row.recomputed),
                        short_number(row.simulated),
                        verdict);
    if (row.verdict == Verdict::fail) text += fmt::format("    {}\n", row.note);
  }
  for (const std::string& note : target.notes) text += "  " + note + "\n";
  return text + "\n";
}

}  // namespace graintruth::app
