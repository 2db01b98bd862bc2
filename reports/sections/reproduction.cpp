#include "reports/sections/reproduction.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <utility>

#include "reports/page/assets.h"
#include "reports/page/page.h"
#include "reports/page/words.h"
#include "reports/sections/sections.h"

namespace graintruth::reports {

namespace {

struct Word {
  std::string_view verdict, meaning;
};
constexpr std::array words = {
    Word{"FAIL", "a discrepancy that nobody has explained"},
    Word{"contradicted",
         "our simulation differs, with five seeds or more, and a run in the thesis's manner shows "
         "why"},
    Word{"not confirmed", "our simulation differs or was not run, or the errata cannot explain it"},
    Word{"confirmed", "our simulation finds it too"},
    Word{"misprint", "does not follow from the thesis's own data; the errata say what does"},
    Word{"reproduced", "the printed digits follow from the printed data"},
    Word{"input", "a measured value, taken as it is"}};

Json tiles(const Json& counts) {
  Json all = Json::array();
  for (const Word& word : words) {
    const double number_of = number(counts, {word.verdict});
    const bool is_nothing = !(number_of > 0.0);
    if (is_nothing && word.verdict != "FAIL") continue;
    all.push_back({{"label", word.verdict},
                   {"value", count(number_of)},
                   {"detail", word.meaning},
                   {"muted", is_nothing}});
  }
  return all;
}

// Whether anything that the thesis prints is left unexplained.
datasets::Verdict judge_reproduction(const RunData& data) {
  const double failures = number(data.result, {"verdicts", "FAIL"});
  if (!(failures > 0.0)) {
    return {datasets::Mark::agrees,
            "Every printed value that does not follow from the thesis's own data is in the errata, "
            "with its digits.",
            "Read first what could not be confirmed, and why"};
  }
  return {datasets::Mark::does_not_agree,
          fmt::format("{} {} unexplained.",
                      count(failures),
                      failures == 1.0 ? "discrepancy is" : "discrepancies are"),
          "See the rows marked FAIL"};
}

Json reproduction_view(const RunData& data) {
  Json view = view_of(judge_reproduction(data));
  view["tiles"] = tiles(at(data.result, {"verdicts"}));
  return view;
}

std::string unit_text(const Json& row) {
  std::string unit = reports::unit_text(text(row, {"unit"}));
  if (const auto percent = unit.find("percent"); percent != std::string::npos)
    unit.replace(percent, std::string_view("percent").size(), "%");
  return unit;
}

bool is_numeric(const std::string& printed) {
  return !printed.empty() && printed.find_first_not_of("0123456789.eE+-") == std::string::npos &&
         printed.find_first_of("0123456789") != std::string::npos;
}

// "0.271 ± 0.004 (n = 5)"; with its unit where nothing printed has it.
std::string simulated_text(const Json& row) {
  const double mean = number(row, {"simulated"});
  if (!std::isfinite(mean)) return "";
  const double spread = number(row, {"spread"});
  std::string text = significant(mean, 4);
  // Spreads that are rounding alone say nothing
  if (spread > 1e-6 * std::abs(mean)) text += " ± " + significant(spread, 2);
  if (const std::string unit = unit_text(row);
      !unit.empty() && !is_numeric(reports::text(row, {"printed"})))
    text += " " + unit;
  if (std::isfinite(spread)) text += fmt::format(" (n = {})", count(number(row, {"seeds"})));
  return text;
}

std::string number_text(const Json& row, std::string_view key, int digits) {
  const double value = number(row, {key});
  return std::isfinite(value) ? significant(value, digits) : "";
}

// With the number of the erratum, where there is one.
std::string note_text(const Json& row) {
  const double erratum = number(row, {"errata"});
  std::string note = text(row, {"note"});
  if (!std::isfinite(erratum)) return note;
  return note + fmt::format("{}(errata {})", note.empty() ? "" : " ", count(erratum));
}

std::string printed_text(const Json& row) {
  const std::string unit = unit_text(row), printed = text(row, {"printed"});
  return printed + (unit.empty() || !is_numeric(printed) ? "" : " " + unit);
}

TableView table_of_rows(const Json& target) {
  TableView table(text(target, {"name"}) + ": " + text(target, {"what"}),
                  {{"Where", Align::left},
                   {"Printed", Align::right},
                   {"Recomputed", Align::right},
                   {"Simulated again", Align::right},
                   {"Tolerance", Align::right},
                   {"Verdict", Align::left},
                   {"Note", Align::left}});
  for (const Json& row : list(target, {"rows"})) {
    table.add_row({spaced(text(row, {"where"})),
                   printed_text(row),
                   number_text(row, "recomputed", 5),
                   simulated_text(row),
                   number_text(row, "tolerance", 2),
                   text(row, {"verdict"}),
                   note_text(row)});
  }
  table.drop_empty_columns();
  return table;
}

// All rows of a verdict, target by target.
TableView table_of_verdict(const RunData& data, std::string_view verdict, std::string caption) {
  const bool is_simulated = verdict != "misprint";
  TableView table(std::move(caption),
                  {{"Target", Align::left},
                   {"Where", Align::left},
                   {"Printed", Align::right},
                   {is_simulated ? "Ours" : "Recomputed", Align::right},
                   {"Note", Align::left}});
  for (const Json& target : list(data.result, {"targets"})) {
    for (const Json& row : list(target, {"rows"})) {
      if (text(row, {"verdict"}) != verdict) continue;
      const std::string ours = is_simulated ? simulated_text(row) : std::string();
      table.add_row({text(target, {"name"}),
                     spaced(text(row, {"where"})),
                     printed_text(row),
                     ours.empty() ? number_text(row, "recomputed", 5) : ours,
                     note_text(row)});
    }
  }
  return table;
}

Section claims_section(const RunData& data) {
  struct List {
    std::string_view verdict, caption;
  };
  constexpr std::array lists = {
      List{"FAIL", "FAIL: discrepancies that nobody has explained"},
      List{"contradicted", "Contradicted by our simulations"},
      List{"not confirmed", "Not confirmed"},
      List{"confirmed", "Confirmed by our simulations"},
      List{"misprint", "Misprints, and what follows from the printed data"}};
  Section section("claims", "Claims");
  for (const List& one : lists) {
    if (number(data.result, {"verdicts", one.verdict}) > 0.0)
      section.add_table(table_of_verdict(data, one.verdict, std::string(one.caption)));
  }
  return section;
}

// Squares whose colour shows a number.
Json squares_trace(const Json& series) {
  constexpr std::array<std::string_view, 4> shades = {
      "var(--rank0)", "var(--rank1)", "var(--rank2)", "var(--rank3)"};
  Json scale = Json::array();
  for (std::size_t i = 0; i < shades.size(); ++i)
    scale.push_back({static_cast<double>(i) / (shades.size() - 1), shades[i]});
  return {
      {"type", "heatmap"},
      {"x", plot_numbers(numbers(series, {"x"}))},
      {"y", plot_numbers(numbers(series, {"y"}))},
      {"z", plot_numbers(numbers(series, {"colour"}))},
      {"colorscale", scale},
      {"xgap", 1},
      {"ygap", 1},
      {"colorbar",
       {{"title", {{"text", text(series, {"name"})}, {"side", "right"}, {"font", {{"size", 12}}}}},
        {"thickness", 12},
        {"outlinewidth", 0}}}};
}

// Colour by colour, then dashed and dotted in the same colours.
Json series_trace(const Json& series, std::size_t index, double point_size) {
  constexpr std::array<std::string_view, 6> thesis_colours = {"var(--measured-strong)",
                                                              "var(--stage3)",
                                                              "var(--stage4)",
                                                              "var(--stage5)",
                                                              "var(--stage0)",
                                                              "var(--simulated)"};
  constexpr std::array<std::string_view, 6> our_colours = {"var(--simulated)",
                                                           "var(--stage4)",
                                                           "var(--stage3)",
                                                           "var(--stage5)",
                                                           "var(--measured-strong)",
                                                           "var(--stage0)"};
  constexpr std::array<std::string_view, 3> dashes = {"solid", "dash", "dot"};
  const bool ours = at(series, {"ours"}) == true;
  const std::string_view colour = (ours ? our_colours : thesis_colours)[index % our_colours.size()];
  const std::string name = text(series, {"name"});
  const std::vector<double> x = numbers(series, {"x"}), y = numbers(series, {"y"});
  Json trace;
  if (at(series, {"line"}) == true) {
    trace = line(x, y, name, colour);
    trace["line"]["dash"] = dashes[index / our_colours.size() % dashes.size()];
  } else {
    trace = points(x, y, name, colour, ours ? "diamond" : "circle", point_size);
  }
  const std::vector<double> spread = numbers(series, {"spread"});
  if (!spread.empty()) {
    trace["error_y"] = {{"type", "data"}, {"array", plot_numbers(spread)}, {"thickness", 1.5}};
  }
  return trace;
}

// One choice of a figure: the series that name it, and those that name none.
FigureChoice choice_of(const Json& curve, const std::string& label) {
  FigureChoice choice{.label = label};
  const double point_size = at(curve, {"picture"}) == true ? 4.0 : 9.0;  // px; grains are many
  std::size_t ours = 0, others = 0;
  for (const Json& series : list(curve, {"series"})) {
    const std::string of = text(series, {"choice"});
    if (!of.empty() && of != label) continue;
    if (!list(series, {"colour"}).empty()) {
      choice.traces.push_back(squares_trace(series));
      continue;
    }
    std::size_t& index = at(series, {"ours"}) == true ? ours : others;
    const bool belongs_to_last = at(series, {"belongs_to_last"}) == true && index > 0;
    if (belongs_to_last) --index;
    choice.traces.push_back(series_trace(series, index++, point_size));
    if (belongs_to_last) choice.traces.back()["showlegend"] = false;
  }
  return choice;
}

// px; as high as a picture of this shape can be on a wide page, or as the page allows.
int height_of_picture(const Json& curve) {
  constexpr double plot_width = 700.0, around = 140.0, lowest = 320.0, highest = 640.0;
  const auto extent = [&](std::string_view key) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Json& series : list(curve, {"series"})) {
      for (const double value : numbers(series, {key})) {
        low = std::min(low, value);
        high = std::max(high, value);
      }
    }
    return high - low;
  };
  const double shape = extent("y") / extent("x");
  if (!(shape > 0.0)) return static_cast<int>(highest);
  return static_cast<int>(std::clamp(around + plot_width * shape, lowest, highest));
}

