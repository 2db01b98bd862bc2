// Tracks: what was filmed, with its interval, and what was simulated, particle by particle.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "reports/sections.h"
#include "reports/words.h"

namespace graintruth::reports {

namespace {

// One quantity of one particle over time, in the unit of the picture (mm or degrees).
struct Course {
  std::vector<double> time;
  std::vector<double> measured, lower_thesis, upper_thesis, lower_student, upper_student;
  std::vector<double> simulated, simulated_lower, simulated_upper;
};

struct ParticleCourses {
  Course x, z, angle;
};

std::map<int, ParticleCourses> read_courses(const datasets::Table& bands) {
  constexpr double mm_per_m = 1000.0;
  constexpr double deg_per_rad = 180.0 / std::numbers::pi;
  const auto times = column(bands, "time_s");
  const auto quantities = text_column(bands, "quantity");
  const std::vector<std::pair<std::string, std::vector<double> Course::*>> members = {
      {"replicate_mean", &Course::measured},
      {"lower_196", &Course::lower_thesis},
      {"upper_196", &Course::upper_thesis},
      {"lower_t", &Course::lower_student},
      {"upper_t", &Course::upper_student},
      {"simulated_mean", &Course::simulated},
      {"simulated_lower", &Course::simulated_lower},
      {"simulated_upper", &Course::simulated_upper}};
  std::map<std::string, std::vector<double>> columns;
  for (const auto& [name, member] : members) columns[name] = column(bands, name);

  std::map<int, ParticleCourses> courses;
  for (std::size_t row = 0; row < bands.rows(); ++row) {
    ParticleCourses& of_particle = courses[bands.integer(row, "particle")];
    const std::string& quantity = quantities[row];
    Course* course = quantity == "x"       ? &of_particle.x
                     : quantity == "z"     ? &of_particle.z
                     : quantity == "angle" ? &of_particle.angle
                                           : nullptr;
    if (course == nullptr) continue;
    const double factor = quantity == "angle" ? deg_per_rad : mm_per_m;
    course->time.push_back(times[row]);
    for (const auto& [name, member] : members)
      (course->*member).push_back(factor * columns[name][row]);
  }
  return courses;
}

double median(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2.0;
}

double median_half_width(const Course& course) {
  std::vector<double> widths;
  for (std::size_t i = 0; i < course.time.size(); ++i)
    widths.push_back((course.upper_student[i] - course.lower_student[i]) / 2.0);
  return median(widths);
}

double mean_square_difference(const Course& course) {
  double sum = 0.0;
  int values = 0;
  for (std::size_t i = 0; i < course.time.size(); ++i) {
    const double difference = course.simulated[i] - course.measured[i];
    if (!std::isfinite(difference)) continue;
    sum += difference * difference;
    ++values;
  }
  return values > 0 ? sum / values : std::nan("");
}

// Single balls, and some programs' files, tell no angles.
bool shows_angles(const std::map<int, ParticleCourses>& courses) {
  return std::any_of(courses.begin(), courses.end(), [](const auto& of_particle) {
    const std::vector<double>& angles = of_particle.second.angle.measured;
    return std::any_of(
        angles.begin(), angles.end(), [](double angle) { return std::isfinite(angle); });
  });
}

TableView difference_table(const std::map<int, ParticleCourses>& courses) {
  std::vector<TableView::Column> columns = {{"Particle", Align::left},
                                            {"RMS distance (mm)"},
                                            {"Half-width x (mm)"},
                                            {"Half-width z (mm)"}};
  const bool with_angle = shows_angles(courses);
  if (with_angle) columns.insert(columns.end(), {{"RMS angle (°)"}, {"Half-width angle (°)"}});
  TableView table(
      "How far the simulated mean is from the filmed mean, beside the interval it has to hit",
      columns);
  for (const auto& [particle, course] : courses) {
    std::vector<std::string> cells = {
        std::to_string(particle),
        decimal(std::sqrt(mean_square_difference(course.x) + mean_square_difference(course.z)), 1),
        decimal(median_half_width(course.x), 1),
        decimal(median_half_width(course.z), 1)};
    if (with_angle) {
      cells.push_back(decimal(std::sqrt(mean_square_difference(course.angle)), 1));
      cells.push_back(decimal(median_half_width(course.angle), 1));
    }
    table.add_row(cells);
  }
  return table;
}

// The same as seen from the films' mean, where intervals of a millimetre can be seen.
Course from_measured(const Course& course) {
  Course difference = course;
  for (std::vector<double> Course::*member : {&Course::measured,
                                              &Course::lower_thesis,
                                              &Course::upper_thesis,
                                              &Course::lower_student,
                                              &Course::upper_student,
                                              &Course::simulated,
                                              &Course::simulated_lower,
                                              &Course::simulated_upper}) {
    for (std::size_t i = 0; i < course.time.size(); ++i)
      (difference.*member)[i] -= course.measured[i];
  }
  return difference;
}

void add_course(Json& traces, const Course& course, std::string_view y_axis, bool in_legend) {
  std::vector<Json> made = {
      band(course.time,
           course.lower_student,
           course.upper_student,
           "films: 95 % interval, Student",
           "var(--measured-pale)"),
      band(course.time,
           course.lower_thesis,
           course.upper_thesis,
           "with 1.96",
           "var(--measured-band)"),
      band(course.time,
           course.simulated_lower,
           course.simulated_upper,
           "simulations: one run, ± 1 s",
           "var(--simulated-band)"),
      line(course.time, course.measured, "films: mean", "var(--measured-strong)"),
      line(course.time, course.simulated, "simulations: mean", "var(--simulated)")};
  made.back()["line"]["dash"] = "4px,2px";
  for (Json& trace : made) {
    place(trace, "x", y_axis);
    trace["legendgroup"] = trace["name"];
    trace["showlegend"] = in_legend;
    traces.push_back(trace);
  }
}

// The courses of a particle one above the other, each with the name of its axis.
struct Panel {
  std::string axis;
  Course ParticleCourses::*course;
};

std::vector<Panel> panels(bool with_angle, std::string_view prefix) {
  std::vector<Panel> all = {{fmt::format("{}x (mm)", prefix), &ParticleCourses::x},
                            {fmt::format("{}z (mm)", prefix), &ParticleCourses::z}};
  if (with_angle) all.push_back({fmt::format("{}angle (°)", prefix), &ParticleCourses::angle});
  return all;
}

std::string numbered(std::string_view name, std::size_t panel) {
  return panel == 0 ? std::string(name) : fmt::format("{}{}", name, panel + 1);
}

Json stacked_layout(const std::vector<Panel>& stack) {
  constexpr double gap = 0.05;
  const auto count = static_cast<double>(stack.size());
  const double height = (1.0 - gap * (count - 1.0)) / count;
  Json layout = {
      {"xaxis",
       axis("Time since the start event (s)", {{"anchor", numbered("y", stack.size() - 1)}})}};
  for (std::size_t panel = 0; panel < stack.size(); ++panel) {
    const double top = 1.0 - static_cast<double>(panel) * (height + gap);
    layout[numbered("yaxis", panel)] =
        axis(stack[panel].axis, {{"domain", {std::max(0.0, top - height), top}}});
  }
  return layout;
}

FigureChoice stacked(int particle,
                     const ParticleCourses& courses,
                     const std::vector<Panel>& stack) {
  FigureChoice choice{.label = std::to_string(particle)};
  for (std::size_t panel = 0; panel < stack.size(); ++panel)
    add_course(choice.traces, courses.*stack[panel].course, numbered("y", panel), panel == 0);
  return choice;
}

int stacked_height(const std::vector<Panel>& stack) { return 240 * static_cast<int>(stack.size()); }

Figure course_figure(const std::map<int, ParticleCourses>& courses) {
  const std::vector<Panel> stack = panels(shows_angles(courses), "");
  std::vector<FigureChoice> choices;
  for (const auto& [particle, course] : courses)
    choices.push_back(stacked(particle, course, stack));
  return {
      .id = "tracks-over-time",
      .caption = fmt::format(
          "Position{} of one particle against time; the dashed line should follow the solid one "
          "through every bend.",
          stack.size() > 2 ? " and angle" : ""),
      .height = stacked_height(stack),
      .layout = stacked_layout(stack),
      .menu = "Particle",
      .choices = choices};
}

Figure difference_figure(const std::map<int, ParticleCourses>& courses) {
  const std::vector<Panel> stack = panels(shows_angles(courses), "Δ");
  std::vector<FigureChoice> choices;
  for (const auto& [particle, course] : courses) {
    choices.push_back(
        stacked(particle,
                {from_measured(course.x), from_measured(course.z), from_measured(course.angle)},
                stack));
  }
  return {.id = "tracks-difference",
          .caption =
              "The same as differences from the films' mean: where the dashed line leaves the "
              "shaded interval, "
              "simulation and films disagree by more than the replicates do.",
          .height = stacked_height(stack),
          .layout = stacked_layout(stack),
          .menu = "Particle",
          .choices = choices};
}

// Walls as one line with gaps, mm.
Json wall_trace(const Json& walls) {
  std::vector<double> x;
  std::vector<double> z;
  for (const Json& wall : walls) {
    x.insert(
        x.end(),
        {1000.0 * number(wall, {"from_x_m"}), 1000.0 * number(wall, {"to_x_m"}), std::nan("")});
    z.insert(
        z.end(),
        {1000.0 * number(wall, {"from_z_m"}), 1000.0 * number(wall, {"to_z_m"}), std::nan("")});
  }
  return line(x, z, "walls", "var(--ink)", 2.5);
}

Figure path_figure(const RunData& data, const std::map<int, ParticleCourses>& courses) {
  FigureChoice choice;
  std::vector<double> start_x;
  std::vector<double> start_z;
  Json numbers = Json::array();
  bool first = true;
  for (const auto& [particle, course] : courses) {
    if (course.x.time != course.z.time || course.x.time.empty()) continue;
    Json measured =
        line(course.x.measured, course.z.measured, "films: mean", "var(--measured-strong)");
    Json simulated =
        line(course.x.simulated, course.z.simulated, "simulations: mean", "var(--simulated)");
    simulated["line"]["dash"] = "4px,2px";
    for (Json* trace : {&measured, &simulated}) {
      (*trace)["legendgroup"] = (*trace)["name"];
      (*trace)["showlegend"] = first;
      (*trace)["hovertemplate"] =
          fmt::format("particle {}: %{{x:.0f}}, %{{y:.0f}} mm<extra></extra>", particle);
      choice.traces.push_back(*trace);
    }
    start_x.push_back(course.x.measured.front());
    start_z.push_back(course.z.measured.front());
    numbers.push_back(std::to_string(particle));
    first = false;
  }
  Json starts = points(start_x, start_z, "starting place", "var(--measured-strong)", "circle", 6.0);
  starts["mode"] = "markers+text";
  starts["text"] = numbers;
  starts["textposition"] = "top center";
  starts["hoverinfo"] = "skip";
  choice.traces.push_back(starts);
  const Json& walls = list(data.run, {"rig", "walls"});
  if (!walls.empty()) choice.traces.push_back(wall_trace(walls));
  const double face = 1000.0 * number(data.run, {"rig", "piston", "face_z_m"});
  const double half_width = 1000.0 * number(data.run, {"rig", "piston", "half_width_m"});
  if (std::isfinite(face) && std::isfinite(half_width)) {
    choice.traces.push_back(
        line({-half_width, half_width}, {face, face}, "piston at the start", "var(--muted)", 2.5));
    choice.traces.back()["line"]["dash"] = "dot";
  }
  return {
      .id = "tracks-in-the-rig",
      .caption = fmt::format(
          "Mean paths of all particles in the rig{}: filmed and simulated paths that part show "
          "where the flow differs, whatever the timing.",
          walls.empty() ? " (this run recorded no walls)" : ""),
      .height = 620,
      .layout = {{"xaxis",
                  axis(
                      "x (mm)",
                      {{"zeroline", false}, {"constrain", "domain"}, {"constraintoward", "left"}})},
                 {"yaxis",
                  axis("z (mm)",
                       {{"scaleanchor", "x"},
                        {"scaleratio", 1},
                        {"zeroline", false},
                        {"constrain", "domain"}})}},
      .menu = "",
      .choices = {choice}};
}

}  // namespace

Section tracks_section(const RunData& data, Section section) {
  const auto bands = data.table("bands");
  if (!bands || !bands->has("particle")) {
    section.add_absence(
        "The tracks with their intervals (tables/bands.csv) are absent, so none are drawn here.");
    return section;
  }
  const std::map<int, ParticleCourses> courses = read_courses(*bands);
  section.add_paragraph(
      "Half-widths are those of the films' 95 % interval (Student), the median over the frames. A "
      "particle with a small "
      "distance and a wide interval scores well without much being known; one with a narrow "
      "interval is a hard test.");
  section.add_table(difference_table(courses));
  section.add_figure(course_figure(courses));
  section.add_figure(difference_figure(courses));
  section.add_figure(path_figure(data, courses));
  return section;
}

}  // namespace graintruth::reports
