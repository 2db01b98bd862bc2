// Ball candidates to bodies: single balls, or pairs at the rigid distance, each tried on the
// picture, and of these the set of N that do not overlap and are seen best.
#pragma once

#include <vector>

#include "tracking/balls/locate.h"
#include "tracking/balls/refine.h"

namespace graintruth::tracking {

// Where a body of this shape may lie, as far as the candidates tell: every candidate of a single
// ball, or every pair of them whose distance is within `tolerance` (relative) of the separation.
std::vector<BodyPose> possible_poses(const BodyShape& shape,
                                     const std::vector<BallCandidate>& candidates,
                                     double tolerance);

// Below this support is what clutter reaches: rays meet some edge by chance.
constexpr double clutter_support = 0.55;

// Where a body is expected, this much of an outline will do; less never does.
constexpr double hidden_support = 0.4;

// Bodies fitted from these poses; those that the picture supports less than `least_support` are
// gone.
std::vector<BodyFit> fit_bodies(const EdgeImage& image,
                                const Camera& camera,
                                const BodyShape& shape,
                                const std::vector<BodyPose>& poses,
                                const Surroundings& surroundings,
                                double noise,
                                double least_support = clutter_support);

// How surely a fit is a body: grows with the outline that was seen and supported.
double evidence_of(const BodyFit& fit);

// At most `count` bodies without overlap with the greatest sum of evidence: greedy, then improved
// by exchanges until no exchange helps.
std::vector<BodyFit> choose_bodies(const std::vector<BodyFit>& fits,
                                   const BodyShape& shape,
                                   std::size_t count);

}  // namespace graintruth::tracking