Figure figure_of(const Json& curve) {
  std::vector<std::string> labels;
  for (const Json& series : list(curve, {"series"})) {
    if (const std::string of = text(series, {"choice"}); !of.empty()) add_once(labels, of);
  }
  if (labels.empty()) labels.emplace_back();
  std::vector<FigureChoice> choices;
  for (const std::string& label : labels) choices.push_back(choice_of(curve, label));
  const auto scaled = [&](std::string_view title, std::string_view logarithmic) {
    const bool is_log = at(curve, {logarithmic}) == true;
    return axis(
        text(curve, {title}),
        is_log ? Json{{"type", "log"}, {"exponentformat", "power"}, {"dtick", 1}} : Json::object());
  };
  Json across = scaled("x_title", "log_x"), up = scaled("y_title", "log_y");
  const bool is_picture = at(curve, {"picture"}) == true;
  if (is_picture) {
    across["constrain"] = up["constrain"] = "domain";
    up["scaleanchor"] = "x";
    up["constraintoward"] = "top";
  }
  return {.id = text(curve, {"id"}),
          .caption = text(curve, {"caption"}),
          .height = is_picture ? height_of_picture(curve) : 380,
          .layout = {{"xaxis", across}, {"yaxis", up}},
          .menu = text(curve, {"menu"}),
          .choices = std::move(choices)};
}

