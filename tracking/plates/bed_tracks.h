// Every plate followed from frame to frame: predicted, fitted together with its neighbours, looked
// for again where it was lost. Plates are neither born nor lost inside a closed bin: whatever is
// missing stays expected until it is found again, and only below the orifice may a plate leave.
#pragma once

#include <array>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "tracking/plates/first_bed.h"

namespace graintruth::tracking {

// How fast a plate is: errors differ.
enum class Pace { rest, slow, fast };

// A plate seen in one frame.
struct PlateSighting {
  datasets::Pose pose;                                   // angle continuous along the track
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of x, z, angle; white residuals
  float score = 0.0F;
  float gain = 0.0F;
  Pace pace = Pace::rest;
  bool filled = false;  // found afterwards, between frames in which it was seen
};

struct PlateTrack {
  std::vector<std::optional<PlateSighting>> sightings;  // one a frame; shorter once it has left
  datasets::Pose expected;                              // last seen, or predicted since
  datasets::Pose velocity{0, 0, 0};                     // a frame
  Eigen::Vector3f colour = Eigen::Vector3f::Zero();  // blue, green, red over the usual brightness
  double gain = 0.0;
  int unseen = 0;    // frames since it was seen
  int left_at = -1;  // first frame in which it was gone through the orifice and out of the picture
};

class BedTracks {
 public:
  BedTracks(const BedScene& scene, const FirstBed& bed, const cv::Mat& frame);

  // `parity` as in VideoReader.
  void follow(const cv::Mat& frame, int number, int parity);

  const std::vector<PlateTrack>& tracks() const { return tracks_; }
  // First frame in which the orifice is open; -1 while closed.
  int opened_at() const { return opened_at_; }
  // Ratio of true to white variance of x, z and angle: neighbouring residuals err alike, and motion
  // adds errors of its own.
  Eigen::Vector3d variance_inflation(Pace pace) const;
  int losses() const { return losses_; }          // times that a plate was not where predicted
  int recoveries() const { return recoveries_; }  // and was found again in the same frame
  const std::vector<int>& doubtful_frames() const { return doubtful_frames_; }

 private:
  struct Found {
    std::size_t index;  // in the fit
    PlateFit plate;
    Eigen::Vector3f colour;
  };
  // What a frame looked like, kept for filling gaps.
  struct Memory {
    int number;
    cv::Mat1f contrast;
    int first_row, row_step;
    bool open;
  };

  datasets::Pose predict(const PlateTrack& track) const;
  Eigen::Vector2d gained_about(const datasets::Pose& place) const;
  bool is_coarse() const;
  void match_coarsely(const cv::Mat1f& coarse);
  void fit_all(BedFit& fit, const std::vector<int>& index_of);
  bool retry_doubtful(BedFit& fit, const std::vector<int>& index_of);
  bool is_lost(const PlateFit& plate, const PlateTrack& track) const;
  bool is_in_wall(const datasets::Pose& pose) const;
  Pace pace_of(const PlateTrack& track) const;
  bool has_left(const PlateFit& plate, const datasets::Pose& expected) const;
  std::vector<std::size_t> find_lost(const std::vector<int>& index_of,
                                     const std::vector<PlateFit>& measured) const;
  void recover(BedFit& fit, const cv::Mat& frame, int number, const std::vector<std::size_t>& lost);
  std::vector<Found> find_strangers(BedFit& fit, const cv::Mat& frame) const;
  bool overlaps_any(const BedFit& fit, const datasets::Pose& pose) const;
  bool tell_apart(BedFit& fit,
                  const cv::Mat& frame,
                  const std::vector<datasets::Pose>& predicted,
                  std::vector<std::size_t>& lost,
                  std::vector<std::size_t>& waiting,
                  std::vector<int>& index_of,
                  std::vector<PlateFit>& measured) const;
  // `places[place_of[i]]` is where tracks[i] is now, -1 for nowhere.
  void undo_crossings(const std::vector<std::size_t>& tracks,
                      const std::vector<datasets::Pose>& places,
                      std::vector<int>& place_of) const;
  std::optional<Found> seek(BedFit& fit, const cv::Mat& frame, const PlateTrack& track) const;
  void accept(PlateTrack& track, const PlateFit& plate, const cv::Mat& frame, int number);
  void fill_gap(std::size_t track, int from, int to);
  Eigen::Vector3f colour_of(const cv::Mat& frame, const datasets::Pose& pose) const;

  const BedScene& scene_;
  const FirstBed& bed_;
  OrificeWatcher orifice_;
  BedView closed_view_, open_view_;
  double pixel_;  // m
  double fall_;   // m a frame squared: gravity
  int opened_at_ = -1;
  std::vector<PlateTrack> tracks_;
  std::deque<Memory> memory_;
  struct Inflation {
    Eigen::Vector3d blocks = Eigen::Vector3d::Zero(), halves = Eigen::Vector3d::Zero();
    Eigen::Vector3d leverage = Eigen::Vector3d::Zero();
    double count = 0.0;
  };
  std::array<Inflation, 3> inflation_;  // one a pace
  cv::Mat1f coarse_;                    // contrast of the last frame at half the resolution
  int losses_ = 0, recoveries_ = 0;
  std::vector<int> doubtful_frames_;
};

}  // namespace graintruth::tracking
