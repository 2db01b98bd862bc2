#include "tracking/film/recording.h"

#include <opencv2/videoio.hpp>

#include "tracking/film/fields.h"

namespace graintruth::tracking {

datasets::TrackingSpec as_recorded(datasets::TrackingSpec spec,
                                   const std::filesystem::path& video) {
  if (detect_scan(video) == Scan::progressive) return spec;
  cv::VideoCapture capture(video.string(), cv::CAP_FFMPEG);
  const double declared = capture.get(cv::CAP_PROP_FPS);
  // A laboratory that states the field rate has said it already.
  constexpr double nearer_to_fields = 1.5;
  if (!(declared > 0.0) || spec.camera.frame_rate < nearer_to_fields * declared)
    spec.camera.frame_rate *= 2.0;
  return spec;
}

}  // namespace graintruth::tracking
