#include "tracking/track_video.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "datasets/input_error.h"
#include "tracking/bodies.h"
#include "tracking/clock.h"
#include "tracking/event.h"
#include "tracking/film_camera.h"
#include "tracking/learn.h"
#include "tracking/link.h"
#include "tracking/median.h"
#include "tracking/overlay.h"
#include "tracking/texture.h"
#include "tracking/video.h"

namespace graintruth::tracking {

using datasets::InputError;

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double degree = std::numbers::pi / 180.0;

// Below this share of the support that it used to have, or of what clutter reaches if that is less,
// a body is not where it was thought to be.
constexpr double kept_support = 0.8;
// Below this it never is.
constexpr double least_support = 0.4;

// How far the distance of two candidates may be off the separation, relative: where all is still
// unknown, and where neighbours are known.
constexpr double first_tolerance = 0.12, known_tolerance = 0.15;

// Where particles can be: about the walls, the piston and the start places; the whole picture where
// nothing is known.
PlaneRegion search_region(const datasets::Experiment& experiment,
                          const Camera& camera,
                          double radius) {
  PlaneRegion seen{1.0e9, -1.0e9, 1.0e9, -1.0e9};
  const auto include = [](PlaneRegion& region, double x, double z) {
    region.left = std::min(region.left, x);
    region.right = std::max(region.right, x);
    region.bottom = std::min(region.bottom, z);
    region.top = std::max(region.top, z);
  };
  for (double column : {0.0, camera.width() - 1.0}) {
    for (double row : {0.0, camera.height() - 1.0}) {
      const Eigen::Vector2d corner = camera.unproject({column, row});
      include(seen, corner.x(), corner.y());
    }
  }
  PlaneRegion rig{1.0e9, -1.0e9, 1.0e9, -1.0e9};
  for (const auto& wall : experiment.rig.walls) {
    include(rig, wall.from_x, wall.from_z);
    include(rig, wall.to_x, wall.to_z);
  }
  for (const auto& start : experiment.starts) {
    include(rig, start.x - 2.5 * radius, start.z - 2.5 * radius);
    include(rig, start.x + 2.5 * radius, start.z + 2.5 * radius);
  }
  if (rig.left >= rig.right || rig.bottom >= rig.top) return seen;
  // Particles may lie above the ends of the walls.
  return {std::max(seen.left, rig.left - radius),
          std::min(seen.right, rig.right + radius),
          std::max(seen.bottom, rig.bottom - radius),
          std::min(seen.top, rig.top + 4.0 * radius)};
}

// One particle's history.
struct Track {
  std::vector<std::optional<BodyFit>> fits;  // one a frame
  std::array<std::vector<TexturePatch>, 2>
      textures;   // of each ball, one a frame; empty where unseen
  BodyPose last;  // last seen, or predicted since
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // a frame: x, z, angle
  int unseen = 0;                                      // frames since it was seen
  bool known = false;                                  // was ever seen
  double support = 1.0;                                // of late
  Eigen::Vector3f colour = Eigen::Vector3f::Zero();

  double lost_support() const {
    return std::clamp(kept_support * support, least_support, clutter_support);
  }
};

class FilmTracker {
 public:
  FilmTracker(const datasets::Experiment& experiment, const datasets::Replicate& replicate)
      : experiment_(experiment),
        replicate_(replicate),
        nominal_(nominal_shape(experiment)),
        shape_(nominal_) {
    summary_.replicate = replicate.name;
  }

  TrackedFilm run(const TrackingOptions& options);

 private:
  void begin(const cv::Mat& frame);
  std::vector<BallCandidate> candidates_in(const cv::Mat& frame, const BodyShape& shape) const;
  std::vector<BodyFit> fits_in(const cv::Mat& frame,
                               const EdgeImage& image,
                               const BodyShape& shape,
                               double tolerance,
                               const Surroundings& surroundings) const;
  void find_first_bodies(const cv::Mat& frame);
  void add_hidden(const cv::Mat& frame, const EdgeImage& image, std::vector<BodyFit>& bodies) const;
  void follow(const cv::Mat& frame, int number);
  void recover(const cv::Mat& frame, int number, const std::vector<std::size_t>& lost);
  void accept(Track& track, const BodyFit& fit, int number);
  void keep_textures(const EdgeImage& image, int number);
  void learn_sizes(const EdgeImage& image, std::vector<BodyFit>& bodies);
  Surroundings surroundings_of(std::size_t body) const;
  cv::Rect working_region() const;
  double find_event(int frames);
  void count_doubts(const datasets::Trajectories& tracks);
  void judge(const Learned& learned);
  void warn(std::string sentence) { summary_.warn(std::move(sentence)); }
  void fail(std::string sentence) { summary_.fail(std::move(sentence)); }
  std::string where() const { return replicate_.video.string(); }

