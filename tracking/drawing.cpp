#include "tracking/drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <system_error>

#include "datasets/input_error.h"

namespace graintruth::tracking {

using datasets::InputError;

namespace {

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

}  // namespace

const std::array<cv::Scalar, 6> particle_colours = {cv::Scalar(80, 255, 80),
                                                    cv::Scalar(255, 200, 60),
                                                    cv::Scalar(60, 220, 255),
                                                    cv::Scalar(255, 90, 255),
                                                    cv::Scalar(90, 130, 255),
                                                    cv::Scalar(255, 255, 120)};

cv::Point fixed(const Eigen::Vector2d& pixel) {
  return {static_cast<int>(std::lround(pixel.x() * (1 << drawing_shift))),
          static_cast<int>(std::lround(pixel.y() * (1 << drawing_shift)))};
}

void draw_rig(cv::Mat& picture,
              const Camera& camera,
              const datasets::Rig& rig,
              double time,
              const cv::Scalar& colour,
              int thickness) {
  const auto draw = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    constexpr int pieces = 24;  // a lens bends straight lines
    for (int i = 0; i < pieces; ++i) {
      const Eigen::Vector2d a = from + (to - from) * i / pieces;
      const Eigen::Vector2d b = from + (to - from) * (i + 1) / pieces;
      cv::line(picture,
               fixed(camera.project(a.x(), a.y())),
               fixed(camera.project(b.x(), b.y())),
               colour,
               thickness,
               cv::LINE_AA,
               drawing_shift);
    }
  };
  for (const datasets::Wall& wall : rig.walls)
    draw({wall.from_x, wall.from_z}, {wall.to_x, wall.to_z});
  if (const auto& piston = rig.moving_face) {
    const double face = piston->face_z + piston->velocity_z * std::max(0.0, time);
    draw({piston->left_x, face}, {piston->right_x, face});
  }
}

std::vector<Eigen::Vector2d> plate_outline(const Camera& camera,
                                           const datasets::Pose& pose,
                                           const PlateShape& shape) {
  constexpr int points = 40;
  const double angle = std::isfinite(pose.angle) ? pose.angle : 0.0;
  const double c = std::cos(angle), s = std::sin(angle);
  std::vector<Eigen::Vector2d> outline;
  for (int k = 0; k < points; ++k) {
    const double around = 2.0 * std::numbers::pi * k / points;
    const double u = shape.semi_major * std::cos(around), v = shape.semi_minor * std::sin(around);
    outline.push_back(camera.project(pose.x + c * u - s * v, pose.z + s * u + c * v));
  }
  return outline;
}

void write_text(cv::Mat& picture,
                const std::string& text,
                const cv::Point& at,
                double size,
                const cv::Scalar& colour) {
  cv::putText(
      picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, cv::Scalar(0, 0, 0), 3, cv::LINE_AA);
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, colour, 1, cv::LINE_AA);
}

void write_still(const std::filesystem::path& file, const cv::Mat& picture, int quality) {
  const std::filesystem::path temporary = unfinished(file);
  bool written = false;
  try {
    written = cv::imwrite(temporary.string(), picture, {cv::IMWRITE_JPEG_QUALITY, quality});
  } catch (const cv::Exception&) {
    written = false;
  }
  if (!written) throw InputError(fmt::format("{}: the picture cannot be written", file.string()));
  publish(temporary, file);
}

FilmWriter::FilmWriter(std::filesystem::path file, double frame_rate)
    : file_(std::move(file)), frame_rate_(frame_rate) {}

FilmWriter::~FilmWriter() {
  if (!writer_.isOpened()) return;
  writer_.release();
  std::error_code ignored;
  std::filesystem::remove(unfinished(file_), ignored);
}

void FilmWriter::write(const cv::Mat& picture) {
  // H.264 needs even sizes; OpenCV would cut silently.
  const cv::Mat even = picture(cv::Rect(0, 0, picture.cols & ~1, picture.rows & ~1));
  if (!writer_.isOpened() && !writer_.open(unfinished(file_).string(),
                                           cv::CAP_FFMPEG,
                                           cv::VideoWriter::fourcc('a', 'v', 'c', '1'),
                                           frame_rate_,
                                           even.size())) {
    throw InputError(fmt::format("{}: the film cannot be written (no H.264 encoder, or no room)",
                                 file_.string()));
  }
  writer_.write(even);
}

void FilmWriter::finish() {
  if (!writer_.isOpened()) return;
  writer_.release();
  publish(unfinished(file_), file_);
}

}  // namespace graintruth::tracking
