// Bodies from frame to frame: predicted, fitted where the prediction says, looked for where that
// fails.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "tracking/balls/paint.h"
#include "tracking/view/film_view.h"
#include "tracking/view/texture.h"

namespace graintruth::tracking {

// One particle's history.
struct BodyTrack {
  std::vector<std::optional<BodyFit>> fits;  // one a frame
  // Of each ball, one a frame; empty where unseen, and of single balls.
  std::array<std::vector<TexturePatch>, 2> textures;
  BodyPose last;                                              // last seen, or predicted since
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();         // a frame: x, z, angle
  int unseen = 0;                                             // frames since it was seen
  bool known = false;                                         // was ever seen
  double support = 1.0;                                       // of late
  double likeness = 1.0;                                      // of its paint, of late
  Paint paint;                                                // of pairs
  std::array<double, 4> ray_covariance = {}, ray_pairs = {};  // sums over fits, fading
  Eigen::Vector3f colour = Eigen::Vector3f::Zero();

  // Below this support it is not where it was thought to be.
  double lost_support() const;
  // Below this likeness it is not what it was.
  double lost_likeness() const;
};

// A picture of the clip, or what of it shows bodies, to look at again.
struct KeptPicture {
  int number = 0;
  cv::Mat part;                       // 8-bit BGR
  cv::Point corner;                   // of the part in the frame
  std::vector<datasets::Wall> walls;  // as seen then, and the moving face
};

class BodyFollower {
 public:
  // `first` are the bodies of `frame`, the first one, whose edges `image` has; `view` outlives the
  // follower and knows sizes and limb by now.
  BodyFollower(const FilmView& view,
               const std::vector<std::optional<BodyFit>>& first,
               const cv::Mat& frame,
               const EdgeImage& image);

  // The next frame; `number` counts from 0. The view's moving face was followed there already.
  void follow(const cv::Mat& frame, int number);

  const std::vector<BodyTrack>& tracks() const { return tracks_; }
  // Some of the pictures, evenly spread over the clip, of pairs.
  const std::vector<KeptPicture>& pictures() const { return pictures_; }
  const std::array<TextureGrid, 2>& grids() const { return grids_; }
  // All histories, one entry a frame; the follower is of no more use.
  std::vector<BodyTrack> take_tracks(int frames);

 private:
  Surroundings surroundings_of(std::size_t body) const;
  cv::Rect working_region() const;
  void accept(BodyTrack& track, const BodyFit& fit, int number);
  // Where the paint of a body says that it lies, from where it is expected; nothing where it does
  // not say so clearly.
  std::optional<PaintFit> see_paint(const EdgeImage& image, const BodyTrack& track) const;
  void recover(const cv::Mat& frame, int number, const std::vector<std::size_t>& lost);
  void keep_textures(const EdgeImage& image, int number);

  void keep_picture(const cv::Mat& frame, int number);

  const FilmView& view_;
  std::vector<BodyTrack> tracks_;
  std::array<TextureGrid, 2> grids_;
  std::vector<KeptPicture> pictures_;
  int stride_ = 1;  // of those that are kept
};

}  // namespace graintruth::tracking
