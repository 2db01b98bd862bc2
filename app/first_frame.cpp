#include "app/first_frame.h"

#include <fmt/format.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "datasets/input_error.h"
#include "tracking/camera.h"
#include "tracking/drawing.h"
#include "tracking/fiducials.h"
#include "tracking/registry.h"
#include "tracking/video.h"

namespace graintruth::app {

namespace {

const cv::Scalar rig_colour(40, 160, 40);  // blue, green, red
const cv::Scalar particle_colour(200, 90, 30);
const cv::Scalar found_colour(200, 40, 200);
const cv::Scalar missed_colour(30, 30, 220);

cv::Point2d pixel(const Eigen::Vector2d& at) { return {at.x(), at.y()}; }

// The particles at each nominal starting place, with their numbers.
void draw_starts(cv::Mat& picture,
                 const tracking::Camera& camera,
                 const tracking::ParticleTracker& tracker,
                 const std::vector<datasets::StartPlace>& starts) {
  for (std::size_t n = 0; n < starts.size(); ++n) {
    const datasets::StartPlace& start = starts[n];
    tracker.draw(picture, camera, {n, {start.x, start.z, start.angle}, particle_colour});
    // Black on a broad white edge, to be read on balls of any colour.
    const std::string number = std::to_string(n + 1);
    const cv::Size size = cv::getTextSize(number, cv::FONT_HERSHEY_SIMPLEX, 0.5, 1, nullptr);
    const cv::Point corner = cv::Point(pixel(camera.project(start.x, start.z))) +
                             cv::Point(-size.width, size.height) / 2;
    for (const auto& [colour, thickness] :
         {std::pair(cv::Scalar::all(255), 4), {cv::Scalar(), 1}}) {
      cv::putText(
          picture, number, corner, cv::FONT_HERSHEY_SIMPLEX, 0.5, colour, thickness, cv::LINE_AA);
    }
  }
}

void draw_fiducials(cv::Mat& picture,
                    const tracking::Camera& camera,
                    const std::vector<datasets::Fiducial>& fiducials,
                    const std::vector<tracking::FiducialSighting>& sightings) {
  std::vector<bool> found(fiducials.size(), false);
  for (const tracking::FiducialSighting& sighting : sightings) {
    found[static_cast<std::size_t>(sighting.fiducial)] = true;
    cv::drawMarker(
        picture, pixel(sighting.pixel), found_colour, cv::MARKER_CROSS, 14, 1, cv::LINE_AA);
  }
  for (std::size_t i = 0; i < fiducials.size(); ++i) {
    const datasets::Fiducial& fiducial = fiducials[i];
    const double radius = 0.5 * fiducial.diameter * camera.scale(fiducial.x, fiducial.z);
    cv::circle(picture,
               pixel(camera.project(fiducial.x, fiducial.z)),
               static_cast<int>(std::lround(radius)) + 3,
               found[i] ? found_colour : missed_colour,
               found[i] ? 1 : 2,
               cv::LINE_AA);
  }
}

void write_picture(const std::filesystem::path& file, const cv::Mat& picture) {
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  if (error || !cv::imwrite(file.string(), picture)) {
    throw datasets::InputError(
        fmt::format("{}: cannot be written; choose another folder with --out.", file.string()));
  }
}

}  // namespace

void require_first_frame(const datasets::TrackingSpec& spec, const datasets::Film& film) {
  tracking::VideoReader(film.video, spec.camera.frame_rate);
}

FirstFrame look_at_first_frame(const datasets::TrackingSpec& spec,
                               const datasets::Film& film,
                               const std::filesystem::path& picture_file) {
  // 1. The frame
  tracking::VideoReader reader(film.video, spec.camera.frame_rate);
  cv::Mat picture;
  reader.read(picture);
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  picture = picture.clone();
  FirstFrame frame{.width = reader.width(),
                   .height = reader.height(),
                   .declared_frames = reader.declared_frames(),
                   .declared_frame_rate = reader.declared_frame_rate()};

  // 2. The camera
  const auto& fiducials = spec.camera.fiducials;
  const auto sightings = tracking::find_fiducials(grey, fiducials, spec.camera.pixel_aspect);
  frame.fiducials_found = static_cast<int>(sightings.size());
  std::optional<tracking::Calibration> calibration;
  try {
    calibration = tracking::calibrate(
        fiducials, sightings, frame.width, frame.height, spec.camera.pixel_aspect);
  } catch (const datasets::InputError&) {
    // Fewer than four dots agree with each other: said by the missing residual.
  }

  // 3. What the experiment file says, drawn over it
  if (calibration) {
    frame.residual = calibration->rms;
    double x = 0.0;
    double z = 0.0;
    for (const datasets::Fiducial& fiducial : fiducials) {
      x += fiducial.x / static_cast<double>(fiducials.size());
      z += fiducial.z / static_cast<double>(fiducials.size());
    }
    frame.scale = calibration->camera.scale(x, z);
    tracking::draw_rig(picture, calibration->camera, spec.rig, 0.0, rig_colour, 1);
    draw_starts(picture, calibration->camera, *tracking::make_tracker(spec, film), spec.starts);
    draw_fiducials(picture, calibration->camera, fiducials, sightings);
  } else {
    for (const tracking::DarkDot& dot : tracking::find_dark_dots(grey, spec.camera.fiducials)) {
      cv::circle(picture,
                 pixel(dot.centre),
                 static_cast<int>(std::lround(0.5 * dot.diameter)) + 3,
                 missed_colour,
                 1,
                 cv::LINE_AA);
    }
  }
  write_picture(picture_file, picture);
  return frame;
}

}  // namespace graintruth::app
