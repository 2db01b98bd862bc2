// Where a bed stands still while the rest flows, from a film whose moving plates are smeared:
// places at which edges in every direction persist from frame to frame. No plate is detected in it.
#pragma once

#include <deque>
#include <opencv2/core.hpp>
#include <vector>

#include "datasets/imports/stagnant.h"
#include "tracking/plates/bed_scene.h"

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

// Two pictures show the same place still when the products of their slopes, summed over a window of
// most of a plate, are as large as those of each picture with itself, in the direction in which
// they are smallest:
//   r = lambda_min(sum sym(a b^T)) / sqrt(lambda_min(sum a a^T) lambda_min(sum b b^T)),
// a and b the slopes of both pictures. Smear wipes out edges across its direction, so that plates
// that follow one another along a streak are not taken for one that stays. The limit of r is what
// the first picture gives against itself, shifted by as far as a place may move between the two,
// times what pictures at rest give.
class StagnantWatcher {
 public:
  explicit StagnantWatcher(const BedScene& scene);
  // `parity` as in VideoReader.
  void add(const cv::Mat& frame, int parity);

  // Pictures that are compared lie this many apart: in that time whatever is at the limit of
  // datasets::stagnant_speed moves a pixel at least, and fields are compared with their like.
  int pictures_apart() const { return apart_; }
  // What stands still from each picture to the one that many later, and from the last that has such
  // a one on for the rest.
  std::vector<datasets::StagnantMap> maps() const;
  // For how many pictures the plates of the first one, given by their centres (x, z) in m, stay
  // where they are.
  std::vector<std::size_t> stay_until(const std::vector<Eigen::Vector2d>& centres) const;

 private:
  // Of a picture of the bin seen straight on, with square pixels.
  struct Slopes {
    cv::Mat1f along_x, along_z;  // grey levels a pixel
    cv::Mat1f own;               // lambda_min of the window's sums of a a^T
  };
  // Values at the places, in the order of the map.
  struct Places {
    std::vector<float> to_first, to_earlier;  // r; the latter empty in the first pictures
    std::vector<float> cover;                 // grey levels of contrast
  };
  Slopes slopes_of(const cv::Mat1f& picture) const;
  cv::Mat1f smaller_eigenvalues(const Slopes& a, const Slopes& b) const;
  cv::Mat1f likeness(const Slopes& a, const Slopes& b) const;
  std::vector<float> at_places(const cv::Mat1f& picture) const;
  bool is_covered(const Places& places, std::size_t place) const;
  float typical(const std::vector<float>& likeness, const Places& places) const;
  double shifted_likeness() const;
  float limit() const;

  const BedScene& scene_;
  datasets::StagnantMap places_;
  double pixel_;                  // m
  double step_ = 0.0;             // m, that a place may move from picture to picture
  int window_ = 0;                // px
  int apart_ = 0;                 // pictures
  cv::Mat1f column_of_, row_of_;  // of straight pixels, in the region
  cv::Mat1f first_picture_;
  Slopes first_;
  std::deque<Slopes> recent_;
  std::vector<Places> frames_;
};

}  // namespace graintruth::tracking
