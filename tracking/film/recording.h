// At what rate a film holds pictures, which is not always what a laboratory calls its frame rate.
#pragma once

#include "datasets/experiment/tracking_spec.h"

namespace graintruth::tracking {

// The spec with the rate at which pictures can be had from this film: twice the frame rate where
// frames are woven of two fields and the stated rate is that of the frames.
datasets::TrackingSpec as_recorded(datasets::TrackingSpec spec, const std::filesystem::path& video);

// Throws InputError where a film of so many pictures cannot show the motion that the rig makes.
void require_motion(const datasets::TrackingSpec& spec, const datasets::Film& film, int pictures);

}  // namespace graintruth::tracking
