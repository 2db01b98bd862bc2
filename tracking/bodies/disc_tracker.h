// Round things seen face-on, of any colour, on a ground that changes slowly: discs, tracers, drops.
#pragma once

#include <memory>

#include "tracking/particle_tracker.h"

namespace graintruth::tracking {

// Nothing where the body is no disc.
std::unique_ptr<ParticleTracker> make_disc_tracker(const datasets::TrackingSpec& spec,
                                                   const datasets::Film& film);

}  // namespace graintruth::tracking
