#include "app/scenes/scene_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "app/scenes/scene_look.h"
#include "app/scenes/wall_patches.h"
#include "tracking/drawing/drawing.h"

namespace graintruth::app {

namespace {

using sim::Vec3;

constexpr int largest_width = 1280, largest_height = 800;  // pixels
constexpr int fine = 2;             // drawn so many times larger, then averaged
constexpr int margin = 36;          // pixels
constexpr int caption = 52;         // pixels, above the picture
constexpr double film_rate = 25.0;  // Hz
constexpr int shift = 4;            // sub-pixel drawing: coordinates in 1/16 pixel

// Blue, green, red.
const cv::Scalar paper(250, 248, 246), ink(64, 54, 46), wall_ink(112, 92, 76), belt(60, 110, 235);
const cv::Scalar glass_ink(168, 152, 138);

// From the scene to pixels: a parallel projection along `away`.
struct View : Sight {
  double scale = 1.0;                // pixels a metre
  double left_x = 0.0, top_y = 0.0;  // m, of the upper left corner
  cv::Size size;                     // pixels, with margins

  cv::Point2d pixel(const Vec3& point) const {
    return {margin * fine + (point.dot(right) - left_x) * scale,
            (margin + caption) * fine + (top_y - point.dot(up)) * scale};
  }
};

cv::Point fixed(const cv::Point2d& pixel) {
  constexpr double most = 1e5;  // far outside any picture, inside OpenCV's range
  return {cvRound(std::clamp(pixel.x, -most, most) * (1 << shift)),
          cvRound(std::clamp(pixel.y, -most, most) * (1 << shift))};
}

View make_view(const sim::Box& box, bool is_planar) {
  View view;
  if (!is_planar) static_cast<Sight&>(view) = spatial_sight();
  double low_x = 1e300, high_x = -1e300, low_y = 1e300, high_y = -1e300;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 point((corner & 1) != 0 ? box.high.x() : box.low.x(),
                     (corner & 2) != 0 ? box.high.y() : box.low.y(),
                     (corner & 4) != 0 ? box.high.z() : box.low.z());
    low_x = std::min(low_x, point.dot(view.right));
    high_x = std::max(high_x, point.dot(view.right));
    low_y = std::min(low_y, point.dot(view.up));
    high_y = std::max(high_y, point.dot(view.up));
  }
  const double width = std::max(high_x - low_x, 1e-9), height = std::max(high_y - low_y, 1e-9);
  const double scale = std::min((largest_width - 2.0 * margin) / width,
                                (largest_height - 2.0 * margin - caption) / height);
  view.scale = fine * scale;
  view.left_x = low_x;
  view.top_y = high_y;
  // Even sizes, which H.264 needs; never so narrow that the caption is cut off
  const auto even = [](double pixels) { return 2 * static_cast<int>(std::ceil(0.5 * pixels)); };
  const int across = std::max(even(width * scale + 2 * margin), 480);
  view.left_x -= 0.5 * (across - 2 * margin - width * scale) / scale;
  view.size = {across, even(height * scale + 2 * margin + caption)};
  return view;
}

void write_text(cv::Mat& picture, const std::string& text, cv::Point at, double size) {
  cv::putText(picture,
              text,
              {at.x * fine, at.y * fine},
              cv::FONT_HERSHEY_DUPLEX,
              size * fine,
              ink,
              1,
              cv::LINE_AA);
}

// The largest of 1, 2, 5 times a power of ten below a quarter of the width.
void draw_scale_bar(cv::Mat& picture, const View& view) {
  const double room = 0.25 * picture.cols / view.scale;
  double length = std::pow(10.0, std::floor(std::log10(room)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * length <= room) {
      length *= factor;
      break;
    }
  }
  const int pixels = cvRound(length * view.scale / fine);
  const cv::Point end(view.size.width - margin, 47);
  const cv::Point start(end.x - pixels, end.y);
  cv::line(picture, fine * start, fine * end, ink, 2 * fine, cv::LINE_AA);
  const std::string label = length >= 1.0    ? fmt::format("{:g} m", length)
                            : length >= 0.01 ? fmt::format("{:g} cm", 100.0 * length)
                                             : fmt::format("{:g} mm", 1000.0 * length);
  write_text(picture, label, {start.x - 12 - 9 * static_cast<int>(label.size()), 52}, 0.46);
}

// Title above, time below it and the scale bar beside.
void draw_caption(cv::Mat& picture,
                  const View& view,
                  const datasets::SceneFile& file,
                  double time) {
  double size = 0.56;
  const double room = view.size.width - 2.0 * margin;
  int baseline = 0;
  const auto width = [&] {
    return cv::getTextSize(file.title, cv::FONT_HERSHEY_DUPLEX, size, 1, &baseline).width;
  };
  while (width() > room && size > 0.3) size *= 0.95;
  write_text(picture, file.title, {margin, 28}, size);
  write_text(picture, fmt::format("{:.3f} s", time), {margin, 52}, 0.46);
  draw_scale_bar(picture, view);
}

// Of every body, for OpenCV: blue, green, red.
std::vector<cv::Scalar> inks_of_bodies(const calibrate::SceneRun& run) {
  std::vector<cv::Scalar> inks;
  for (const std::size_t colour : body_colours(run)) {
    const auto& [red, green, blue] = palette[colour];
    inks.emplace_back(blue, green, red);
  }
  return inks;
}

// Ticks that go with a surface that drags.
void draw_belt(cv::Mat& picture,
               const View& view,
               const datasets::SceneWall& wall,
               double moving_time) {
  const Vec3 &from = wall.points[0], &to = wall.points[1];
  const double length = (to - from).norm();
  const Vec3 along = (to - from) / length;
  const double spacing = 24.0 * fine / view.scale;
  const double offset = std::fmod(wall.drag.velocity.dot(along) * moving_time, spacing);
  for (double s = offset; s <= length; s += spacing) {
    if (s < 0.0) continue;
    const cv::Point2d at = view.pixel(from + s * along);
    cv::line(
        picture, fixed(at), fixed({at.x, at.y + 6.0 * fine}), belt, 2 * fine, cv::LINE_AA, shift);
  }
}

class PlanarPainter {
 public:
  PlanarPainter(const datasets::SceneFile& file,
                const calibrate::SceneRun& run,
                const sim::Box& box,
                const View& view)
      : file_(file), run_(run), box_(box), view_(view), colours_(inks_of_bodies(run)) {}

