#include "app/run/first_frame.h"

#include <fmt/format.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"
#include "tracking/drawing/drawing.h"
#include "tracking/film/recording.h"
#include "tracking/film/video.h"
#include "tracking/registry.h"
#include "tracking/view/mask.h"
#include "tracking/view/scale.h"

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

void draw_ring(cv::Mat& picture,
               const Eigen::Vector2d& centre,
               double radius,
               const cv::Scalar& colour,
               int thickness) {
  cv::circle(picture,
             pixel(centre),
             static_cast<int>(std::lround(radius)) + 3,
             colour,
             thickness,
             cv::LINE_AA);
}

// A cross where it was seen, a ring where the camera says it is.
void draw_reference(cv::Mat& picture,
                    const tracking::Camera& camera,
                    const tracking::CameraReference& one) {
  cv::drawMarker(picture, pixel(one.pixel), found_colour, cv::MARKER_CROSS, 14, 1, cv::LINE_AA);
  draw_ring(picture,
            camera.project(one.x, one.z),
            0.5 * one.diameter * camera.scale(one.x, one.z),
            found_colour,
            1);
}

void draw_missed(cv::Mat& picture,
                 const tracking::Camera& camera,
                 const std::vector<datasets::Fiducial>& fiducials,
                 const std::vector<tracking::FiducialSighting>& sightings) {
  std::vector<bool> found(fiducials.size(), false);
  for (const tracking::FiducialSighting& sighting : sightings)
    found[static_cast<std::size_t>(sighting.fiducial)] = true;
  for (std::size_t i = 0; i < fiducials.size(); ++i) {
    const datasets::Fiducial& dot = fiducials[i];
    if (found[i]) continue;
    draw_ring(picture,
              camera.project(dot.x, dot.z),
              0.5 * dot.diameter * camera.scale(dot.x, dot.z),
              missed_colour,
              2);
  }
}

std::vector<tracking::DarkDot> dark_dots(const cv::Mat& picture,
                                         const std::vector<datasets::Fiducial>& fiducials) {
  if (fiducials.empty()) return {};
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  return tracking::find_dark_dots(grey, fiducials);
}

void write_picture(const std::filesystem::path& file, const cv::Mat& picture) {
  datasets::make_folder(file.parent_path());
  tracking::write_still(file, picture);
}

}  // namespace

void require_first_frame(const datasets::TrackingSpec& spec, const datasets::Film& film) {
  const tracking::VideoReader reader(film.video, spec.camera.frame_rate);
  tracking::require_motion(spec, film, reader.declared_frames());
}

FirstFrame look_at_first_frame(const datasets::TrackingSpec& spec,
                               const datasets::Film& film,
                               const std::filesystem::path& picture_file) {
  // 1. The frame
  tracking::VideoReader reader(film.video, spec.camera.frame_rate);
  cv::Mat picture;
  reader.read(picture);
  tracking::Mask(spec.camera).cover(picture);
  FirstFrame frame{.width = reader.width(), .height = reader.height()};

  // 2. The camera
  const tracking::SeenScale seen = tracking::look_for_scale(spec.camera, picture, film);
  frame.scale_from = seen.name;
  frame.given = seen.given;
  frame.found = seen.found;
  std::optional<tracking::Calibration> calibration;
  try {
    calibration = tracking::calibrate(seen, spec.camera, picture.size(), film);
  } catch (const datasets::InputError& error) {
    frame.complaint = error.what();
  }

  // 3. What the experiment file says, drawn over it
  picture = picture.clone();
  if (calibration) {
    const tracking::Camera& camera = calibration->camera;
    frame.residual = calibration->rms;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (const tracking::CameraReference& one : seen.references)
      middle += Eigen::Vector2d(one.x, one.z) / static_cast<double>(seen.references.size());
    frame.scale = camera.scale(middle.x(), middle.y());
    tracking::draw_rig(picture, camera, spec.rig, 0.0, rig_colour, 1);
    draw_starts(picture, camera, *tracking::make_tracker(spec, film), spec.starts);
    for (const tracking::CameraReference& one : seen.references)
      draw_reference(picture, camera, one);
    draw_missed(picture, camera, spec.camera.fiducials, seen.sightings);
  } else {
    for (const tracking::DarkDot& dot : dark_dots(picture, spec.camera.fiducials))
      draw_ring(picture, dot.centre, 0.5 * dot.diameter, missed_colour, 1);
  }
  write_picture(picture_file, picture);

  // 4. The film to its end, as whoever tracks it will read it
  while (reader.read(picture)) {
  }
  tracking::require_motion(spec, film, reader.frames_read());
  frame.frames = reader.frames_read();
  frame.length = (reader.moment() + 1.0) / spec.camera.frame_rate;
  frame.warnings = reader.warnings();
  return frame;
}

}  // namespace graintruth::app
