#include "tracking/balls/ball_tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "datasets/store/input_error.h"
#include "tracking/balls/first_picture.h"
#include "tracking/drawing/drawing.h"
#include "tracking/event/start_of_motion.h"
#include "tracking/film/clock.h"
#include "tracking/median.h"

namespace graintruth::tracking {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double degree = std::numbers::pi / 180.0;

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

// Throws where the rig, as the file states it, lies beside the picture, or so far in the distance
// that the picture would be a small part of it: then a wrong scale was found.
void require_region(const FilmView& view, const cv::Mat& frame, const std::string& film) {
  constexpr double largest = 16.0;  // pictures; tilt hardly makes lengths in it differ by four
  const PlaneRegion& region = view.region;
  const double width = region.right - region.left, height = region.top - region.bottom;
  const double scale = view.lens().scale(0.5 * (region.left + region.right),
                                         0.5 * (region.bottom + region.top));  // px/m
  const double pixels = width * scale * height * scale;
  if (width > 0.0 && height > 0.0 && pixels <= largest * static_cast<double>(frame.total())) return;
  throw datasets::InputError(
      fmt::format("{}: the rig lies outside the picture; check its measures and what gives the "
                  "scale in [camera]",
                  film));
}

}  // namespace

BallTracker::BallTracker(const datasets::TrackingSpec& spec, const datasets::Film& film)
    : spec_(spec), film_(film), nominal_(nominal_shape(spec.body, film.experiment)) {}

void BallTracker::prepare(cv::Mat& frame, int number) {
  if (number == 0) noise_as_filmed_ = camera_noise(frame);
  quieten(frame, noise_as_filmed_);
}

void BallTracker::find_first(const Picture& picture,
                             const FilmCamera& camera,
                             TrackingSummary& summary) {
  const cv::Mat& frame = picture.frame;
  view_.emplace(view_of(spec_, nominal_, camera, frame));
  require_region(*view_, frame, film_.video.string());
  const EdgeImage image(frame, cv::Rect(0, 0, frame.cols, frame.rows), 0.8);
  const auto first = find_first_bodies(*view_, frame, image, film_.video.string(), summary);
  follower_.emplace(*view_, first, frame, image);
}

void BallTracker::follow(const Picture& picture) {
  view_->watch_face(picture.frame, picture.moment);
  follower_->follow(picture.frame, picture.number);
}

datasets::Trajectories BallTracker::finish(TrackingSummary& summary) {
  // 1. Sizes of each body from the whole clip; time zero
  learn(summary.frames_read);
  const Event start = find_start(*view_, tracks_, film_.video.string(), summary);
  summary.event_time_s = start.time;
  summary.event_uncertainty_s = start.uncertainty;
  summary.event_source = start.how;
  // 2. Poses with these sizes, their uncertainty, and doubts
  datasets::Trajectories out = solve_poses(start.time, summary);
  count_doubts(out, view_->shape, summary);
  const double pixel = 1.0e-3 / summary.scale_px_per_mm;  // m
  for (std::string& sentence :
       tracking::describe(find_clock_faults(out, pixel, summary.clock), summary.repeated_frames))
    summary.warn(std::move(sentence));
  judge(summary);
  judge_bodies(summary);
  return out;
}

void BallTracker::learn(int frames) {
  tracks_ = follower_->take_tracks(frames);
  std::vector<std::vector<BodyFit>> seen;
  for (const BodyTrack& track : tracks_) {
    std::vector<BodyFit>& list = seen.emplace_back();
    for (const auto& fit : track.fits)
      if (fit) list.push_back(*fit);
  }
  learned_ = learn_shapes(seen, view_->shape);
  clip_.resize(tracks_.size(), std::vector<ClipPose>(static_cast<std::size_t>(frames)));
  if (!view_->shape.shows_angle()) return;
  Clip clip = solve_clip(*view_, tracks_, follower_->grids(), follower_->pictures());
  clip_ = std::move(clip.poses);
  checks_ = std::move(clip.checks);
  for (std::size_t body = 0; body < tracks_.size(); ++body) {
    learned_.bodies[body].shape = clip.learned.bodies[body].shape;
    learned_.bodies[body].radius_difference = clip.learned.bodies[body].radius_difference;
  }
  clip.learned.bodies = std::move(learned_.bodies);
  learned_ = std::move(clip.learned);
}

