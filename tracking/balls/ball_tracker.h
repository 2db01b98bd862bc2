// Balls, single or glued in pairs. A single ball shows where it is but not how it turns: its angles
// are NaN.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "tracking/balls/body_follower.h"
#include "tracking/balls/learn.h"
#include "tracking/balls/whole_clip.h"
#include "tracking/particle_tracker.h"

namespace graintruth::tracking {

class BallTracker : public ParticleTracker {
 public:
  // Throws InputError where bodies of such balls cannot be followed.
  BallTracker(const datasets::TrackingSpec& spec, const datasets::Film& film);

  void prepare(cv::Mat& frame, int number) override;
  void find_first(const Picture& picture,
                  const FilmCamera& camera,
                  TrackingSummary& summary) override;
  void follow(const Picture& picture) override;
  datasets::Trajectories finish(TrackingSummary& summary) override;
  void draw(cv::Mat& picture, const Camera& camera, const DrawnBody& body) const override;
  void describe(nlohmann::ordered_json& film) const override;

  // Sizes from the whole film, after `finish`.
  const Learned& learned() const { return learned_; }

 private:
  void learn(int frames);
  datasets::Trajectories solve_poses(double zero, TrackingSummary& summary);
  void judge(TrackingSummary& summary) const;
  void judge_bodies(TrackingSummary& summary) const;

  datasets::TrackingSpec spec_;
  datasets::Film film_;
  BodyShape nominal_;
  double noise_as_filmed_ = 0.0;  // grey levels
  std::optional<FilmView> view_;
  std::optional<BodyFollower> follower_;
  std::vector<BodyTrack> tracks_;
  Learned learned_;
  std::vector<std::vector<ClipPose>> clip_;  // of pairs; one list a body, one entry a frame
  std::vector<BodyCheck> checks_;            // of pairs; one a body
  std::vector<double> sigmas_;               // m, one a body: median of its positions, per axis
};

// Nothing where the body is none of balls.
std::unique_ptr<ParticleTracker> make_ball_tracker(const datasets::TrackingSpec& spec,
                                                   const datasets::Film& film);

}  // namespace graintruth::tracking
