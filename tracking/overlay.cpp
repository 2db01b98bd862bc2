#include "tracking/overlay.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <system_error>

#include "datasets/input_error.h"
#include "tracking/video.h"

namespace graintruth::tracking {

using datasets::InputError;

namespace {

// Sub-pixel drawing: OpenCV takes coordinates in 1/16 pixel.
constexpr int shift = 4;
cv::Point fixed(const Eigen::Vector2d& pixel) {
  return {static_cast<int>(std::lround(pixel.x() * (1 << shift))),
          static_cast<int>(std::lround(pixel.y() * (1 << shift)))};
}

// Bright and apart from one another; particles take them in turn.
const std::array<cv::Scalar, 6> colours = {cv::Scalar(80, 255, 80),
                                           cv::Scalar(255, 200, 60),
                                           cv::Scalar(60, 220, 255),
                                           cv::Scalar(255, 90, 255),
                                           cv::Scalar(90, 130, 255),
                                           cv::Scalar(255, 255, 120)};

void write_text(cv::Mat& picture,
                const std::string& text,
                const cv::Point& at,
                double size,
                const cv::Scalar& colour) {
  cv::putText(
      picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, cv::Scalar(0, 0, 0), 3, cv::LINE_AA);
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, colour, 1, cv::LINE_AA);
}

// Outline and long axis; numbers would hide plates as small as buttons.
void draw_plate(cv::Mat& picture,
                const Camera& camera,
                const datasets::Pose& pose,
                const PlateShape& shape,
                const cv::Scalar& colour) {
  constexpr int points = 40;
  const bool turned = std::isfinite(pose.angle);
  const double c = turned ? std::cos(pose.angle) : 1.0, s = turned ? std::sin(pose.angle) : 0.0;
  const auto at = [&](double u, double v) {
    return fixed(camera.project(pose.x + c * u - s * v, pose.z + s * u + c * v));
  };
  std::vector<cv::Point> outline;
  for (int k = 0; k < points; ++k) {
    const double angle = 2.0 * 3.14159265358979 * k / points;
    outline.push_back(at(shape.semi_major * std::cos(angle), shape.semi_minor * std::sin(angle)));
  }
  cv::polylines(picture, outline, true, colour, 1, cv::LINE_AA, shift);
  if (!turned) return;
  cv::line(picture,
           at(-0.5 * shape.semi_major, 0.0),
           at(0.5 * shape.semi_major, 0.0),
           colour,
           1,
           cv::LINE_AA,
           shift);
}

// A name in the same folder that keeps the ending, by which OpenCV chooses the format.
std::filesystem::path unfinished(const std::filesystem::path& file) {
  std::filesystem::path result = file;
  result.replace_filename(file.stem().string() + ".unfinished" + file.extension().string());
  return result;
}

void publish(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::error_code error;
  std::filesystem::rename(from, to, error);
  if (error)
    throw InputError(fmt::format("{}: cannot be written: {}", to.string(), error.message()));
}

void write_still(const std::filesystem::path& file, const cv::Mat& picture) {
  const std::filesystem::path temporary = unfinished(file);
  bool written = false;
  try {
    written = cv::imwrite(temporary.string(), picture, {cv::IMWRITE_JPEG_QUALITY, 90});
  } catch (const cv::Exception&) {
    written = false;
  }
  if (!written) throw InputError(fmt::format("{}: the picture cannot be written", file.string()));
  publish(temporary, file);
}

}  // namespace

