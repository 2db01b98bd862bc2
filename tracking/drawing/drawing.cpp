#include "tracking/drawing/drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <system_error>

#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"

namespace graintruth::tracking {

using datasets::InputError;

namespace {

const cv::Scalar ink(30, 28, 26);

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

void draw_line(cv::Mat& picture,
               const Eigen::Vector2d& from,
               const Eigen::Vector2d& to,
               const cv::Scalar& colour,
               int thickness) {
  cv::line(picture, fixed(from), fixed(to), colour, thickness, cv::LINE_AA, drawing_shift);
}

void fill_outline(cv::Mat& picture,
                  const std::vector<Eigen::Vector2d>& outline,
                  const cv::Scalar& colour) {
  std::vector<cv::Point> points;
  for (const Eigen::Vector2d& at : outline) points.push_back(fixed(at));
  cv::fillPoly(picture, std::vector{points}, 0.75 * colour, cv::LINE_AA, drawing_shift);
  cv::polylines(picture, points, true, ink, 1, cv::LINE_AA, drawing_shift);
}

void draw_outline(cv::Mat& picture,
                  const std::vector<Eigen::Vector2d>& outline,
                  const DrawnBody& body) {
  if (body.filled) {
    fill_outline(picture, outline, body.colour);
    return;
  }
  for (std::size_t k = 0; k < outline.size(); ++k)
    draw_line(picture, outline[k], outline[(k + 1) % outline.size()], body.colour);
}

void draw_axis(cv::Mat& picture,
               const Eigen::Vector2d& from,
               const Eigen::Vector2d& to,
               const DrawnBody& body) {
  draw_line(picture, from, to, body.filled ? ink : body.colour, body.filled ? 2 : 1);
}

void draw_rig(cv::Mat& picture,
              const Camera& camera,
              const datasets::SeenRig& rig,
              double time,
              const cv::Scalar& colour,
              int thickness) {
  const auto draw = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    constexpr int pieces = 24;  // a lens bends straight lines
    for (int i = 0; i < pieces; ++i) {
      const Eigen::Vector2d a = from + (to - from) * i / pieces;
      const Eigen::Vector2d b = from + (to - from) * (i + 1) / pieces;
      draw_line(
          picture, camera.project(a.x(), a.y()), camera.project(b.x(), b.y()), colour, thickness);
    }
  };
  for (const datasets::Wall& wall : rig.walls)
    draw({wall.from_x, wall.from_z}, {wall.to_x, wall.to_z});
  if (const auto& face = rig.face) {
    const double height = face->face_z + face->velocity_z * std::max(0.0, time);
    draw({face->left_x, height}, {face->right_x, height});
  }
  if (!rig.outline) return;
  const datasets::SeenOutline& bed = *rig.outline;
  if (bed.mover) {
    const Eigen::Vector2d moved = bed.mover->velocity * std::max(0.0, time);
    const datasets::SeenOutline::Polygon& corners = bed.mover->drawing;
    for (std::size_t k = 0; k < corners.size(); ++k)
      draw(corners[k] + moved, corners[(k + 1) % corners.size()] + moved);
  }
  if (!bed.drum) {
    draw({bed.from_x, bed.floor_z}, {bed.to_x, bed.floor_z});
    return;
  }
  constexpr int sides = 12;  // each of many pieces
  const auto on_shell = [&](int side) -> Eigen::Vector2d {
    const double angle = 2.0 * std::numbers::pi * side / sides;
    return bed.drum->centre + bed.drum->radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  };
  for (int side = 0; side < sides; ++side) draw(on_shell(side), on_shell(side + 1));
}

void draw_surface(cv::Mat& picture,
                  const Camera& camera,
                  const datasets::Outline& outline,
                  std::size_t moment,
                  const cv::Scalar& colour,
                  int thickness) {
  const double half = 0.5 * (outline.column[1] - outline.column[0]);
  for (std::size_t k = 0; k < outline.column.size(); ++k) {
    const double x = outline.column[k], z = outline.height[outline.index(moment, k)];
    if (!std::isfinite(z)) continue;
    draw_line(picture, camera.project(x - half, z), camera.project(x + half, z), colour, thickness);
  }
}

void fill_bed(cv::Mat& picture,
              const Camera& camera,
              const datasets::Outline& outline,
              std::size_t moment,
              const datasets::SeenOutline& rig,
              const cv::Scalar& colour) {
  const double half = 0.5 * (outline.column[1] - outline.column[0]);
  const auto surface = datasets::surface_named(rig, outline.surface);
  const auto lowest = [&](double x) {
    if (!rig.drum) return surface ? surface->floor_z : rig.floor_z;
    const double aside = std::min(std::abs(x - rig.drum->centre.x()), rig.drum->radius);
    return rig.drum->centre.y() - std::sqrt(rig.drum->radius * rig.drum->radius - aside * aside);
  };
  for (std::size_t k = 0; k < outline.column.size(); ++k) {
    const double z = outline.height[outline.index(moment, k)];
    if (!std::isfinite(z)) continue;
    const double left = outline.column[k] - half, right = outline.column[k] + half;
    std::vector<cv::Point> corners;
    for (const auto& [x, height] : {std::pair(left, std::min(z, lowest(left))),
                                    {right, std::min(z, lowest(right))},
                                    {right, z},
                                    {left, z}})
      corners.push_back(fixed(camera.project(x, height)));
    cv::fillConvexPoly(picture, corners, colour, cv::LINE_8, drawing_shift);
  }
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
  std::vector<int> options;
  if (file.extension() == ".jpg") options = {cv::IMWRITE_JPEG_QUALITY, quality};
  std::vector<unsigned char> bytes;
  bool is_encoded = false;
  try {
    is_encoded = cv::imencode(file.extension().string(), picture, bytes, options);
  } catch (const cv::Exception&) {
    is_encoded = false;
  }
  if (!is_encoded)
    throw InputError(fmt::format("{}: the picture cannot be written", file.string()));
  datasets::write_whole(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
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
  ++written_;
}

void FilmWriter::finish() {
  if (!writer_.isOpened()) return;
  writer_.release();
  // The encoder does not tell of a full disk
  const std::filesystem::path made = unfinished(file_);
  cv::VideoCapture film(made.string(), cv::CAP_FFMPEG);
  if (!film.isOpened() || film.get(cv::CAP_PROP_FRAME_COUNT) < written_) {
    film.release();
    std::error_code ignored;
    std::filesystem::remove(made, ignored);
    throw InputError(
        fmt::format("{}: the film cannot be written whole; make room on the disk, or choose "
                    "another folder with --out",
                    file_.string()));
  }
  publish(made, file_);
}

}  // namespace graintruth::tracking
