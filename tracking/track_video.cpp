#include "tracking/track_video.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>

#include "tracking/body_follower.h"
#include "tracking/clock.h"
#include "tracking/first_picture.h"
#include "tracking/learn.h"
#include "tracking/median.h"
#include "tracking/overlay.h"
#include "tracking/start_of_motion.h"
#include "tracking/video.h"

namespace graintruth::tracking {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double degree = std::numbers::pi / 180.0;

// What the film shows, and every body's history through it.
struct FollowedFilm {
  FilmView view;
  std::vector<BodyTrack> tracks;
  std::array<TextureGrid, 2> grids;
  int frames = 0;
};

// Reads the film frame by frame; what is said of the film itself goes to the summary.
FollowedFilm follow_film(const datasets::Experiment& experiment,
                         VideoReader& video,
                         const std::string& where,
                         const TrackingOptions& options,
                         TrackingSummary& summary) {
  std::optional<FilmView> view;
  std::optional<BodyFollower> follower;
  cv::Mat frame;
  double noise_as_filmed = 0.0;  // grey levels
  while (video.read(frame)) {
    const int number = video.frames_read() - 1;
    if (number == 0) noise_as_filmed = camera_noise(frame);
    quieten(frame, noise_as_filmed);
    if (number == 0) {
      view.emplace(view_of(experiment, frame, where, summary));
      const EdgeImage image(frame, cv::Rect(0, 0, frame.cols, frame.rows), 0.8);
      const auto first = find_first_bodies(*view, frame, image, summary);
      follower.emplace(*view, first, image);
      video.hold_steady(view->camera.sightings);
    } else {
      view->watch_piston(frame);
      follower->follow(frame, number);
    }
    if (options.progress) options.progress(video.frames_read(), video.declared_frames());
    if (options.stop && options.stop()) throw Stopped{};
  }
  const int frames = video.frames_read();
  summary.width = video.width();
  summary.height = video.height();
  summary.frames_declared = video.declared_frames();
  summary.frames_read = summary.frames_used = frames;
  summary.frame_rate_hz = experiment.camera.frame_rate;
  summary.frame_rate_declared_hz = video.declared_frame_rate();
  summary.repeated_frames = video.repeated_frames();
  for (std::string& sentence : video.warnings()) summary.warn(std::move(sentence));
  describe_steadiness(*video.steady(), summary);
  return {std::move(*view), follower->take_tracks(frames), follower->grids(), frames};
}

Learned learn_from(const FollowedFilm& film) {
  std::vector<std::vector<BodyFit>> seen;
  for (const BodyTrack& track : film.tracks) {
    std::vector<BodyFit>& list = seen.emplace_back();
    for (const auto& fit : track.fits)
      if (fit) list.push_back(*fit);
  }
  return learn_shapes(seen, film.view.shape);
}

// Every pose with the sizes learned, joined with what the balls' textures tell, and its
// uncertainty; what can be said of all of them goes to the summary. `zero` in seconds of film.
datasets::Trajectories solve_poses(FollowedFilm& film,
                                   const Learned& learned,
                                   double zero,
                                   TrackingSummary& summary) {
  const int frames = film.frames;
  const int count = film.view.experiment.particle.count;
  datasets::Trajectories out =
      datasets::make_trajectories(static_cast<std::size_t>(frames), count, true);
  for (int k = 0; k < frames; ++k)
    out.time[static_cast<std::size_t>(k)] = k / film.view.experiment.camera.frame_rate - zero;
  // Real balls differ: masses go with r^3, so the centre of mass moves along the axis by 3/4 of the
  // separation times the relative difference of the two radii.
  const double mass_shift =
      0.75 * film.view.shape.separation * learned.radius_difference / learned.radius_mean;
  std::vector<BodyWitness> witnesses;
  for (std::size_t body = 0; body < film.tracks.size(); ++body) {
    BodyWitness& witness = witnesses.emplace_back();
    witness.shape = learned.bodies[body].shape;
    witness.grids = film.grids;
    for (std::size_t k = 0; k < static_cast<std::size_t>(frames); ++k) {
      const auto& fit = film.tracks[body].fits[k];
      WitnessedPose& pose = witness.outline.emplace_back();
      if (!fit) continue;
      const SolvedPose solved = solve_pose(*fit, learned.bodies[body]);
      pose = {solved.pose, solved.covariance};
    }
    for (std::size_t ball = 0; ball < 2; ++ball) {
      witness.patches[ball] = std::move(film.tracks[body].textures[ball]);
      witness.patches[ball].resize(static_cast<std::size_t>(frames));
    }
  }
  const auto joined = join_witnesses(witnesses);
  std::vector<double> position_sigmas, angle_sigmas, scatters;
  double score_sum = 0.0;
  int worst = frames;
  for (std::size_t body = 0; body < film.tracks.size(); ++body) {
    int detections = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(frames); ++k) {
      const auto& fit = film.tracks[body].fits[k];
      if (!fit) {
        if (k == 0 || film.tracks[body].fits[k - 1]) ++summary.gaps;
        continue;
      }
      ++detections;
      const WitnessedPose& solved = joined[body][k];
      Eigen::Matrix3d covariance = solved.covariance;
      covariance.topLeftCorner<2, 2>() +=
          film.view.camera.calibration.point_covariance(solved.pose.x, solved.pose.z);
      const Eigen::Vector2d axis(std::cos(solved.pose.angle), std::sin(solved.pose.angle));
      covariance.topLeftCorner<2, 2>() += mass_shift * mass_shift * axis * axis.transpose();
      const std::size_t i = out.index(k, body);
      const bool turned = film.view.shape.shows_angle();
      out.poses[i] = {solved.pose.x, solved.pose.z, turned ? solved.pose.angle : nan};
      out.sigmas[i] = {std::sqrt(covariance(0, 0)),
                       std::sqrt(covariance(1, 1)),
                       turned ? std::sqrt(covariance(2, 2)) : nan};
      out.scores[i] = fit->support;
      score_sum += fit->support;
      position_sigmas.push_back(std::sqrt(0.5 * (covariance(0, 0) + covariance(1, 1))));
      angle_sigmas.push_back(out.sigmas[i].angle);
      scatters.push_back(fit->scatter_px);
    }
    summary.detections += detections;
    worst = std::min(worst, detections);
  }
  const BodyPose& any = film.tracks[0].last;
  const double scale = film.view.lens().scale(any.x, any.z);  // px/m
  summary.particles = count;
  summary.completeness = summary.detections / (static_cast<double>(frames) * count);
  summary.least_complete_particle = static_cast<double>(worst) / frames;
  summary.mean_score = summary.detections > 0 ? score_sum / summary.detections : 0.0;
  summary.scale_px_per_mm = 1.0e-3 * scale;
  summary.position_sigma_mm = 1.0e3 * median(position_sigmas, nan);
  summary.pixel_error_px = summary.position_sigma_mm * summary.scale_px_per_mm;
  summary.angle_sigma_deg = median(angle_sigmas, nan) / degree;
  summary.ray_scatter_px = median(scatters, nan);
  return out;
}

