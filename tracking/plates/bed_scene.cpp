#include "tracking/plates/bed_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "datasets/store/input_error.h"

namespace graintruth::tracking {

using datasets::InputError;

namespace {

// A pixel beside a wall sees some of it through the blur of the lens.
constexpr double wall_margin_px = 0.7;

// Floors are a few millimetres thick; plates that have passed one may drift sideways below it.
constexpr double floor_thickness = 10.0e-3;  // m

void mark_usable(BedScene& scene) {
  const datasets::OpenBox& box = scene.box();
  const double margin = wall_margin_px * scene.pixel();
  const double side = 0.5 * box.width - margin, edge = 0.5 * box.opening;
  scene.in_bin = cv::Mat1b(scene.region.size(), std::uint8_t{0});
  scene.in_bin_or_below = scene.in_bin.clone();
  for (int row = 0; row < scene.region.height; ++row) {
    for (int column = 0; column < scene.region.width; ++column) {
      const Eigen::Vector2d at =
          scene.film.calibration.camera.unproject({static_cast<double>(scene.region.x + column),
                                                   static_cast<double>(scene.region.y + row)});
      const double off = std::abs(at.x());
      const bool above = off < side && at.y() > margin;
      const bool below = at.y() < margin && (off < edge - margin || at.y() < -floor_thickness);
      if (above) scene.in_bin(row, column) = 255;
      if (above || below) scene.in_bin_or_below(row, column) = 255;
    }
  }
}

cv::Rect region_of(const Camera& camera, const datasets::OpenBox& box) {
  const double side = 0.5 * box.width;
  double left = 1.0e9, right = -1.0e9, top = 1.0e9;
  for (const double z : {0.0, box.height}) {
    left = std::min(left, camera.project(-side, z).x());
    right = std::max(right, camera.project(side, z).x());
    top = std::min({top, camera.project(-side, z).y(), camera.project(side, z).y()});
  }
  const int x = static_cast<int>(std::floor(left)), y = static_cast<int>(std::floor(top));
  return cv::Rect(x, y, static_cast<int>(std::ceil(right)) + 1 - x, camera.height() - y) &
         cv::Rect(0, 0, camera.width(), camera.height());
}

}  // namespace

BedView BedScene::view(bool is_open) const {
  return {
      &film.calibration.camera, shape, plate_height, region, is_open ? in_bin_or_below : in_bin};
}

double BedScene::pixel() const {
  return 1.0 / film.calibration.camera.scale(0.0, 0.25 * box().height);
}

BedScene prepare_bed(const datasets::TrackingSpec& spec,
                     FilmCamera camera,
                     const cv::Mat& first,
                     const cv::Mat& last,
                     const std::string& where) {
  BedScene scene;
  scene.spec = spec;
  scene.shape = plate_shape(spec.body);
  scene.plate_height = seen_height(spec.body.lengths.at("thickness"));
  scene.film = std::move(camera);
  scene.region = region_of(scene.film.calibration.camera, scene.box());
  const double plate_width_px = 2.0 * scene.shape.semi_minor / scene.pixel();
  if (scene.region.width < 3.0 * plate_width_px || scene.region.height < 3.0 * plate_width_px) {
    throw InputError(fmt::format(
        "{}: the bin of {:.0f} mm lies outside the picture; check bin_width, bin_height and the "
        "scale",
        where,
        1.0e3 * scene.box().width));
  }
  constexpr double smallest_plate_px = 8.0;
  if (plate_width_px < smallest_plate_px) {
    throw InputError(fmt::format(
        "{}: a plate is only {:.1f} pixels wide, at least {:.0f} are needed; film from nearer",
        where,
        plate_width_px,
        smallest_plate_px));
  }
  mark_usable(scene);
  const LearnedContrast learned =
      learn_contrast(first(scene.region), last(scene.region), scene.in_bin);
  scene.contrast = learned.contrast;
  scene.changed = learned.changed;
  return scene;
}

OrificeWatcher::OrificeWatcher(const BedScene& scene, const cv::Mat& first) {
  const double half = 0.45 * scene.box().opening;
  constexpr int columns = 64;
  const double pixel = scene.pixel();
  for (int i = 0; i < columns; ++i) {
    for (const double depth : {1.5, 2.5, 3.5}) {  // pixels: any lid is thicker
      const Eigen::Vector2d at = scene.film.calibration.camera.project(
          half * (2.0 * i / (columns - 1.0) - 1.0), -depth * pixel);
      const cv::Point point(static_cast<int>(std::lround(at.x())),
                            static_cast<int>(std::lround(at.y())));
      if (!cv::Rect(0, 0, first.cols, first.rows).contains(point)) continue;
      strip_.push_back(point);
      closed_.push_back(first.at<cv::Vec3b>(point));
    }
  }
}

bool OrificeWatcher::is_open(const cv::Mat& frame) {
  if (open_ || strip_.empty()) return open_;
  constexpr int changed_level = 40;  // grey levels, all channels together
  std::size_t changed = 0;
  for (std::size_t i = 0; i < strip_.size(); ++i) {
    const cv::Vec3b& now = frame.at<cv::Vec3b>(strip_[i]);
    int sum = 0;
    for (int c = 0; c < 3; ++c) sum += std::abs(now[c] - closed_[i][c]);
    changed += sum > changed_level;
  }
  open_ = 4 * changed > strip_.size();
  return open_;
}

}  // namespace graintruth::tracking
