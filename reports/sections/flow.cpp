// Flow through orifices, filmed and simulated: rates in the terms of ASME V&V 20, discharge curves,
// velocity profiles, Beverloo's C and k and the kinematic B.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "reports/page/words.h"
#include "reports/sections/sections.h"

namespace graintruth::reports {

namespace {

constexpr double coverage = 2.0;  // of u_val, as ASME V&V 20 takes for 95 %

// Grains leave some rigs otherwise than through an orifice.
std::string opening(double metres) {
  return std::isfinite(metres) ? plain(1e3 * metres) + "\u00a0mm" : "the exit";
}
std::string grams_per_second(double rate) { return decimal(1e3 * rate, 2); }

bool is_resolved(const Json& row) {
  return std::abs(number(row, {"error_kg_per_s"})) >
         coverage * number(row, {"validation_uncertainty_kg_per_s"});
}

std::string verdict_on(const Json& row) {
  if (!std::isfinite(number(row, {"error_kg_per_s"}))) return "jammed, no rate";
  return is_resolved(row) ? "differs" : "no difference shown";
}

std::string jam_text(const Json& jams) {
  if (number(jams, {"runs"}) == 0.0) return "not known";  // of discharge curves
  return fmt::format("{} of {} ({} to {})",
                     count(number(jams, {"jams"})),
                     count(number(jams, {"runs"})),
                     percent(100.0 * number(jams, {"lower"})),
                     percent(100.0 * number(jams, {"upper"})));
}

TableView rate_table(const RunData& data, const Json& rows) {
  TableView table("Flow rate of each orifice, filmed (D) and simulated (S), in g/s",
                  {{"Orifice", Align::left},
                   {"Used for", Align::left},
                   {"D"},
                   {"S"},
                   {"E = S − D"},
                   {"E/D"},
                   {"2 u_val"},
                   {"Verdict", Align::left}});
  for (const Json& row : rows) {
    const double filmed = number(row, {"filmed_kg_per_s"});
    const double error = number(row, {"error_kg_per_s"});
    table.add_row({opening(number(row, {"orifice_m"})),
                   use_of(data, row),
                   grams_per_second(filmed),
                   grams_per_second(number(row, {"simulated_kg_per_s"})),
                   grams_per_second(error),
                   percent(100.0 * error / filmed),
                   grams_per_second(coverage * number(row, {"validation_uncertainty_kg_per_s"})),
                   verdict_on(row)});
  }
  return table;
}

TableView uncertainty_table(const Json& rows) {
  TableView table(
      "The parts of u_val (standard uncertainties in g/s), and how often the flow jammed",
      {{"Orifice", Align::left},
       {"Films"},
       {"Simulated runs"},
       {"Parameters"},
       {"Time step"},
       {"Filmed jams (95 %)"},
       {"Simulated jams (95 %)"},
       {"Curve inside the measured band"}});
  for (const Json& row : rows) {
    table.add_row({opening(number(row, {"orifice_m"})),
                   grams_per_second(number(row, {"film_uncertainty_kg_per_s"})),
                   grams_per_second(number(row, {"run_uncertainty_kg_per_s"})),
                   grams_per_second(number(row, {"input_uncertainty_kg_per_s"})),
                   grams_per_second(number(row, {"numerical_uncertainty_kg_per_s"})),
                   jam_text(at(row, {"filmed_jams"})),
                   jam_text(at(row, {"simulated_jams"})),
                   percent(100.0 * number(row, {"curve_inside"}))});
  }
  return table;
}

// Widths that can be told apart: where there is no orifice the cell is empty.
std::vector<double> orifice_column(const datasets::Table& table) {
  std::vector<double> widths = column(table, "orifice_m");
  for (double& width : widths) {
    if (std::isnan(width)) width = std::numeric_limits<double>::infinity();
  }
  return widths;
}

// The rows of one orifice (and, where it is not empty, of one source).
struct Selected {
  std::vector<std::size_t> rows;
  std::vector<double> of(const std::vector<double>& column, double factor = 1.0) const {
    std::vector<double> values;
    for (const std::size_t row : rows) values.push_back(factor * column[row]);
    return values;
  }
};
Selected select(const datasets::Table& table, double orifice, std::string_view source = {}) {
  const std::vector<double> orifices = orifice_column(table);
  const std::vector<std::string> sources =
      source.empty() ? std::vector<std::string>() : text_column(table, "source");
  Selected selected;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (orifices[row] == orifice && (source.empty() || sources[row] == source))
      selected.rows.push_back(row);
  }
  return selected;
}

std::set<double> orifices_of(const datasets::Table& table) {
  const std::vector<double> all = orifice_column(table);
  return {all.begin(), all.end()};
}

Figure curve_figure(const datasets::Table& table) {
  Figure figure{.id = "flow-curves",
                .caption =
                    "Particles that have left, against time. Films: the mean, with the band in "
                    "which one more film would lie with 95 %. Simulation: the mean, the lowest and "
                    "the highest run.",
                .height = 420,
                .layout = {{"xaxis", axis("Time since the start event (s)")},
                           {"yaxis", axis("Discharged particles")}},
                .menu = "Orifice",
                .choices = {}};
  for (const double orifice : orifices_of(table)) {
    const Selected rows = select(table, orifice);
    const std::vector<double> time = rows.of(column(table, "time_s"));
    const auto numbers = [&](const char* name) { return rows.of(column(table, name)); };
    FigureChoice choice{.label = opening(orifice)};
    choice.traces.push_back(band(time,
                                 numbers("filmed_lower"),
                                 numbers("filmed_upper"),
                                 "films, 95 % band of one more",
                                 "var(--measured-band)"));
    choice.traces.push_back(
        line(time, numbers("filmed_count"), "films, mean", "var(--measured-strong)"));
    choice.traces.push_back(
        line(time, numbers("simulated_count"), "simulation, mean", "var(--simulated)"));
    for (const char* edge : {"simulated_lower", "simulated_upper"}) {
      Json trace =
          line(time, numbers(edge), "simulation, lowest and highest", "var(--simulated)", 1.0);
      trace["line"]["dash"] = "dot";
      trace["legendgroup"] = "runs";
      trace["showlegend"] = std::string_view(edge) == "simulated_lower";
      choice.traces.push_back(trace);
    }
    figure.choices.push_back(std::move(choice));
  }
  return figure;
}

Figure profile_figure(const datasets::Table& table) {
  Figure figure{.id = "flow-profiles",
                .caption =
                    "Downward velocity across the bed, half way up, in bins one particle diameter "
                    "wide. Bars reach from the lowest to the highest run of each bin.",
                .height = 400,
                .layout = {{"xaxis", axis("Place across the bin (mm)")},
                           {"yaxis", axis("Downward velocity (mm/s)")}},
                .menu = "Orifice",
                .choices = {}};
  for (const double orifice : orifices_of(table)) {
    FigureChoice choice{.label = opening(orifice)};
    for (const bool simulated : {false, true}) {
      const Selected rows = select(table, orifice, simulated ? "simulation" : "experiment");
      if (rows.rows.empty()) continue;
      const std::vector<double> mean = rows.of(column(table, "velocity_m_per_s"), 1e3);
      const std::vector<double> lowest = rows.of(column(table, "lowest"), 1e3);
      const std::vector<double> highest = rows.of(column(table, "highest"), 1e3);
      std::vector<double> up, down;
      for (std::size_t i = 0; i < mean.size(); ++i) {
        up.push_back(highest[i] - mean[i]);
        down.push_back(mean[i] - lowest[i]);
      }
      Json trace = line(rows.of(column(table, "x_m"), 1e3),
                        mean,
                        simulated ? "simulation" : "films",
                        simulated ? "var(--simulated)" : "var(--measured-strong)");
      trace["mode"] = "lines+markers";
      trace["marker"] = {{"symbol", simulated ? "diamond" : "circle"}};
      trace["error_y"] = {{"type", "data"},
                          {"symmetric", false},
                          {"array", plot_numbers(up)},
                          {"arrayminus", plot_numbers(down)},
                          {"thickness", 1.2}};
      choice.traces.push_back(trace);
    }
    figure.choices.push_back(std::move(choice));
  }
  return figure;
}

Figure boundary_figure(const datasets::Table& table) {
  Figure figure{
      .id = "flow-stagnant",
      .caption =
          "Height up to which the bed stands still beside the flow, in columns half a particle "
          "diameter wide. Lines are means over films and over simulated runs.",
      .height = 380,
      .layout = {{"xaxis", axis("Place across the bin (mm)")}, {"yaxis", axis("Height (mm)")}},
      .menu = "Orifice",
      .choices = {}};
  for (const double orifice : orifices_of(table)) {
    const Selected rows = select(table, orifice);
    const std::vector<double> x = rows.of(column(table, "x_m"), 1e3);
    FigureChoice choice{.label = opening(orifice)};
    choice.traces.push_back(
        line(x, rows.of(column(table, "filmed_height_m"), 1e3), "films", "var(--measured-strong)"));
    choice.traces.push_back(line(
        x, rows.of(column(table, "simulated_height_m"), 1e3), "simulation", "var(--simulated)"));
    figure.choices.push_back(std::move(choice));
  }
  return figure;
}

// Of each orifice, how far the regions that stand still coincide.
TableView overlap_table(const Json& rows) {
  TableView table(
      "Regions that stand still: area in both films and simulation, over area in either",
      {{"Orifice", Align::left}, {"Overlap"}});
  for (const Json& row : rows)
    table.add_row(
        {opening(number(row, {"orifice_m"})), decimal(number(row, {"stagnant_overlap"}), 2)});
  return table;
}

// q^(2/3) against D, where Beverloo's law is a straight line through D = k d.
Figure beverloo_figure(const Json& rows) {
  FigureChoice choice;
  for (const bool simulated : {false, true}) {
    std::vector<double> orifice, power, bar;
    for (const Json& row : rows) {
      const double rate = number(row, {simulated ? "simulated_kg_per_s" : "filmed_kg_per_s"});
      const double uncertainty =
          number(row, {simulated ? "run_uncertainty_kg_per_s" : "film_uncertainty_kg_per_s"});
      orifice.push_back(1e3 * number(row, {"orifice_m"}));
      power.push_back(std::pow(1e3 * rate, 2.0 / 3.0));
      bar.push_back(coverage * uncertainty / rate * 2.0 / 3.0 * power.back());
    }
    Json trace = points(orifice,
                        power,
                        simulated ? "simulation" : "films",
                        simulated ? "var(--simulated)" : "var(--measured-strong)",
                        simulated ? "diamond" : "circle",
                        9.0);
    trace["error_y"] = {{"type", "data"}, {"array", plot_numbers(bar)}, {"thickness", 1.2}};
    choice.traces.push_back(trace);
  }
  return {.id = "flow-beverloo",
          .caption =
              "Flow rate to the power 2/3 against the width of the orifice. Beverloo's law is a "
              "straight line here. Bars are two standard uncertainties.",
          .height = 380,
          .layout = {{"xaxis", axis("Orifice (mm)")}, {"yaxis", axis("Rate^(2/3) ((g/s)^(2/3))")}},
          .menu = "",
          .choices = {choice}};
}

TableView derived_table(const Json& result) {
  TableView table(fmt::format("Derived from the rates and profiles above; {}",
                              text(result, {"objective", "form"}) == "requested"
                                  ? "the search minimised their differences"
                                  : "the search did not use them"),
                  {{"Quantity", Align::left}, {"Films"}, {"Simulation"}});
  const auto beverloo = [&](const char* source, const char* name, std::size_t index) {
    const Json& fit = at(result, {"beverloo", source});
    const double value = number(fit, {name});
    if (!std::isfinite(value)) return std::string(nothing);
    const double variance = list(fit, {"covariance"}).at(index).at(index).get<double>();
    return fmt::format("{} ± {}", decimal(value, 3), decimal(std::sqrt(variance), 3));
  };
  for (const auto& [name, index] : {std::pair{"C", 0UL}, std::pair{"k", 1UL}}) {
    table.add_row({fmt::format("Beverloo {} (both fitted together, ± standard error)", name),
                   beverloo("experiment", name, index),
                   beverloo("simulation", name, index)});
  }
  std::set<double> orifices;
  for (const Json& row : list(result, {"kinematic"})) orifices.insert(number(row, {"orifice_m"}));
  for (const double orifice : orifices) {
    std::vector<std::string> cells = {fmt::format("B/d at {} (95 % interval)", opening(orifice))};
    for (const char* source : {"experiment", "simulation"}) {
      std::string cell(nothing);
      for (const Json& row : list(result, {"kinematic"})) {
        if (number(row, {"orifice_m"}) != orifice || text(row, {"source"}) != source) continue;
        const double upper = number(row, {"upper"});
        cell = fmt::format("{} ({} to {})",
                           decimal(number(row, {"B_over_d"}), 2),
                           decimal(number(row, {"lower"}), 2),
                           std::isfinite(upper) ? decimal(upper, 2) : "not bounded");
      }
      cells.push_back(std::move(cell));
    }
    table.add_row(std::move(cells));
  }
  return table;
}

}  // namespace

