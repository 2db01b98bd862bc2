// The pipeline: a film in; who was where when with calibrated uncertainty out, whatever the body.
#pragma once

#include <filesystem>
#include <functional>

#include "datasets/experiment/tracking_spec.h"
#include "datasets/store/trajectories.h"
#include "tracking/particle_tracker.h"

namespace graintruth::tracking {

struct TrackingOptions {
  std::filesystem::path overlay_file;  // mp4 with what was found drawn on it; empty: none
  std::filesystem::path
      annotated_first;  // JPEG of the first frame with the findings drawn in; empty: none
  std::filesystem::path annotated_middle;  // halfway between the event and the end
  std::filesystem::path annotated_last;
  std::function<void(int frame, int total)>
      progress;                // called after every frame; total 0 when unknown
  std::function<bool()> stop;  // true: give up; track_film then throws Stopped
};

// Thrown when TrackingOptions::stop said so. No file is left behind.
struct Stopped {};

struct TrackedFilm {
  datasets::Trajectories trajectories;
  TrackingSummary summary;
};

// Tracks one film with the tracker that was made for it; `spec` is that of the recording. Throws
// datasets::InputError for a film that cannot be tracked. Deterministic; safe to call from several
// threads at once. The drawing of overlays reads the film once more.
TrackedFilm track_film(ParticleTracker& tracker,
                       const datasets::TrackingSpec& spec,
                       const datasets::Film& film,
                       const TrackingOptions& options = {});

}  // namespace graintruth::tracking
