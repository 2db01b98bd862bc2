#include "calibrate/observables/outline_results.h"

#include <cmath>
#include <limits>

#include "calibrate/observables/steady_surface.h"
#include "datasets/store/table.h"

namespace graintruth::calibrate {

namespace {

using datasets::number_text;

constexpr const char* table_name = "outlines";
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

void tell_outlines(const MeasuredExperiment& measured, Results& results) {
  if (results.tables.contains(table_name)) return;
  datasets::Table table({"replicate",
                         "setting",
                         "surface",
                         "angle_left_rad",
                         "angle_left_error_rad",
                         "angle_right_rad",
                         "angle_right_error_rad",
                         "roughness_m",
                         "height_m",
                         "foot_left_m",
                         "foot_right_m",
                         "slope_rad",
                         "slope_error_rad",
                         "slope_sd_rad"});
  for (std::size_t r = 0; r < measured.recordings.size(); ++r) {
    const datasets::Recording& recording = measured.recordings[r];
    const Situation& situation = measured.situations[r];
    for (const datasets::Outline& outline : recording.outlines) {
      if (outline.column.size() < 2) continue;
      std::vector<double> values(11, nan);
      if (situation.rig.seen_outline->drum) {
        if (const auto surface = steady_surface(outline, situation)) {
          values[8] = surface->slope;
          values[9] = surface->slope_error;
          values[10] = surface->slope_sd;
        }
      } else if (const auto profile = profile_at_rest(recording, situation, outline.surface);
                 profile && apex_of(*profile)) {
        double squares = 0.0;
        int flanks = 0;
        for (const Side side : {Side::left, Side::right}) {
          const bool runs_out = runs_out_below(situation, outline.surface);
          const auto flank =
              runs_out ? slope_of(*profile, side, situation) : flank_of(*profile, side, situation);
          const std::size_t at = side == Side::left ? 0 : 2;
          if (!runs_out) values[6 + at / 2] = foot_of(*profile, side, situation);
          if (!flank) continue;
          values[at] = flank->angle;
          values[at + 1] = flank->standard_error;
          squares += flank->roughness * flank->roughness;
          ++flanks;
        }
        if (flanks > 0) values[4] = std::sqrt(squares / flanks);
        values[5] = profile->z[*apex_of(*profile)] - profile->floor;
      }
      std::vector<std::string> row = {measured.experiment.replicates[r].name,
                                      datasets::words_on(situation.rig.settings),
                                      outline.surface};
      for (const double value : values) row.push_back(std::isnan(value) ? "" : number_text(value));
      table.add(std::move(row));
    }
  }
  if (table.rows() > 0) results.tables[table_name] = std::move(table);
}

}  // namespace graintruth::calibrate
