// What is known of a filmed bin before any plate is found: the camera, where plates can be seen,
// and how they differ from the ground.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "tracking/plates/bed_fit.h"
#include "tracking/view/contrast.h"
#include "tracking/view/film_camera.h"

namespace graintruth::tracking {

struct BedScene {
  datasets::TrackingSpec spec;
  FilmCamera film;
  PlateShape shape;
  double plate_height = 0.0;  // m, of what is seen of a plate above the plane of the centres
  cv::Rect region;            // of the frame: the bin and what lies below its orifice
  cv::Mat1b in_bin;           // of the region: clear of walls, above the floor
  cv::Mat1b in_bin_or_below;  // and below the orifice, too
  Contrast contrast;
  double changed = 0.0;  // share of the bin that looks different at the end of the film

  const datasets::OpenBox& box() const { return *spec.rig.box; }
  BedView view(bool is_open) const;
  double pixel() const;  // m, at the middle of the bin
};

// Throws InputError where the bin lies outside the picture, or is too small in it. `first` and
// `last` are pictures of the film that `camera` took; `where` names it in sentences.
BedScene prepare_bed(const datasets::TrackingSpec& spec,
                     FilmCamera camera,
                     const cv::Mat& first,
                     const cv::Mat& last,
                     const std::string& where);

// Says when the orifice opens: whatever closes it is seen in the strip just below the floor.
class OrificeWatcher {
 public:
  OrificeWatcher(const BedScene& scene, const cv::Mat& first);
  // True from the first picture on in which the strip looks different.
  bool is_open(const cv::Mat& frame);

 private:
  std::vector<cv::Point> strip_;
  std::vector<cv::Vec3b> closed_;
  bool open_ = false;
};

}  // namespace graintruth::tracking
