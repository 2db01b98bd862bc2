// The pipeline for a bin of plates: a film of a bed that runs out through an orifice in, who was
// where when with calibrated uncertainty out, and how many had left.
#pragma once

#include "datasets/stagnant.h"
#include "tracking/track_video.h"

namespace graintruth::tracking {

struct BedSummary {
  int stated = 0;           // plates, by the experiment file
  int found_first = 0;      // in the first frame
  int discharged = 0;       // crossed the level of the floor by the end of the film
  int remaining = 0;        // seen above it at the end
  int unaccounted = 0;      // neither: lost inside the bin
  int filled = 0;           // sightings found afterwards between frames in which a plate was seen
  int losses = 0;           // times that a plate was not where it was predicted
  double size_ratio = 1.0;  // true size over the stated one, as contacts and outlines tell
  double semi_major_learned_mm = 0.0, semi_minor_learned_mm = 0.0;
  double gravity_measured = 0.0;     // m/s2, of plates below the orifice; NaN where too few fell
  std::string scan;                  // "progressive", "even rows first", "odd rows first"
  double sharpness = 1.0;            // of moving places over the bed at rest, see stagnant.h
  std::vector<int> doubtful_frames;  // with plates that were not found
};

// Of a film whose moving plates are smeared, what stands still (datasets/stagnant.h) from each
// frame to the one that is `frames_apart` later, and up to which height.
struct StagnantBed {
  int frames_apart = 0;
  std::vector<datasets::StagnantMap> maps;  // one a frame
  std::vector<double> x;                    // m
  std::vector<std::vector<double>> height;  // m, of each frame and x; NaN over the orifice
};

struct TrackedBed {
  // Of a smeared film: the plates of the first frame, each as long as its place stands still.
  datasets::Trajectories trajectories;
  StagnantBed stagnant;  // empty where plates were tracked
  TrackingSummary summary;
  BedSummary bed;
};

// Tracks one film of experiment.rig.bin with plates. Throws datasets::InputError for a film or an
// experiment that cannot be tracked. Deterministic; safe to call from several threads at once.
TrackedBed track_bed(const datasets::Experiment& experiment,
                     const datasets::Replicate& replicate,
                     const TrackingOptions& options = {});

}  // namespace graintruth::tracking
