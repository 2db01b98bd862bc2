// Figures for plotly (https://plotly.com/javascript/reference): traces and axes as JSON. Colours
// are written as var(--name) and looked up by figures.js in the page's style sheet, so that they
// follow light and dark.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "reports/page/run_data.h"

namespace graintruth::reports {

// One thing that a figure can show; a figure with several gets a menu.
struct FigureChoice {
  std::string label;
  Json traces = Json::array();
};

struct Figure {
  std::string id;       // unique on the page
  std::string caption;  // one sentence that says what to see
  int height = 380;     // px
  Json layout = Json::object();
  std::string menu;  // what the choices are: "Particle"
  std::vector<FigureChoice> choices;
};

// What figure.mustache draws.
Json figure_view(const Figure& figure);

// Six significant digits, null for NaN.
Json plot_numbers(const std::vector<double>& values);
// Text for labels: plotly reads markup in them, so & and < are escaped.
std::string plot_text(std::string_view text);

Json axis(std::string_view title, Json more = Json::object());
Json line(const std::vector<double>& x,
          const std::vector<double>& y,
          std::string_view name,
          std::string_view colour,
          double width = 2.0);
Json points(const std::vector<double>& x,
            const std::vector<double>& y,
            std::string_view name,
            std::string_view colour,
            std::string_view symbol = "circle",
            double size = 7.0);
// The area between two curves.
Json band(const std::vector<double>& x,
          const std::vector<double>& lower,
          const std::vector<double>& upper,
          std::string_view name,
          std::string_view colour);

// Puts a trace into the subplot with axes x<suffix>, y<suffix>, e.g. "2".
void place(Json& trace, std::string_view x_axis, std::string_view y_axis);

}  // namespace graintruth::reports