  void draw(std::size_t frame, cv::Mat& picture) const {
    const sim::State& state = run_.frames[frame].state;
    for (std::size_t i = 0; i < state.position.size(); ++i) draw_body(state, i, picture);
    for (const sim::Wall& wall : run_.walls_at(frame)) {
      for (const Patch& patch : patches_of(wall, box_)) draw_patch(patch, picture);
    }
    const double moving_time = std::max(state.time - run_.event_time, 0.0);
    for (const datasets::SceneWall& wall : file_.walls) {
      if (wall.kind != datasets::SceneWall::Kind::segment || wall.drag.velocity.isZero(0.0)) {
        continue;
      }
      draw_belt(picture, view_, wall, std::max(moving_time - wall.drag.start, 0.0));
    }
  }

 private:
  void draw_body(const sim::State& state, std::size_t i, cv::Mat& picture) const {
    const sim::Clump& clump = run_.scene.types[run_.scene.bodies[i].type];
    const auto place = [&](const sim::ElementSphere& sphere) {
      return view_.pixel(state.position[i] + state.orientation[i] * sphere.centre);
    };
    // Dark discs, then slightly smaller ones in colour: what is left is the outline of the union
    for (const bool outline : {true, false}) {
      for (const sim::ElementSphere& sphere : clump.spheres) {
        const double radius = sphere.radius * view_.scale - (outline ? 0.0 : 1.0 * fine);
        if (radius <= 0.5) continue;
        cv::circle(picture,
                   fixed(place(sphere)),
                   cvRound(radius * (1 << shift)),
                   outline ? ink : colours_[i],
                   cv::FILLED,
                   cv::LINE_AA,
                   shift);
      }
    }
    draw_mark(state, i, clump, picture);
  }

  // A line along the body's x axis from its centre, which shows how it has turned.
  void draw_mark(const sim::State& state,
                 std::size_t i,
                 const sim::Clump& clump,
                 cv::Mat& picture) const {
    const Vec3 end =
        state.position[i] + state.orientation[i] * Vec3(0.7 * clump.bounding_radius, 0.0, 0.0);
    cv::line(picture,
             fixed(view_.pixel(state.position[i])),
             fixed(view_.pixel(end)),
             ink,
             fine,
             cv::LINE_AA,
             shift);
    cv::circle(picture,
               fixed(view_.pixel(state.position[i])),
               static_cast<int>(1.6 * fine * (1 << shift)),
               ink,
               cv::FILLED,
               cv::LINE_AA,
               shift);
  }