  const datasets::Experiment& experiment_;
  const datasets::Replicate& replicate_;
  BodyShape nominal_;
  BodyShape shape_;  // sizes as they look in this film, learned in the first frame
  FilmCamera camera_;
  PlaneRegion region_;
  double camera_noise_ = 1.0;         // grey levels, of a pixel
  double noise_ = 1.0;                // grey levels, of edges
  std::optional<LimbModel> limb_;     // from the first frame on
  std::array<TextureGrid, 2> grids_;  // likewise
  std::vector<Track> tracks_;
  std::vector<datasets::Wall> walls_;  // as seen: in the particle plane, and their front edges
  std::optional<PistonWatcher> piston_;
  TrackingSummary summary_;
};

void FilmTracker::begin(const cv::Mat& frame) {
  cv::Mat grey;
  cv::cvtColor(frame, grey, cv::COLOR_BGR2GRAY);
  camera_ = calibrate_on(experiment_, frame, where());
  const datasets::Fiducial& any = experiment_.camera.fiducials.front();
  describe_camera(
      camera_, experiment_, 1.0 / camera_.calibration.camera.scale(any.x, any.z), summary_);
  const double noise = camera_noise(frame);
  camera_noise_ = std::max(1.0, noise);
  noise_ = edge_noise(frame, noise);
  region_ = search_region(experiment_, camera_.calibration.camera, nominal_.radius[0]);
  // Bars reach half the gap towards the camera; their front edges are seen beside their place in
  // the plane.
  walls_ = experiment_.rig.walls;
  for (const datasets::Wall& wall : experiment_.rig.walls) {
    const Camera& camera = camera_.calibration.camera;
    const double front = 0.5 * experiment_.rig.front_back_gap;
    const Eigen::Vector2d from =
        camera.unproject(camera.project(Eigen::Vector3d(wall.from_x, wall.from_z, front)));
    const Eigen::Vector2d to =
        camera.unproject(camera.project(Eigen::Vector3d(wall.to_x, wall.to_z, front)));
    walls_.push_back({wall.name + " front", from.x(), from.y(), to.x(), to.y()});
  }
  if (experiment_.rig.piston)
    piston_.emplace(*experiment_.rig.piston, experiment_.camera.frame_rate);
  if (piston_) piston_->measure(grey, camera_.calibration.camera);
  find_first_bodies(frame);
}

std::vector<BallCandidate> FilmTracker::candidates_in(const cv::Mat& frame,
                                                      const BodyShape& shape) const {
  const double radius = 0.5 * (shape.radius[0] + shape.radius[1]);
  std::vector<BallCandidate> candidates = locate_balls(frame,
                                                       camera_.calibration.camera,
                                                       region_,
                                                       radius,
                                                       camera_noise_,
                                                       static_cast<int>(8 * tracks_.size() + 16));
  if (shape.balls == 2) return candidates;
  // A dot as large as a ball is as round as one.
  std::erase_if(candidates, [&](const BallCandidate& candidate) {
    return std::any_of(experiment_.camera.fiducials.begin(),
                       experiment_.camera.fiducials.end(),
                       [&](const datasets::Fiducial& dot) {
                         return std::hypot(candidate.x - dot.x, candidate.z - dot.z) < 0.5 * radius;
                       });
  });
  return candidates;
}

// What looks like a body of this shape, beside these surroundings.
std::vector<BodyFit> FilmTracker::fits_in(const cv::Mat& frame,
                                          const EdgeImage& image,
                                          const BodyShape& shape,
                                          double tolerance,
                                          const Surroundings& surroundings) const {
  return fit_bodies(image,
                    camera_.calibration.camera,
                    shape,
                    possible_poses(shape, candidates_in(frame, shape), tolerance),
                    surroundings,
                    noise_);
}

void FilmTracker::find_first_bodies(const cv::Mat& frame) {
  const auto count = static_cast<std::size_t>(experiment_.particle.count);
  const EdgeImage image(frame, cv::Rect(0, 0, frame.cols, frame.rows), 0.8);
  tracks_.resize(count);
  const Surroundings alone = surroundings_of(count);
  // 1. Candidates over a range of sizes: the stated one may be wrong by some per cent, and must
  // then be told so
  std::vector<BodyFit> best;
  double best_evidence = -1.0, best_factor = 1.0;
  for (const double factor : {1.0, 0.94, 1.06, 0.88, 1.12}) {
    BodyShape tried = nominal_;
    tried.separation *= factor;
    for (double& r : tried.radius) r *= factor;
    const auto chosen =
        choose_bodies(fits_in(frame, image, tried, first_tolerance, alone), tried, count);
    double sum = 0.0;
    for (const BodyFit& fit : chosen) sum += evidence_of(fit);
    // The stated size is believed unless another one explains the picture clearly better.
    if (best_evidence < 0.0 || sum > 1.05 * best_evidence) {
      best = chosen;
      best_evidence = sum;
      best_factor = factor;
    }
    // All bodies, plainly seen, at the stated size: no need to look further.
    const bool convincing =
        chosen.size() == count && std::all_of(chosen.begin(), chosen.end(), [](const BodyFit& fit) {
          return fit.support > 0.7;
        });
    if (factor == 1.0 && convincing) break;
  }
  shape_.separation = nominal_.separation * best_factor;
  for (std::size_t ball = 0; ball < 2; ++ball)
    shape_.radius[ball] = nominal_.radius[ball] * best_factor;
  if (best.empty()) {
    const std::string sought =
        nominal_.shows_angle()
            ? fmt::format("two balls of radius {:.1f} mm, {:.1f} mm apart,",
                          1.0e3 * nominal_.radius[0],
                          1.0e3 * nominal_.separation)
            : fmt::format("one ball of radius {:.1f} mm", 1.0e3 * nominal_.radius[0]);
    throw InputError(
        fmt::format("{}: no particle of {} was found in the first frame; check the film, the "
                    "particle's size and the fiducials",
                    where(),
                    sought));
  }
  if (best.size() < count) add_hidden(frame, image, best);
  learn_sizes(image, best);
  if (shape_.shows_angle()) {
    for (std::size_t ball = 0; ball < 2; ++ball) grids_[ball] = make_texture_grid(shape_, ball);
  }
  // 2. Numbers
  std::vector<Eigen::Vector2d> centres;
  for (const BodyFit& fit : best) centres.emplace_back(fit.pose.x, fit.pose.z);
  const std::vector<int> numbered =
      number_by_start(centres, experiment_.starts, experiment_.particle.count, nominal_.radius[0]);
  for (std::size_t body = 0; body < count; ++body) {
    if (numbered[body] < 0) continue;
    BodyFit fit = best[static_cast<std::size_t>(numbered[body])];
    // First seen angle in [0, pi). Bodies with unequal balls keep their direction.
    if (nominal_.shows_angle() && nominal_.radius[0] == nominal_.radius[1] &&
        (fit.pose.angle < 0.0 || fit.pose.angle >= std::numbers::pi)) {
      const double turns = std::floor(fit.pose.angle / std::numbers::pi);
      fit.pose.angle -= turns * std::numbers::pi;
      if (static_cast<long>(turns) % 2 != 0) std::swap(fit.balls[0], fit.balls[1]);
    }
    accept(tracks_[body], fit, 0);
    if (!experiment_.starts.empty()) {
      const auto& start = experiment_.starts[body];
      const double off = std::hypot(fit.pose.x - start.x, fit.pose.z - start.z);
      if (off > nominal_.radius[0]) {
        warn(fmt::format("Particle {} was found {:.0f} mm from its start place in frame 0.",
                         body + 1,
                         1.0e3 * off));
      }
    }
  }
  keep_textures(image, 0);
  if (best.size() < count) {
    fail(fmt::format("Frame 0 shows {} particles but the experiment says {}.", best.size(), count));
  } else {
    // One more than stated?
    const auto more =
        choose_bodies(fits_in(frame, image, shape_, first_tolerance, alone), shape_, count + 1);
    if (more.size() > count) {
      double weakest_known = 1.0e9;
      for (const BodyFit& fit : best) weakest_known = std::min(weakest_known, evidence_of(fit));
      double weakest = 1.0e9;
      for (const BodyFit& fit : more) weakest = std::min(weakest, evidence_of(fit));
      if (weakest > 0.6 * weakest_known)
        warn(fmt::format(
            "Frame 0 seems to show more than the {} particles that the experiment states.", count));
    }
  }
}

// Adds bodies that an outline of their own hardly shows: neighbours cover most of it, or what lies
// behind has the same shade. What was found is known by now and no longer looked at. Where the
// experiment says that a body starts less of an outline will do.
void FilmTracker::add_hidden(const cv::Mat& frame,
                             const EdgeImage& image,
                             std::vector<BodyFit>& bodies) const {
  const auto count = static_cast<std::size_t>(experiment_.particle.count);
  const auto add_from = [&](std::vector<BodyPose> poses, double support) {
    for (std::size_t before = 0; bodies.size() > before && bodies.size() < count;) {
      before = bodies.size();
      const auto is_taken = [&](const BodyPose& pose) {
        return std::any_of(bodies.begin(), bodies.end(), [&](const BodyFit& known) {
          return overlap(known.pose, pose, shape_);
        });
      };
      std::erase_if(poses, is_taken);
      Surroundings around = surroundings_of(tracks_.size());
      for (const BodyFit& known : bodies) around.add(known.pose, shape_);
      std::vector<BodyFit> found =
          fit_bodies(image, camera_.calibration.camera, shape_, poses, around, noise_, support);
      std::erase_if(found, [&](const BodyFit& fit) { return is_taken(fit.pose); });
      for (BodyFit& fit : choose_bodies(found, shape_, count - bodies.size()))
        bodies.push_back(std::move(fit));
    }
  };
  std::vector<BodyPose> starts;
  for (const datasets::StartPlace& start : experiment_.starts) {
    const double stride = 0.15 * shape_.radius[0];
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j)
        starts.push_back({start.x + i * stride, start.z + j * stride, start.angle});
  }
  add_from(starts, least_support);
  add_from(possible_poses(shape_, candidates_in(frame, shape_), known_tolerance), clutter_support);
}

