#include "reports/page/plot.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace graintruth::reports {

namespace {

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  for (auto place = text.find(from); place != std::string::npos;
       place = text.find(from, place + to.size()))
    text.replace(place, from.size(), to);
  return text;
}

}  // namespace

Json figure_view(const Figure& figure) {
  Json choices = Json::array();
  Json options = Json::array();
  for (std::size_t i = 0; i < figure.choices.size(); ++i) {
    choices.push_back(figure.choices[i].traces);
    options.push_back({{"index", std::to_string(i)}, {"label", figure.choices[i].label}});
  }
  const Json data = {{"layout", figure.layout}, {"choices", choices}};
  // Inside a script element only "<" could end the element or open a comment.
  const std::string script =
      replaced(data.dump(-1, ' ', false, Json::error_handler_t::replace), "<", "\\u003c");
  return {{"id", figure.id},
          {"caption", figure.caption},
          {"height", std::to_string(figure.height)},
          {"menu", figure.menu},
          {"has_menu", figure.choices.size() > 1},
          {"options", options},
          {"script", script}};
}

Json plot_numbers(const std::vector<double>& values) {
  Json array = Json::array();
  for (const double value : values) {
    if (!std::isfinite(value)) {
      array.push_back(nullptr);
      continue;
    }
    const std::string digits = fmt::format("{:.6g}", value);
    double rounded = 0.0;
    std::from_chars(digits.data(), digits.data() + digits.size(), rounded);
    array.push_back(rounded);
  }
  return array;
}

std::string plot_text(std::string_view text) {
  return replaced(replaced(std::string(text), "&", "&amp;"), "<", "&lt;");
}

Json axis(std::string_view title, Json more) {
  more["title"] = {{"text", title}};
  return more;
}

Json line(const std::vector<double>& x,
          const std::vector<double>& y,
          std::string_view name,
          std::string_view colour,
          double width) {
  return {{"type", "scatter"},
          {"mode", "lines"},
          {"x", plot_numbers(x)},
          {"y", plot_numbers(y)},
          {"name", plot_text(name)},
          {"line", {{"color", colour}, {"width", width}}}};
}

Json points(const std::vector<double>& x,
            const std::vector<double>& y,
            std::string_view name,
            std::string_view colour,
            std::string_view symbol,
            double size) {
  return {{"type", "scatter"},
          {"mode", "markers"},
          {"x", plot_numbers(x)},
          {"y", plot_numbers(y)},
          {"name", plot_text(name)},
          {"marker", {{"color", colour}, {"symbol", symbol}, {"size", size}}}};
}

Json band(const std::vector<double>& x,
          const std::vector<double>& lower,
          const std::vector<double>& upper,
          std::string_view name,
          std::string_view colour) {
  // Closed outlines, there and back, parted where an edge is not known: unlike fill "tonexty" they
  // do not depend on their neighbours.
  std::vector<double> around_x, around_y;
  const auto is_known = [&](std::size_t i) {
    return i < x.size() && std::isfinite(lower[i]) && std::isfinite(upper[i]);
  };
  for (std::size_t begin = 0; begin < x.size(); ++begin) {
    if (!is_known(begin)) continue;
    std::size_t end = begin;
    for (; is_known(end); ++end) {
      around_x.push_back(x[end]);
      around_y.push_back(upper[end]);
    }
    for (std::size_t i = end; i-- > begin;) {
      around_x.push_back(x[i]);
      around_y.push_back(lower[i]);
    }
    if (end < x.size()) {
      around_x.push_back(std::nan(""));
      around_y.push_back(std::nan(""));
    }
    begin = end;
  }
  Json trace = line(around_x, around_y, name, colour, 0.0);
  trace["fill"] = "toself";
  trace["fillcolor"] = colour;
  trace["hoverinfo"] = "skip";
  return trace;
}

void place(Json& trace, std::string_view x_axis, std::string_view y_axis) {
  trace["xaxis"] = x_axis;
  trace["yaxis"] = y_axis;
}

}  // namespace graintruth::reports
