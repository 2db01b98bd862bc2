// Every compared quantity, measured and simulated: whatever result.json lists under `channels`, one
// heading an observable.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "reports/page/words.h"
#include "reports/sections/sections.h"

namespace graintruth::reports {

namespace {

// One observable in one condition.
struct Channel {
  std::string condition;  // empty where there is only one
  std::string use;        // see use_of()
  std::vector<double> axis, measured, lower, upper, simulated;

  bool is_curve() const { return axis.size() > 1 && axis.size() == measured.size(); }
  // Several values at each place of the axis, as tracks have
  bool is_bundle() const {
    return axis.size() > 1 && measured.size() > axis.size() && measured.size() % axis.size() == 0;
  }
};

struct Observable {
  std::string name, title, unit, axis, axis_unit;
  std::vector<Channel> channels;
};

std::string capitalised(std::string words) {
  // A single letter is a symbol
  if (words.size() > 1)
    words[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(words[0])));
  return words;
}

std::vector<Observable> read_observables(const RunData& data) {
  std::vector<Observable> all;
  for (const Json& json : list(data.result, {"channels"})) {
    const std::string name = text(json, {"observable"});
    Observable& observable = with_key(all, &Observable::name, name);
    observable.title = text(json, {"title"});
    if (observable.title.empty()) observable.title = capitalised(spaced(name));
    observable.unit = text(json, {"unit"});
    observable.axis = text(json, {"axis", "name"});
    observable.axis_unit = text(json, {"axis", "unit"});
    Channel channel{.condition = text(json, {"condition"}),
                    .use = use_of(data, json),
                    .axis = numbers(json, {"axis", "values"}),
                    .measured = numbers(json, {"measured"}),
                    .lower = numbers(json, {"lower"}),
                    .upper = numbers(json, {"upper"}),
                    .simulated = numbers(json, {"simulated"})};
    for (auto* values : {&channel.lower, &channel.upper, &channel.simulated})
      values->resize(channel.measured.size(), std::nan(""));
    observable.channels.push_back(std::move(channel));
  }
  return all;
}

// Units of the values of one place of the axis, in turn: "m, m, rad".
std::vector<std::string> units_in_turn(std::string units) {
  std::vector<std::string> all;
  for (std::size_t comma; (comma = units.find(", ")) != std::string::npos;
       units.erase(0, comma + 2))
    all.push_back(units.substr(0, comma));
  all.push_back(units);
  return all;
}

std::string axis_title(const Observable& observable, const ShownUnit& unit) {
  const bool is_time = observable.axis == "time";
  return with_unit(is_time ? "Time since the start event" : capitalised(observable.axis),
                   unit.text);
}

// Simulated values inside the measured interval, of those for which both are known. Directions in a
// bundle are those of axes, which repeat every half turn.
struct Count {
  int inside = 0, values = 0;
};

Count count_inside(const Channel& channel, const std::vector<std::string>& units) {
  Count counted;
  for (std::size_t i = 0; i < channel.measured.size(); ++i) {
    const double middle = (channel.lower[i] + channel.upper[i]) / 2.0;
    double apart = channel.simulated[i] - middle;
    if (!std::isfinite(apart)) continue;
    if (channel.is_bundle() && units[i % units.size()] == "rad")
      apart = std::remainder(apart, std::numbers::pi);
    ++counted.values;
    counted.inside += std::abs(apart) <= channel.upper[i] - middle ? 1 : 0;
  }
  return counted;
}

TableView inside_table(const Observable& observable) {
  TableView table(
      "Simulated means inside the 95 % interval of the measured mean",
      {{"Condition", Align::left}, {"Used for", Align::left}, {"Values"}, {"Inside"}, {"Share"}});
  for (const Channel& channel : observable.channels) {
    if (!channel.is_curve() && !channel.is_bundle()) continue;
    const Count counted = count_inside(channel, units_in_turn(observable.unit));
    table.add_row({channel.condition,
                   channel.use,
                   std::to_string(counted.values),
                   std::to_string(counted.inside),
                   percent(100.0 * counted.inside / counted.values)});
  }
  table.drop_empty_columns();
  return table;
}

Figure curve_figure(const Observable& observable) {
  const ShownUnit up = shown_unit(observable.unit), along = shown_unit(observable.axis_unit);
  const auto shown = [](std::vector<double> values, const ShownUnit& unit) {
    for (double& value : values) value *= unit.factor;
    return values;
  };
  Figure figure{.id = "compared-figure-" + identifier(observable.name),
                .caption = fmt::format(
                    "{}: simulation and replicates disagree where the dashed line leaves the "
                    "95 % interval.",
                    observable.title),
                .layout = {{"xaxis", axis(plot_text(axis_title(observable, along)))},
                           {"yaxis", axis(plot_text(with_unit(observable.title, up.text)))}},
                .menu = "Condition",
                .choices = {}};
  for (const Channel& channel : observable.channels) {
    if (!channel.is_curve()) continue;
    const bool is_predicted = channel.use == "prediction";
    const std::vector<double> x = shown(channel.axis, along);
    FigureChoice choice{.label = channel.condition + (is_predicted ? " (predicted)" : "")};
    choice.traces.push_back(band(x,
                                 shown(channel.lower, up),
                                 shown(channel.upper, up),
                                 "measured: 95 % interval of the mean",
                                 "var(--measured-band)"));
    choice.traces.push_back(
        line(x, shown(channel.measured, up), "measured: mean", "var(--measured-strong)"));
    choice.traces.push_back(line(x,
                                 shown(channel.simulated, up),
                                 is_predicted ? "predicted: mean" : "simulated: mean",
                                 "var(--simulated)"));
    choice.traces.back()["line"]["dash"] = "4px,2px";
    for (std::size_t i = 1; i < choice.traces.size(); ++i)
      choice.traces[i]["mode"] = "lines+markers";  // a value between two unknown ones shows, too
    figure.choices.push_back(std::move(choice));
  }
  return figure;
}

// Channels of one number, or of a few that no axis orders.
TableView number_table(const Observable& observable, std::size_t conditions) {
  const ShownUnit unit = shown_unit(observable.unit);
  TableView table(with_unit(observable.title, unit.text),
                  {{"Condition", Align::left},
                   {"Number"},
                   {"Measured"},
                   {"95 % interval"},
                   {"Simulated"},
                   {"Difference"},
                   {"Inside", Align::left},
                   {"Used for", Align::left}});
  // What the conditions have in common, a law's constants, is told once
  const bool is_of_all = conditions > 1 && observable.channels.size() == 1;
  for (const Channel& channel : observable.channels) {
    if (channel.is_curve() || channel.is_bundle()) continue;
    for (std::size_t i = 0; i < channel.measured.size(); ++i) {
      const double measured = unit.factor * channel.measured[i];
      const double simulated = unit.factor * channel.simulated[i];
      const double lower = unit.factor * channel.lower[i], upper = unit.factor * channel.upper[i];
      const bool is_known =
          std::isfinite(lower) && std::isfinite(upper) && std::isfinite(simulated);
      const auto cell = [&](double value) { return to_interval(value, lower, upper); };
      table.add_row({is_of_all ? "all together" : channel.condition,
                     channel.measured.size() > 1 ? std::to_string(i + 1) : "",
                     cell(measured),
                     interval_text(lower, upper),
                     cell(simulated),
                     cell(simulated - measured),
                     !is_known                                  ? std::string(nothing)
                     : lower <= simulated && simulated <= upper ? "yes"
                                                                : "no",
                     is_of_all ? "" : channel.use});
    }
  }
  table.drop_empty_columns();
  return table;
}

void add_observable(const RunData& data,
                    const Observable& observable,
                    std::size_t conditions,
                    Section& section) {
  section.add_heading(observable.title, "compared-" + identifier(observable.name));
  const auto has = [&](bool (Channel::*is)() const) {
    return std::any_of(observable.channels.begin(),
                       observable.channels.end(),
                       [&](const Channel& channel) { return (channel.*is)(); });
  };
  const bool has_curves = has(&Channel::is_curve), has_bundles = has(&Channel::is_bundle);
  // Tracks have sections of their own: here they are but counted
  if (has_bundles && !has_curves)
    section.begin_fold("How many simulated means lie inside the interval");
  if (has_bundles) {
    const Channel& first = *std::find_if(observable.channels.begin(),
                                         observable.channels.end(),
                                         [](const Channel& one) { return one.is_bundle(); });
    section.add_paragraph(
        fmt::format("{} values at each of {} values of {}.{}",
                    first.measured.size() / first.axis.size(),
                    first.axis.size(),
                    observable.axis,
                    observable.name == "tracks" && has_tracks(data)
                        ? " The sections \u201cAgreement\u201d and \u201cTracks\u201d show them."
                        : ""));
  }
  if (has_curves) section.add_figure(curve_figure(observable));
  const TableView single = number_table(observable, conditions);
  if (!single.is_empty()) section.add_table(single);
  if (!has_curves && !has_bundles) return;
  if (has_curves) section.begin_fold("How many simulated means lie inside the interval");
  section.add_table(inside_table(observable));
}

// What each kind of quantity leaves of the objective.
void add_shares(const RunData& data, const std::vector<Observable>& observables, Section& section) {
  const Json& shares = at(data.result, {"objective", "shares"});
  if (!shares.is_object()) return;
  TableView table("What is left of the objective at these parameters",
                  {{"Quantity", Align::left}, {"Objective of it alone"}});
  for (const auto& item : shares.items()) {
    const std::string& kind = item.key();
    const auto& share = item.value();
    const auto found = std::find_if(observables.begin(),
                                    observables.end(),
                                    [&](const Observable& one) { return one.name == kind; });
    table.add_row({found == observables.end() ? capitalised(spaced(kind)) : found->title,
                   significant(number(share, {}), 2)});
  }
  section.begin_fold("Shares of the objective");
  section.add_table(table);
  section.add_paragraph(
      "0 means that the simulated means are equal to the measured ones. The objective is the mean "
      "of these numbers. A quantity counts by the weight that the experiment file gives it, and "
      "not by how many values it has.");
}

}  // namespace

