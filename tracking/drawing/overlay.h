// What was found, drawn on the film: outlines, numbers, axes, trails, fiducials and the clock.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "datasets/store/trajectories.h"
#include "tracking/particle_tracker.h"
#include "tracking/view/camera.h"

namespace graintruth::tracking {

struct Findings {
  const Camera* camera = nullptr;
  const datasets::Trajectories* trajectories = nullptr;
  const ParticleTracker* tracker = nullptr;  // draws the particles
  std::vector<FiducialSighting> fiducials;
};

struct OverlayFiles {
  std::filesystem::path film;  // mp4; empty: none
  // Still pictures of frames; a frame number below 0 or an empty name: none.
  struct Still {
    int frame = -1;
    std::filesystem::path file;
  };
  std::vector<Still> stills;
  double frame_rate = 25.0;  // Hz, of the film
};

// Reads `video` again and draws. Every file is written beside its place and then renamed. Throws
// InputError when a file cannot be written. `stop` is asked before every frame; when it says so
// nothing is left and false is returned.
bool draw_overlay(const std::filesystem::path& video,
                  const Findings& findings,
                  const OverlayFiles& files,
                  const std::function<bool()>& stop);

// Draws the findings of one frame on it.
void draw_findings(cv::Mat& picture, const Findings& findings, std::size_t frame);

}  // namespace graintruth::tracking