  void draw_patch(const Patch& patch, cv::Mat& picture) const {
    std::vector<cv::Point> points;
    for (const Vec3& corner : patch) points.push_back(fixed(view_.pixel(corner)));
    cv::polylines(picture, points, true, wall_ink, 3 * fine, cv::LINE_AA, shift);
  }

  const datasets::SceneFile& file_;
  const calibrate::SceneRun& run_;
  const sim::Box& box_;
  const View& view_;
  std::vector<cv::Scalar> colours_;
};

// Spheres by depth, lit from the upper left, with dark edges where one particle ends.
class SpatialPainter {
 public:
  SpatialPainter(const datasets::SceneFile& file,
                 const calibrate::SceneRun& run,
                 const sim::Box& box,
                 const View& view)
      : file_(file), run_(run), box_(box), view_(view), colours_(inks_of_bodies(run)) {}

  void draw(std::size_t frame, cv::Mat& picture) {
    const sim::State& state = run_.frames[frame].state;
    draw_walls(frame, true, picture);
    depth_.create(picture.size(), CV_32F);
    depth_.setTo(1e30f);
    body_.create(picture.size(), CV_32S);
    body_.setTo(-1);
    for (std::size_t i = 0; i < state.position.size(); ++i) {
      const sim::Clump& clump = run_.scene.types[run_.scene.bodies[i].type];
      for (const sim::ElementSphere& sphere : clump.spheres) {
        splat(state.position[i] + state.orientation[i] * sphere.centre,
              sphere.radius,
              static_cast<int>(i),
              picture);
      }
    }
    draw_edges(picture);
    draw_walls(frame, false, picture);
  }

 private:
  // Mean place of a mesh or cylinder along the view, m; of any other wall that of the whole scene.
  std::vector<double> middles(const std::vector<sim::Wall>& walls, double of_scene) const {
    std::vector<double> sums(file_.walls.size(), 0.0), counts(file_.walls.size(), 0.0);
    for (std::size_t w = 0; w < walls.size(); ++w) {
      const std::vector<Patch> patches = patches_of(walls[w], box_);
      if (walls[w].shape != sim::Wall::Shape::cylinder &&
          file_.walls[run_.owner[w]].kind != datasets::SceneWall::Kind::mesh) {
        continue;
      }
      for (const Patch& patch : patches) {
        sums[run_.owner[w]] += middle_of(patch).dot(view_.away);
        counts[run_.owner[w]] += 1.0;
      }
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
      sums[i] = counts[i] > 0.0 ? sums[i] / counts[i] : of_scene;
    }
    return sums;
  }

  static Vec3 middle_of(const Patch& patch) {
    Vec3 middle = Vec3::Zero();
    for (const Vec3& corner : patch) middle += corner / static_cast<double>(patch.size());
    return middle;
  }

  // Walls behind the middle, and those that lie flat, are filled; the others are thin lines in
  // front.
  void draw_walls(std::size_t frame, bool behind, cv::Mat& picture) const {
    const std::vector<sim::Wall>& walls = run_.walls_at(frame);
    const std::vector<double> middle = middles(walls, 0.5 * (box_.low + box_.high).dot(view_.away));
    std::vector<std::pair<double, Patch>> patches;
    for (std::size_t w = 0; w < walls.size(); ++w) {
      for (Patch& patch : patches_of(walls[w], box_)) {
        const Vec3 normal = (patch[1] - patch[0]).cross(patch[2] - patch[0]).normalized();
        const bool is_floor = std::abs(normal.z()) > 0.95;
        const double away = middle_of(patch).dot(view_.away);
        if ((is_floor || away >= middle[run_.owner[w]]) == behind) {
          patches.emplace_back(away, std::move(patch));
        }
      }
    }
    std::sort(patches.begin(), patches.end(), [](const auto& a, const auto& b) {
      return a.first > b.first;
    });
    for (const auto& [away, patch] : patches) draw_patch(patch, behind, picture);
  }

  void draw_patch(const Patch& patch, bool is_filled, cv::Mat& picture) const {
    std::vector<cv::Point> points, whole;
    for (const Vec3& corner : patch) {
      points.push_back(fixed(view_.pixel(corner)));
      whole.emplace_back(points.back().x >> shift, points.back().y >> shift);
    }
    if (!is_filled) {
      cv::polylines(picture, points, true, glass_ink, 1, cv::LINE_AA, shift);
      return;
    }
    const cv::Rect area = cv::boundingRect(whole) & cv::Rect({0, 0}, picture.size());
    if (area.empty()) return;
    const Vec3 normal = (patch[1] - patch[0]).cross(patch[2] - patch[0]).normalized();
    const double light = 205.0 + 30.0 * std::abs(normal.dot(light_));
    cv::Mat under = picture(area).clone();
    cv::fillConvexPoly(
        picture, points, cv::Scalar(light, light - 4, light - 10), cv::LINE_AA, shift);
    cv::addWeighted(picture(area), 0.75, under, 0.25, 0.0, picture(area));
    cv::polylines(picture, points, true, cv::Scalar(176, 164, 152), 1, cv::LINE_AA, shift);
  }

