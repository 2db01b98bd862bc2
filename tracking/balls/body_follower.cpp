#include "tracking/balls/body_follower.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tracking/balls/bodies.h"
#include "tracking/bodies/link.h"

namespace graintruth::tracking {

namespace {

constexpr double degree = std::numbers::pi / 180.0;

// Of the support that a body used to have; below that share, or below what clutter reaches if that
// is less, it is lost.
constexpr double kept_support = 0.8;

// Paint that has less than half of its variance in common with what was seen before tells nothing.
constexpr double least_likeness = 0.7;

}  // namespace

double BodyTrack::lost_support() const {
  return std::clamp(kept_support * support, hidden_support, clutter_support);
}

double BodyTrack::lost_likeness() const {
  return std::max(kept_support * likeness, least_likeness);
}

BodyFollower::BodyFollower(const FilmView& view,
                           const std::vector<std::optional<BodyFit>>& first,
                           const cv::Mat& frame,
                           const EdgeImage& image)
    : view_(view), tracks_(first.size()) {
  if (view_.shape.shows_angle()) {
    for (std::size_t ball = 0; ball < 2; ++ball)
      grids_[ball] = make_texture_grid(view_.shape, ball);
  }
  for (std::size_t body = 0; body < tracks_.size(); ++body) {
    if (first[body]) accept(tracks_[body], *first[body], 0);
  }
  keep_textures(image, 0);
  keep_picture(frame, 0);
}

std::vector<BodyTrack> BodyFollower::take_tracks(int frames) {
  for (BodyTrack& track : tracks_) track.fits.resize(static_cast<std::size_t>(frames));
  return std::move(tracks_);
}

Surroundings BodyFollower::surroundings_of(std::size_t body) const {
  Surroundings result = view_.surroundings();
  for (std::size_t other = 0; other < tracks_.size(); ++other) {
    if (other == body || !tracks_[other].known) continue;
    result.add(tracks_[other].last, view_.shape);
  }
  return result;
}

cv::Rect BodyFollower::working_region() const {
  double left = 1.0e9, right = -1.0e9, top = 1.0e9, bottom = -1.0e9;
  for (const BodyTrack& track : tracks_) {
    if (!track.known) continue;
    const Eigen::Vector2d pixel = view_.lens().project(track.last.x, track.last.z);
    const Eigen::Matrix2d jacobian = view_.lens().jacobian(track.last.x, track.last.z);
    const double reach = 0.5 * view_.shape.separation + 1.6 * view_.shape.radius[0];
    const double half_width = jacobian.row(0).norm() * reach,
                 half_height = jacobian.row(1).norm() * reach;
    left = std::min(left, pixel.x() - half_width);
    right = std::max(right, pixel.x() + half_width);
    top = std::min(top, pixel.y() - half_height);
    bottom = std::max(bottom, pixel.y() + half_height);
  }
  const int x = static_cast<int>(left) - 8, y = static_cast<int>(top) - 8;
  return {x, y, static_cast<int>(right) + 9 - x, static_cast<int>(bottom) + 9 - y};
}

void BodyFollower::accept(BodyTrack& track, const BodyFit& fit, int number) {
  if (track.known && track.unseen == 0 && number > 0) {
    const BodyPose& before = track.fits.back()->pose;
    track.velocity << fit.pose.x - before.x, fit.pose.z - before.z, fit.pose.angle - before.angle;
  }
  track.fits.resize(static_cast<std::size_t>(number));
  track.fits.push_back(fit);
  track.last = fit.pose;
  track.unseen = 0;
  for (std::size_t lag = 0; lag < fit.autocovariance.size(); ++lag) {
    constexpr double kept = 0.9;
    track.ray_covariance[lag] = kept * track.ray_covariance[lag] + fit.autocovariance[lag];
    track.ray_pairs[lag] = kept * track.ray_pairs[lag] + fit.pairs[lag];
  }
  track.support = track.known ? 0.9 * track.support + 0.1 * fit.support : fit.support;
  // Light changes along the way: the colour is remembered for about fifty frames.
  track.colour =
      track.known ? Eigen::Vector3f(0.98F * track.colour + 0.02F * fit.colour) : fit.colour;
  track.known = true;
}

void BodyFollower::follow(const cv::Mat& frame, int number) {
  // 1. Prediction: as fast as in the last frame; what was not seen slows down
  for (BodyTrack& track : tracks_) {
    if (!track.known) continue;
    track.last.x += track.velocity[0];
    track.last.z += track.velocity[1];
    track.last.angle += track.velocity[2];
  }
  // 2. Two sweeps: the second knows where the neighbours are now
  const EdgeImage image(frame, working_region(), 0.8);
  std::vector<BodyFit> fits(tracks_.size());
  std::vector<BodyPose> predicted;
  for (const BodyTrack& track : tracks_) predicted.push_back(track.last);
  // The paint first: it knows its body apart from neighbours and ground
  std::vector<std::optional<PaintFit>> paints(tracks_.size());
  for (std::size_t body = 0; body < tracks_.size(); ++body) {
    if (!tracks_[body].known) continue;
    paints[body] = see_paint(image, tracks_[body]);
    if (paints[body]) tracks_[body].last = paints[body]->pose;
  }
  for (int sweep = 0; sweep < 2; ++sweep) {
    for (std::size_t body = 0; body < tracks_.size(); ++body) {
      BodyTrack& track = tracks_[body];
      if (!track.known) continue;
      const double radius_px =
          view_.lens().scale(track.last.x, track.last.z) * view_.shape.radius[0];
      RefineOptions refine{.window_px = std::max(2.5, (sweep == 0 ? 0.18 : 0.1) * radius_px),
                           .iterations = sweep == 0 ? 3 : 1,
                           .noise = view_.edge_noise,
                           .limb = sweep == 0 ? nullptr : &*view_.limb};
      if (const auto& paint = paints[body]) {
        refine.known = {paint->pose, paint->information};
        refine.ray_variance = ray_variance(track.ray_covariance, track.ray_pairs);
      }
      fits[body] =
          refine_body(image, view_.lens(), view_.shape, track.last, surroundings_of(body), refine);
      if (paints[body] || fits[body].support >= track.lost_support()) track.last = fits[body].pose;
    }
  }
  // 3. Who was lost: neither outline nor paint there, too far from where it could be, or inside
  // another body
  std::vector<std::size_t> lost;
  for (std::size_t body = 0; body < tracks_.size(); ++body) {
    bool is_lost = !tracks_[body].known ||
                   (!paints[body] && (fits[body].support < tracks_[body].lost_support() ||
                                      fits[body].visible < 0.08));
    for (std::size_t other = 0; other < tracks_.size() && !is_lost && !paints[body]; ++other) {
      if (other != body && tracks_[other].known &&
          (paints[other] || fits[other].support >= fits[body].support) &&
          overlap(fits[body].pose, fits[other].pose, view_.shape))
        is_lost = true;
    }
    if (is_lost) {
      lost.push_back(body);
      tracks_[body].last = predicted[body];
    } else {
      if (paints[body]) {
        double& likeness = tracks_[body].likeness;
        likeness = 0.9 * likeness + 0.1 * paints[body]->likeness;
      }
      accept(tracks_[body], fits[body], number);
    }
  }
  if (!lost.empty()) recover(frame, number, lost);
  // 4. What the balls show
  keep_textures(image, number);
  keep_picture(frame, number);
}

// Every one at first; every second of them when they become too many, and so on.
void BodyFollower::keep_picture(const cv::Mat& frame, int number) {
  if (!view_.shape.shows_angle() || number % stride_ != 0) return;
  constexpr std::size_t most = 64;
  if (pictures_.size() >= most) {
    stride_ *= 2;
    std::erase_if(pictures_, [&](const KeptPicture& kept) { return kept.number % stride_ != 0; });
    if (number % stride_ != 0) return;
  }
  const cv::Rect region = working_region() & cv::Rect({}, frame.size());
  pictures_.push_back({number, frame(region).clone(), region.tl(), view_.surroundings().walls});
}

std::optional<PaintFit> BodyFollower::see_paint(const EdgeImage& image,
                                                const BodyTrack& track) const {
  if (!view_.shape.shows_angle()) return std::nullopt;
  PaintFit fit = fit_paint(image, view_.lens(), view_.shape, track.last, grids_, track.paint);
  // Further than a predicted body can be off, it found somebody else's paint
  const double off = std::hypot(fit.pose.x - track.last.x, fit.pose.z - track.last.z);
  if (!fit.found || fit.likeness < track.lost_likeness() || off > 0.5 * view_.shape.radius[0])
    return std::nullopt;
  return fit;
}

// A single ball may roll: what it shows moves and turns in ways that the outline does not tell, and
// is no witness of where it is.
void BodyFollower::keep_textures(const EdgeImage& image, int number) {
  if (!view_.shape.shows_angle()) return;
  const auto frame = static_cast<std::size_t>(number);
  for (BodyTrack& track : tracks_) {
    for (std::size_t ball = 0; ball < 2; ++ball) {
      track.textures[ball].resize(frame + 1);
      if (track.fits.size() > frame && track.fits[frame])
        track.textures[ball][frame] =
            sample_texture(image, view_.lens(), view_.shape, track.fits[frame]->pose, grids_[ball]);
    }
    // Light changes along the way: looks are remembered for about fifty frames
    track.paint.learn({track.textures[0][frame], track.textures[1][frame]}, 0.02F);
  }
}

// A body that the prediction did not find: looked for about the predicted place, then in the whole
// region.
void BodyFollower::recover(const cv::Mat& frame, int number, const std::vector<std::size_t>& lost) {
  const EdgeImage image(frame, cv::Rect(0, 0, frame.cols, frame.rows), 0.8);
  std::vector<char> is_lost(tracks_.size(), 0);
  for (std::size_t body : lost) is_lost[body] = 1;
  Surroundings others = view_.surroundings();
  for (std::size_t body = 0; body < tracks_.size(); ++body) {
    if (is_lost[body] || !tracks_[body].known) continue;
    others.add(tracks_[body].last, view_.shape);
  }
  // 1. Detections: the picture's own candidates, and starts all round each predicted place
  std::vector<BodyFit> found = view_.fits_in(frame, image, view_.shape, known_tolerance, others);
  for (std::size_t body : lost) {
    if (!tracks_[body].known) continue;
    const BodyPose& at = tracks_[body].last;
    const double radius_px = view_.lens().scale(at.x, at.z) * view_.shape.radius[0];
    const int turns = view_.shape.shows_angle() ? 1 : 0;
    for (int i = -2; i <= 2; ++i) {
      for (int j = -2; j <= 2; ++j) {
        for (int k = -turns; k <= turns; ++k) {
          const double stride = 0.25 * view_.shape.radius[0];
          const BodyPose start{at.x + i * stride, at.z + j * stride, at.angle + 15.0 * degree * k};
          BodyFit fit = refine_body(image,
                                    view_.lens(),
                                    view_.shape,
                                    start,
                                    others,
                                    {.window_px = std::max(2.5, 0.16 * radius_px),
                                     .iterations = 3,
                                     .noise = view_.edge_noise});
          if (fit.support >= tracks_[body].lost_support()) found.push_back(fit);
        }
      }
    }
  }
  // 2. Not where somebody else is
  std::erase_if(found, [&](const BodyFit& fit) {
    for (std::size_t body = 0; body < tracks_.size(); ++body)
      if (!is_lost[body] && tracks_[body].known &&
          overlap(fit.pose, tracks_[body].last, view_.shape))
        return true;
    return false;
  });
  const std::vector<BodyFit> chosen = choose_bodies(found, view_.shape, lost.size());
  // 3. To whom each belongs
  std::vector<Expectation> expectations;
  std::vector<std::size_t> waiting;
  for (std::size_t body : lost) {
    const BodyTrack& track = tracks_[body];
    if (!track.known) continue;
    // A frame of free fall and a push of as much again, growing while unseen; the angle may have
    // turned with it.
    const double interval = 1.0 / view_.spec.camera.frame_rate;
    const double frames = 1.0 + track.unseen;
    const double reach = 2.0 * view_.spec.rig.gravity * interval * interval * frames * frames +
                         0.25 * view_.shape.radius[0];
    const double lever =
        0.5 * (view_.shape.shows_angle() ? view_.shape.separation : view_.shape.radius[0]);
    expectations.push_back({track.last, reach, reach / lever, track.colour});
    waiting.push_back(body);
  }
  std::vector<Detection> detections;
  for (const BodyFit& fit : chosen) detections.push_back({fit.pose, fit.colour});
  const std::vector<int> detection_of = link(expectations, detections);
  std::vector<char> used(chosen.size(), 0);
  std::vector<char> recovered(tracks_.size(), 0);
  for (std::size_t i = 0; i < waiting.size(); ++i) {
    if (detection_of[i] < 0) continue;
    const auto detection = static_cast<std::size_t>(detection_of[i]);
    used[detection] = 1;
    BodyTrack& track = tracks_[waiting[i]];
    BodyFit fit = refine_body(image,
                              view_.lens(),
                              view_.shape,
                              chosen[detection].pose,
                              others,
                              {.iterations = 1, .noise = view_.edge_noise, .limb = &*view_.limb});
    // The end nearest to the expected direction
    const double turn =
        view_.shape.shows_angle() ? axis_difference(fit.pose.angle, track.last.angle) : 0.0;
    const double turned = track.last.angle + turn - fit.pose.angle;
    if (static_cast<long>(std::lround(turned / std::numbers::pi)) % 2 != 0)
      std::swap(fit.balls[0], fit.balls[1]);
    fit.pose.angle += turned;
    accept(track, fit, number);
    recovered[waiting[i]] = 1;
  }
  for (std::size_t body : lost) {
    BodyTrack& track = tracks_[body];
    if (recovered[body] || !track.known) continue;
    ++track.unseen;
    track.velocity *= 0.8;
    track.fits.resize(static_cast<std::size_t>(number) + 1);
  }
}

}  // namespace graintruth::tracking