// The size at which the outlines of the first frame lie best, and how blurred they are. Edges are
// first taken where the picture changes most, which is near enough to learn the limb from.
void FilmTracker::learn_sizes(const EdgeImage& image, std::vector<BodyFit>& bodies) {
  const Surroundings alone = surroundings_of(tracks_.size());
  const auto surroundings_among = [&](std::size_t body) {
    Surroundings around = alone;
    for (std::size_t other = 0; other < bodies.size(); ++other) {
      if (other != body) around.add(bodies[other].pose, shape_);
    }
    return around;
  };
  const auto options_at = [&](const BodyPose& pose) {
    const double radius_px = camera_.calibration.camera.scale(pose.x, pose.z) * shape_.radius[0];
    return RefineOptions{.window_px = std::max(2.5, 0.1 * radius_px),
                         .iterations = 4,
                         .noise = noise_,
                         .limb = limb_ ? &*limb_ : nullptr};
  };
  for (int pass = 0; pass < 3; ++pass) {
    std::vector<double> radius_ratios, separations;
    std::vector<std::vector<BodyFit>> one_frame;
    for (const BodyFit& fit : bodies) one_frame.push_back({fit});
    const Learned learned = learn_shapes(one_frame, shape_);
    for (const LearnedShape& body : learned.bodies) {
      for (std::size_t ball = 0; ball < shape_.balls; ++ball)
        radius_ratios.push_back(body.shape.radius[ball] / shape_.radius[ball]);
      if (shape_.balls == 2) separations.push_back(body.shape.separation);
    }
    const double ratio = std::clamp(median(radius_ratios, nan), 0.9, 1.1);
    for (double& r : shape_.radius) r *= ratio;
    if (shape_.balls == 2)
      shape_.separation *= std::clamp(median(separations, nan) / shape_.separation, 0.9, 1.1);
    if (pass == 1) {
      ObservedLimbs observed;
      for (std::size_t i = 0; i < bodies.size(); ++i)
        observe_limbs(image,
                      camera_.calibration.camera,
                      shape_,
                      bodies[i].pose,
                      surroundings_among(i),
                      options_at(bodies[i].pose),
                      observed);
      const BodyPose& any = bodies.front().pose;
      limb_.emplace(
          learn_limb_model(camera_.calibration.camera.scale(any.x, any.z) * shape_.radius[0],
                           observed.profiles,
                           observed.edges));
    }
    std::vector<BodyFit> refitted;
    for (std::size_t i = 0; i < bodies.size(); ++i)
      refitted.push_back(refine_body(image,
                                     camera_.calibration.camera,
                                     shape_,
                                     bodies[i].pose,
                                     surroundings_among(i),
                                     options_at(bodies[i].pose)));
    bodies = refitted;
  }
}

