#include "tracking/drawing/overlay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>

#include "tracking/drawing/drawing.h"
#include "tracking/film/video.h"

namespace graintruth::tracking {

void draw_findings(cv::Mat& picture, const Findings& findings, std::size_t frame) {
  const Camera& camera = *findings.camera;
  const datasets::Trajectories& trajectories = *findings.trajectories;
  const double text = std::clamp(picture.cols / 1600.0, 0.35, 1.0);
  for (const FiducialSighting& dot : findings.fiducials) {
    const double radius = 0.5 * dot.diameter_px;
    cv::circle(picture,
               fixed(dot.pixel),
               static_cast<int>(radius * (1 << drawing_shift)),
               cv::Scalar(0, 165, 255),
               1,
               cv::LINE_AA,
               drawing_shift);
    cv::drawMarker(picture,
                   cv::Point(static_cast<int>(std::lround(dot.pixel.x())),
                             static_cast<int>(std::lround(dot.pixel.y()))),
                   cv::Scalar(0, 165, 255),
                   cv::MARKER_CROSS,
                   5,
                   1,
                   cv::LINE_AA);
  }
  findings.tracker->draw_frame(picture, camera, frame);
  const bool crowd = findings.tracker->is_crowd();
  const std::size_t trail = crowd ? 8 : 50;  // frames
  for (std::size_t body = 0; body < static_cast<std::size_t>(trajectories.particles); ++body) {
    const cv::Scalar& colour = particle_colours[body % particle_colours.size()];
    const std::size_t from = frame > trail ? frame - trail : 0;
    for (std::size_t k = from + 1; k <= frame; ++k) {
      const datasets::Pose& a = trajectories.poses[trajectories.index(k - 1, body)];
      const datasets::Pose& b = trajectories.poses[trajectories.index(k, body)];
      if (!std::isfinite(a.x) || !std::isfinite(b.x)) continue;
      draw_line(picture, camera.project(a.x, a.z), camera.project(b.x, b.z), colour);
    }
    const datasets::Pose& pose = trajectories.poses[trajectories.index(frame, body)];
    if (!std::isfinite(pose.x)) continue;
    findings.tracker->draw(picture, camera, {body, pose, colour});
    if (crowd) continue;
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
  std::optional<FilmWriter> film;
  if (!files.film.empty()) film.emplace(files.film, files.frame_rate);
  const std::size_t frames = findings.trajectories->frames();
  cv::Mat picture;
  for (std::size_t frame = 0; frame < frames && reader.read(picture); ++frame) {
    if (stop && stop()) return false;
    const auto is_this = [&](const OverlayFiles::Still& still) {
      return still.frame == static_cast<int>(frame) && !still.file.empty();
    };
    if (!film && std::none_of(files.stills.begin(), files.stills.end(), is_this)) continue;
    draw_findings(picture, findings, frame);
    for (const OverlayFiles::Still& still : files.stills)
      if (is_this(still)) write_still(still.file, picture);
    if (film) film->write(picture);
  }
  if (film) film->finish();
  return true;
}

}  // namespace graintruth::tracking
