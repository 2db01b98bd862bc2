#include "reports/report.h"

#include "datasets/store/input_error.h"
#include "reports/page/assets.h"
#include "reports/page/page.h"
#include "reports/page/run_data.h"
#include "reports/sections/reproduction.h"
#include "reports/sections/sections.h"

namespace graintruth::reports {

namespace {

// A validation needs something that was held out.
std::string kind_of(const RunData& data) {
  if (data.is_under_way()) return "Calibration under way";
  if (!data.is_calibration()) return "Comparison at given parameters";
  return data.has_held_out() ? "Calibration and validation report" : "Calibration report";
}

constexpr const char* reload_pause = "10";  // s; of the page of a run under way

// Which runs have a section.
using Belongs = bool (*)(const RunData& data);
bool always(const RunData&) { return true; }
bool is_finished(const RunData& data) { return !data.is_under_way(); }
bool is_of_one(const RunData& data) { return !data.is_of_several(); }
bool is_of_several(const RunData& data) { return data.is_of_several(); }
bool is_finished_and_of_one(const RunData& data) { return is_finished(data) && is_of_one(data); }
bool has_agreement(const RunData& data) { return at(data.result, {"agreement"}).is_object(); }
bool has_flow(const RunData& data) { return !list(data.result, {"comparison"}).empty(); }

// Versions that told no channels had another rule for intervals of a flow.
bool has_flow_of_older_version(const RunData& data) {
  for (const Json& experiment : list(data.result, {"experiments"}))
    if (at(experiment, {"compared"}).is_string()) return true;
  return has_flow(data) && list(data.result, {"channels"}).empty();
}

Section method_section(const RunData& data, Section section) {
  const bool has_channels = !list(data.result, {"channels"}).empty();
  section.begin_fold("What every word and number on this page means");
  section.add_template("method",
                       {{"calibration", data.is_calibration()},
                        {"agreement", has_agreement(data)},
                        {"intervals", has_agreement(data) || has_channels},
                        {"flow", has_flow(data)},
                        {"flow_of_older_version", has_flow_of_older_version(data)},
                        {"several", data.is_of_several()}});
  return section;
}

struct Part {
  const char* id;
  const char* heading;
  Section (*filled)(const RunData& data, Section section);
  Belongs belongs;
};

// In the order in which the reader meets them.
constexpr Part parts[] = {
    {"parameters", "Parameters", parameters_section, is_finished},
    {"experiments", "Experiments", experiments_section, is_of_several},
    {"film-and-simulation", "Film and simulation", side_by_side_section, is_finished_and_of_one},
    {"compared", "What was compared", compared_section, has_comparisons},
    {"surface", "Free surface", surface_section, has_outlines},
    {"flow", "Flow", flow_section, has_flow},
    {"agreement", "Agreement", agreement_section, has_agreement},
    {"tracks", "Tracks", tracks_section, has_tracks},
    {"search", "Search", search_section, always},
    {"time-step", "Time step", time_step_section, is_finished},
    {"films", "Films and tracking", films_section, is_of_one},
    {"method", "Method and definitions", method_section, always},
    {"thesis", "Appendix: the thesis\u2019s form", thesis_section, has_agreement},
    {"provenance", "Provenance", provenance_section, always}};

// A section whose files are damaged says so; the others are not affected.
Json section_view(const Part& part, const RunData& data) {
  std::string reason;
  try {
    return part.filled(data, Section(part.id, part.heading)).view();
  } catch (const datasets::InputError& error) {
    reason = error.what();
  } catch (const Json::exception&) {
    reason = "result.json, run.json or tracking.json holds something else than a run writes there.";
  }
  Section section(part.id, part.heading);
  section.add_absence("This section cannot be made, because a file of the run is damaged. " +
                      reason);
  return section.view();
}

Json verdict_or_damage(const RunData& data) {
  Json view;
  try {
    view = verdict_view(data);
  } catch (const Json::exception&) {
    view = {
        {"absence", "There is no verdict: result.json holds something else than a run writes."}};
  }
  if (!data.damage.empty()) view["damage"] = {{"damage_sentences", data.damage}};
  return view;
}

std::string experiment_title(const RunData& data) {
  for (const char* key : {"title", "experiment"}) {
    std::string title = text(data.result, {key});
    if (!title.empty()) return title;
  }
  if (std::string title = text(data.run, {"configuration", "title"}); !title.empty()) return title;
  return "Experiment without a title";
}

// Where the films come from must be said before there is a result, too.
std::string note_of(const RunData& data) {
  const std::string note = text(data.result, {"note"});
  return note.empty() ? text(data.run, {"configuration", "note"}) : note;
}

}  // namespace

std::string build_report(const datasets::RunFolder& folder) {
  // 1. What the run left behind
  const RunData data = read_run_data(folder);
  if (is_reproduction(data)) return build_reproduction_page(data);

  // 2. The sections, each from the data alone
  Json sections = Json::array();
  for (const Part& part : parts)
    if (part.belongs(data)) sections.push_back(section_view(part, data));

  // 3. The page around them
  return render("page",
                {{"kind", kind_of(data)},
                 {"title", experiment_title(data)},
                 {"experiment", text(data.result, {"experiment"})},
                 {"date", text(data.run, {"started_at"})},
                 {"reload", data.is_under_way() ? reload_pause : ""},
                 {"version", text(data.run, {"version"})},
                 {"note", note_of(data)},
                 {"verdict", render("verdict", verdict_or_damage(data))},
                 {"sections", sections},
                 {"style", asset("page.css")},
                 {"plotly", asset("plotly.min.js")},
                 {"figures", asset("figures.js")},
                 {"film_script", asset("side_by_side.js")},
                 {"table_script", asset("tables.js")}});
}

void write_report(const datasets::RunFolder& folder) {
  datasets::write_whole(folder.report(), build_report(folder));
}

}  // namespace graintruth::reports
