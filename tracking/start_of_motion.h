// Time zero of a film of balls: when a face starts, or where there is none the first particle.
#pragma once

#include <string>
#include <vector>

#include "tracking/body_follower.h"
#include "tracking/event.h"

namespace graintruth::tracking {

// `tracks` hold one entry a frame. Sentences go to the summary where witnesses disagree, or where
// what the laboratory noted is off. Throws InputError where nothing tells.
Event find_start(const FilmView& view,
                 const std::vector<BodyTrack>& tracks,
                 const std::string& where,
                 TrackingSummary& summary);

}  // namespace graintruth::tracking