std::vector<std::string> flow_sentences(const RunData& data) {
  const Json& rows = list(data.result, {"comparison"});
  if (rows.empty()) return {};
  std::vector<std::string> sentences;
  for (const bool held_out : {false, true}) {
    std::vector<std::string> widths, differing, jammed;
    double largest = 0.0;
    for (const Json& row : rows) {
      if ((at(row, {"held_out"}) == true) != held_out) continue;
      widths.push_back(opening(number(row, {"orifice_m"})));
      const double relative = number(row, {"error_kg_per_s"}) / number(row, {"filmed_kg_per_s"});
      if (!std::isfinite(relative)) {
        jammed.push_back(opening(number(row, {"orifice_m"})));
        continue;
      }
      if (std::abs(relative) > std::abs(largest)) largest = relative;
      if (is_resolved(row))
        differing.push_back(
            fmt::format("{} ({})", opening(number(row, {"orifice_m"})), percent(100.0 * relative)));
    }
    if (widths.empty()) continue;
    std::string sentence =
        !data.is_calibration()
            ? fmt::format("Simulated at given parameters: the flow through {}.", joined(widths))
        : held_out ? fmt::format(
                         "Predicted, not fitted: the flow through {}. The search never saw these "
                         "films.",
                         joined(widths))
                   : fmt::format("Fitted to the flow through {}.", joined(widths));
    if (jammed.size() < widths.size()) {
      sentence +=
          differing.empty()
              ? fmt::format(
                    " No rate differs from the films by more than twice the uncertainty of the "
                    "comparison. The largest difference is {}.",
                    percent(100.0 * largest))
              : fmt::format(
                    " Rates differ by more than twice the uncertainty of the comparison at {}.",
                    joined(differing));
    }
    if (!jammed.empty())
      sentence += fmt::format(" Nothing flowed steadily at {}, so no rate is compared there.",
                              joined(jammed));
    sentences.push_back(std::move(sentence));
  }
  sentences.emplace_back("Differences below 2 u_val cannot be told from chance.");
  return sentences;
}