// Targets belong to the chapter or appendix whose number they bear.
std::string chapter_of(const std::string& name) {
  if (name.starts_with("deck")) return "Decks";
  if (name.starts_with("appendix")) return "Appendices";
  if (name == "study-micro" || name == "study-macro") return "Chapter 4";
  if (name == "study-shape") return "Chapter 5";
  for (const char letter : name) {
    if (letter == '1' || letter == '2') return "Chapters 1 and 2";
    if (letter >= '3' && letter <= '5') return std::string("Chapter ") + letter;
  }
  return "Chapters 1 and 2";
}

std::vector<Section> chapter_sections(const RunData& data) {
  std::vector<std::pair<std::string, Section>> chapters;
  for (const Json& target : list(data.result, {"targets"})) {
    const std::string chapter = chapter_of(text(target, {"name"}));
    auto found = std::find_if(chapters.begin(), chapters.end(), [&](const auto& known) {
      return known.first == chapter;
    });
    if (found == chapters.end()) {
      chapters.emplace_back(chapter, Section(identifier(chapter), chapter));
      found = std::prev(chapters.end());
    }
    Section& section = found->second;
    section.add_table(table_of_rows(target));
    for (const Json& note : list(target, {"notes"})) section.add_paragraph(note.get<std::string>());
    for (const Json& curve : list(target, {"curves"})) section.add_figure(figure_of(curve));
  }
  std::vector<Section> sections;
  for (auto& [chapter, section] : chapters) sections.push_back(std::move(section));
  return sections;
}

