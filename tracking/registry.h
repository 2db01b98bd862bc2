// The kinds of bodies that can be followed.
#pragma once

#include <memory>

#include "datasets/experiment/tracking_spec.h"
#include "tracking/particle_tracker.h"

namespace graintruth::tracking {

// The tracker that follows this body in this view. `spec` is that of the recording, see
// recording.h. Throws InputError where none does; then the sentence says what is missing.
std::unique_ptr<ParticleTracker> make_tracker(const datasets::TrackingSpec& spec,
                                              const datasets::Film& film);

}  // namespace graintruth::tracking
