// Tracks: what was filmed, with its interval, and what was simulated, particle by particle.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <utility>

#include "reports/page/words.h"
#include "reports/sections/sections.h"

namespace graintruth::reports {

namespace {

// One quantity of one particle over time, in the unit of the picture (mm or degrees).
struct Course {
  std::vector<double> time;
  std::vector<double> measured, lower_student, upper_student;
  std::vector<double> simulated, simulated_lower, simulated_upper;
};

using ParticleCourses = std::map<std::string, Course>;  // by quantity

struct Quantity {
  std::string_view name, unit;
  double factor;  // from the unit of the table
};
constexpr Quantity all_quantities[] = {
    {"x", "mm", 1000.0}, {"z", "mm", 1000.0}, {"angle", "°", 180.0 / std::numbers::pi}};

std::map<int, ParticleCourses> read_courses(const datasets::Table& bands) {
  const auto times = column(bands, "time_s");
  const auto quantities = text_column(bands, "quantity");
  const std::vector<std::pair<std::string, std::vector<double> Course::*>> members = {
      {"replicate_mean", &Course::measured},
      {"lower_t", &Course::lower_student},
      {"upper_t", &Course::upper_student},
      {"simulated_mean", &Course::simulated},
      {"simulated_lower", &Course::simulated_lower},
      {"simulated_upper", &Course::simulated_upper}};
  std::map<std::string, std::vector<double>> columns;
  for (const auto& [name, member] : members) columns[name] = column(bands, name);

  std::map<int, ParticleCourses> courses;
  for (std::size_t row = 0; row < bands.rows(); ++row) {
    const auto* quantity = std::find_if(
        std::begin(all_quantities), std::end(all_quantities), [&](const Quantity& one) {
          return one.name == quantities[row];
        });
    if (quantity == std::end(all_quantities)) continue;
    Course& course = courses[bands.integer(row, "particle")][quantities[row]];
    course.time.push_back(times[row]);
    for (const auto& [name, member] : members)
      (course.*member).push_back(quantity->factor * columns[name][row]);
  }
  return courses;
}

// Those that the tracks tell of any particle: single balls have no angle, a heap no x.
std::vector<Quantity> quantities_of(const std::map<int, ParticleCourses>& courses) {
  std::vector<Quantity> told;
  for (const Quantity& quantity : all_quantities) {
    const bool is_told = std::any_of(courses.begin(), courses.end(), [&](const auto& particle) {
      const auto course = particle.second.find(std::string(quantity.name));
      if (course == particle.second.end()) return false;
      const std::vector<double>& values = course->second.measured;
      return std::any_of(
          values.begin(), values.end(), [](double value) { return std::isfinite(value); });
    });
    if (is_told) told.push_back(quantity);
  }
  return told;
}

// Empty where the tracks of this particle do not tell it.
const Course& course_of(const ParticleCourses& particle, const Quantity& quantity) {
  static const Course none;
  const auto found = particle.find(std::string(quantity.name));
  return found == particle.end() ? none : found->second;
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

bool is_angle(const Quantity& quantity) { return quantity.name == "angle"; }

TableView difference_table(const std::map<int, ParticleCourses>& courses,
                           const std::vector<Quantity>& quantities) {
  std::vector<TableView::Column> columns = {{"Particle", Align::left}, {"RMS distance (mm)"}};
  for (const Quantity& quantity : quantities) {
    if (is_angle(quantity)) columns.push_back({"RMS angle (°)"});
    columns.push_back({fmt::format("Half-width {} ({})", quantity.name, quantity.unit)});
  }
  TableView table("Distance of the simulated mean from the films' mean, beside the films' interval",
                  columns);
  for (const auto& [particle, of_particle] : courses) {
    double distance = 0.0;
    std::vector<std::string> cells = {std::to_string(particle), ""};
    for (const Quantity& quantity : quantities) {
      const Course& course = course_of(of_particle, quantity);
      const double square = mean_square_difference(course);
      if (is_angle(quantity)) cells.push_back(decimal(std::sqrt(square), 1));
      if (!is_angle(quantity)) distance += square;
      cells.push_back(decimal(median_half_width(course), 1));
    }
    cells[1] = decimal(std::sqrt(distance), 1);
    table.add_row(cells);
  }
  return table;
}

// The same as seen from the films' mean, where intervals of a millimetre can be seen.
Course from_measured(const Course& course) {
  Course difference = course;
  for (std::vector<double> Course::*member : {&Course::measured,
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
           "replicates: 95 % interval",
           "var(--measured-band)"),
      band(course.time,
           course.simulated_lower,
           course.simulated_upper,
           "simulations: one run, ± 1 s.d.",
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

std::string numbered(std::string_view name, std::size_t panel) {
  return panel == 0 ? std::string(name) : fmt::format("{}{}", name, panel + 1);
}

// The courses of a particle one above the other, each as it is or as the difference from the films'
// mean.
Figure stacked_figure(const std::map<int, ParticleCourses>& courses,
                      const std::vector<Quantity>& quantities,
                      bool is_difference) {
  constexpr double gap = 0.05;
  const auto panels = static_cast<double>(quantities.size());
  const double height = (1.0 - gap * (panels - 1.0)) / panels;
  std::vector<std::string> names(quantities.size());
  std::transform(quantities.begin(), quantities.end(), names.begin(), [](const Quantity& one) {
    return std::string(one.name);
  });
  Figure figure{
      .id = is_difference ? "tracks-difference" : "tracks-over-time",
      .caption =
          is_difference
              ? "The same as differences from the films' mean. Simulation and films disagree where "
                "the dashed line leaves the shaded interval."
              : fmt::format(
                    "Tracks of one particle against time: {}. The dashed line should follow "
                    "the solid one.",
                    joined(names)),
      .height = 240 * static_cast<int>(quantities.size()),
      .layout = {{"xaxis",
                  axis("Time since the start event (s)",
                       {{"anchor", numbered("y", quantities.size() - 1)}})}},
      .menu = "Particle",
      .choices = {}};
  for (std::size_t panel = 0; panel < quantities.size(); ++panel) {
    const double top = 1.0 - static_cast<double>(panel) * (height + gap);
    figure.layout[numbered("yaxis", panel)] = axis(
        fmt::format(
            "{}{} ({})", is_difference ? "Δ" : "", quantities[panel].name, quantities[panel].unit),
        {{"domain", {std::max(0.0, top - height), top}}});
  }
  for (const auto& [particle, of_particle] : courses) {
    FigureChoice choice{.label = std::to_string(particle)};
    for (std::size_t panel = 0; panel < quantities.size(); ++panel) {
      const Course& course = course_of(of_particle, quantities[panel]);
      add_course(choice.traces,
                 is_difference ? from_measured(course) : course,
                 numbered("y", panel),
                 panel == 0);
    }
    figure.choices.push_back(std::move(choice));
  }
  return figure;
}

// Root of the mean square over particles, moment by moment.
class MeanSquare {
 public:
  void add(double time, double square) {
    if (!std::isfinite(square)) return;
    Sum& sum = sums_[time];
    sum.squares += square;
    ++sum.count;
    total_.squares += square;
    ++total_.count;
  }
  std::vector<double> times() const {
    std::vector<double> all;
    for (const auto& [time, sum] : sums_) all.push_back(time);
    return all;
  }
  std::vector<double> roots() const {
    std::vector<double> all;
    for (const auto& [time, sum] : sums_) all.push_back(std::sqrt(sum.squares / sum.count));
    return all;
  }
  double root() const { return std::sqrt(total_.squares / total_.count); }  // NaN of nothing

 private:
  struct Sum {
    double squares = 0.0;
    int count = 0;
  };
  std::map<double, Sum> sums_;
  Sum total_;
};

// The quantities that one panel takes together: places as a distance, angles by themselves.
std::vector<std::vector<Quantity>> panels_of(const std::vector<Quantity>& quantities) {
  std::vector<Quantity> places, angles;
  for (const Quantity& quantity : quantities)
    (is_angle(quantity) ? angles : places).push_back(quantity);
  std::vector<std::vector<Quantity>> panels;
  if (!places.empty()) panels.push_back(places);
  if (!angles.empty()) panels.push_back(angles);
  return panels;
}

// Panels above each other, of distances and of angles.
Json panel_layout(const std::vector<std::vector<Quantity>>& panels, std::string_view what) {
  constexpr double lower_part = 0.44, upper_part = 0.54;
  Json layout = {
      {"xaxis",
       axis("Time since the start event (s)", {{"anchor", numbered("y", panels.size() - 1)}})}};
  for (std::size_t panel = 0; panel < panels.size(); ++panel) {
    Json domain = {0.0, 1.0};
    if (panels.size() == 2) domain = panel == 0 ? Json{upper_part, 1.0} : Json{0.0, lower_part};
    layout[numbered("yaxis", panel)] = axis(
        fmt::format("{} ({})", is_angle(panels[panel][0]) ? "Angle" : what, panels[panel][0].unit),
        {{"domain", domain}, {"rangemode", "tozero"}});
  }
  return layout;
}

// How far the simulated mean lies from the measured one, of every particle.
Figure error_figure(const std::map<int, ParticleCourses>& courses,
                    const std::vector<Quantity>& quantities) {
  const auto panels = panels_of(quantities);
  FigureChoice choice;
  for (std::size_t panel = 0; panel < panels.size(); ++panel) {
    MeanSquare error, half_width;
    bool is_first = true;
    const auto add = [&](Json trace, bool in_legend) {
      place(trace, "x", numbered("y", panel));
      trace["legendgroup"] = trace["name"];
      trace["showlegend"] = in_legend && panel == 0;
      choice.traces.push_back(std::move(trace));
    };
    for (const auto& [particle, of_particle] : courses) {
      const std::vector<double>& time = course_of(of_particle, panels[panel][0]).time;
      std::vector<double> apart(time.size());
      for (std::size_t i = 0; i < time.size(); ++i) {
        double square = 0.0, width = 0.0;
        for (const Quantity& quantity : panels[panel]) {
          const Course& course = course_of(of_particle, quantity);
          if (i >= course.time.size()) continue;
          square += std::pow(course.simulated[i] - course.measured[i], 2);
          width += std::pow(0.5 * (course.upper_student[i] - course.lower_student[i]), 2);
        }
        apart[i] = std::sqrt(square);
        error.add(time[i], square);
        half_width.add(time[i], width);
      }
      Json trace = line(time, apart, "one particle", "var(--faint)", 1.5);
      trace["hovertemplate"] = fmt::format("particle {}: %{{y:.2f}}<extra></extra>", particle);
      add(std::move(trace), std::exchange(is_first, false));
    }
    Json width = line(half_width.times(),
                      half_width.roots(),
                      "half-width of the replicates' interval",
                      "var(--measured-strong)",
                      2.0);
    width["line"]["dash"] = "4px,2px";
    add(std::move(width), true);
    add(line(error.times(), error.roots(), "all particles (RMS)", "var(--simulated)", 3.0), true);
  }
  return {.id = "tracks-error",
          .caption =
              "Distance of the simulated mean from the measured one, of all particles. Below "
              "the dashed line it is smaller than what the replicates tell.",
          .height = panels.size() == 2 ? 460 : 320,
          .layout = panel_layout(panels, "Distance"),
          .menu = "",
          .choices = {choice}};
}

// How far each replicate lies from the simulated mean.
Figure residual_figure(const datasets::Table& residuals, const std::vector<Quantity>& quantities) {
  const auto panels = panels_of(quantities);
  const auto times = column(residuals, "time_s"), particles = column(residuals, "particle"),
             values = column(residuals, "residual");
  const auto names = text_column(residuals, "quantity"),
             replicates = text_column(residuals, "replicate");
  std::vector<std::string> order;
  for (const std::string& replicate : replicates) add_once(order, replicate);
  FigureChoice choice;
  std::vector<double> whole(order.size(), std::nan(""));  // of the first panel
  for (std::size_t panel = 0; panel < panels.size(); ++panel) {
    // Squares of the quantities of a panel add up to one of a particle at a moment
    std::map<std::string, std::map<std::pair<double, double>, double>> squares;
    for (std::size_t row = 0; row < names.size(); ++row) {
      for (const Quantity& quantity : panels[panel]) {
        if (quantity.name != names[row]) continue;
        squares[replicates[row]][{times[row], particles[row]}] +=
            std::pow(quantity.factor * values[row], 2);
      }
    }
    for (std::size_t r = 0; r < order.size(); ++r) {
      MeanSquare sum;
      for (const auto& [key, square] : squares[order[r]]) sum.add(key.first, square);
      if (panel == 0) whole[r] = sum.root();
      Json trace =
          line(sum.times(), sum.roots(), order[r], fmt::format("var(--stage{})", (r + 1) % 6), 2.0);
      place(trace, "x", numbered("y", panel));
      trace["legendgroup"] = trace["name"];
      trace["showlegend"] = panel == 0;
      choice.traces.push_back(std::move(trace));
    }
  }
  std::string farthest;
  const auto most = std::max_element(whole.begin(), whole.end());
  if (order.size() > 2 && std::isfinite(*most)) {
    farthest = fmt::format(" {} lies farthest: {} {}, against a median of {} {}.",
                           order[static_cast<std::size_t>(most - whole.begin())],
                           significant(*most, 2),
                           panels[0][0].unit,
                           significant(median(whole), 2),
                           panels[0][0].unit);
  }
  return {.id = "tracks-residuals",
          .caption =
              "Distance of each replicate from the simulated mean (RMS over particles). A "
              "replicate far above the others may be of another experiment." +
              farthest,
          .height = panels.size() == 2 ? 460 : 320,
          .layout = panel_layout(panels, "Distance"),
          .menu = "",
          .choices = {choice}};
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
  for (const auto& [particle, of_particle] : courses) {
    const Course &x = course_of(of_particle, all_quantities[0]),
                 &z = course_of(of_particle, all_quantities[1]);
    if (x.time != z.time || x.time.empty()) continue;
    Json measured = line(x.measured, z.measured, "films: mean", "var(--measured-strong)");
    Json simulated = line(x.simulated, z.simulated, "simulations: mean", "var(--simulated)");
    simulated["line"]["dash"] = "4px,2px";
    for (Json* trace : {&measured, &simulated}) {
      (*trace)["legendgroup"] = (*trace)["name"];
      (*trace)["showlegend"] = first;
      (*trace)["hovertemplate"] =
          fmt::format("particle {}: %{{x:.0f}}, %{{y:.0f}} mm<extra></extra>", particle);
      choice.traces.push_back(*trace);
    }
    start_x.push_back(x.measured.front());
    start_z.push_back(z.measured.front());
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
          "Mean paths of all particles in the rig{}. Paths that part show where films and "
          "simulations move differently. The figure does not show when.",
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

bool has_tracks(const RunData& data) {
  if (data.is_under_way()) return false;
  return at(data.result, {"agreement"}).is_object() ||
         std::filesystem::exists(data.folder.table("bands"));
}

Section tracks_section(const RunData& data, Section section) {
  const auto bands = data.table("bands");
  if (!bands || !bands->has("particle")) {
    section.add_absence(
        "The tracks with their intervals (tables/bands.csv) are absent, so they are not drawn.");
    return section;
  }
  const std::map<int, ParticleCourses> courses = read_courses(*bands);
  const std::vector<Quantity> quantities = quantities_of(courses);
  if (!quantities.empty()) {
    section.add_figure(error_figure(courses, quantities));
    if (const auto residuals = data.table("residuals")) {
      section.add_figure(residual_figure(*residuals, quantities));
    } else {
      section.add_absence(
          "The distances of single replicates (tables/residuals.csv) are absent, so they are not "
          "drawn.");
    }
  }
  section.begin_fold("Particle by particle");
  section.add_paragraph(
      "Half-widths are those of the films' 95 % interval (Student), the median over the frames. A "
      "narrow interval is a hard test. A particle with a wide interval scores well, although the "
      "films tell little of it.");
  section.add_table(difference_table(courses, quantities));
  if (quantities.empty()) return section;
  for (const bool is_difference : {false, true})
    section.add_figure(stacked_figure(courses, quantities, is_difference));
  if (quantities[0].name == "x") section.add_figure(path_figure(data, courses));
  return section;
}

}  // namespace graintruth::reports
