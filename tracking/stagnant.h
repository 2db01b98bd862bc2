// Where a bed stands still while the rest flows, from a film whose moving plates are smeared: the
// map of what changes from frame to frame. No plate is detected in it.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "tracking/bed_scene.h"
#include "tracking/track_bed.h"

namespace graintruth::tracking {

// How much sharper or duller moving places are than the bed at rest: 1 as sharp, towards 0 smeared.
class SharpnessWatcher {
 public:
  void add(const cv::Mat& frame);
  double sharpness() const;  // 1 where too little moved to tell

 private:
  cv::Mat first_, previous_;  // brightness
  double moving_ = 0.0, resting_ = 0.0;
  long moved_ = 0;
};

// Below this, plates in motion cannot be detected.
inline constexpr double least_sharpness = 0.75;

class StagnantWatcher {
 public:
  explicit StagnantWatcher(const BedScene& scene);
  void add(const cv::Mat& frame);
  // The height, seen from the floor, up to which the bed is covered and moves less than a pixel a
  // frame; columns are as wide as a plate. `opened_at`: the first frame that is not at rest; what
  // changes before it is noise.
  StagnantBed profile(int opened_at) const;
  // Whether the bed is still at a place in a frame.
  bool is_still(const StagnantBed& profile, std::size_t frame, double x, double z) const;

 private:
  struct Cells {
    std::vector<float> change, cover;  // grey levels; of each column, from the floor up. Of the
                                       // first frame: what a shift by a pixel would change
  };
  const BedScene& scene_;
  double step_;  // m, of cells
  std::vector<double> x_;
  int rows_ = 0;
  cv::Mat1f previous_;
  std::vector<Cells> frames_;
};

}  // namespace graintruth::tracking
