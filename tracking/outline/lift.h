// What is lifted off a bed or pulled from under it - a tube, a gate, a slide - read from the film:
// where it is when, how fast it goes, and when it began.
#pragma once

#include <Eigen/Dense>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "datasets/rigs/rig.h"
#include "tracking/event/event.h"
#include "tracking/outline/plane_picture.h"

namespace graintruth::tracking {

// Heights of something that stands still and then rises at one speed, or rises all the time.
struct Lift {
  double start = 0.0, start_sigma = 0.0;  // s from the first frame
  double speed = 0.0, speed_sigma = 0.0;  // m/s
  double from = 0.0;                      // m, its height before
  double scatter = 0.0;                   // m, of the record about that
  bool start_is_seen = false;             // else it moves from the first frame on

  double height(double time) const { return from + speed * std::max(0.0, time - start); }
};

// Least squares with the outliers of Cauchy's weights; all is free. Nothing where fewer than eight
// heights are known, or they do not move by more than they scatter. Where the first frame shows it
// moving, `drawn` (m) says where it stood.
std::optional<Lift> fit_lift(const HeightRecord& record, double drawn);

// Follows the leading and the trailing edge of the mover through plane pictures: the change of
// brightness along its way, averaged over both of its sides. The way is up, or to one side. Then
// pictures are turned by a quarter, so that it is up: what is said of heights here is said of
// places along the way.
class LiftWatcher {
 public:
  LiftWatcher() = default;
  // `eye` (m; x right, z up, h towards the camera): parts of a tube stand before the plane.
  LiftWatcher(const datasets::SeenOutline::Mover& mover,
              const PlaneGrid& grid,
              const Eigen::Vector3d& eye);

  void look(const cv::Mat& grey, const cv::Mat1b& seen, double time);

  // How it rose from where it is drawn, by the edge that tells it best: what lies still behind the
  // other one may be taken for it. Nothing where neither is seen to move.
  std::optional<Lift> lift() const;
  bool is_seen() const { return edges_[0].found + edges_[1].found > 0; }

  // m: by how much both edges are farther apart than they are drawn, in the pictures up to this
  // time. Nothing where fewer than two show both.
  std::optional<double> longer_by(double until) const;
  double length() const { return edges_[0].drawn - edges_[1].drawn; }  // m, along its way

  // The mover's shadow on the plane from the eye after it rose so far.
  std::vector<Eigen::Vector2d> shadow(double rise) const;

 private:
  struct Edge {
    double drawn = 0.0;  // m, height before the event, at the middle of the mover
    double row = 0.0;    // where it was last
    double step = 0.0;   // rows a frame
    double sign = 0.0;   // +1: brighter below
    double strength = 0.0;
    bool lost = false;
    int found = 0;
    HeightRecord record;
  };
  enum class Way { up, right, left };
  Eigen::Vector2d turned(const Eigen::Vector2d& point) const;
  Eigen::Vector2d turned_back(const Eigen::Vector2d& point) const;
  double rises_by(const Edge& edge, double row) const;
  void look_upwards(const cv::Mat& grey, const cv::Mat1b& seen, double time);

  Way way_ = Way::up;
  std::optional<double> last_time_;  // s, of the picture before

  datasets::SeenOutline::Mover mover_;
  PlaneGrid grid_;
  Eigen::Vector3d eye_ = Eigen::Vector3d::Zero();
  std::vector<std::pair<int, int>> bands_;  // columns
  double depth_ = 0.0;                      // m, of the bands' front before the plane
  std::array<Edge, 2> edges_;               // upper, lower
};

}  // namespace graintruth::tracking
