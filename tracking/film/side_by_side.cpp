#include "tracking/film/side_by_side.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
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
const cv::Scalar ground(70, 66, 64), bar(190, 190, 188), dot(120, 116, 114), grains(70, 110, 150);

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

// The rig as the film's camera would see it, at a time after the start event.
cv::Mat draw_stage(const Camera& camera, const datasets::TrackingSpec& spec, double time) {
  cv::Mat picture(camera.height(), camera.width(), CV_8UC3, ground);
  draw_fiducials(picture, camera, spec.camera.fiducials);
  draw_rig(picture, camera, spec.rig, time, bar, 2);
  return picture;
}

double size_of_text(const cv::Mat& picture) {
  return 1.2 * std::clamp(picture.cols / 1600.0, 0.35, 1.0);
}

void write_clock(cv::Mat& picture, const std::string& what, double time) {
  const double text = size_of_text(picture);
  const double milliseconds = std::round(1e3 * time) + 0.0;  // no -0
  write_text(picture,
             fmt::format("{}   {:+.3f} s", what, 1e-3 * milliseconds),
             cv::Point(8, static_cast<int>(8 + 25 * text)),
             text,
             cv::Scalar(255, 255, 255));
}

// Both halves of the picture, for what is seen of film and simulation.
class Halves {
 public:
  virtual ~Halves() = default;
  // Pictures of the film that are drawn, by their numbers, and when they were taken: from time 0 on
  struct Chosen {
    std::vector<std::size_t> frames;
    std::vector<double> times;  // s from the start event
  };
  const Chosen& chosen() const { return chosen_; }
  virtual void draw_found(cv::Mat& film, const Camera& camera, std::size_t chosen) const = 0;
  virtual cv::Mat draw_simulated(const Camera& camera, std::size_t chosen) const = 0;

 protected:
  Chosen chosen_;
};

// Grains that are followed.
class TrackHalves final : public Halves {
 public:
  // Every picture of so many.
  TrackHalves(const FilmAndSimulation& both, const ParticleTracker& tracker, std::size_t stride)
      : spec_(both.recorded), tracker_(tracker), filmed_(*both.filmed.tracks) {
    const datasets::Trajectories& simulated = *both.simulated.tracks;
    const double half = 0.5 / spec_.camera.frame_rate;
    std::size_t first = 0;
    while (first < filmed_.frames() && filmed_.time[first] < -half) ++first;
    for (std::size_t frame = first;
         frame < filmed_.frames() && filmed_.time[frame] < simulated.time.back() + half;
         frame += stride) {
      chosen_.frames.push_back(frame);
      chosen_.times.push_back(filmed_.time[frame]);
    }
    sampled_ = datasets::sample(simulated, chosen_.times);
  }

  void draw_found(cv::Mat& film, const Camera& camera, std::size_t chosen) const override {
    const Findings findings{&camera, &filmed_, &tracker_, {}};
    draw_findings(film, findings, chosen_.frames[chosen]);
  }

  cv::Mat draw_simulated(const Camera& camera, std::size_t chosen) const override {
    cv::Mat picture = draw_stage(camera, spec_, sampled_.time[chosen]);
    const double text = size_of_text(picture);
    for (std::size_t body = 0; body < static_cast<std::size_t>(sampled_.particles); ++body) {
      const datasets::Pose& pose = sampled_.poses[sampled_.index(chosen, body)];
      if (!std::isfinite(pose.x) || !std::isfinite(pose.z)) continue;
      const cv::Scalar& colour = particle_colours[body % particle_colours.size()];
      tracker_.draw(picture, camera, {body, pose, colour, true});
      if (tracker_.is_crowd()) continue;
      const Eigen::Vector2d middle = camera.project(pose.x, pose.z);
      write_text(picture,
                 std::to_string(body + 1),
                 cv::Point(static_cast<int>(middle.x()) + 3, static_cast<int>(middle.y()) - 3),
                 text,
                 colour);
    }
    write_clock(picture, "simulation", sampled_.time[chosen]);
    return picture;
  }

 private:
  const datasets::TrackingSpec& spec_;
  const ParticleTracker& tracker_;
  const datasets::Trajectories& filmed_;
  datasets::Trajectories sampled_;  // of the simulation, at the times that are drawn
};

