// The pipeline: a film of balls, single or glued in pairs, in; who was where when with calibrated
// uncertainty out. A single ball shows where it is but not how it turns: its angles are NaN.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "datasets/experiment.h"
#include "datasets/trajectories.h"

namespace graintruth::tracking {

struct TrackingOptions {
  std::filesystem::path overlay_file;  // mp4 with what was found drawn on it; empty: none
  std::filesystem::path
      annotated_first;  // JPEG of the first frame with the findings drawn in; empty: none
  std::filesystem::path annotated_middle;  // halfway between the event and the end
  std::filesystem::path annotated_last;
  std::function<void(int frame, int total)>
      progress;                // called after every frame; total 0 when unknown
  std::function<bool()> stop;  // true: give up; track_video then throws Stopped
};

// Thrown when TrackingOptions::stop said so. No file is left behind.
struct Stopped {};

enum class Grade { ok, warn, fail };
std::string to_string(Grade grade);

struct TrackingSummary {
  std::string replicate;
  Grade grade = Grade::ok;
  std::vector<std::string> warnings;  // sentences, with frame numbers

  // Adds a sentence; the grade sinks to match.
  void warn(std::string sentence);
  void fail(std::string sentence);

  // Camera
  double scale_px_per_mm = 0.0;  // at the middle of the particles
  double distortion_k1 = 0.0, distortion_k2 = 0.0;
  double pixel_aspect = 1.0;
  int fiducials_given = 0, fiducials_found = 0, fiducials_used = 0;
  double calibration_rms_mm = 0.0, calibration_max_mm = 0.0;
  double calibration_leave_one_out_rms_mm = 0.0, calibration_leave_one_out_max_mm = 0.0;
  double camera_shift_px =
      0.0;  // largest move of a fiducial during the film, after the first frame

  // Film
  int width = 0, height = 0;
  int frames_declared = 0, frames_read = 0, frames_used = 0;
  double frame_rate_hz = 0.0, frame_rate_declared_hz = 0.0;
  std::vector<int> repeated_frames;

  // Particles
  int particles = 0;
  int detections = 0;
  double completeness = 0.0;             // detections / (frames * particles)
  double least_complete_particle = 0.0;  // the same for the worst particle
  int gaps = 0;                          // runs of frames in which a particle was not seen
  int suspected_swaps = 0;      // steps that two bodies would explain about as well if exchanged
  int angle_jumps = 0;          // steps of more than 60 degrees between neighbouring frames
  double pixel_error_px = 0.0;  // median standard uncertainty of a position, per axis
  double position_sigma_mm = 0.0;
  double angle_sigma_deg = 0.0;  // NaN of single balls
  double ray_scatter_px = 0.0;   // robust scatter of one edge about the outlines
  double mean_score = 0.0;
  double radius_learned_mm = 0.0, radius_nominal_mm = 0.0, radius_spread_mm = 0.0;
  double separation_learned_mm = 0.0, separation_nominal_mm = 0.0,
         separation_spread_mm = 0.0;  // 0 of single balls

  // Time zero
  double event_time_s = 0.0;  // s of film
  double event_uncertainty_s = 0.0;
  std::string event_source;  // "piston face", "particles on the piston", "first motion", "noted by
                             // the laboratory"
  double event_speed_m_per_s = 0.0;  // of what was followed; 0 where no speed was fitted
  double noted_event_time_s = 0.0;   // NaN where none was noted

  // Speed; without drawing the overlay
  double seconds = 0.0;
  double frames_per_second = 0.0;
};

struct TrackedFilm {
  datasets::Trajectories trajectories;
  TrackingSummary summary;
};

// Tracks one film. Throws datasets::InputError for a film or an experiment that cannot be tracked.
// Deterministic; safe to call from several threads at once. The drawing of overlays reads the film
// a second time.
TrackedFilm track_video(const datasets::Experiment& experiment,
                        const datasets::Replicate& replicate,
                        const TrackingOptions& options = {});

}  // namespace graintruth::tracking
