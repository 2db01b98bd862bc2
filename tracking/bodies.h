// Ball candidates to bodies: single balls, or pairs at the rigid distance, each tried on the
// picture, and of these the set of N that do not overlap and are seen best.
#pragma once

#include <vector>

#include "tracking/locate.h"
#include "tracking/refine.h"

namespace graintruth::tracking {

// Every candidate of a single ball, or every pair of candidates whose distance is within
// `tolerance` (relative) of the separation, fitted; those that the picture does not support are
// gone.
std::vector<BodyFit> fit_bodies(const EdgeImage& image,
                                const Camera& camera,
                                const BodyShape& shape,
                                const std::vector<BallCandidate>& candidates,
                                const Surroundings& surroundings,
                                double noise,
                                double tolerance);

// How surely a fit is a body: grows with the outline that was seen and supported.
double evidence_of(const BodyFit& fit);

// At most `count` bodies without overlap with the greatest sum of evidence: greedy, then improved
// by exchanges until no exchange helps.
std::vector<BodyFit> choose_bodies(const std::vector<BodyFit>& fits,
                                   const BodyShape& shape,
                                   std::size_t count);

}  // namespace graintruth::tracking
