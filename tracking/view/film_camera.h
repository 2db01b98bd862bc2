// The camera of a film, calibrated on its first frame, and what the summary says of it.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "tracking/tracking_summary.h"
#include "tracking/view/scale.h"
#include "tracking/view/steady_view.h"

namespace graintruth::tracking {

struct FilmCamera {
  Calibration calibration;
  SeenScale scale;
  cv::Rect region;  // px, the part of the picture that is looked at
};

// Throws InputError where too little of a scale is given or found.
FilmCamera calibrate_on(const datasets::Camera& stated,
                        const cv::Mat& first_frame,
                        const datasets::Film& film);

// Figures of the calibration, and sentences where it is doubtful or rests on assumptions.
void describe_camera(const FilmCamera& film,
                     const datasets::Camera& stated,
                     TrackingSummary& summary);

// Sentences where the camera did not stand still, or nobody can tell.
void describe_steadiness(const SteadyView& steady, TrackingSummary& summary);

}  // namespace graintruth::tracking
