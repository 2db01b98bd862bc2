// Time zero of a film of balls: when a face starts, or where there is none the first particle.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tracking/balls/body_follower.h"
#include "tracking/event/event.h"

namespace graintruth::tracking {

// When the first particle leaves its place; nothing where all rest, or move from the first frame
// on.
std::optional<Event> find_first_motion(const datasets::Trajectories& tracks,
                                       const Camera& camera,
                                       double frame_rate,
                                       const std::vector<double>& moments);

// Time zero of a film that need not show a start: what was found, what the laboratory noted, or the
// first frame.
Event start_of_a_film(const std::optional<Event>& found,
                      const datasets::Camera& camera,
                      TrackingSummary& summary);

// `tracks` hold one entry a frame. Sentences go to the summary where witnesses disagree, or where
// what the laboratory noted is off. Throws InputError where nothing tells.
Event find_start(const FilmView& view,
                 const std::vector<BodyTrack>& tracks,
                 const std::string& where,
                 TrackingSummary& summary);

}  // namespace graintruth::tracking
