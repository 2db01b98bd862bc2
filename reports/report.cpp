#include "reports/report.h"

#include "reports/assets.h"
#include "reports/page.h"
#include "reports/reproduction.h"
#include "reports/run_data.h"
#include "reports/sections.h"

namespace graintruth::reports {

namespace {

Section method_section(const RunData& data) {
  Section section("method", "Method and definitions");
  section.add_template("method", {{"calibration", data.is_calibration()}});
  return section;
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
  if (is_reproduction(data)) return build_reproduction_page(data);

  // 2. The sections, each from the data alone
  Json sections = Json::array();
  for (const Section& section : {parameters_section(data),
                                 agreement_section(data),
                                 tracks_section(data),
                                 search_section(data),
                                 rms_section(data),
                                 time_step_section(data),
                                 films_section(data),
                                 method_section(data),
                                 provenance_section(data)})
    sections.push_back(section.view());

  // 3. The page around them
  return render(
      "page",
      {{"kind", data.is_calibration() ? "Calibration report" : "Comparison at given parameters"},
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
