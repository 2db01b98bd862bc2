#include "tracking/plates/plate_tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "datasets/store/input_error.h"
#include "tracking/bodies/located_tracker.h"
#include "tracking/bodies/spots.h"
#include "tracking/plates/first_bed.h"
#include "tracking/plates/plate_bank.h"
#include "tracking/plates/plate_drawing.h"

namespace graintruth::tracking {

namespace {

class PlateTracker : public LocatedTracker {
 public:
  PlateTracker(const datasets::TrackingSpec& spec, const datasets::Film& film)
      : LocatedTracker(spec, film), shape_(plate_shape(spec.body)) {}

  void draw(cv::Mat& picture, const Camera& camera, const DrawnBody& body) const override {
    draw_plate(picture, camera, body, shape_);
  }

 protected:
  bool shows_angle() const override { return shape_.shows_angle(); }
  double row_height() const override { return shape_.semi_minor; }
  // A plate that moves by more than half its width may be taken for its neighbour.
  LinkOptions link_options() const override {
    return {.reach = shape_.semi_minor, .lever = shape_.semi_major};
  }
  // A tenth of a pixel is what light and optics leave of a centre (Middleton et al. 2000).
  double usual_error_px() const override { return 0.1; }

  Eigen::Vector2d lasting_error(const datasets::Pose& pose) const override {
    return height_error(lens(), view_.height, {pose.x, pose.z});
  }

  void prepare_locator(const cv::Mat& first) override {
    const double width_px = 2.0 * shape_.semi_minor * scale();
    constexpr double narrowest = 8.0;
    if (width_px < narrowest) {
      throw datasets::InputError(
          fmt::format("{}: a plate is only {:.1f} pixels wide, at least {:.0f} are needed; film "
                      "from nearer",
                      film().video.string(),
                      width_px,
                      narrowest));
    }
    view_ = {&lens(),
             shape_,
             seen_height(length("thickness")),
             region(),
             cv::Mat1b(region().size(), std::uint8_t{255})};
    const cv::Mat seen = first(region());
    const auto length_px = static_cast<int>(2.0 * shape_.semi_major * scale());
    const cv::Mat ground = local_ground(seen, length_px);
    contrast_ = learn_contrast(seen, ground, view_.usable).contrast;
    first_ =
        find_bed(view_, contrast_of(first, region(), contrast_), contrast_.gain, 1.0 / scale(), -1);
  }

  std::vector<Sighting> locate(const cv::Mat& frame,
                               const std::vector<Sighting>& expected) override {
    if (expected.empty()) return sightings_of(first_->plates);
    BedFit fit(view_, first_->look, contrast_of(frame, region(), contrast_), 0, 1);
    for (const Sighting& plate : expected) fit.add(plate.pose, first_->usual_gain);
    settle(fit);
    for (const PlateCandidate& candidate :
         find_plates(view_, fit.residual(), least_share_of_gain * contrast_.gain))
      fit.add(candidate.pose, candidate.gain);
    settle(fit);
    std::vector<PlateFit> plates;
    for (std::size_t k = 0; k < fit.size(); ++k)
      if (fit.is_present(k)) plates.push_back(fit.measure(k));
    return sightings_of(plates);
  }

 private:
  void settle(BedFit& fit) const {
    constexpr int sweeps = 6;
    const double longest_step = 2.0 / scale();  // m
    for (int i = 0; i < sweeps; ++i) fit.sweep(longest_step);
    drop_impostors(fit, contrast_.gain);
  }

  std::vector<Sighting> sightings_of(const std::vector<PlateFit>& plates) const {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<Sighting> sightings;
    for (const PlateFit& plate : plates) {
      const Eigen::Vector3d sigma = plate.covariance.diagonal().cwiseSqrt();
      const bool turned = shows_angle();
      sightings.push_back({.pose = {plate.pose.x, plate.pose.z, turned ? plate.pose.angle : nan},
                           .sigma = {sigma[0], sigma[1], turned ? sigma[2] : nan},
                           // Brightness is all that the contrast leaves of a plate's colour
                           .colour = Eigen::Vector3f(static_cast<float>(plate.gain), 0.0F, 0.0F),
                           .score = std::clamp(plate.score, 0.0, 1.0)});
    }
    return sightings;
  }

  PlateShape shape_;
  BedView view_;
  Contrast contrast_;
  std::optional<FirstBed> first_;
};

}  // namespace

std::unique_ptr<ParticleTracker> make_plate_tracker(const datasets::TrackingSpec& spec,
                                                    const datasets::Film& film) {
  if (spec.body.kind != "plate" || spec.rig.box) return nullptr;
  return std::make_unique<PlateTracker>(spec, film);
}

}  // namespace graintruth::tracking
