// The free surface of every replicate: the angle of both flanks with their standard errors, how
// high the bed is and how far it reaches; of a drum the slope of its mean surface.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "reports/page/words.h"
#include "reports/sections/sections.h"

namespace graintruth::reports {

namespace {

constexpr double degrees = 180.0 / std::numbers::pi;
constexpr double millimetres = 1e3;

std::string value_cell(double value, double factor, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", factor * value, decimals) : "";
}

// "23.1 +- 0.9"
std::string angle_cell(double angle, double error) {
  if (!std::isfinite(angle)) return "";
  return fmt::format("{:.1f} \u00b1 {:.1f}", degrees * angle, degrees * error);
}

}  // namespace

bool has_outlines(const RunData& data) { return data.table("outlines").has_value(); }

Section surface_section(const RunData& data, Section section) {
  const datasets::Table outlines = *data.table("outlines");
  TableView table("The outline of every replicate",
                  {{"Replicate", Align::left},
                   {"Setting", Align::left},
                   {"Surface", Align::left},
                   {"Left flank (\u00b0)"},
                   {"Right flank (\u00b0)"},
                   {"Mean (\u00b0)"},
                   {"Roughness (mm)"},
                   {"Height (mm)"},
                   {"From (mm)"},
                   {"To (mm)"},
                   {"Slope (\u00b0)"},
                   {"Its spread in time (\u00b0)"}});
  const auto replicate = text_column(outlines, "replicate");
  const auto setting = text_column(outlines, "setting");
  // Runs from before rigs had several surfaces do not name any
  const auto surface = outlines.has("surface") ? text_column(outlines, "surface")
                                               : std::vector<std::string>(outlines.rows());
  const auto left = column(outlines, "angle_left_rad");
  const auto left_error = column(outlines, "angle_left_error_rad");
  const auto right = column(outlines, "angle_right_rad");
  const auto right_error = column(outlines, "angle_right_error_rad");
  const auto roughness = column(outlines, "roughness_m");
  const auto height = column(outlines, "height_m");
  const auto from = column(outlines, "foot_left_m");
  const auto to = column(outlines, "foot_right_m");
  const auto slope = column(outlines, "slope_rad");
  const auto slope_error = column(outlines, "slope_error_rad");
  const auto slope_sd = column(outlines, "slope_sd_rad");
  for (std::size_t i = 0; i < outlines.rows(); ++i) {
    table.add_row(
        {replicate[i],
         setting[i],
         surface[i],
         angle_cell(left[i], left_error[i]),
         angle_cell(right[i], right_error[i]),
         angle_cell(0.5 * (left[i] + right[i]), 0.5 * std::hypot(left_error[i], right_error[i])),
         value_cell(roughness[i], millimetres, 2),
         value_cell(height[i], millimetres, 1),
         value_cell(from[i], millimetres, 1),
         value_cell(to[i], millimetres, 1),
         angle_cell(slope[i], slope_error[i]),
         value_cell(slope_sd[i], degrees, 1)});
  }
  table.drop_empty_columns();
  section.add_table(table);
  section.add_paragraph(
      "Angles are those of straight lines by least squares with their standard errors: through "
      "each "
      "flank of a bed at rest where it is 20 to 80 % as high as its top, or through the middle "
      "half "
      "of the mean surface in a drum. Roughness is how far columns lie off these lines (root mean "
      "square). A bed reaches as far as it is higher than one grain. The section \u201cWhat was "
      "compared\u201d shows the surfaces themselves.");
  return section;
}

}  // namespace graintruth::reports
