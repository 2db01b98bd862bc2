// Bodies that can be found in every picture by itself: located where they are expected and anywhere
// else, then linked. For kinds that need no more than a locator and an outline.
#pragma once

#include <optional>
#include <vector>

#include "datasets/experiment/tracking_spec.h"
#include "tracking/bodies/linked_tracks.h"
#include "tracking/particle_tracker.h"

namespace graintruth::tracking {

class LocatedTracker : public ParticleTracker {
 public:
  LocatedTracker(const datasets::TrackingSpec& spec, const datasets::Film& film)
      : spec_(spec), film_(film) {}

  void find_first(const Picture& picture,
                  const FilmCamera& camera,
                  TrackingSummary& summary) override;
  void follow(const Picture& picture) override;
  datasets::Trajectories finish(TrackingSummary& summary) override;
  bool is_crowd() const override { return true; }
  void describe(nlohmann::ordered_json& film) const override;

 protected:
  // Told before the first picture is located. Throws InputError where bodies are too small in it.
  virtual void prepare_locator(const cv::Mat& first) = 0;
  // All that are seen; `expected` are those that were seen before, where they should be now.
  virtual std::vector<Sighting> locate(const cv::Mat& frame,
                                       const std::vector<Sighting>& expected) = 0;
  virtual bool shows_angle() const = 0;
  virtual LinkOptions link_options() const = 0;
  virtual double row_height() const = 0;  // m, see number_by_start
  // m, per axis: what no number of pictures makes less.
  virtual Eigen::Vector2d lasting_error(const datasets::Pose& /*pose*/) const {
    return Eigen::Vector2d::Zero();
  }
  // px, one standard deviation per axis where the film is too short to tell: what light and optics
  // leave.
  virtual double usual_error_px() const = 0;

  double length(const char* name) const { return spec_.body.lengths.at(name); }  // m
  const Camera& lens() const { return camera_.calibration.camera; }
  const cv::Rect& region() const { return camera_.region; }
  double scale() const { return scale_; }  // px/m, in the middle of the region
  const datasets::Film& film() const { return film_; }
  const datasets::TrackingSpec& spec() const { return spec_; }

 private:
  datasets::Trajectories trajectories_of(TrackingSummary& summary);
  void count_seen(const datasets::Trajectories& tracks, TrackingSummary& summary) const;

  datasets::TrackingSpec spec_;
  datasets::Film film_;
  FilmCamera camera_;
  double scale_ = 0.0;
  std::vector<std::vector<Sighting>> frames_;
  std::optional<TrackLinker> linker_;
  int brief_tracks_ = 0;  // too short to be believed, left out
  double scatter_ = 1.0;  // of positions over the locator's own sigma
};

}  // namespace graintruth::tracking
