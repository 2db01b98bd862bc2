#include "datasets/experiment/camera.h"

#include <fmt/format.h>

#include "datasets/toml_section.h"

namespace graintruth::datasets {

Camera read_camera(TomlSection section, bool films) {
  Camera camera;
  camera.frame_rate = section.quantity("frame_rate", rate_units, positive);
  camera.pixel_aspect = section.optional_quantity("pixel_aspect", plain, positive).value_or(1.0);
  camera.noted_event_time = section.optional_quantity("noted_event", time_units, not_negative);
  const auto centres = section.rows("fiducials", 2, length_units);
  if (films || !centres.empty()) {
    const double diameter = section.quantity("fiducial_diameter", length_units, positive);
    for (const auto& centre : centres) camera.fiducials.push_back({centre[0], centre[1], diameter});
    if (camera.fiducials.size() < 4) {
      section.fail(
          section.has("fiducials_m") ? "fiducials_m" : "fiducials_mm",
          fmt::format("gives {} fiducials, but at least 4 are needed to find scale and tilt",
                      camera.fiducials.size()));
    }
  }
  section.finish();
  return camera;
}

}  // namespace graintruth::datasets
