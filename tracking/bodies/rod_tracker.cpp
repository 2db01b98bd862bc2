#include "tracking/bodies/rod_tracker.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "datasets/store/input_error.h"
#include "tracking/bodies/located_tracker.h"
#include "tracking/bodies/rods.h"
#include "tracking/drawing/drawing.h"

namespace graintruth::tracking {

namespace {

// L*a*b* differs by 7 where light and shade change a rod, brightness and chroma by 12.
constexpr float colour_weight = 12.0F / 7.0F;

class RodTracker : public LocatedTracker {
 public:
  using LocatedTracker::LocatedTracker;

  void draw(cv::Mat& picture, const Camera& camera, const DrawnBody& body) const override {
    if (!std::isfinite(body.pose.angle)) return;
    const Eigen::Vector2d centre(body.pose.x, body.pose.z);
    const Eigen::Vector2d axis(std::cos(body.pose.angle), std::sin(body.pose.angle));
    const Eigen::Vector2d along = 0.5 * length("length") * axis;
    const Eigen::Vector2d across = 0.5 * length("diameter") * Eigen::Vector2d(-axis.y(), axis.x());
    std::vector<Eigen::Vector2d> outline;
    for (const auto& [ahead, aside] : {std::pair(1, 1), {-1, 1}, {-1, -1}, {1, -1}}) {
      const Eigen::Vector2d corner = centre + ahead * along + aside * across;
      outline.push_back(camera.project(corner.x(), corner.y()));
    }
    draw_outline(picture, outline, body);
  }

 protected:
  bool shows_angle() const override { return true; }
  double row_height() const override { return 0.5 * length("diameter"); }
  LinkOptions link_options() const override {
    return {.reach = std::max(length("diameter"), 0.25 * length("length")),
            .lever = 0.5 * length("length")};
  }
  // Ends are found in whole pixels.
  double usual_error_px() const override { return 0.3; }

  void prepare_locator(const cv::Mat& /*first*/) override {
    options_.width_px = length("diameter") * scale();
    constexpr double thinnest = 3.0;
    if (options_.width_px < thinnest) {
      throw datasets::InputError(
          fmt::format("{}: a rod is only {:.1f} pixels thick, at least {:.0f} are needed; film "
                      "from nearer",
                      film().video.string(),
                      options_.width_px,
                      thinnest));
    }
    // Rods nearer to the camera than its plane look longer
    constexpr double nearest = 1.15;
    options_.longest_px = nearest * length("length") * scale();
    options_.region = region();
  }

  std::vector<Sighting> locate(const cv::Mat& frame,
                               const std::vector<Sighting>& expected) override {
    std::vector<Rod> known;
    for (const Sighting& rod : expected) {
      const Eigen::Vector2d centre(rod.pose.x, rod.pose.z);
      const Eigen::Vector2d half =
          0.5 * rod.length * Eigen::Vector2d(std::cos(rod.pose.angle), std::sin(rod.pose.angle));
      const Eigen::Vector2d from = centre - half, to = centre + half;
      known.push_back({.from = lens().project(from.x(), from.y()),
                       .to = lens().project(to.x(), to.y()),
                       .colour = rod.colour / colour_weight});
    }
    std::vector<Sighting> sightings;
    for (const Rod& rod : locate_rods(frame, options_, known)) {
      const Eigen::Vector2d from = lens().unproject(rod.from), to = lens().unproject(rod.to);
      const Eigen::Vector2d centre = 0.5 * (from + to), axis = (to - from).normalized();
      // Ends err along the rod. A middle line that errs by s across it is turned by sqrt(12) s / L
      const double pixel = 1.0 / lens().scale(centre.x(), centre.y());  // m
      const double along = 0.5 * pixel * std::hypot(rod.from_sigma_px, rod.to_sigma_px);
      const double across = pixel * rod.across_sigma_px;
      sightings.push_back({.pose = {centre.x(), centre.y(), std::atan2(axis.y(), axis.x())},
                           .sigma = {std::hypot(along * axis.x(), across * axis.y()),
                                     std::hypot(along * axis.y(), across * axis.x()),
                                     std::sqrt(12.0) * across / (to - from).norm()},
                           .colour = colour_weight * rod.colour,
                           .length = (to - from).norm(),
                           .score = rod.coverage});
      double& angle = sightings.back().pose.angle;
      if (angle < 0.0) angle += std::numbers::pi;
    }
    return sightings;
  }

 private:
  RodOptions options_;
};

}  // namespace

std::unique_ptr<ParticleTracker> make_rod_tracker(const datasets::TrackingSpec& spec,
                                                  const datasets::Film& film) {
  if (spec.body.kind != "rod") return nullptr;
  return std::make_unique<RodTracker>(spec, film);
}

}  // namespace graintruth::tracking
