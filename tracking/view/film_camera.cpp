#include "tracking/view/film_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets/store/input_error.h"

namespace graintruth::tracking {

namespace {

cv::Rect region_of(const datasets::Camera& stated,
                   const cv::Size& size,
                   const datasets::Film& film) {
  const cv::Rect whole({}, size);
  if (!stated.region) return whole;
  const auto& [left, top, right, bottom] = *stated.region;
  const cv::Rect region = cv::Rect(left, top, right - left, bottom - top) & whole;
  if (region.empty()) {
    throw datasets::InputError(
        fmt::format("{}: camera.region_px lies outside the picture of {} x {} pixels",
                    film.experiment.string(),
                    size.width,
                    size.height));
  }
  return region;
}

// Known lengths that only check the scale.
void compare_with_checks(const Calibration& calibration,
                         const datasets::Camera& stated,
                         TrackingSummary& summary) {
  if (!stated.checks) return;
  for (const datasets::CheckedLength& check : *stated.checks) {
    const MeasuredLength seen = measure_length(calibration,
                                               {check.from[0], check.from[1]},
                                               {check.to[0], check.to[1]},
                                               stated.click_error);
    const double sigma = std::hypot(seen.sigma, check.length_uncertainty);
    constexpr double sure = 3.0;
    if (std::abs(seen.length - check.length) <= sure * sigma) continue;
    summary.warn(fmt::format(
        "By this scale a length that was stated as {:.4g} mm is {:.4g} +- {:.2g} mm long (pixel "
        "{:.1f}, {:.1f} to {:.1f}, {:.1f}): one of the two is wrong.",
        1.0e3 * check.length,
        1.0e3 * seen.length,
        1.0e3 * sigma,
        check.from[0],
        check.from[1],
        check.to[0],
        check.to[1]));
  }
}

}  // namespace

FilmCamera calibrate_on(const datasets::Camera& stated,
                        const cv::Mat& first_frame,
                        const datasets::Film& film) {
  FilmCamera camera{.scale = look_for_scale(stated, first_frame, film),
                    .region = region_of(stated, first_frame.size(), film)};
  camera.calibration = calibrate(camera.scale, stated, first_frame.size(), film);
  return camera;
}

void describe_camera(const FilmCamera& film,
                     const datasets::Camera& stated,
                     TrackingSummary& summary) {
  const Calibration& calibration = film.calibration;
  const Camera& camera = calibration.camera;
  const std::string& name = film.scale.name;
  summary.references = name;
  summary.references_given = film.scale.given;
  summary.references_found = film.scale.found;
  summary.references_used = stated.stick ? 1 : static_cast<int>(calibration.used.size());
  summary.distortion_k1 = camera.k1();
  summary.distortion_k2 = camera.k2();
  summary.pixel_aspect = camera.pixel_aspect();
  summary.calibration_rms_mm = 1.0e3 * calibration.rms;
  summary.calibration_max_mm = 1.0e3 * calibration.max;
  summary.calibration_leave_one_out_rms_mm = 1.0e3 * calibration.leave_one_out_rms;
  summary.calibration_leave_one_out_max_mm = 1.0e3 * calibration.leave_one_out_max;
  compare_with_checks(calibration, stated, summary);
  if (film.scale.sightings.empty())
    summary.findings.emplace_back(
        "The camera is assumed to stand still. Only fiducials can show that it moves");
  if (const auto& stick = stated.stick) {
    constexpr double tilt = 5.0;  // degrees
    summary.warn(fmt::format(
        "The scale comes from a length of {:.4g} mm. The camera is assumed to be level and square "
        "to the plane{}. Nothing on the film measures it ({:.0f} degrees of tilt change lengths by "
        "{:.1f} %).",
        1.0e3 * stick->length,
        stated.lens ? "" : ", and its lens to bend no lines",
        tilt,
        100.0 * (1.0 - std::cos(tilt * std::numbers::pi / 180.0))));
    return;
  }
  if (summary.references_used < summary.references_given) {
    summary.warn(fmt::format(
        "{} of {} {} were used to calibrate the camera; the others were not found or lie off.",
        summary.references_used,
        summary.references_given,
        name));
  }
  if (calibration.used.size() == fewest_references) {
    summary.warn(fmt::format(
        "Only four {}: the camera's distortion and the calibration's error cannot be checked.",
        name));
  }
  // A tilt of some degrees looks like a per cent or two
  constexpr double aspect_tolerance = 0.03;
  if (std::abs(summary.pixel_aspect / stated.pixel_aspect - 1.0) > aspect_tolerance) {
    summary.warn(fmt::format(
        "The {} show pixels {:.3f} times as wide as high but camera.pixel_aspect is {:.3f}; what "
        "the {} show was used.",
        name,
        summary.pixel_aspect,
        stated.pixel_aspect,
        name));
  }
  // Half a pixel is ten times what a well-seen disc leaves; clicks scatter by more
  const double limit_px = std::max(0.5, 3.0 * std::numbers::sqrt2 * film.scale.expected_sigma_px);
  const CameraReference& any = film.scale.references.front();
  const double pixel = 1.0 / camera.scale(any.x, any.z);  // m
  if (calibration.rms > limit_px * pixel) {
    summary.fail(
        fmt::format("The {} fit the camera model only to {:.2f} mm rms ({:.1f} pixels are {:.2f} "
                    "mm): positions "
                    "in the experiment file may be wrong.",
                    name,
                    summary.calibration_rms_mm,
                    limit_px,
                    1.0e3 * limit_px * pixel));
  }
}

void describe_steadiness(const SteadyView& steady, TrackingSummary& summary) {
  summary.camera_shift_px = steady.largest_shift_px();
  constexpr double noticeable = 0.5;  // px
  if (summary.camera_shift_px > noticeable) {
    summary.warn(
        fmt::format("The camera or the rig moved: in frame {} a fiducial lies {:.1f} px from where "
                    "it was. Pictures were put back by the fiducials.",
                    steady.frame_of_largest_shift(),
                    summary.camera_shift_px));
  }
  constexpr double tolerated_share = 0.1;
  if (steady.unchecked_frames() > tolerated_share * summary.frames_read) {
    summary.warn(
        fmt::format("In {} frames too few fiducials could be seen to tell whether the camera stood "
                    "still.",
                    steady.unchecked_frames()));
  }
}

}  // namespace graintruth::tracking