// The outline of a bed: on the film as it was found; on the right the simulated bed, filled, and
// the film's outline over it. A bed that lies still is recorded no longer: it stays as it was last.
class OutlineHalves final : public Halves {
 public:
  // Every picture of so many.
  OutlineHalves(const FilmAndSimulation& both, std::size_t stride) : spec_(both.recorded) {
    for (const datasets::Outline& filmed : both.filmed.outlines) {
      const datasets::Outline* simulated = both.simulated.outline_of(filmed.surface);
      if (simulated && !filmed.time.empty() && !simulated->time.empty())
        surfaces_.push_back({&filmed, simulated});
    }
    if (surfaces_.empty()) return;
    const double rate = spec_.camera.frame_rate;
    const auto time_of = [&](std::size_t frame) {
      return static_cast<double>(frame) / rate - both.event_time;
    };
    std::size_t frame = 0;
    while (time_of(frame) < -0.5 / rate) ++frame;
    const double last = surfaces_.front().filmed->time.back();
    for (; time_of(frame) < last + 0.5 / rate; frame += stride) {
      chosen_.frames.push_back(frame);
      chosen_.times.push_back(time_of(frame));
    }
  }

  void draw_found(cv::Mat& film, const Camera& camera, std::size_t chosen) const override {
    const double time = chosen_.times[chosen];
    draw_filmed(film, camera, time);
    write_clock(film, fmt::format("frame {}", chosen_.frames[chosen]), time);
  }

  cv::Mat draw_simulated(const Camera& camera, std::size_t chosen) const override {
    const double time = chosen_.times[chosen];
    cv::Mat picture = draw_stage(camera, spec_, time);
    // What turns steadily has no start: both are shown from their first moments on
    for (const auto& [filmed, simulated] : surfaces_) {
      const double own =
          spec_.rig.outline->drum ? time - chosen_.times.front() + simulated->time.front() : time;
      fill_bed(picture, camera, *simulated, nearest(*simulated, own), *spec_.rig.outline, grains);
    }
    draw_rig(picture, camera, spec_.rig, time, bar, 1);
    draw_filmed(picture, camera, time);
    write_clock(picture, "simulation", time);
    return picture;
  }

 private:
  static std::size_t nearest(const datasets::Outline& outline, double time) {
    const auto after = std::lower_bound(outline.time.begin(), outline.time.end(), time);
    if (after == outline.time.begin()) return 0;
    const auto before = static_cast<std::size_t>(after - outline.time.begin()) - 1;
    return after == outline.time.end() || time - outline.time[before] < *after - time ? before
                                                                                      : before + 1;
  }

  // Where nothing was seen in this picture there is nothing to draw.
  void draw_filmed(cv::Mat& picture, const Camera& camera, double time) const {
    for (const auto& [filmed, simulated] : surfaces_) {
      const std::size_t moment = nearest(*filmed, time);
      if (std::abs(filmed->time[moment] - time) > 0.75 / spec_.camera.frame_rate) continue;
      draw_surface(picture, camera, *filmed, moment, particle_colours[2], 2);
    }
  }

  const datasets::TrackingSpec& spec_;
  struct Surface {
    const datasets::Outline* filmed = nullptr;
    const datasets::Outline* simulated = nullptr;
  };
  std::vector<Surface> surfaces_;  // those of both
};

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
  const double rate = recorded.camera.frame_rate;
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::round(rate / film_rate)));
  std::unique_ptr<Halves> halves;
  if (!both.filmed.outlines.empty() && !both.simulated.outlines.empty()) {
    halves = std::make_unique<OutlineHalves>(both, stride);
  } else if (both.filmed.tracks && both.simulated.tracks) {
    halves = std::make_unique<TrackHalves>(both, *tracker, stride);
  } else {
    return {};
  }
  const auto& [frames, times] = halves->chosen();
  if (frames.empty()) return {};
  const std::size_t stills = std::min(files.stills.size(), frames.size());
  const auto frame_of_still = [&, &frames = frames](std::size_t i) {
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
    halves->draw_found(left, camera, next);
    cv::Mat pair;
    cv::hconcat(left, halves->draw_simulated(camera, next), pair);
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
