// Straight rods of one thickness that may cross each other: locate_rods in every picture.
#pragma once

#include <memory>

#include "tracking/particle_tracker.h"

namespace graintruth::tracking {

// Nothing where the body is no rod.
std::unique_ptr<ParticleTracker> make_rod_tracker(const datasets::TrackingSpec& spec,
                                                  const datasets::Film& film);

}  // namespace graintruth::tracking
