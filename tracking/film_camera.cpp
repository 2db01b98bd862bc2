#include "tracking/film_camera.h"

#include <fmt/format.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "datasets/input_error.h"

namespace graintruth::tracking {

using datasets::InputError;

namespace {
constexpr std::size_t fewest = 4;  // fiducials that fix a camera
}

FilmCamera calibrate_on(const datasets::Camera& stated,
                        const cv::Mat& first_frame,
                        const datasets::Film& where) {
  const auto& given = stated.fiducials;
  if (given.size() < fewest) {
    throw InputError(fmt::format(
        "{}: camera.fiducials: {} given; at least {} dots of known position are needed to "
        "calibrate the camera",
        where.experiment.string(),
        given.size(),
        fewest));
  }
  cv::Mat grey;
  cv::cvtColor(first_frame, grey, cv::COLOR_BGR2GRAY);
  FilmCamera film;
  film.sightings = find_fiducials(grey, given, stated.pixel_aspect);
  if (film.sightings.size() < fewest) {
    throw InputError(fmt::format(
        "{}: only {} of {} fiducials were found in the first frame, at least {} are needed; "
        "check that the dots are dark on a light ground, unobstructed, and that their "
        "positions in the experiment file are right",
        where.video.string(),
        film.sightings.size(),
        given.size(),
        fewest));
  }
  film.calibration = calibrate(given, film.sightings, grey.cols, grey.rows, stated.pixel_aspect);
  return film;
}

void describe_camera(const FilmCamera& film,
                     const datasets::Camera& stated,
                     TrackingSummary& summary) {
  const Calibration& calibration = film.calibration;
  const datasets::Fiducial& any = stated.fiducials.front();
  const double pixel = 1.0 / calibration.camera.scale(any.x, any.z);  // m
  summary.fiducials_given = static_cast<int>(stated.fiducials.size());
  summary.fiducials_found = static_cast<int>(film.sightings.size());
  summary.fiducials_used = static_cast<int>(calibration.used.size());
  summary.distortion_k1 = calibration.camera.k1();
  summary.distortion_k2 = calibration.camera.k2();
  summary.pixel_aspect = calibration.camera.pixel_aspect();
  summary.calibration_rms_mm = 1.0e3 * calibration.rms;
  summary.calibration_max_mm = 1.0e3 * calibration.max;
  summary.calibration_leave_one_out_rms_mm = 1.0e3 * calibration.leave_one_out_rms;
  summary.calibration_leave_one_out_max_mm = 1.0e3 * calibration.leave_one_out_max;
  if (summary.fiducials_used < summary.fiducials_given) {
    summary.warn(
        fmt::format("{} of {} fiducials were used to calibrate the camera; the others were not "
                    "found or lie off.",
                    summary.fiducials_used,
                    summary.fiducials_given));
  }
  if (calibration.used.size() == fewest) {
    summary.warn(
        "Only four fiducials: the camera's distortion and the calibration's error cannot be "
        "checked.");
  }
  // A tilt of some degrees looks like a per cent or two
  constexpr double aspect_tolerance = 0.03;
  if (std::abs(summary.pixel_aspect / stated.pixel_aspect - 1.0) > aspect_tolerance) {
    summary.warn(fmt::format(
        "The fiducials show pixels {:.3f} times as wide as high but camera.pixel_aspect "
        "is {:.3f}; what the fiducials show was used.",
        summary.pixel_aspect,
        stated.pixel_aspect));
  }
  if (calibration.rms > 0.5 * pixel) {
    summary.fail(
        fmt::format("The fiducials fit the camera model only to {:.2f} mm rms (half a pixel is "
                    "{:.2f} mm): positions in the experiment file may be wrong.",
                    summary.calibration_rms_mm,
                    0.5e3 * pixel));
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
