// A small bin whose discharge was weighed: two orifices, two curves each.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "tests/support/temporary_folder.h"

namespace graintruth::tests {

inline constexpr int weighed_particles = 30;
inline constexpr double weighed_particle_mass = 0.332e-3;  // kg
inline constexpr double weighed_share = 0.8;               // of the particles leave

// kg/s; replicates of one orifice differ by 4 %.
inline double weighed_rate(const std::string& name) {
  const double of_orifice = name.starts_with("narrow") ? 0.022 : 0.034;
  return of_orifice * (name.ends_with("1") ? 0.98 : 1.02);
}

inline std::string weighed_bin() {
  std::string text = fmt::format(R"(title = "A weighed bin"
[particle]
count = {}
mass_g = {}
plate = {{semi_major_mm = 6.9, semi_minor_mm = 5.3, thickness_mm = 2.3}}
[material]
elastic_modulus_mpa = 20
poisson_ratio = 0.3
friction_particle_particle = 0.4
friction_particle_wall = 0.4
restitution = 0.7
[rig]
kind = "flat_bin_orifice"
bin_width_mm = 150
bin_height_mm = 100
front_back_gap_mm = 2.6
[tune]
friction_particle_particle = {{lower = 0.0, upper = 0.7}}
)",
                                 weighed_particles,
                                 1e3 * weighed_particle_mass);
  for (const char* name : {"narrow1", "narrow2", "wide1", "wide2"})
    text += fmt::format(
        "[[replicate]]\ndischarge = \"{0}.csv\"\nname = \"{0}\"\norifice_width_mm = {1}\nevent_s = "
        "0.5\n",
        name,
        std::string(name).starts_with("narrow") ? 75 : 100);
  return text;
}

// As a load cell under the bin writes them: a tare, half a second of rest, 100 readings a second.
inline void write_curves(const TemporaryFolder& folder) {
  for (const char* name : {"narrow1", "narrow2", "wide1", "wide2"}) {
    const double all = weighed_share * weighed_particles * weighed_particle_mass;
    std::string text = "Time (s),Mass (g)\n";
    for (int reading = 0; reading <= 105; ++reading) {
      const double time = 0.01 * reading;
      const double left = std::clamp((time - 0.55) * weighed_rate(name), 0.0, all);
      text += fmt::format("{:.2f},{:.4f}\n", time, 12.5 + 1e3 * left);
    }
    folder.write(std::string(name) + ".csv", text);
  }
}

}  // namespace graintruth::tests
