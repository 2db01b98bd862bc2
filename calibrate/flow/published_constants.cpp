#include "calibrate/flow/published_constants.h"

#include <fmt/format.h>

#include <string_view>

namespace graintruth::calibrate {

namespace {

struct Published {
  std::string_view name;
  double from, to;                // that were measured
  double lowest, highest;         // that are not doubted
  std::string_view source, hint;  // hint: where a mistake is likely
};

constexpr Published published_C{"C",
                                0.55,
                                0.65,
                                0.3,
                                1.0,
                                "Nedderman 1992; Mankoc et al. 2007",
                                "look at the units of rate, density and width"};
constexpr Published published_k{"k",
                                1.0,
                                3.0,
                                0.6,
                                3.5,
                                "Beverloo et al. 1961; Nedderman 1992; Mankoc et al. 2007",
                                "look at the particles' diameter and at the widths"};
constexpr Published published_B{"B/d",
                                1.3,
                                3.5,
                                0.7,
                                6.0,
                                "Choi, Kudrolli and Bazant 2005",
                                "look at the particles' diameter, the places and the height"};

void doubt(const Published& published, double value, std::vector<std::string>& doubts) {
  if (value >= published.lowest && value <= published.highest) return;
  doubts.push_back(fmt::format("{} = {:.4g} is doubtful: from {} to {} was published ({}); {}.",
                               published.name,
                               value,
                               published.from,
                               published.to,
                               published.source,
                               published.hint));
}

}  // namespace

std::vector<std::string> doubts_about_beverloo(double C, double k) {
  std::vector<std::string> doubts;
  doubt(published_C, C, doubts);
  doubt(published_k, k, doubts);
  return doubts;
}

std::vector<std::string> doubts_about_kinematic(double B_over_d) {
  std::vector<std::string> doubts;
  doubt(published_B, B_over_d, doubts);
  return doubts;
}

}  // namespace graintruth::calibrate