// Turns too large for a frame, and steps that two neighbours would have explained about as well the
// other way round.
void count_doubts(const datasets::Trajectories& tracks,
                  const BodyShape& shape,
                  TrackingSummary& summary) {
  constexpr double largest_turn = 60.0 * degree;
  const auto count = static_cast<std::size_t>(tracks.particles);
  // A step into another's place is in doubt when it is not shorter by half a radius: bodies cannot
  // come that near to each other while the camera looks.
  const double margin = 0.5 * shape.radius[0];
  const auto step = [&](std::size_t k, std::size_t from, std::size_t to) {
    const datasets::Pose &before = tracks.poses[tracks.index(k - 1, from)],
                         &now = tracks.poses[tracks.index(k, to)];
    return std::hypot(now.x - before.x, now.z - before.z);
  };
  for (std::size_t k = 1; k < tracks.frames(); ++k) {
    for (std::size_t a = 0; a < count; ++a) {
      const double turn =
          tracks.poses[tracks.index(k, a)].angle - tracks.poses[tracks.index(k - 1, a)].angle;
      if (std::abs(turn) > largest_turn) ++summary.angle_jumps;
      // Not seen compares false
      for (std::size_t b = a + 1; b < count; ++b)
        if (step(k, a, b) + step(k, b, a) < step(k, a, a) + step(k, b, b) + 2.0 * margin)
          ++summary.suspected_swaps;
    }
  }
}

