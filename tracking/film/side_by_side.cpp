#include "tracking/film/side_by_side.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tracking/drawing/drawing.h"
#include "tracking/drawing/overlay.h"
#include "tracking/film/video.h"
#include "tracking/registry.h"
#include "tracking/view/film_camera.h"
#include "tracking/view/mask.h"

namespace graintruth::tracking {

namespace {

constexpr double film_rate = 25.0;  // Hz, at most
constexpr int widest = 1280;        // px, of both pictures together
constexpr int widest_still = 960;   // px; the report holds some twenty of them
constexpr int still_quality = 75;   // of JPEG
const cv::Scalar ground(70, 66, 64), bar(190, 190, 188), dot(120, 116, 114);

void draw_fiducials(cv::Mat& picture,
                    const Camera& camera,
                    const std::vector<datasets::Fiducial>& fiducials) {
  for (const datasets::Fiducial& fiducial : fiducials) {
    cv::circle(picture,
               fixed(camera.project(fiducial.x, fiducial.z)),
               static_cast<int>(0.5 * fiducial.diameter * camera.scale(fiducial.x, fiducial.z) *
                                (1 << drawing_shift)),
               dot,
               cv::FILLED,
               cv::LINE_AA,
               drawing_shift);
  }
}

// The simulation at one frame of `poses`, whose times count from the start event.
cv::Mat draw_simulation(const Camera& camera,
                        const datasets::TrackingSpec& spec,
                        const ParticleTracker& tracker,
                        const datasets::Trajectories& poses,
                        std::size_t frame) {
  cv::Mat picture(camera.height(), camera.width(), CV_8UC3, ground);
  draw_fiducials(picture, camera, spec.camera.fiducials);
  draw_rig(picture, camera, spec.rig, poses.time[frame], bar, 2);
  const double text = 1.2 * std::clamp(picture.cols / 1600.0, 0.35, 1.0);
  for (std::size_t body = 0; body < static_cast<std::size_t>(poses.particles); ++body) {
    const datasets::Pose& pose = poses.poses[poses.index(frame, body)];
    if (!std::isfinite(pose.x) || !std::isfinite(pose.z)) continue;
    const cv::Scalar& colour = particle_colours[body % particle_colours.size()];
    tracker.draw(picture, camera, {body, pose, colour, true});
    if (tracker.is_crowd()) continue;
    const Eigen::Vector2d middle = camera.project(pose.x, pose.z);
    write_text(picture,
               std::to_string(body + 1),
               cv::Point(static_cast<int>(middle.x()) + 3, static_cast<int>(middle.y()) - 3),
               text,
               colour);
  }
  const double milliseconds = std::round(1e3 * poses.time[frame]) + 0.0;  // no -0
  write_text(picture,
             fmt::format("simulation   {:+.3f} s", 1e-3 * milliseconds),
             cv::Point(8, static_cast<int>(8 + 25 * text)),
             text,
             cv::Scalar(255, 255, 255));
  return picture;
}

// Pictures of the film that are drawn, by their numbers: from time 0 on.
std::vector<std::size_t> chosen_frames(const FilmAndSimulation& both) {
  const double last = both.simulated.time.back();
  const double rate = both.recorded.camera.frame_rate;
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::round(rate / film_rate)));
  std::vector<std::size_t> frames;
  std::size_t first = 0;
  while (first < both.filmed.frames() && both.filmed.time[first] < -0.5 / rate) ++first;
  for (std::size_t frame = first;
       frame < both.filmed.frames() && both.filmed.time[frame] < last + 0.5 / rate;
       frame += stride)
    frames.push_back(frame);
  return frames;
}

cv::Mat at_most(int width, const cv::Mat& picture) {
  if (picture.cols <= width) return picture;
  const double share = static_cast<double>(width) / picture.cols;
  cv::Mat smaller;
  cv::resize(picture, smaller, cv::Size(), share, share, cv::INTER_AREA);
  return smaller;
}

}  // namespace

std::vector<double> draw_side_by_side(const FilmAndSimulation& both,
                                      const SideBySideFiles& files,
                                      const std::function<bool()>& stop) {
  // 1. The film's camera
  const datasets::TrackingSpec& recorded = both.recorded;
  VideoReader reader(both.film.video, recorded.camera.frame_rate);
  cv::Mat picture;
  reader.read(picture);
  cv::Mat seen = picture;
  Mask(recorded.camera).cover(seen);
  const FilmCamera film_camera = calibrate_on(recorded.camera, seen, both.film);
  const Camera& camera = film_camera.calibration.camera;
  const auto tracker = make_tracker(recorded, both.film);
  reader.hold_steady(film_camera.scale.sightings);

  // 2. What is drawn of either
  const std::vector<std::size_t> frames = chosen_frames(both);
  if (frames.empty()) return {};
  std::vector<double> times;
  for (const std::size_t frame : frames) times.push_back(both.filmed.time[frame]);
  const datasets::Trajectories simulated = datasets::sample(both.simulated, times);
  const Findings findings{&camera, &both.filmed, tracker.get(), {}};
  const std::size_t stills = std::min(files.stills.size(), frames.size());
  const auto frame_of_still = [&](std::size_t i) {
    return stills < 2 ? 0 : i * (frames.size() - 1) / (stills - 1);
  };

  // 3. Picture by picture
  FilmWriter film(files.film, film_rate);
  std::vector<double> times_of_stills;
  std::size_t next = 0;
  for (std::size_t number = 0; next < frames.size(); ++number) {
    if (number > 0 && !reader.read(picture)) break;
    if (number != frames[next]) continue;
    if (stop && stop()) return {};
    cv::Mat left = picture.clone();
    draw_findings(left, findings, number);
    cv::Mat pair;
    cv::hconcat(left, draw_simulation(camera, recorded, *tracker, simulated, next), pair);
    pair = at_most(widest, pair);
    film.write(pair);
    while (times_of_stills.size() < stills && frame_of_still(times_of_stills.size()) == next) {
      write_still(files.stills[times_of_stills.size()], at_most(widest_still, pair), still_quality);
      times_of_stills.push_back(times[next]);
    }
    ++next;
  }
  film.finish();
  return times_of_stills;
}

}  // namespace graintruth::tracking