  void splat(const Vec3& centre, double radius, int body, cv::Mat& picture) {
    const cv::Point2d middle = view_.pixel(centre);
    const double pixels = radius * view_.scale;
    const int x0 = std::max(static_cast<int>(middle.x - pixels), 0);
    const int x1 = std::min(static_cast<int>(middle.x + pixels) + 1, picture.cols - 1);
    const int y0 = std::max(static_cast<int>(middle.y - pixels), 0);
    const int y1 = std::min(static_cast<int>(middle.y + pixels) + 1, picture.rows - 1);
    const double away = centre.dot(view_.away);
    const cv::Scalar& colour = colours_[body];
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const double dx = (x - middle.x) / pixels, dy = (middle.y - y) / pixels;
        const double rest = 1.0 - dx * dx - dy * dy;
        if (rest <= 0.0) continue;
        const double out = std::sqrt(rest);
        const float depth = static_cast<float>(away - radius * out);
        if (depth >= depth_.at<float>(y, x)) continue;
        depth_.at<float>(y, x) = depth;
        body_.at<int>(y, x) = body;
        const Vec3 normal = dx * view_.right + dy * view_.up - out * view_.away;
        const double lit = 0.42 + 0.62 * std::max(normal.dot(light_), 0.0);
        const double glint = 70.0 * std::pow(std::max(normal.dot(half_), 0.0), 40.0);
        cv::Vec3b& pixel = picture.at<cv::Vec3b>(y, x);
        for (int c = 0; c < 3; ++c) {
          pixel[c] = cv::saturate_cast<uchar>(colour[c] * lit + glint);
        }
      }
    }
  }

  void draw_edges(cv::Mat& picture) const {
    for (int y = 1; y < body_.rows; ++y) {
      for (int x = 1; x < body_.cols; ++x) {
        const int here = body_.at<int>(y, x);
        if (here == body_.at<int>(y, x - 1) && here == body_.at<int>(y - 1, x)) continue;
        cv::Vec3b& pixel = picture.at<cv::Vec3b>(y, x);
        for (int c = 0; c < 3; ++c) pixel[c] = static_cast<uchar>(0.4 * pixel[c] + 0.6 * ink[c]);
      }
    }
  }

  const datasets::SceneFile& file_;
  const calibrate::SceneRun& run_;
  const sim::Box& box_;
  const View& view_;
  std::vector<cv::Scalar> colours_;
  const Vec3 light_ = Vec3(-0.45, -0.55, 0.7).normalized();
  const Vec3 half_ = (Vec3(-0.45, -0.55, 0.7).normalized() - view_.away).normalized();
  cv::Mat depth_, body_;
};

}  // namespace

void render_scene(const std::filesystem::path& folder,
                  const datasets::SceneFile& file,
                  const calibrate::SceneRun& run,
                  const std::function<void(double)>& progress) {
  if (run.frames.empty()) return;
  const sim::Box box = scene_box(run);
  const View view = make_view(box, file.is_planar);
  const PlanarPainter planar(file, run, box, view);
  SpatialPainter spatial(file, run, box, view);
  std::unique_ptr<tracking::FilmWriter> film;
  if (run.frames.size() > 1)
    film = std::make_unique<tracking::FilmWriter>(folder / "simulation.mp4", film_rate);
  cv::Mat large(view.size * fine, CV_8UC3), picture;
  for (std::size_t f = 0; f < run.frames.size(); ++f) {
    large.setTo(paper);
    if (file.is_planar) {
      planar.draw(f, large);
    } else {
      spatial.draw(f, large);
    }
    draw_caption(large, view, file, run.frames[f].state.time - run.event_time);
    cv::resize(large, picture, view.size, 0.0, 0.0, cv::INTER_AREA);
    if (film) film->write(picture);
    progress(static_cast<double>(f + 1) / static_cast<double>(run.frames.size()));
  }
  if (film) film->finish();
  tracking::write_still(folder / "simulation.png", picture);
}

}  // namespace graintruth::app
