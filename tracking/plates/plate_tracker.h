// Plates that lie or move anywhere in the picture, on an even ground that is lighter than all of
// them or darker. Those in a box that runs out are followed by bed_tracker.h, which counts them.
#pragma once

#include <memory>

#include "tracking/particle_tracker.h"

namespace graintruth::tracking {

// Nothing where the body is no plate, or lies in a box.
std::unique_ptr<ParticleTracker> make_plate_tracker(const datasets::TrackingSpec& spec,
                                                    const datasets::Film& film);

}  // namespace graintruth::tracking
