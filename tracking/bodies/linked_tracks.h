// Tracks of bodies that were found in each picture by itself: whoever is seen is given to the track
// that expected it there, or begins a new one.
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "datasets/store/trajectories.h"

namespace graintruth::tracking {

// A body in one picture.
struct Sighting {
  datasets::Pose pose;                               // the angle of a round one is NaN
  datasets::Pose sigma;                              // standard deviations, of the locator alone
  Eigen::Vector3f colour = Eigen::Vector3f::Zero();  // Y, Cr, Cb, or as far apart as these
  double length = 0.0;                               // m, as it looks; 0 of round ones
  double score = 1.0;                                // 0..1
};

struct LinkOptions {
  double reach = 0.0;  // m, that a body may be off where it is expected
  double lever = 0.0;  // m, from the centre to the rim: turns what it may be off into an angle
  int memory = 10;     // frames that a track waits for a body that is not seen
};

// Frame by frame. How well the next step of a track is predicted is learned from the steps before.
class TrackLinker {
 public:
  explicit TrackLinker(const LinkOptions& options) : options_(options) {}

  // Where those that were seen of late are expected in the next frame.
  std::vector<Sighting> expected() const;
  // The next frame.
  void add(const std::vector<Sighting>& sightings);

  // Of each track the index of its sighting in every frame, -1 where unseen; in the order in which
  // tracks begin.
  std::vector<std::vector<int>> tracks() const;
  int doubts() const {
    return doubts_;
  }  // steps that two bodies would explain about as well if
     // exchanged

 private:
  struct Track {
    std::vector<int> sightings;
    datasets::Pose last{0.0, 0.0, 0.0};              // angle continuous; 0 of round bodies
    Eigen::Vector3d step = Eigen::Vector3d::Zero();  // a frame: x, z, angle
    Eigen::Vector3f colour = Eigen::Vector3f::Zero();
    double length = 0.0;
    int seen = 0, unseen = 0;

    datasets::Pose expected() const;
  };
  void accept(Track& track, const Sighting& sighting, int index);
  double spread_of(const Track& track) const;
  // Of each pair of a waiting track and a sighting; who jumped, turned or changed colour by too
  // much is another.
  Eigen::MatrixXd costs(const std::vector<std::size_t>& waiting,
                        const std::vector<Sighting>& sightings) const;
  void note_doubts(const Eigen::MatrixXd& cost, const std::vector<int>& of_track);
  void learn_spread();

  LinkOptions options_;
  std::vector<Track> tracks_;
  std::size_t frames_ = 0;
  std::vector<double> misses_;     // m, of tracks that had a step
  std::optional<double> learned_;  // m per axis, of their next step
  int doubts_ = 0;
};

// How much larger errors are than the sightings' sigmas, at least 1: of positions, and of angles.
// Third differences of a track cancel smooth motion; what is left is the locator's scatter, and
// jerks if there are any. Nothing where there are too few of them.
struct ScatterRatio {
  std::optional<double> position, angle;
};
ScatterRatio scatter_ratio(const datasets::Trajectories& tracks);

}  // namespace graintruth::tracking