// Whether sizes and completeness are what they should be.
void judge(const Learned& learned, const BodyShape& nominal, TrackingSummary& summary) {
  const double nominal_radius = 0.5 * (nominal.radius[0] + nominal.radius[1]);
  summary.radius_learned_mm = 1.0e3 * learned.radius_mean;
  summary.radius_nominal_mm = 1.0e3 * nominal_radius;
  summary.radius_spread_mm = 1.0e3 * learned.radius_spread;
  summary.separation_learned_mm = 1.0e3 * learned.separation_mean;
  summary.separation_nominal_mm = 1.0e3 * nominal.separation;
  summary.separation_spread_mm = 1.0e3 * learned.separation_spread;
  // Real particles and the look of their edges stay within three per cent.
  constexpr double size_tolerance = 0.03;
  if (std::abs(learned.radius_mean / nominal_radius - 1.0) > size_tolerance) {
    summary.warn(
        fmt::format("The balls look {:.2f} mm in radius but the experiment says {:.2f} mm ({:+.1f} "
                    "%): check the "
                    "particle's size and the fiducials' positions.",
                    1.0e3 * learned.radius_mean,
                    1.0e3 * nominal_radius,
                    100.0 * (learned.radius_mean / nominal_radius - 1.0)));
  }
  if (nominal.shows_angle() &&
      std::abs(learned.separation_mean / nominal.separation - 1.0) > size_tolerance) {
    summary.warn(
        fmt::format("The ball centres look {:.2f} mm apart but the experiment says {:.2f} mm "
                    "({:+.1f} %): check the "
                    "particle's size.",
                    1.0e3 * learned.separation_mean,
                    1.0e3 * nominal.separation,
                    100.0 * (learned.separation_mean / nominal.separation - 1.0)));
  }
  if (summary.least_complete_particle < 0.995) {
    const std::string sentence = fmt::format("A particle was seen in only {:.1f} % of the frames.",
                                             100.0 * summary.least_complete_particle);
    if (summary.least_complete_particle < 0.9)
      summary.fail(sentence);
    else
      summary.warn(sentence);
  }
}

// The findings on the film, which is read once more.
void draw_findings(const FollowedFilm& film,
                   const Learned& learned,
                   const TrackedFilm& tracked,
                   const std::filesystem::path& video,
                   const TrackingOptions& options) {
  const double frame_rate = film.view.experiment.camera.frame_rate;
  Findings findings{&film.view.lens(), &tracked.trajectories, {}, film.view.camera.sightings};
  for (const LearnedShape& body : learned.bodies) findings.shapes.push_back(body.shape);
  const int event_frame = std::clamp(
      static_cast<int>(std::lround(tracked.summary.event_time_s * frame_rate)), 0, film.frames - 1);
  OverlayFiles files;
  files.film = options.overlay_file;
  files.frame_rate = frame_rate;
  files.stills = {{0, options.annotated_first},
                  {(event_frame + film.frames - 1) / 2, options.annotated_middle},
                  {film.frames - 1, options.annotated_last}};
  if (!draw_overlay(video, findings, files, options.stop)) throw Stopped{};
}

}  // namespace

void TrackingSummary::warn(std::string sentence) {
  warnings.push_back(std::move(sentence));
  if (grade == Grade::ok) grade = Grade::warn;
}

void TrackingSummary::fail(std::string sentence) {
  warnings.push_back(std::move(sentence));
  grade = Grade::fail;
}

std::string to_string(Grade grade) {
  switch (grade) {
    case Grade::ok:
      return "ok";
    case Grade::warn:
      return "warn";
    case Grade::fail:
      return "fail";
  }
  return "";
}

TrackedFilm track_video(const datasets::Experiment& experiment,
                        const datasets::Replicate& replicate,
                        const TrackingOptions& options) {
  // Films are tracked side by side; more threads would only get in each other's way.
  cv::setNumThreads(1);
  const auto started = std::chrono::steady_clock::now();
  TrackedFilm result;
  TrackingSummary& summary = result.summary;
  summary.replicate = replicate.name;
  // 1. The film, frame by frame
  VideoReader video(replicate.video, experiment.camera.frame_rate);
  FollowedFilm film = follow_film(experiment, video, replicate.video.string(), options, summary);
  // 2. Sizes of each body from the whole clip; time zero
  const Learned learned = learn_from(film);
  const Event start = find_start(film.view, film.tracks, summary);
  summary.event_time_s = start.time;
  summary.event_uncertainty_s = start.uncertainty;
  summary.event_source = start.how;
  summary.event_speed_m_per_s = start.speed;
  summary.noted_event_time_s = experiment.camera.noted_event_time.value_or(nan);
  // 3. Poses with these sizes, their uncertainty, and doubts
  result.trajectories = solve_poses(film, learned, start.time, summary);
  count_doubts(result.trajectories, film.view.shape, summary);
  const double pixel = 1.0e-3 / summary.scale_px_per_mm;  // m
  for (std::string& sentence :
       describe(find_clock_faults(result.trajectories, pixel), video.repeated_frames()))
    summary.warn(std::move(sentence));
  judge(learned, film.view.nominal, summary);
  summary.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  summary.frames_per_second = film.frames / summary.seconds;
  // 4. The findings drawn on the film, outside the clock
  draw_findings(film, learned, result, replicate.video, options);
  return result;
}

}  // namespace graintruth::tracking
