// A scene of a few balls in a box, as the text of a scene file that tests change.
#pragma once

#include <string>

namespace graintruth::tests {

inline std::string small_scene() {
  return R"(title = "Balls in a box"
dimensions = 3

[[material]]
name = "ball"
elastic_modulus_mpa = 20
poisson_ratio = 0.3

[[material]]
name = "wall"
rigid = true

[[surfaces]]
first = "ball"
second = "ball"
friction = 0.3
restitution = 0.5

[[surfaces]]
first = "ball"
second = "wall"
friction = 0.3
restitution = 0.5

[[particle]]
name = "ball"
material = "ball"
count = 27
radius_mm = 10
density_g_per_cm3 = 1.0

[[wall]]
name = "box"
material = "wall"
shape = "box"
low_mm = [-35, -35, 0]
high_mm = [35, 35, 200]
open = "top"

[fill]
method = "lattice"
low_mm = [-35, -35, 0]
high_mm = [35, 35, 200]
clearance_mm = 1

[settle]
longest_s = 2.0
restitution = 0.2

[run]
duration_s = 0.02
output_interval_s = 0.01
)";
}

}  // namespace graintruth::tests