Section flow_section(const RunData& data, Section section) {
  const Json& rows = list(data.result, {"comparison"});
  section.add_table(rate_table(data, rows));
  if (const auto curves = data.table("discharge_curves")) section.add_figure(curve_figure(*curves));
  section.begin_fold("Uncertainties, velocities and laws of the flow");
  section.add_paragraph(
      "D is the mean over films, S the mean over fresh simulations. Each simulation starts from "
      "the bed on its film. Where a film or a discharge curve does not show the bed, the "
      "simulation prepares one. u_val is the standard uncertainty of the comparison (ASME V&V 20). "
      "It has four parts: the scatter of films, the scatter of simulated runs, the uncertainty of "
      "the parameters, and the change on halving the time step.");
  section.add_table(uncertainty_table(rows));
  if (const auto profiles = data.table("velocity_comparison"))
    section.add_figure(profile_figure(*profiles));
  if (const auto boundaries = data.table("stagnant_boundary")) {
    section.add_figure(boundary_figure(*boundaries));
    section.add_table(overlap_table(rows));
  }
  const bool has_orifices = std::all_of(rows.begin(), rows.end(), [](const Json& row) {
    return std::isfinite(number(row, {"orifice_m"}));
  });
  if (!has_orifices) return section;  // nothing else depends on their width
  section.add_figure(beverloo_figure(rows));
  section.add_table(derived_table(data.result));
  return section;
}

}  // namespace graintruth::reports
