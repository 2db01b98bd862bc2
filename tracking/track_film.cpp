#include "tracking/track_film.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include "tracking/drawing/overlay.h"
#include "tracking/film/corrections.h"
#include "tracking/film/recording.h"
#include "tracking/film/video.h"
#include "tracking/view/mask.h"

namespace graintruth::tracking {

namespace {

// Reads the film from end to end; its camera is calibrated on the first picture where it is not
// known yet. What is said of the film itself goes to the summary where there is one.
template <typename Visit>
void read_through(ParticleTracker& tracker,
                  const datasets::TrackingSpec& spec,
                  const datasets::Film& film,
                  const TrackingOptions& options,
                  std::optional<FilmCamera>& camera,
                  Mask& mask,
                  TrackingSummary* summary,
                  const Visit& visit) {
  VideoReader video(film.video, spec.camera.frame_rate);
  if (camera) video.hold_steady(camera->scale.sightings);
  cv::Mat frame;
  while (video.read(frame)) {
    const int number = video.frames_read() - 1;
    mask.cover(frame);
    tracker.prepare(frame, number);
    if (!camera) {
      camera = calibrate_on(spec.camera, frame, film);
      video.hold_steady(camera->scale.sightings);
    }
    if (summary) summary->clock.moments.push_back(video.moment());
    visit(Picture{frame, number, video.parity(), video.moment()});
    if (summary && options.progress) options.progress(video.frames_read(), video.declared_frames());
    if (options.stop && options.stop()) throw Stopped{};
  }
  if (!summary) return;
  require_motion(spec, film, video.frames_read());
  summary->width = video.width();
  summary->height = video.height();
  summary->frames_declared = video.declared_frames();
  summary->frames_read = video.frames_read();
  summary->frame_rate_hz = spec.camera.frame_rate;
  summary->frame_rate_declared_hz = video.declared_frame_rate();
  summary->repeated_frames = video.repeated_frames();
  summary->clock.changes = video.changes();
  summary->clock.pictures_a_frame = video.scan() == Scan::progressive ? 1 : 2;
  for (std::string& sentence : video.warnings()) summary->warn(std::move(sentence));
  if (video.steady()) describe_steadiness(*video.steady(), *summary);
}

void draw_findings(const ParticleTracker& tracker,
                   const FilmCamera& camera,
                   const datasets::Film& film,
                   const TrackedFilm& tracked,
                   const TrackingOptions& options) {
  const TrackingSummary& summary = tracked.summary;
  const int last = summary.frames_read - 1;
  const double event = summary.event_time_s * summary.frame_rate_hz;
  const auto& moments = summary.clock.moments;
  const auto event_frame =
      static_cast<int>(std::min_element(moments.begin(),
                                        moments.end(),
                                        [&](double one, double other) {
                                          return std::abs(one - event) < std::abs(other - event);
                                        }) -
                       moments.begin());
  OverlayFiles files;
  files.film = options.overlay_file;
  files.frame_rate = summary.frame_rate_hz;
  files.stills = {{0, options.annotated_first},
                  {(event_frame + last) / 2, options.annotated_middle},
                  {last, options.annotated_last}};
  const Findings findings{
      &camera.calibration.camera, &tracked.trajectories, &tracker, camera.scale.sightings};
  if (!draw_overlay(film.video, findings, files, options.stop)) throw Stopped{};
}

}  // namespace

TrackedFilm track_film(ParticleTracker& tracker,
                       const datasets::TrackingSpec& spec,
                       const datasets::Film& film,
                       const TrackingOptions& options) {
  // Films are tracked side by side; more threads would only get in each other's way.
  cv::setNumThreads(1);
  const auto started = std::chrono::steady_clock::now();
  TrackedFilm result;
  TrackingSummary& summary = result.summary;
  std::optional<FilmCamera> camera;
  Mask mask(spec.camera);
  // 1. The film from end to end, for those who must know it all first
  if (tracker.looks_ahead()) {
    read_through(tracker, spec, film, options, camera, mask, nullptr, [&](const Picture& picture) {
      tracker.look_ahead(picture, *camera);
    });
  }
  // 2. Every particle from picture to picture
  read_through(tracker, spec, film, options, camera, mask, &summary, [&](const Picture& picture) {
    if (picture.number > 0) {
      tracker.follow(picture);
      return;
    }
    describe_camera(*camera, spec.camera, summary);
    tracker.find_first(picture, *camera, summary);
  });
  // 3. Tracks with their uncertainty and time zero; repairs by hand
  summary.noted_event_time_s =
      spec.camera.noted_event_time.value_or(std::numeric_limits<double>::quiet_NaN());
  result.trajectories = tracker.finish(summary);
  if (!film.corrections.empty()) {
    const double pixel = 1.0e-3 / summary.scale_px_per_mm;  // m
    for (std::string& sentence :
         apply_corrections(film.corrections, pixel, summary.shows_angle, result.trajectories))
      summary.warn(std::move(sentence));
  }
  summary.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  summary.frames_per_second = summary.frames_read / summary.seconds;
  // 4. The findings drawn on the film, outside the clock
  draw_findings(tracker, *camera, film, result, options);
  return result;
}

}  // namespace graintruth::tracking
