// Who is where in the first frame, and how large and how blurred balls look in this film.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tracking/view/film_view.h"

namespace graintruth::tracking {

// One fit a particle, by its number; none where it was not found. Single balls and pairs of equal
// balls get angles in [0, pi). From here on `view` knows the sizes and the limb. Sentences go to
// the summary where particles are missing, too many or far from their start places. Throws
// InputError where no particle is found; `where` names the film.
std::vector<std::optional<BodyFit>> find_first_bodies(FilmView& view,
                                                      const cv::Mat& frame,
                                                      const EdgeImage& image,
                                                      const std::string& where,
                                                      TrackingSummary& summary);

}  // namespace graintruth::tracking
