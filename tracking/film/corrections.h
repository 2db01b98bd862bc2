// Corrections made by hand after looking at the overlay, kept in a file and replayed on every run,
// so that hand repair can be reproduced.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/store/trajectories.h"

namespace graintruth::tracking {

// Applies a CSV with the columns frame, action, particle and, as the action needs them, other, x_m,
// z_m, angle_rad, in the order of its rows, to tracks of any kind of body:
//   move    sets the particle's pose in that frame; one pixel of uncertainty. A body that shows how
//           it lies needs an angle, any other has none
//   delete  takes the particle out from that frame on
//   swap    exchanges the particle with `other` from that frame on
// Angles are continuous along each track afterwards. Returns one sentence a row. Throws InputError
// naming the row that cannot be applied.
std::vector<std::string> apply_corrections(const std::filesystem::path& file,
                                           double pixel,
                                           bool shows_angle,
                                           datasets::Trajectories& tracks);

}  // namespace graintruth::tracking
