// The camera of a film, calibrated on its first frame, and what the summary says of it.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "datasets/experiment/tracking_spec.h"
#include "tracking/fiducials.h"
#include "tracking/steady_view.h"
#include "tracking/tracking_summary.h"

namespace graintruth::tracking {

struct FilmCamera {
  Calibration calibration;
  std::vector<FiducialSighting> sightings;
};

// Throws InputError where too few fiducials are given or found.
FilmCamera calibrate_on(const datasets::Camera& stated,
                        const cv::Mat& first_frame,
                        const datasets::Film& where);

// Figures of the calibration, and sentences where it is doubtful.
void describe_camera(const FilmCamera& film,
                     const datasets::Camera& stated,
                     TrackingSummary& summary);

// Sentences where the camera did not stand still, or nobody can tell.
void describe_steadiness(const SteadyView& steady, TrackingSummary& summary);

}  // namespace graintruth::tracking