bool has_comparisons(const RunData& data) {
  return !list(data.result, {"channels"}).empty() ||
         at(data.result, {"objective", "shares"}).is_object();
}

std::vector<std::string> compared_sentences(const RunData& data) {
  std::vector<std::string> sentences;
  if (!list(data.result, {"comparison"}).empty()) return sentences;
  for (const Observable& observable : read_observables(data)) {
    if (observable.channels.front().is_bundle() && has_tracks(data)) continue;
    Count counted;
    for (const Channel& channel : observable.channels) {
      const Count own = count_inside(channel, units_in_turn(observable.unit));
      counted.inside += own.inside;
      counted.values += own.values;
    }
    sentences.push_back(fmt::format(
        "{}: the simulated mean lies inside the 95 % interval of the measured mean for {} of {} "
        "values.",
        observable.title,
        counted.inside,
        counted.values));
  }
  return sentences;
}

Section compared_section(const RunData& data, Section section) {
  const std::vector<Observable> observables = read_observables(data);
  if (!observables.empty()) {
    section.add_paragraph(
        "Measured: the mean of the replicates, with the 95 % interval of this mean. Simulated: the "
        "mean of fresh simulations at the parameters of this page.");
    if (data.is_calibration() && data.has_held_out()) {
      section.add_paragraph(
          "Conditions used for calibration had a part in the search for these parameters. Those "
          "used for prediction were held out: the search never saw them.");
    }
  }
  std::vector<std::string> conditions;
  for (const Observable& observable : observables)
    for (const Channel& channel : observable.channels) add_once(conditions, channel.condition);
  for (const Observable& observable : observables)
    add_observable(data, observable, conditions.size(), section);
  add_shares(data, observables, section);
  return section;
}

}  // namespace graintruth::reports
