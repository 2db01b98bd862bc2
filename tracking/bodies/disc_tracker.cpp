#include "tracking/bodies/disc_tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "datasets/store/input_error.h"
#include "tracking/bodies/located_tracker.h"
#include "tracking/bodies/spots.h"
#include "tracking/drawing/drawing.h"
#include "tracking/view/colour.h"
#include "tracking/view/edge_image.h"

namespace graintruth::tracking {

namespace {

class DiscTracker : public LocatedTracker {
 public:
  using LocatedTracker::LocatedTracker;

  void draw(cv::Mat& picture, const Camera& camera, const DrawnBody& body) const override {
    constexpr int points = 40;
    const double radius = 0.5 * length("diameter");
    std::vector<Eigen::Vector2d> outline;
    for (int k = 0; k < points; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / points;
      outline.push_back(camera.project(body.pose.x + radius * std::cos(angle),
                                       body.pose.z + radius * std::sin(angle)));
    }
    draw_outline(picture, outline, body);
  }

 protected:
  bool shows_angle() const override { return false; }
  double row_height() const override { return 0.5 * length("diameter"); }
  // A disc that moves further than its radius may be taken for its neighbour.
  LinkOptions link_options() const override {
    return {.reach = 0.5 * length("diameter"), .lever = 0.5 * length("diameter")};
  }
  // A tenth of a pixel is what light and optics leave of a centre of mass (Middleton et al. 2000).
  double usual_error_px() const override { return 0.1; }

  // What the picture cuts off pulls the centre of area the other way, by less than half as much.
  Eigen::Vector2d lasting_error(const datasets::Pose& pose) const override {
    const Eigen::Vector2d at = lens().project(pose.x, pose.z);
    const double radius_px = 0.5 * length("diameter") * scale();
    const auto cut = [&](double place, int from, int to) {
      return std::max({0.0, radius_px - (place - from), radius_px - (to - 1 - place)});
    };
    const cv::Rect& seen = region();
    return 0.5 / scale() *
           Eigen::Vector2d(cut(at.x(), seen.x, seen.br().x), cut(at.y(), seen.y, seen.br().y));
  }

  void prepare_locator(const cv::Mat& first) override {
    const double diameter_px = length("diameter") * scale();
    constexpr double smallest = 4.0;
    if (diameter_px < smallest) {
      throw datasets::InputError(
          fmt::format("{}: a disc is only {:.1f} pixels wide, at least {:.0f} are needed; film "
                      "from nearer",
                      film().video.string(),
                      diameter_px,
                      smallest));
    }
    noise_ = std::max(1.0, camera_noise(first));
    // Of discs in touch each is looked for without what blurs into it from the others
    constexpr double inner = 0.85;
    options_.diameter_px = 2 * static_cast<int>(0.5 * inner * diameter_px) + 1;
    // A square inside a disc of one shade would take the disc for ground
    options_.ground_px = 2 * static_cast<int>(0.75 * diameter_px) + 1;
    options_.noise_px = std::max(1.0, 0.1 * diameter_px);
    // What one grey level all over a disc makes: below it nothing can be told apart
    if (spec().body.count)
      options_.least_mass = 0.25 * std::numbers::pi * diameter_px * diameter_px;
  }

  std::vector<Sighting> locate(const cv::Mat& frame,
                               const std::vector<Sighting>& /*expected*/) override {
    const double diameter_px = length("diameter") * scale();
    const cv::Mat contrast =
        contrast_to_ground(frame(region()), 2 * static_cast<int>(0.5 * diameter_px) + 1);
    // Discs that the picture cuts are seen to a quarter of their width from its edge
    const int beyond = options_.diameter_px / 4;
    cv::Mat padded;
    cv::copyMakeBorder(
        contrast, padded, beyond, beyond, beyond, beyond, cv::BORDER_CONSTANT, cv::Scalar::all(0));
    std::vector<Spot> spots = locate_spots(padded, options_);
    for (Spot& spot : spots) spot.pixel.array() -= beyond;
    if (const auto& count = spec().body.count) spots.resize(particles_among(spots, *count));
    const std::vector<double> errors = centre_on_discs(contrast, diameter_px, noise_, spots);
    std::vector<Sighting> sightings;
    for (std::size_t i = 0; i < spots.size(); ++i) {
      const Eigen::Vector2d at = spots[i].pixel + Eigen::Vector2d(region().x, region().y);
      const Eigen::Vector2d place = lens().unproject(at);
      const Eigen::Vector2d sigma =
          errors[i] * lens().jacobian(place.x(), place.y()).inverse().rowwise().norm();
      constexpr double nan = std::numeric_limits<double>::quiet_NaN();
      sightings.push_back({.pose = {place.x(), place.y(), nan},
                           .sigma = {sigma.x(), sigma.y(), nan},
                           .colour = colour_of(frame, at)});
    }
    return sightings;
  }

 private:
  // Mean colour inside the rim.
  Eigen::Vector3f colour_of(const cv::Mat& frame, const Eigen::Vector2d& at) const {
    const int half = std::max(1, static_cast<int>(0.25 * options_.diameter_px));
    const cv::Rect box(static_cast<int>(std::lround(at.x())) - half,
                       static_cast<int>(std::lround(at.y())) - half,
                       2 * half + 1,
                       2 * half + 1);
    const cv::Scalar mean = cv::mean(frame(box & cv::Rect({}, frame.size())));
    return luma_and_chroma(mean[0], mean[1], mean[2]);
  }

  double noise_ = 1.0;  // grey levels
  SpotOptions options_;
};

}  // namespace

std::unique_ptr<ParticleTracker> make_disc_tracker(const datasets::TrackingSpec& spec,
                                                   const datasets::Film& film) {
  if (spec.body.kind != "disc") return nullptr;
  return std::make_unique<DiscTracker>(spec, film);
}

}  // namespace graintruth::tracking
