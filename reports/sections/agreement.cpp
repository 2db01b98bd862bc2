// The agreement (equation 4.2 of the thesis), with the scores that it is compared with: in
// Student's form in its own section, in the thesis's form (1.96, Table 4.2) in an appendix.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "reports/page/words.h"
#include "reports/sections/sections.h"

namespace graintruth::reports {

namespace {

struct ScoreRow {
  std::string label;
  double student = 0.0;
  double thesis = 0.0;
};

// The score of the run, and the scores that it is compared with.
std::vector<ScoreRow> scores(const Json& agreement) {
  const auto row = [&](std::string label, const std::string& key) {
    return ScoreRow{std::move(label),
                    number(agreement, {key + "_percent_student_t"}),
                    number(agreement, {key + "_percent"})};
  };
  const std::string seeds = count(number(agreement, {"seeds"}));
  std::vector<ScoreRow> rows;
  rows.push_back({fmt::format("Mean of {} simulations (the score)", seeds),
                  number(agreement, {"percent_student_t"}),
                  number(agreement, {"percent"})});
  rows.push_back({"The same without the first frame",
                  number(agreement, {"without_first_frame", "percent_student_t"}),
                  number(agreement, {"without_first_frame", "percent"})});
  rows.push_back(row(fmt::format("A perfect model on average, mean of {} runs", seeds), "ceiling"));
  rows.push_back(row("One simulated run, median", "single_run_median"));
  rows.push_back(row("Leave-one-out: one more real replicate", "leave_one_out"));
  return rows;
}

// In which a value is tested: Student's interval, or the thesis's with 1.96.
enum class Form { student, thesis };

TableView score_table(const std::vector<ScoreRow>& rows, Form form) {
  TableView table(form == Form::student ? "Agreement, and the scores to compare it with"
                                        : "The same scores in the thesis's form",
                  {{"Whose tracks", Align::left}, {"Inside the interval"}});
  for (const ScoreRow& row : rows)
    table.add_row({row.label, percent(form == Form::student ? row.student : row.thesis)});
  return table;
}

struct ParticleRow {
  std::string particle;
  double ranks[4] = {};
  double points = 0.0;
  double possible = 0.0;  // points to be had; in folders that do not tell, all of every frame
  double thesis = 0.0;
  double student = 0.0;
};

std::vector<ParticleRow> particle_rows(const RunData& data) {
  const auto table = data.table("agreement");
  if (!table) return {};
  const auto quantities = static_cast<double>(compared_quantities(data).size());
  std::vector<ParticleRow> rows(table->rows());
  const auto particles = text_column(*table, "particle");
  const auto points = column(*table, "points"), possible = column(*table, "possible");
  const auto thesis = column(*table, "percent"), student = column(*table, "percent_student_t");
  for (std::size_t i = 0; i < rows.size(); ++i)
    rows[i] = {particles[i], {}, points[i], 0.0, thesis[i], student[i]};
  for (int rank = 0; rank < 4; ++rank) {
    const auto frames = column(*table, fmt::format("rank{}", rank));
    for (std::size_t i = 0; i < rows.size(); ++i) {
      rows[i].ranks[rank] = frames[i];
      rows[i].possible += quantities * frames[i];
    }
  }
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (table->has("possible")) rows[i].possible = possible[i];
  return rows;
}

TableView student_table(const std::vector<ParticleRow>& rows) {
  TableView table("Agreement per particle", {{"Particle", Align::left}, {"Inside the interval"}});
  double sum = 0.0;
  for (const ParticleRow& row : rows) {
    table.add_row({row.particle, percent(row.student)});
    sum += row.student;
  }
  table.add_total({"All", percent(sum / static_cast<double>(rows.size()))});
  return table;
}

// In the thesis's form. `quantities` is the highest rank.
TableView particle_table(const std::vector<ParticleRow>& rows, int quantities) {
  std::vector<TableView::Column> columns = {{"Particle", Align::left}, {"Frames of rank 0"}};
  for (int rank = 1; rank <= quantities; ++rank) columns.push_back({fmt::format("rank {}", rank)});
  columns.insert(columns.end(), {{"Weighted points"}, {"Agreement"}});
  TableView table("Agreement per particle, laid out as the thesis's Table 4.2", columns);
  // A row: name, what each rank has, the rest
  const auto cells = [&](std::string name, const auto& of_rank, std::vector<std::string> rest) {
    std::vector<std::string> row = {std::move(name)};
    for (int rank = 0; rank <= quantities; ++rank) row.push_back(of_rank(rank));
    row.insert(row.end(), rest.begin(), rest.end());
    return row;
  };
  double frames_total = 0.0;
  double sums[4] = {};
  double points = 0.0;
  double possible = 0.0;
  double thesis = 0.0;
  for (const ParticleRow& row : rows) {
    for (int rank = 0; rank < 4; ++rank) {
      sums[rank] += row.ranks[rank];
      frames_total += row.ranks[rank];
    }
    points += row.points;
    possible += row.possible;
    thesis += row.thesis;
    table.add_row(cells(
        row.particle,
        [&](int rank) { return count(row.ranks[rank]); },
        {fmt::format("{} of {}", count(row.points), count(row.possible)), percent(row.thesis)}));
  }
  const double particles = static_cast<double>(rows.size());
  table.add_total(cells(
      "All",
      [&](int rank) { return count(sums[rank]); },
      {fmt::format("{} of {}", count(points), count(possible)), percent(thesis / particles)}));
  table.add_total(cells("Share of frames",
                        [&](int rank) { return percent(100.0 * sums[rank] / frames_total); },
                        {"", ""}));
  return table;
}

// One cell a particle and frame: how many quantities lie inside, at most `quantities`.
Figure rank_figure(const datasets::Table& ranks, int quantities, Form form) {
  const std::vector<double> times = column(ranks, "time_s");
  const std::vector<double> particles = column(ranks, "particle");
  const std::set<double> columns(times.begin(), times.end());
  const std::set<double> rows(particles.begin(), particles.end());
  Json names = Json::array();
  for (const double particle : rows) names.push_back(count(particle));
  const std::vector<double> x(columns.begin(), columns.end());

  const auto choice = [&](const std::string& label, std::string_view name) {
    const std::vector<double> values = column(ranks, name);
    std::map<std::pair<double, double>, double> cells;
    for (std::size_t i = 0; i < values.size(); ++i) cells[{particles[i], times[i]}] = values[i];
    Json z = Json::array();
    for (const double particle : rows) {
      std::vector<double> line_of_cells;
      for (const double time : columns) {
        const auto found = cells.find({particle, time});
        line_of_cells.push_back(found == cells.end() ? std::nan("") : found->second);
      }
      z.push_back(plot_numbers(line_of_cells));
    }
    Json scale = Json::array();
    const double shades = quantities + 1.0;
    Json ticks = Json::array();
    for (int rank = 0; rank <= quantities; ++rank) {
      // The best is as dark whatever it is out of.
      const std::string colour = fmt::format("var(--rank{})", rank == quantities ? 3 : rank);
      scale.push_back({rank / shades, colour});
      scale.push_back({(rank + 1) / shades, colour});
      ticks.push_back(rank);
    }
    FigureChoice made{.label = label};
    made.traces.push_back({{"type", "heatmap"},
                           {"x", plot_numbers(x)},
                           {"y", names},
                           {"z", z},
                           {"zmin", -0.5},
                           {"zmax", quantities + 0.5},
                           {"xgap", 1},
                           {"ygap", 1},
                           {"colorscale", scale},
                           {"hovertemplate", "particle %{y}, %{x} s: rank %{z}<extra></extra>"},
                           {"colorbar",
                            {{"title", {{"text", "rank"}, {"font", {{"size", 12}}}}},
                             {"tickvals", ticks},
                             {"thickness", 12},
                             {"outlinewidth", 0}}}});
    return made;
  };
  const bool is_student = form == Form::student;
  const FigureChoice only =
      is_student ? choice("Student's t", "rank_student_t") : choice("thesis form, 1.96", "rank");
  return {
      .id = is_student ? "agreement-ranks" : "thesis-ranks",
      .caption = is_student
                     ? fmt::format("How many values of a particle lie inside the 95 % "
                                   "interval of the replicates at each moment, 0 to {} (its "
                                   "rank). Pale regions show what the simulation gets wrong.",
                                   quantities)
                     : "The same with the interval of the thesis.",
      .height = 120 + 26 * static_cast<int>(rows.size()),
      .layout = {{"xaxis", axis("Time since the start event (s)", {{"showgrid", false}})},
                 {"yaxis",
                  axis("Particle (its starting place)",
                       {{"autorange", "reversed"}, {"type", "category"}, {"showgrid", false}})}},
      .menu = "",
      .choices = {only}};
}

}  // namespace

Section agreement_section(const RunData& data, Section section) {
  const Json& agreement = at(data.result, {"agreement"});
  const std::vector<std::string> quantities = compared_quantities(data);
  const auto highest = static_cast<int>(quantities.size());
  section.add_paragraph(fmt::format(
      "{} of the compared values ({}) lie inside the 95 % interval of the replicates. A perfect "
      "model reaches {} on average, a further replicate {}.",
      percent(number(agreement, {"percent_student_t"})),
      joined(quantities),
      percent(number(agreement, {"ceiling_percent_student_t"})),
      percent(number(agreement, {"leave_one_out_percent_student_t"}))));
  const auto ranks = data.table("ranks");
  if (ranks && ranks->has("rank_student_t")) {
    section.add_figure(rank_figure(*ranks, highest, Form::student));
  } else {
    section.add_absence(
        "The ranks frame by frame (tables/ranks.csv) are absent, so they are not drawn.");
  }
  section.begin_fold("Scores in a table, and particle by particle");
  section.add_table(score_table(scores(agreement), Form::student));
  const double rms = number(data.result, {"rms_position_m"});
  if (std::isfinite(rms)) {
    section.add_paragraph(fmt::format(
        "A wide interval is easy to hit. So this page also gives the distance. The "
        "root-mean-square "
        "distance between the mean simulated and the mean filmed centre is {} mm over all "
        "particles and frames. One row leaves out the first frame: all replicates start in the "
        "same places, so there is almost no interval to hit.",
        significant(1000.0 * rms)));
  }
  const std::vector<ParticleRow> particles = particle_rows(data);
  if (particles.empty()) {
    section.add_absence("The table of agreement per particle (tables/agreement.csv) is absent.");
  } else {
    section.add_table(student_table(particles));
  }
  return section;
}

Section thesis_section(const RunData& data, Section section) {
  section.add_paragraph(
      "For comparison with the thesis only: it uses 1.96 in place of Student\u2019s t, so that its "
      "intervals are too narrow for few replicates and its scores lower.");
  section.begin_fold("Scores and ranks in the thesis\u2019s form");
  section.add_table(score_table(scores(at(data.result, {"agreement"})), Form::thesis));
  const std::vector<std::string> quantities = compared_quantities(data);
  const auto highest = static_cast<int>(quantities.size());
  const std::vector<ParticleRow> particles = particle_rows(data);
  if (!particles.empty()) {
    section.add_paragraph(fmt::format(
        "Rank of a particle in a frame: how many of its values ({}) lie inside the interval, 0 to "
        "{}. Weighted points are the sum of the ranks. Agreement is the share of the points that "
        "could be reached.",
        joined(quantities),
        highest));
    section.add_table(particle_table(particles, highest));
  }
  if (const auto ranks = data.table("ranks"); ranks && ranks->has("rank"))
    section.add_figure(rank_figure(*ranks, highest, Form::thesis));
  return section;
}

}  // namespace graintruth::reports
