#include "reports/report.h"

#include <vector>

#include "reports/assets.h"
#include "reports/page.h"
#include "reports/run_data.h"
#include "reports/sections.h"

namespace graintruth::reports {

namespace {

Section method_section(const RunData& data) {
  Section section("method", "Method and definitions");
  section.add_template(data.is_flow() ? "method_flow" : "method",
                       {{"calibration", data.is_calibration()}});
  return section;
}

// A validation needs something that was held out.
std::string kind_of(const RunData& data) {
  if (!data.is_calibration()) return "Comparison at given parameters";
  return data.has_held_out() ? "Calibration and validation report" : "Calibration report";
}

std::string experiment_title(const RunData& data) {
  for (const char* key : {"title", "experiment"}) {
    std::string title = text(data.result, {key});
    if (!title.empty()) return title;
  }
  return "Experiment without a title";
}

}  // namespace

std::string build_report(const datasets::RunFolder& folder) {
  // 1. What the run left behind
  const RunData data = read_run_data(folder);

  // 2. The sections, each from the data alone
  Json sections = Json::array();
  std::vector<Section> all = {parameters_section(data)};
  if (data.is_flow()) {
    all.push_back(flow_section(data));
  } else {
    all.push_back(agreement_section(data));
    all.push_back(tracks_section(data));
  }
  all.push_back(search_section(data));
  if (!data.is_flow()) all.push_back(rms_section(data));
  for (auto* make : {time_step_section, films_section, method_section, provenance_section})
    all.push_back(make(data));
  for (const Section& section : all) sections.push_back(section.view());

  // 3. The page around them
  return render("page",
                {{"kind", kind_of(data)},
                 {"title", experiment_title(data)},
                 {"experiment", text(data.result, {"experiment"})},
                 {"date", text(data.run, {"started_at"})},
                 {"version", text(data.run, {"version"})},
                 {"note", text(data.result, {"note"})},
                 {"verdict", render("verdict", verdict_view(data))},
                 {"sections", sections},
                 {"style", asset("page.css")},
                 {"plotly", asset("plotly.min.js")},
                 {"figures", asset("figures.js")}});
}

void write_report(const datasets::RunFolder& folder) {
  datasets::write_whole(folder.report(), build_report(folder));
}

}  // namespace graintruth::reports
