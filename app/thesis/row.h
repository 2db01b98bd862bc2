// What reproduce finds out: rows of printed beside recomputed beside simulated, each with one of
// seven words for it.
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace graintruth::app {

enum class Verdict {
  reproduced,     // the printed digits follow from the printed data
  misprint,       // they do not; the errata list them and say what is right
  input,          // a measured value that is taken as it is
  confirmed,      // our simulation finds what the thesis claims
  not_confirmed,  // it does not, or was not run; no more is known
  contradicted,   // it does not with five seeds or more, and a thesis-compatible run shows why
  fail            // a discrepancy that nobody has explained
};
std::string_view word_of(Verdict verdict);

inline constexpr double no_number = std::numeric_limits<double>::quiet_NaN();

struct Row {
  std::string where;    // unique in its target
  std::string printed;  // the thesis's own digits; empty where it prints none
  std::string unit;
  double recomputed = no_number;  // from printed data
  double simulated = no_number;   // by us: mean over the seeds
  double spread = no_number;      // standard deviation over the seeds
  int seeds = 0;
  double tolerance = no_number;  // largest difference from what is printed, in the same unit
  Verdict verdict = Verdict::fail;
  bool was_not_run = false;  // no run of ours has looked at it
  int errata = 0;            // number of the erratum; 0: none
  std::string note;
  std::string source;  // in the thesis
};

// A line, points or squares of a figure.
struct Series {
  std::string name;
  std::vector<double> x, y;
  std::vector<double> spread = {};  // standard deviation of y; empty where there is none
  bool is_ours = false;             // simulated or recomputed by us
  bool is_line = false;
  bool belongs_to_last = false;     // a line through the points of the series before: its colour
  std::vector<double> colour = {};  // of squares: what the colour at (x, y) shows; else empty
  std::string choice = {};          // the entry of the figure's menu that shows it; empty: all
};

struct Curve {
  std::string id;  // unique on the page
  std::string caption, x_title, y_title;
  bool log_x = false, log_y = false;
  std::vector<Series> series;
  std::string menu = {};    // what its choices are: "Aspect ratio"
  bool is_picture = false;  // both axes in the same scale
};

struct TargetResult {
  std::string name, what;
  std::vector<Row> rows;
  std::vector<Curve> curves;
  std::vector<std::string> notes;  // sentences above the table
};

}  // namespace graintruth::app