Section errata_section(const RunData& data) {
  Section section("errata", "Errata");
  section.add_paragraph(
      "All known discrepancies of the thesis. Those with a target were recomputed by it on this "
      "page; the others concern words, references or methods.");
  TableView table("Errata",
                  {{"No.", Align::right},
                   {"Where", Align::left},
                   {"Printed", Align::left},
                   {"Correct", Align::left},
                   {"Evidence", Align::left},
                   {"Examined by", Align::left}});
  for (const Json& erratum : list(data.result, {"errata"})) {
    table.add_row({text(erratum, {"number"}),
                   text(erratum, {"where"}),
                   text(erratum, {"printed"}),
                   text(erratum, {"correct"}),
                   text(erratum, {"evidence"}),
                   at(erratum, {"examined"}) == true ? text(erratum, {"target"}) : ""});
  }
  section.add_table(table);
  return section;
}

Section method_section(const RunData& data) {
  Section section("method", "Method");
  section.add_paragraph(
      "Printed digits come from the thesis's tables and text and are never changed. A recomputed "
      "value reproduces them when it rounds to the same digits. Where it is computed from rounded "
      "values, the tolerance is the effect of that rounding. A printed value that does not follow "
      "must be in the table of errata, with the printed digits and the correct ones. Otherwise it "
      "is "
      "a FAIL. Simulations are ours. Their seeds change what the thesis leaves open, such as the "
      "place of a start within one time step. Shown are mean ± standard deviation over n seeds.");
  section.add_heading("Provenance");
  section.add_code(text(data.run, {"command"}));
  section.add_paragraph(fmt::format(
      "Seed {}; graintruth {}.", text(data.run, {"seed"}), text(data.run, {"version"})));
  return section;
}

}  // namespace

bool is_reproduction(const RunData& data) { return text(data.result, {"kind"}) == "reproduction"; }

std::string build_reproduction_page(const RunData& data) {
  Json sections = Json::array();
  sections.push_back(claims_section(data).view());
  for (const Section& section : chapter_sections(data)) sections.push_back(section.view());
  sections.push_back(errata_section(data).view());
  sections.push_back(method_section(data).view());
  return render("page",
                {{"kind", "Reproduction report"},
                 {"title", text(data.result, {"title"})},
                 {"experiment", ""},
                 {"date", text(data.run, {"started_at"})},
                 {"version", text(data.run, {"version"})},
                 {"note", ""},
                 {"verdict", render("verdict", reproduction_view(data))},
                 {"sections", sections},
                 {"style", asset("page.css")},
                 {"plotly", asset("plotly.min.js")},
                 {"figures", asset("figures.js")},
                 {"table_script", asset("tables.js")}});
}

}  // namespace graintruth::reports
