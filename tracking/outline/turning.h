// How fast a drum turns, read from whatever is seen to go round outside its grains: a painted line,
// dirt, screws.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "datasets/rigs/rig.h"
#include "tracking/view/camera.h"

namespace graintruth::tracking {

struct Turning {
  double rate = 0.0, sigma = 0.0;  // rad/s, counter-clockwise as seen
};

class TurningWatcher {
 public:
  TurningWatcher() = default;
  TurningWatcher(const datasets::SeenOutline::Drum& drum,
                 const Camera& camera,
                 const cv::Rect& region);

  void look(const cv::Mat& grey, double time);

  // Nothing where nothing is seen to go round.
  std::optional<Turning> turning() const;

 private:
  cv::Mat map_x_, map_y_;  // rings x angles
  std::vector<cv::Mat1b> pictures_;
  std::vector<double> times_;
};

}  // namespace graintruth::tracking
