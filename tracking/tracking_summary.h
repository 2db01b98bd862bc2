// How well a film was read: figures and sentences that every kind of body has.
#pragma once

#include <string>
#include <vector>

#include "tracking/film/clock.h"

namespace graintruth::tracking {

enum class Grade { ok, warn, fail };
std::string to_string(Grade grade);

struct TrackingSummary {
  Grade grade = Grade::ok;
  std::vector<std::string> warnings;  // sentences, with frame numbers
  std::vector<std::string> failures;  // those of the warnings that make the grade "fail"
  std::vector<std::string> findings;  // what the film shows, as a phrase to print

  // Adds a sentence; the grade sinks to match.
  void warn(std::string sentence);
  void fail(std::string sentence);

  // Camera
  double scale_px_per_mm = 0.0;  // at the middle of the particles
  double distortion_k1 = 0.0, distortion_k2 = 0.0;
  double pixel_aspect = 1.0;
  std::string references;  // what gave scale: "fiducials", "points", "corners" or "stick"
  int references_given = 0, references_found = 0, references_used = 0;
  double calibration_rms_mm = 0.0, calibration_max_mm = 0.0;
  double calibration_leave_one_out_rms_mm = 0.0, calibration_leave_one_out_max_mm = 0.0;
  double camera_shift_px =
      0.0;  // largest move of a fiducial during the film, after the first frame

  // Film
  int width = 0, height = 0;
  int frames_declared = 0, frames_read = 0;
  double frame_rate_hz = 0.0, frame_rate_declared_hz = 0.0;
  std::vector<int> repeated_frames;
  PictureClock clock;

  // Particles
  int particles = 0;
  int detections = 0;
  double completeness = 0.0;             // detections / (frames * particles)
  double least_complete_particle = 0.0;  // the same for the worst particle
  int gaps = 0;                          // runs of frames in which a particle was not seen
  int suspected_swaps = 0;      // steps that two bodies would explain about as well if exchanged
  double pixel_error_px = 0.0;  // median standard uncertainty of a position, per axis
  double position_sigma_mm = 0.0;
  bool shows_angle = true;  // whether the body shows how it lies; else the next two say nothing
  double angle_sigma_deg = 0.0;  // median standard uncertainty
  int angle_jumps = 0;           // steps of more than 60 degrees between neighbouring frames
  double mean_score = 0.0;

  // Time zero
  double event_time_s = 0.0;  // s of film
  double event_uncertainty_s = 0.0;
  std::string event_source;         // "piston face", "first motion", "noted by the laboratory", ...
  double noted_event_time_s = 0.0;  // NaN where none was noted

  // Speed; without drawing the overlay
  double seconds = 0.0;
  double frames_per_second = 0.0;
};

}  // namespace graintruth::tracking