// Every pose with the sizes learned, joined with what the balls' textures tell, and its
// uncertainty; what can be said of all of them goes to the summary. `zero` in seconds of film.
datasets::Trajectories BallTracker::solve_poses(double zero, TrackingSummary& summary) {
  const int frames = summary.frames_read;
  const int count = view_->count;
  datasets::Trajectories out =
      datasets::make_trajectories(static_cast<std::size_t>(frames), count, true);
  for (std::size_t k = 0; k < out.frames(); ++k)
    out.time[k] = summary.clock.moments[k] / spec_.camera.frame_rate - zero;
  std::vector<double> position_sigmas, angle_sigmas;
  double score_sum = 0.0;
  int worst = frames;
  for (std::size_t body = 0; body < tracks_.size(); ++body) {
    int detections = 0;
    std::vector<double> own_sigmas;
    // Real balls differ: masses go with r^3, so the centre of mass moves along the axis by 3/4 of
    // the separation times the relative difference of the two radii.
    const double mass_shift = 0.75 * view_->shape.separation *
                              learned_.bodies[body].radius_difference / learned_.radius_mean;
    for (std::size_t k = 0; k < static_cast<std::size_t>(frames); ++k) {
      const auto& fit = tracks_[body].fits[k];
      if (!fit) {
        if (k == 0 || tracks_[body].fits[k - 1]) ++summary.gaps;
        continue;
      }
      ++detections;
      ClipPose solved = clip_[body][k];
      if (!solved.found) {
        const SolvedPose outline = solve_pose(*fit, learned_.bodies[body]);
        solved = {true, outline.pose, outline.covariance};
      }
      Eigen::Matrix3d covariance = solved.covariance;
      covariance.topLeftCorner<2, 2>() +=
          view_->camera.calibration.point_covariance(solved.pose.x, solved.pose.z);
      const Eigen::Vector2d axis(std::cos(solved.pose.angle), std::sin(solved.pose.angle));
      covariance.topLeftCorner<2, 2>() += mass_shift * mass_shift * axis * axis.transpose();
      const std::size_t i = out.index(k, body);
      const bool turned = view_->shape.shows_angle();
      out.poses[i] = {solved.pose.x, solved.pose.z, turned ? solved.pose.angle : nan};
      out.sigmas[i] = {std::sqrt(covariance(0, 0)),
                       std::sqrt(covariance(1, 1)),
                       turned ? std::sqrt(covariance(2, 2)) : nan};
      out.scores[i] = fit->support;
      score_sum += fit->support;
      position_sigmas.push_back(std::sqrt(0.5 * (covariance(0, 0) + covariance(1, 1))));
      own_sigmas.push_back(position_sigmas.back());
      angle_sigmas.push_back(out.sigmas[i].angle);
    }
    sigmas_.push_back(median(std::move(own_sigmas), nan));
    summary.detections += detections;
    worst = std::min(worst, detections);
  }
  const BodyPose& any = tracks_[0].last;
  const double scale = view_->lens().scale(any.x, any.z);  // px/m
  summary.particles = count;
  summary.shows_angle = view_->shape.shows_angle();
  summary.completeness = summary.detections / (static_cast<double>(frames) * count);
  summary.least_complete_particle = static_cast<double>(worst) / frames;
  summary.mean_score = summary.detections > 0 ? score_sum / summary.detections : 0.0;
  summary.scale_px_per_mm = 1.0e-3 * scale;
  summary.position_sigma_mm = 1.0e3 * median(position_sigmas, nan);
  summary.pixel_error_px = summary.position_sigma_mm * summary.scale_px_per_mm;
  summary.angle_sigma_deg = median(angle_sigmas, nan) / degree;
  return out;
}

