// The camera of a film, calibrated on its first frame, and what the summary says of it.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "datasets/experiment.h"
#include "tracking/fiducials.h"
#include "tracking/steady_view.h"
#include "tracking/track_video.h"

namespace graintruth::tracking {

struct FilmCamera {
  Calibration calibration;
  std::vector<FiducialSighting> sightings;
};

// Throws InputError where too few fiducials are given or found; `where` names the film.
FilmCamera calibrate_on(const datasets::Experiment& experiment,
                        const cv::Mat& first_frame,
                        const std::string& where);

// Figures of the calibration, and sentences where it is doubtful. `pixel` is the width of a pixel
// where the particles are, m.
void describe_camera(const FilmCamera& film,
                     const datasets::Experiment& experiment,
                     double pixel,
                     TrackingSummary& summary);

// Sentences where the camera did not stand still, or nobody can tell.
void describe_steadiness(const SteadyView& steady, TrackingSummary& summary);

}  // namespace graintruth::tracking
