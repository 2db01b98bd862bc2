#include "tracking/recording.h"

#include <opencv2/videoio.hpp>

#include "tracking/fields.h"

namespace graintruth::tracking {

datasets::Experiment as_recorded(const datasets::Experiment& experiment,
                                 const datasets::Replicate& replicate) {
  datasets::Experiment recorded = experiment;
  if (detect_scan(replicate.video) == Scan::progressive) return recorded;
  cv::VideoCapture capture(replicate.video.string(), cv::CAP_FFMPEG);
  const double declared = capture.get(cv::CAP_PROP_FPS);
  // A laboratory that states the field rate has said it already.
  constexpr double nearer_to_fields = 1.5;
  if (!(declared > 0.0) || experiment.camera.frame_rate < nearer_to_fields * declared)
    recorded.camera.frame_rate *= 2.0;
  return recorded;
}

}  // namespace graintruth::tracking