// Whether sizes and completeness are what they should be.
void BallTracker::judge(TrackingSummary& summary) const {
  const double nominal_radius = 0.5 * (nominal_.radius[0] + nominal_.radius[1]);
  // Real particles and the look of their edges stay within three per cent.
  constexpr double size_tolerance = 0.03;
  if (std::abs(learned_.radius_mean / nominal_radius - 1.0) > size_tolerance) {
    summary.warn(
        fmt::format("The balls look {:.2f} mm in radius but the experiment says {:.2f} mm ({:+.1f} "
                    "%): check the "
                    "particle's size and the scale.",
                    1.0e3 * learned_.radius_mean,
                    1.0e3 * nominal_radius,
                    100.0 * (learned_.radius_mean / nominal_radius - 1.0)));
  }
  if (nominal_.shows_angle() &&
      std::abs(learned_.separation_mean / nominal_.separation - 1.0) > size_tolerance) {
    summary.warn(
        fmt::format("The ball centres look {:.2f} mm apart but the experiment says {:.2f} mm "
                    "({:+.1f} %): check the "
                    "particle's size.",
                    1.0e3 * learned_.separation_mean,
                    1.0e3 * nominal_.separation,
                    100.0 * (learned_.separation_mean / nominal_.separation - 1.0)));
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

// Where the witnesses of one body disagree more than those of the others: its errors were widened
// by it, and who uses its track must know.
void BallTracker::judge_bodies(TrackingSummary& summary) const {
  constexpr double unusual = 3.0;  // times what is usual in this film
  std::vector<double> wanders, ratios, sigmas;
  const auto ratio_of = [](const BodyCheck& check) {
    return check.outline_usual > 0.0 ? check.outline_left / check.outline_usual : 0.0;
  };
  for (std::size_t body = 0; body < checks_.size(); ++body) {
    if (!(sigmas_[body] > 0.0)) continue;  // never seen
    wanders.push_back(checks_[body].paint_wander);
    ratios.push_back(ratio_of(checks_[body]));
    sigmas.push_back(sigmas_[body]);
  }
  const double usual_wander = median(wanders), usual_ratio = median(ratios);
  const double usual_sigma = median(sigmas);
  for (std::size_t body = 0; body < checks_.size(); ++body) {
    if (!(sigmas_[body] > 0.0)) continue;
    const BodyCheck& check = checks_[body];
    const double sigma_mm = 1.0e3 * sigmas_[body], ratio = ratio_of(check);
    if (ratio > unusual * usual_ratio)
      summary.warn(fmt::format(
          "Particle {}: the sides of its outline disagree by {:.2f} px, where {:.2f} px are usual "
          "in this film. A shadow or a neighbour may look like its edge. Its uncertainty contains "
          "it: {:.2f} mm.",
          body + 1,
          check.outline_left,
          usual_ratio * check.outline_usual,
          sigma_mm));
    if (check.paint_wander > unusual * usual_wander)
      summary.warn(fmt::format(
          "Particle {}: what its two balls show moves apart by {:.2f} px between frames, where "
          "{:.2f} px are usual in this film, though they are rigid. Its uncertainty contains it: "
          "{:.2f} mm.",
          body + 1,
          check.paint_wander,
          usual_wander,
          sigma_mm));
    if (sigmas_[body] > unusual * usual_sigma)
      summary.warn(
          fmt::format("Particle {} hardly stands out from what lies behind it: its place is known "
                      "to {:.2f} mm, "
                      "those of most others to {:.2f} mm.",
                      body + 1,
                      sigma_mm,
                      1.0e3 * usual_sigma));
  }
}

void BallTracker::draw(cv::Mat& picture, const Camera& camera, const DrawnBody& body) const {
  const BodyShape& shape =
      body.filled || learned_.bodies.empty() ? nominal_ : learned_.bodies[body.particle].shape;
  const bool turned = shape.shows_angle() && std::isfinite(body.pose.angle);
  const auto centres =
      ball_centres({body.pose.x, body.pose.z, turned ? body.pose.angle : 0.0}, shape);
  std::vector<Eigen::Vector2d> outline(72);
  for (std::size_t ball = 0; ball < shape.balls; ++ball) {
    sphere_outline(camera, centres[ball].x(), centres[ball].y(), shape.radius[ball], outline);
    if (body.filled) {
      fill_outline(picture, outline, body.colour);
      continue;
    }
    // Not where it lies inside the other ball
    for (std::size_t k = 0; k < outline.size(); ++k) {
      const double angle = 2.0 * std::numbers::pi * (static_cast<double>(k) + 0.5) /
                           static_cast<double>(outline.size());
      const Eigen::Vector2d point =
          centres[ball] + shape.radius[ball] * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      if (shape.balls == 2 && (point - centres[1 - ball]).norm() < shape.radius[1 - ball]) continue;
      draw_line(picture, outline[k], outline[(k + 1) % outline.size()], body.colour);
    }
  }
  if (turned)
    draw_axis(picture,
              camera.project(centres[0].x(), centres[0].y()),
              camera.project(centres[1].x(), centres[1].y()),
              body);
}

void BallTracker::describe(nlohmann::ordered_json& film) const {
  film["radius_learned_mm"] = 1.0e3 * learned_.radius_mean;
  film["radius_nominal_mm"] = 1.0e3 * 0.5 * (nominal_.radius[0] + nominal_.radius[1]);
  film["radius_spread_mm"] = 1.0e3 * learned_.radius_spread;
  if (!nominal_.shows_angle()) return;
  film["separation_learned_mm"] = 1.0e3 * learned_.separation_mean;
  film["separation_nominal_mm"] = 1.0e3 * nominal_.separation;
  film["separation_spread_mm"] = 1.0e3 * learned_.separation_spread;
  for (std::size_t body = 0; body < checks_.size(); ++body) {
    const BodyCheck& check = checks_[body];
    const BodyShape& shape = learned_.bodies[body].shape;
    const Eigen::Vector3f& colour = tracks_[body].colour;
    film["bodies"].push_back({{"particle", body + 1},
                              {"brightness", colour[0]},
                              {"redness", colour[1]},
                              {"blueness", colour[2]},
                              {"radii_mm", {1.0e3 * shape.radius[0], 1.0e3 * shape.radius[1]}},
                              {"separation_mm", 1.0e3 * shape.separation},
                              {"position_sigma_mm", 1.0e3 * sigmas_[body]},
                              {"outline_left_px", check.outline_left},
                              {"outline_usual_px", check.outline_usual},
                              {"outline_sides_seen", check.sides},
                              {"paint_wander_px", check.paint_wander}});
  }
}

std::unique_ptr<ParticleTracker> make_ball_tracker(const datasets::TrackingSpec& spec,
                                                   const datasets::Film& film) {
  if (spec.body.kind != "balls") return nullptr;
  return std::make_unique<BallTracker>(spec, film);
}

}  // namespace graintruth::tracking