Surroundings FilmTracker::surroundings_of(std::size_t body) const {
  Surroundings result;
  result.walls = walls_;
  if (experiment_.rig.piston && piston_) {
    const auto& piston = *experiment_.rig.piston;
    const double face = piston_->last_height();
    result.walls.push_back({"piston", piston.left_x, face, piston.right_x, face});
  }
  for (std::size_t other = 0; other < tracks_.size(); ++other) {
    if (other == body || !tracks_[other].known) continue;
    result.add(tracks_[other].last, shape_);
  }
  return result;
}

cv::Rect FilmTracker::working_region() const {
  double left = 1.0e9, right = -1.0e9, top = 1.0e9, bottom = -1.0e9;
  for (const Track& track : tracks_) {
    if (!track.known) continue;
    const Eigen::Vector2d pixel = camera_.calibration.camera.project(track.last.x, track.last.z);
    const Eigen::Matrix2d jacobian =
        camera_.calibration.camera.jacobian(track.last.x, track.last.z);
    const double reach = 0.5 * shape_.separation + 1.6 * shape_.radius[0];
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

void FilmTracker::accept(Track& track, const BodyFit& fit, int number) {
  if (track.known && track.unseen == 0 && number > 0) {
    const BodyPose& before = track.fits.back()->pose;
    track.velocity << fit.pose.x - before.x, fit.pose.z - before.z, fit.pose.angle - before.angle;
  }
  track.fits.resize(static_cast<std::size_t>(number));
  track.fits.push_back(fit);
  track.last = fit.pose;
  track.unseen = 0;
  track.support = track.known ? 0.9 * track.support + 0.1 * fit.support : fit.support;
  // Light changes along the way: the colour is remembered for about fifty frames.
  track.colour =
      track.known ? Eigen::Vector3f(0.98F * track.colour + 0.02F * fit.colour) : fit.colour;
  track.known = true;
}

void FilmTracker::follow(const cv::Mat& frame, int number) {
  cv::Mat grey;
  if (piston_) {
    cv::cvtColor(frame, grey, cv::COLOR_BGR2GRAY);
    piston_->measure(grey, camera_.calibration.camera);
  }
  // 1. Prediction: as fast as in the last frame; what was not seen slows down
  for (Track& track : tracks_) {
    if (!track.known) continue;
    track.last.x += track.velocity[0];
    track.last.z += track.velocity[1];
    track.last.angle += track.velocity[2];
  }
  // 2. Two sweeps: the second knows where the neighbours are now
  const EdgeImage image(frame, working_region(), 0.8);
  std::vector<BodyFit> fits(tracks_.size());
  std::vector<BodyPose> predicted;
  for (const Track& track : tracks_) predicted.push_back(track.last);
  for (int sweep = 0; sweep < 2; ++sweep) {
    for (std::size_t body = 0; body < tracks_.size(); ++body) {
      Track& track = tracks_[body];
      if (!track.known) continue;
      const double radius_px =
          camera_.calibration.camera.scale(track.last.x, track.last.z) * shape_.radius[0];
      const RefineOptions refine{.window_px = std::max(2.5, (sweep == 0 ? 0.18 : 0.1) * radius_px),
                                 .iterations = sweep == 0 ? 3 : 1,
                                 .noise = noise_,
                                 .limb = sweep == 0 ? nullptr : &*limb_};
      fits[body] = refine_body(
          image, camera_.calibration.camera, shape_, track.last, surroundings_of(body), refine);
      if (fits[body].support >= track.lost_support()) track.last = fits[body].pose;
    }
  }
  // 3. Who was lost: no outline there, too far from where it could be, or inside another body
  std::vector<std::size_t> lost;
  for (std::size_t body = 0; body < tracks_.size(); ++body) {
    bool is_lost = !tracks_[body].known || fits[body].support < tracks_[body].lost_support() ||
                   fits[body].visible < 0.08;
    for (std::size_t other = 0; other < tracks_.size() && !is_lost; ++other) {
      if (other != body && tracks_[other].known && fits[other].support >= fits[body].support &&
          overlap(fits[body].pose, fits[other].pose, shape_))
        is_lost = true;
    }
    if (is_lost) {
      lost.push_back(body);
      tracks_[body].last = predicted[body];
    } else {
      accept(tracks_[body], fits[body], number);
    }
  }
  if (!lost.empty()) recover(frame, number, lost);
  // 4. What the balls show
  keep_textures(image, number);
}

// A single ball may roll: what it shows moves and turns in ways that the outline does not tell, and
// is no witness of where it is.
void FilmTracker::keep_textures(const EdgeImage& image, int number) {
  if (!shape_.shows_angle()) return;
  const auto frame = static_cast<std::size_t>(number);
  for (Track& track : tracks_) {
    for (std::size_t ball = 0; ball < 2; ++ball) {
      track.textures[ball].resize(frame + 1);
      if (track.fits.size() > frame && track.fits[frame])
        track.textures[ball][frame] = sample_texture(
            image, camera_.calibration.camera, shape_, track.fits[frame]->pose, grids_[ball]);
    }
  }
}

// A body that the prediction did not find: looked for about the predicted place, then in the whole
// region.
void FilmTracker::recover(const cv::Mat& frame, int number, const std::vector<std::size_t>& lost) {
  const EdgeImage image(frame, cv::Rect(0, 0, frame.cols, frame.rows), 0.8);
  std::vector<char> is_lost(tracks_.size(), 0);
  for (std::size_t body : lost) is_lost[body] = 1;
  Surroundings others;
  others.walls = surroundings_of(tracks_.size()).walls;
  for (std::size_t body = 0; body < tracks_.size(); ++body) {
    if (is_lost[body] || !tracks_[body].known) continue;
    others.add(tracks_[body].last, shape_);
  }
  // 1. Detections: the picture's own candidates, and starts all round each predicted place
  std::vector<BodyFit> found = fits_in(frame, image, shape_, known_tolerance, others);
  for (std::size_t body : lost) {
    if (!tracks_[body].known) continue;
    const BodyPose& at = tracks_[body].last;
    const double radius_px = camera_.calibration.camera.scale(at.x, at.z) * shape_.radius[0];
    const int turns = shape_.shows_angle() ? 1 : 0;
    for (int i = -2; i <= 2; ++i) {
      for (int j = -2; j <= 2; ++j) {
        for (int k = -turns; k <= turns; ++k) {
          const double stride = 0.25 * shape_.radius[0];
          const BodyPose start{at.x + i * stride, at.z + j * stride, at.angle + 15.0 * degree * k};
          BodyFit fit = refine_body(
              image,
              camera_.calibration.camera,
              shape_,
              start,
              others,
              {.window_px = std::max(2.5, 0.16 * radius_px), .iterations = 3, .noise = noise_});
          if (fit.support >= tracks_[body].lost_support()) found.push_back(fit);
        }
      }
    }
  }
  // 2. Not where somebody else is
  std::erase_if(found, [&](const BodyFit& fit) {
    for (std::size_t body = 0; body < tracks_.size(); ++body)
      if (!is_lost[body] && tracks_[body].known && overlap(fit.pose, tracks_[body].last, shape_))
        return true;
    return false;
  });
  const std::vector<BodyFit> chosen = choose_bodies(found, shape_, lost.size());
  // 3. To whom each belongs
  std::vector<Expectation> expectations;
  std::vector<std::size_t> waiting;
  for (std::size_t body : lost) {
    const Track& track = tracks_[body];
    if (!track.known) continue;
    // A frame of free fall and a push of as much again, growing while unseen; the angle may have
    // turned with it.
    const double interval = 1.0 / experiment_.camera.frame_rate;
    const double frames = 1.0 + track.unseen;
    const double reach = 2.0 * experiment_.rig.gravity * interval * interval * frames * frames +
                         0.25 * shape_.radius[0];
    const double lever = 0.5 * (shape_.shows_angle() ? shape_.separation : shape_.radius[0]);
    expectations.push_back({track.last, reach, reach / lever, track.colour});
    waiting.push_back(body);
  }
  const std::vector<int> detection_of = link(expectations, chosen);
  std::vector<char> used(chosen.size(), 0);
  std::vector<char> recovered(tracks_.size(), 0);
  for (std::size_t i = 0; i < waiting.size(); ++i) {
    if (detection_of[i] < 0) continue;
    const auto detection = static_cast<std::size_t>(detection_of[i]);
    used[detection] = 1;
    Track& track = tracks_[waiting[i]];
    BodyFit fit = refine_body(image,
                              camera_.calibration.camera,
                              shape_,
                              chosen[detection].pose,
                              others,
                              {.iterations = 1, .noise = noise_, .limb = &*limb_});
    // The end nearest to the expected direction
    const double turn =
        shape_.shows_angle() ? axis_difference(fit.pose.angle, track.last.angle) : 0.0;
    const double turned = track.last.angle + turn - fit.pose.angle;
    if (static_cast<long>(std::lround(turned / std::numbers::pi)) % 2 != 0)
      std::swap(fit.balls[0], fit.balls[1]);
    fit.pose.angle += turned;
    accept(track, fit, number);
    recovered[waiting[i]] = 1;
  }
  for (std::size_t body : lost) {
    Track& track = tracks_[body];
    if (recovered[body] || !track.known) continue;
    ++track.unseen;
    track.velocity *= 0.8;
    track.fits.resize(static_cast<std::size_t>(number) + 1);
  }
}

// Time zero in seconds of film.
double FilmTracker::find_event(int frames) {
  const double interval = 1.0 / experiment_.camera.frame_rate;
  const auto& noted = experiment_.camera.noted_event_time;
  summary_.noted_event_time_s = noted ? *noted : nan;
  std::optional<Event> event;
  if (piston_) {
    const datasets::Piston& piston = *experiment_.rig.piston;
    event = fit_onset(piston_->record(), piston.velocity_z);
    // Second witness: the particles that rest on the face at first, their mean height
    HeightRecord resting;
    const double reach = 0.15 * shape_.radius[0];
    std::vector<std::size_t> on_face;
    for (std::size_t body = 0; body < tracks_.size(); ++body) {
      if (tracks_[body].fits.empty() || !tracks_[body].fits[0]) continue;
      const auto centres = ball_centres(tracks_[body].fits[0]->pose, shape_);
      const double lowest =
          std::min(centres[0].y() - shape_.radius[0], centres[1].y() - shape_.radius[1]);
      const double middle = tracks_[body].fits[0]->pose.x;
      if (middle > piston.left_x && middle < piston.right_x && lowest < piston.face_z + reach &&
          lowest > piston.face_z - reach)
        on_face.push_back(body);
    }
    for (int frame = 0; frame < frames && !on_face.empty(); ++frame) {
      double sum = 0.0;
      for (std::size_t body : on_face) {
        const auto& fits = tracks_[body].fits;
        const auto k = static_cast<std::size_t>(frame);
        sum += k < fits.size() && fits[k] ? fits[k]->pose.z : nan;
      }
      resting.time.push_back(frame * interval);
      resting.height.push_back(sum / static_cast<double>(on_face.size()));
    }
    std::optional<Event> witness;
    if (!on_face.empty()) witness = fit_onset(resting, piston.velocity_z);
    if (!event && witness) {
      event = witness;
      event->how = "particles on the piston";
      // Held back by its neighbours a particle sinks more slowly than the piston at first and
      // catches up later: the line through its path meets the rest up to a frame late.
      event->uncertainty = std::max(event->uncertainty, interval);
      warn(
          "The piston's face could not be followed; the start of motion is that of the particles "
          "resting on it.");
    } else if (event && witness && std::abs(event->time - witness->time) > 2.0 * interval) {
      warn(fmt::format(
          "The piston seems to start at {:.3f} s of film but the particles on it at {:.3f} s.",
          event->time,
          witness->time));
    }
    if (event && std::abs(event->speed / piston.velocity_z - 1.0) > 0.05) {
      warn(
          fmt::format("The piston moves at {:.1f} mm/s on the film but the experiment says {:.1f} "
                      "mm/s: frame rate, scale "
                      "or speed is wrong.",
                      1.0e3 * event->speed,
                      1.0e3 * piston.velocity_z));
    }
  } else {
    // First motion of any particle: the first of three frames in a row away from rest by five times
    // the jitter of rest
    int earliest = -1;
    for (const Track& track : tracks_) {
      if (track.fits.size() < 8 || !track.fits[0]) continue;
      const BodyPose& rest = track.fits[0]->pose;
      std::vector<double> steps;
      for (std::size_t k = 1; k < track.fits.size(); ++k)
        if (track.fits[k] && track.fits[k - 1])
          steps.push_back(std::hypot(track.fits[k]->pose.x - track.fits[k - 1]->pose.x,
                                     track.fits[k]->pose.z - track.fits[k - 1]->pose.z));
      std::sort(steps.begin(), steps.end());
      const double pixel = 1.0 / camera_.calibration.camera.scale(rest.x, rest.z);
      const double jitter =
          steps.empty() ? pixel
                        : std::max(0.05 * pixel, std::min(steps[steps.size() / 10], 0.3 * pixel));
      int run = 0;
      for (std::size_t k = 1; k < track.fits.size(); ++k) {
        const bool away =
            track.fits[k] && std::hypot(track.fits[k]->pose.x - rest.x,
                                        track.fits[k]->pose.z - rest.z) > 5.0 * jitter;
        run = away ? run + 1 : 0;
        if (run == 3) {
          const int start = static_cast<int>(k) - 2;
          if (earliest < 0 || start < earliest) earliest = start;
          break;
        }
      }
    }
    if (earliest > 1) {
      event.emplace();
      event->time = (earliest - 0.5) * interval;
      event->uncertainty = interval;
      event->how = "first motion";
    }
  }
  if (!event) {
    if (!noted) {
      throw InputError(fmt::format(
          "{}: the start of motion cannot be found on the film (it must show at least a few "
          "frames before it); cut the film less closely or give camera.noted_event_s",
          where()));
    }
    event.emplace();
    event->time = *noted;
    event->uncertainty = interval;
    event->how = "noted by the laboratory";
    fail(fmt::format(
        "The start of motion could not be found on the film; the noted time {:.3f} s was used.",
        *noted));
  } else if (noted && std::abs(event->time - *noted) > 3.0 * event->uncertainty + 0.5 * interval) {
    warn(fmt::format("Motion starts at {:.3f} s of film (+- {:.3f} s, {}), but {:.3f} s was noted.",
                     event->time,
                     event->uncertainty,
                     event->how,
                     *noted));
  }
  summary_.event_time_s = event->time;
  summary_.event_uncertainty_s = event->uncertainty;
  summary_.event_source = event->how;
  summary_.event_speed_m_per_s = event->speed;
  return event->time;
}

// Turns too large for a frame, and steps that two neighbours would have explained about as well the
// other way round.
void FilmTracker::count_doubts(const datasets::Trajectories& tracks) {
  constexpr double largest_turn = 60.0 * degree;
  const auto count = static_cast<std::size_t>(tracks.particles);
  // A step into another's place is in doubt when it is not shorter by half a radius: bodies cannot
  // come that near to each other while the camera looks.
  const double margin = 0.5 * shape_.radius[0];
  const auto step = [&](std::size_t k, std::size_t from, std::size_t to) {
    const datasets::Pose &before = tracks.poses[tracks.index(k - 1, from)],
                         &now = tracks.poses[tracks.index(k, to)];
    return std::hypot(now.x - before.x, now.z - before.z);
  };
  for (std::size_t k = 1; k < tracks.frames(); ++k) {
    for (std::size_t a = 0; a < count; ++a) {
      const double turn =
          tracks.poses[tracks.index(k, a)].angle - tracks.poses[tracks.index(k - 1, a)].angle;
      if (std::abs(turn) > largest_turn) ++summary_.angle_jumps;
      // Not seen compares false
      for (std::size_t b = a + 1; b < count; ++b)
        if (step(k, a, b) + step(k, b, a) < step(k, a, a) + step(k, b, b) + 2.0 * margin)
          ++summary_.suspected_swaps;
    }
  }
}

void FilmTracker::judge(const Learned& learned) {
  const double nominal_radius = 0.5 * (nominal_.radius[0] + nominal_.radius[1]);
  summary_.radius_learned_mm = 1.0e3 * learned.radius_mean;
  summary_.radius_nominal_mm = 1.0e3 * nominal_radius;
  summary_.radius_spread_mm = 1.0e3 * learned.radius_spread;
  summary_.separation_learned_mm = 1.0e3 * learned.separation_mean;
  summary_.separation_nominal_mm = 1.0e3 * nominal_.separation;
  summary_.separation_spread_mm = 1.0e3 * learned.separation_spread;
  // Real particles and the look of their edges stay within three per cent.
  constexpr double size_tolerance = 0.03;
  if (std::abs(learned.radius_mean / nominal_radius - 1.0) > size_tolerance) {
    warn(
        fmt::format("The balls look {:.2f} mm in radius but the experiment says {:.2f} mm ({:+.1f} "
                    "%): check the "
                    "particle's size and the fiducials' positions.",
                    1.0e3 * learned.radius_mean,
                    1.0e3 * nominal_radius,
                    100.0 * (learned.radius_mean / nominal_radius - 1.0)));
  }
  if (nominal_.shows_angle() &&
      std::abs(learned.separation_mean / nominal_.separation - 1.0) > size_tolerance) {
    warn(
        fmt::format("The ball centres look {:.2f} mm apart but the experiment says {:.2f} mm "
                    "({:+.1f} %): check the "
                    "particle's size.",
                    1.0e3 * learned.separation_mean,
                    1.0e3 * nominal_.separation,
                    100.0 * (learned.separation_mean / nominal_.separation - 1.0)));
  }
  if (summary_.least_complete_particle < 0.995) {
    const std::string sentence = fmt::format("A particle was seen in only {:.1f} % of the frames.",
                                             100.0 * summary_.least_complete_particle);
    if (summary_.least_complete_particle < 0.9)
      fail(sentence);
    else
      warn(sentence);
  }
}

TrackedFilm FilmTracker::run(const TrackingOptions& options) {
  const auto started = std::chrono::steady_clock::now();
  // 1. The film, frame by frame
  VideoReader video(replicate_.video, experiment_.camera.frame_rate);
  summary_.width = video.width();
  summary_.height = video.height();
  cv::Mat frame;
  double noise_as_filmed = 0.0;  // grey levels
  while (video.read(frame)) {
    const int number = video.frames_read() - 1;
    if (number == 0) noise_as_filmed = camera_noise(frame);
    quieten(frame, noise_as_filmed);
    if (number == 0) {
      begin(frame);
      video.hold_steady(camera_.sightings);
    } else {
      follow(frame, number);
    }
    if (options.progress) options.progress(video.frames_read(), video.declared_frames());
    if (options.stop && options.stop()) throw Stopped{};
  }
  const int frames = video.frames_read();
  summary_.frames_declared = video.declared_frames();
  summary_.frames_read = summary_.frames_used = frames;
  summary_.frame_rate_hz = experiment_.camera.frame_rate;
  summary_.frame_rate_declared_hz = video.declared_frame_rate();
  summary_.repeated_frames = video.repeated_frames();
  for (std::string& sentence : video.warnings()) warn(std::move(sentence));
  describe_steadiness(*video.steady(), summary_);

  // 2. Sizes of each body from the whole clip; time zero
  std::vector<std::vector<BodyFit>> seen;
  for (Track& track : tracks_) {
    track.fits.resize(static_cast<std::size_t>(frames));
    std::vector<BodyFit>& list = seen.emplace_back();
    for (const auto& fit : track.fits)
      if (fit) list.push_back(*fit);
  }
  const Learned learned = learn_shapes(seen, shape_);
  const double zero = find_event(frames);

  // 3. Poses with these sizes, and their uncertainty
  TrackedFilm result;
  const int count = experiment_.particle.count;
  result.trajectories = datasets::make_trajectories(static_cast<std::size_t>(frames), count, true);
  datasets::Trajectories& out = result.trajectories;
  for (int k = 0; k < frames; ++k)
    out.time[static_cast<std::size_t>(k)] = k / experiment_.camera.frame_rate - zero;
  // Real balls differ: masses go with r^3, so the centre of mass moves along the axis by 3/4 of the
  // separation times the relative difference of the two radii.
  const double mass_shift =
      0.75 * shape_.separation * learned.radius_difference / learned.radius_mean;
  std::vector<BodyWitness> witnesses;
  for (std::size_t body = 0; body < tracks_.size(); ++body) {
    BodyWitness& witness = witnesses.emplace_back();
    witness.shape = learned.bodies[body].shape;
    witness.grids = grids_;
    for (std::size_t k = 0; k < static_cast<std::size_t>(frames); ++k) {
      const auto& fit = tracks_[body].fits[k];
      WitnessedPose& pose = witness.outline.emplace_back();
      if (!fit) continue;
      const SolvedPose solved = solve_pose(*fit, learned.bodies[body]);
      pose = {solved.pose, solved.covariance};
    }
    for (std::size_t ball = 0; ball < 2; ++ball) {
      witness.patches[ball] = std::move(tracks_[body].textures[ball]);
      witness.patches[ball].resize(static_cast<std::size_t>(frames));
    }
  }
  const auto joined = join_witnesses(witnesses);
  std::vector<double> position_sigmas, angle_sigmas, scatters;
  double score_sum = 0.0;
  int worst = frames;
  for (std::size_t body = 0; body < tracks_.size(); ++body) {
    int detections = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(frames); ++k) {
      const auto& fit = tracks_[body].fits[k];
      if (!fit) {
        if (k == 0 || tracks_[body].fits[k - 1]) ++summary_.gaps;
        continue;
      }
      ++detections;
      const WitnessedPose& solved = joined[body][k];
      Eigen::Matrix3d covariance = solved.covariance;
      covariance.topLeftCorner<2, 2>() +=
          camera_.calibration.point_covariance(solved.pose.x, solved.pose.z);
      const Eigen::Vector2d axis(std::cos(solved.pose.angle), std::sin(solved.pose.angle));
      covariance.topLeftCorner<2, 2>() += mass_shift * mass_shift * axis * axis.transpose();
      const std::size_t i = out.index(k, body);
      const bool turned = shape_.shows_angle();
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
    summary_.detections += detections;
    worst = std::min(worst, detections);
  }
  count_doubts(out);
  const BodyPose& any = tracks_[0].last;
  const double scale = camera_.calibration.camera.scale(any.x, any.z);  // px/m
  for (std::string& sentence :
       describe(find_clock_faults(out, 1.0 / scale), video.repeated_frames()))
    warn(std::move(sentence));
  summary_.particles = count;
  summary_.completeness = summary_.detections / (static_cast<double>(frames) * count);
  summary_.least_complete_particle = static_cast<double>(worst) / frames;
  summary_.mean_score = summary_.detections > 0 ? score_sum / summary_.detections : 0.0;
  summary_.scale_px_per_mm = 1.0e-3 * scale;
  summary_.position_sigma_mm = 1.0e3 * median(position_sigmas, nan);
  summary_.pixel_error_px = summary_.position_sigma_mm * summary_.scale_px_per_mm;
  summary_.angle_sigma_deg = median(angle_sigmas, nan) / degree;
  summary_.ray_scatter_px = median(scatters, nan);
  judge(learned);
  summary_.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  summary_.frames_per_second = frames / summary_.seconds;
  result.summary = summary_;

  // 4. The findings drawn on the film, outside the clock
  Findings findings{&camera_.calibration.camera, &result.trajectories, {}, camera_.sightings};
  for (const LearnedShape& body : learned.bodies) findings.shapes.push_back(body.shape);
  const int event_frame = std::clamp(
      static_cast<int>(std::lround(zero * experiment_.camera.frame_rate)), 0, frames - 1);
  OverlayFiles files;
  files.film = options.overlay_file;
  files.frame_rate = experiment_.camera.frame_rate;
  files.stills = {{0, options.annotated_first},
                  {(event_frame + frames - 1) / 2, options.annotated_middle},
                  {frames - 1, options.annotated_last}};
  if (!draw_overlay(replicate_.video, findings, files, options.stop)) throw Stopped{};
  return result;
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
  cv::setNumThreads(
      1);  // films are tracked side by side; more threads would only get in each other's way
  FilmTracker tracker(experiment, replicate);
  return tracker.run(options);
}

}  // namespace graintruth::tracking
