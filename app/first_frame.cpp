#include "app/first_frame.h"

#include <fmt/format.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "datasets/input_error.h"
#include "tracking/camera.h"
#include "tracking/drawing.h"
#include "tracking/fiducials.h"
#include "tracking/video.h"

namespace graintruth::app {

namespace {

const cv::Scalar rig_colour(40, 160, 40);  // blue, green, red
const cv::Scalar particle_colour(200, 90, 30);
const cv::Scalar found_colour(200, 40, 200);
const cv::Scalar missed_colour(30, 30, 220);

cv::Point2d pixel(const Eigen::Vector2d& at) { return {at.x(), at.y()}; }

// Outlines of the balls at each nominal starting place, with the particle's number.
void draw_starts(cv::Mat& picture,
                 const tracking::Camera& camera,
                 const datasets::Experiment& experiment) {
  std::vector<Eigen::Vector2d> outline(72);
  for (std::size_t n = 0; n < experiment.starts.size(); ++n) {
    const datasets::StartPlace& start = experiment.starts[n];
    for (const datasets::AxialSphere& sphere : experiment.particle.spheres) {
      tracking::sphere_outline(camera,
                               start.x + sphere.offset * std::cos(start.angle),
                               start.z + sphere.offset * std::sin(start.angle),
                               sphere.radius,
                               outline);
      std::vector<cv::Point> points;
      for (const Eigen::Vector2d& at : outline) points.emplace_back(pixel(at));
      cv::polylines(picture, points, true, particle_colour, 1, cv::LINE_AA);
    }
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

void require_first_frame(const datasets::Experiment& experiment,
                         const datasets::Replicate& replicate) {
  tracking::VideoReader(replicate.video, experiment.camera.frame_rate);
}

FirstFrame look_at_first_frame(const datasets::Experiment& experiment,
                               const datasets::Replicate& replicate,
                               const std::filesystem::path& picture_file) {
  // 1. The frame
  tracking::VideoReader reader(replicate.video, experiment.camera.frame_rate);
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
  const auto& fiducials = experiment.camera.fiducials;
  const auto sightings = tracking::find_fiducials(grey, fiducials, experiment.camera.pixel_aspect);
  frame.fiducials_found = static_cast<int>(sightings.size());
  std::optional<tracking::Calibration> calibration;
  try {
    calibration = tracking::calibrate(
        fiducials, sightings, frame.width, frame.height, experiment.camera.pixel_aspect);
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
    tracking::draw_rig(picture, calibration->camera, experiment.rig, 0.0, rig_colour, 1);
    draw_starts(picture, calibration->camera, experiment);
    draw_fiducials(picture, calibration->camera, fiducials, sightings);
  } else {
    for (const tracking::DarkDot& dot :
         tracking::find_dark_dots(grey, experiment.camera.fiducials)) {
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