void draw_findings(cv::Mat& picture, const Findings& findings, std::size_t frame) {
  const Camera& camera = *findings.camera;
  const datasets::Trajectories& trajectories = *findings.trajectories;
  const double text = std::clamp(picture.cols / 1600.0, 0.35, 1.0);
  for (const FiducialSighting& dot : findings.fiducials) {
    const double radius = 0.5 * dot.diameter_px;
    cv::circle(picture,
               fixed(dot.pixel),
               static_cast<int>(radius * (1 << shift)),
               cv::Scalar(0, 165, 255),
               1,
               cv::LINE_AA,
               shift);
    cv::drawMarker(picture,
                   cv::Point(static_cast<int>(std::lround(dot.pixel.x())),
                             static_cast<int>(std::lround(dot.pixel.y()))),
                   cv::Scalar(0, 165, 255),
                   cv::MARKER_CROSS,
                   5,
                   1,
                   cv::LINE_AA);
  }
  const std::size_t trail = findings.plate ? 8 : 50;  // frames; many plates would hide each other
  std::vector<Eigen::Vector2d> outline(72);
  for (std::size_t body = 0; body < static_cast<std::size_t>(trajectories.particles); ++body) {
    const cv::Scalar& colour = colours[body % colours.size()];
    const std::size_t from = frame > trail ? frame - trail : 0;
    for (std::size_t k = from + 1; k <= frame; ++k) {
      const datasets::Pose& a = trajectories.poses[trajectories.index(k - 1, body)];
      const datasets::Pose& b = trajectories.poses[trajectories.index(k, body)];
      if (!std::isfinite(a.x) || !std::isfinite(b.x)) continue;
      cv::line(picture,
               fixed(camera.project(a.x, a.z)),
               fixed(camera.project(b.x, b.z)),
               colour,
               1,
               cv::LINE_AA,
               shift);
    }
    const datasets::Pose& pose = trajectories.poses[trajectories.index(frame, body)];
    if (!std::isfinite(pose.x)) continue;
    if (findings.plate) {
      draw_plate(picture, camera, pose, *findings.plate, colour);
      continue;
    }
    const BodyShape& shape = findings.shapes[body];
    const auto centres =
        ball_centres({pose.x, pose.z, shape.shows_angle() ? pose.angle : 0.0}, shape);
    for (std::size_t ball = 0; ball < shape.balls; ++ball) {
      sphere_outline(camera, centres[ball].x(), centres[ball].y(), shape.radius[ball], outline);
      for (std::size_t k = 0; k < outline.size(); ++k) {
        const double angle = 2.0 * 3.14159265358979 * (static_cast<double>(k) + 0.5) /
                             static_cast<double>(outline.size());
        const Eigen::Vector2d point =
            centres[ball] + shape.radius[ball] * Eigen::Vector2d(std::cos(angle), std::sin(angle));
        if (shape.balls == 2 && (point - centres[1 - ball]).norm() < shape.radius[1 - ball])
          continue;
        cv::line(picture,
                 fixed(outline[k]),
                 fixed(outline[(k + 1) % outline.size()]),
                 colour,
                 1,
                 cv::LINE_AA,
                 shift);
      }
    }
    if (shape.shows_angle()) {
      cv::line(picture,
               fixed(camera.project(centres[0].x(), centres[0].y())),
               fixed(camera.project(centres[1].x(), centres[1].y())),
               colour,
               1,
               cv::LINE_AA,
               shift);
    }
    const Eigen::Vector2d middle = camera.project(pose.x, pose.z);
    write_text(picture,
               std::to_string(body + 1),
               cv::Point(static_cast<int>(middle.x()) + 3, static_cast<int>(middle.y()) - 3),
               1.2 * text,
               colour);
  }
  write_text(picture,
             fmt::format("frame {}   {:+.3f} s", frame, trajectories.time[frame]),
             cv::Point(8, static_cast<int>(8 + 30 * text)),
             1.2 * text,
             cv::Scalar(255, 255, 255));
}

bool draw_overlay(const std::filesystem::path& video,
                  const Findings& findings,
                  const OverlayFiles& files,
                  const std::function<bool()>& stop) {
  const bool wants_stills =
      std::any_of(files.stills.begin(), files.stills.end(), [](const OverlayFiles::Still& still) {
        return still.frame >= 0 && !still.file.empty();
      });
  if (files.film.empty() && !wants_stills) return true;
  VideoReader reader(video, files.frame_rate);
  reader.hold_steady(findings.fiducials);
  cv::VideoWriter writer;
  const std::filesystem::path temporary = unfinished(files.film);
  const std::size_t frames = findings.trajectories->frames();
  cv::Mat picture;
  for (std::size_t frame = 0; frame < frames && reader.read(picture); ++frame) {
    if (stop && stop()) {
      writer.release();
      std::error_code ignored;
      if (!files.film.empty()) std::filesystem::remove(temporary, ignored);
      return false;
    }
    const auto is_this = [&](const OverlayFiles::Still& still) {
      return still.frame == static_cast<int>(frame) && !still.file.empty();
    };
    if (files.film.empty() && std::none_of(files.stills.begin(), files.stills.end(), is_this))
      continue;
    draw_findings(picture, findings, frame);
    for (const OverlayFiles::Still& still : files.stills)
      if (is_this(still)) write_still(still.file, picture);
    if (files.film.empty()) continue;
    // H.264 needs even sizes; OpenCV would cut silently.
    const cv::Mat even = picture(cv::Rect(0, 0, picture.cols & ~1, picture.rows & ~1));
    if (!writer.isOpened() && !writer.open(temporary.string(),
                                           cv::CAP_FFMPEG,
                                           cv::VideoWriter::fourcc('a', 'v', 'c', '1'),
                                           files.frame_rate,
                                           even.size())) {
      throw InputError(
          fmt::format("{}: the overlay film cannot be written (no H.264 encoder, or no room)",
                      files.film.string()));
    }
    writer.write(even);
  }
  if (writer.isOpened()) {
    writer.release();
    publish(temporary, files.film);
  }
  return true;
}

}  // namespace graintruth::tracking
