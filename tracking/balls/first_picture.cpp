#include "tracking/balls/first_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "datasets/store/input_error.h"
#include "tracking/balls/bodies.h"
#include "tracking/balls/learn.h"
#include "tracking/bodies/link.h"
#include "tracking/median.h"

namespace graintruth::tracking {

using datasets::InputError;

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// How far the distance of two candidates may be off the separation, relative.
constexpr double tolerance = 0.12;

// Candidates over a range of sizes: the stated one may be wrong by some per cent, and must then be
// told so.
std::vector<BodyFit> find_at_any_size(FilmView& view,
                                      const cv::Mat& frame,
                                      const EdgeImage& image,
                                      const std::string& where) {
  const auto count = static_cast<std::size_t>(view.count);
  std::vector<BodyFit> best;
  double best_evidence = -1.0, best_factor = 1.0;
  for (const double factor : {1.0, 0.94, 1.06, 0.88, 1.12}) {
    BodyShape tried = view.nominal;
    tried.separation *= factor;
    for (double& r : tried.radius) r *= factor;
    const auto chosen = choose_bodies(
        view.fits_in(frame, image, tried, tolerance, view.surroundings()), tried, count);
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
  view.shape.separation = view.nominal.separation * best_factor;
  for (std::size_t ball = 0; ball < 2; ++ball)
    view.shape.radius[ball] = view.nominal.radius[ball] * best_factor;
  if (best.empty()) {
    const std::string sought =
        view.nominal.shows_angle()
            ? fmt::format("two balls of radius {:.1f} mm, {:.1f} mm apart,",
                          1.0e3 * view.nominal.radius[0],
                          1.0e3 * view.nominal.separation)
            : fmt::format("one ball of radius {:.1f} mm", 1.0e3 * view.nominal.radius[0]);
    throw InputError(
        fmt::format("{}: no particle of {} was found in the first frame; check the film, the "
                    "particle's size and the scale",
                    where,
                    sought));
  }
  return best;
}

// Adds bodies that an outline of their own hardly shows: neighbours cover most of it, or what lies
// behind has the same shade. What was found is known by now and no longer looked at. Where the
// experiment says that a body starts less of an outline will do.
void add_hidden(const FilmView& view,
                const cv::Mat& frame,
                const EdgeImage& image,
                std::vector<BodyFit>& bodies) {
  const auto count = static_cast<std::size_t>(view.count);
  const auto add_from = [&](std::vector<BodyPose> poses, double support) {
    for (std::size_t before = 0; bodies.size() > before && bodies.size() < count;) {
      before = bodies.size();
      const auto is_taken = [&](const BodyPose& pose) {
        return std::any_of(bodies.begin(), bodies.end(), [&](const BodyFit& known) {
          return overlap(known.pose, pose, view.shape);
        });
      };
      std::erase_if(poses, is_taken);
      Surroundings around = view.surroundings();
      for (const BodyFit& known : bodies) around.add(known.pose, view.shape);
      std::vector<BodyFit> found =
          fit_bodies(image, view.lens(), view.shape, poses, around, view.edge_noise, support);
      std::erase_if(found, [&](const BodyFit& fit) { return is_taken(fit.pose); });
      for (BodyFit& fit : choose_bodies(found, view.shape, count - bodies.size()))
        bodies.push_back(std::move(fit));
    }
  };
  std::vector<BodyPose> starts;
  for (const datasets::StartPlace& start : view.spec.starts) {
    const double stride = 0.15 * view.shape.radius[0];
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j)
        starts.push_back({start.x + i * stride, start.z + j * stride, start.angle});
  }
  add_from(starts, hidden_support);
  add_from(possible_poses(view.shape, view.candidates_in(frame, view.shape), known_tolerance),
           clutter_support);
}

// The size at which the outlines of the first frame lie best, and how blurred they are. Edges are
// first taken where the picture changes most, which is near enough to learn the limb from.
void learn_sizes(FilmView& view, const EdgeImage& image, std::vector<BodyFit>& bodies) {
  const Surroundings alone = view.surroundings();
  const auto surroundings_among = [&](std::size_t body) {
    Surroundings around = alone;
    for (std::size_t other = 0; other < bodies.size(); ++other) {
      if (other != body) around.add(bodies[other].pose, view.shape);
    }
    return around;
  };
  const auto options_at = [&](const BodyPose& pose) {
    const double radius_px = view.lens().scale(pose.x, pose.z) * view.shape.radius[0];
    return RefineOptions{.window_px = std::max(2.5, 0.1 * radius_px),
                         .iterations = 4,
                         .noise = view.edge_noise,
                         .limb = view.limb ? &*view.limb : nullptr};
  };
  for (int pass = 0; pass < 3; ++pass) {
    std::vector<double> radius_ratios, separations;
    std::vector<std::vector<BodyFit>> one_frame;
    for (const BodyFit& fit : bodies) one_frame.push_back({fit});
    const Learned learned = learn_shapes(one_frame, view.shape);
    for (const LearnedShape& body : learned.bodies) {
      for (std::size_t ball = 0; ball < view.shape.balls; ++ball)
        radius_ratios.push_back(body.shape.radius[ball] / view.shape.radius[ball]);
      if (view.shape.balls == 2) separations.push_back(body.shape.separation);
    }
    const double ratio = std::clamp(median(radius_ratios, nan), 0.9, 1.1);
    for (double& r : view.shape.radius) r *= ratio;
    if (view.shape.balls == 2)
      view.shape.separation *=
          std::clamp(median(separations, nan) / view.shape.separation, 0.9, 1.1);
    if (pass == 1) {
      ObservedLimbs observed;
      std::vector<std::size_t> firsts;  // of each body's profiles
      for (std::size_t i = 0; i < bodies.size(); ++i) {
        firsts.push_back(observed.profiles.size());
        observe_limbs(image,
                      view.lens(),
                      view.shape,
                      bodies[i].pose,
                      surroundings_among(i),
                      options_at(bodies[i].pose),
                      observed);
      }
      firsts.push_back(observed.profiles.size());
      const BodyPose& any = bodies.front().pose;
      view.limb.emplace(learn_limb_model(view.lens().scale(any.x, any.z) * view.shape.radius[0],
                                         observed.profiles,
                                         observed.edges,
                                         learn_black(observed.profiles, firsts)));
    }
    std::vector<BodyFit> refitted;
    for (std::size_t i = 0; i < bodies.size(); ++i)
      refitted.push_back(refine_body(image,
                                     view.lens(),
                                     view.shape,
                                     bodies[i].pose,
                                     surroundings_among(i),
                                     options_at(bodies[i].pose)));
    bodies = refitted;
  }
}

// The first bodies by their particles' numbers.
std::vector<std::optional<BodyFit>> give_numbers(const FilmView& view,
                                                 const std::vector<BodyFit>& best,
                                                 TrackingSummary& summary) {
  const auto count = static_cast<std::size_t>(view.count);
  std::vector<std::optional<BodyFit>> first(count);
  std::vector<Eigen::Vector2d> centres;
  for (const BodyFit& fit : best) centres.emplace_back(fit.pose.x, fit.pose.z);
  const std::vector<int> numbered =
      number_by_start(centres, view.spec.starts, view.count, view.nominal.radius[0]);
  for (std::size_t body = 0; body < count; ++body) {
    if (numbered[body] < 0) continue;
    BodyFit fit = best[static_cast<std::size_t>(numbered[body])];
    // First seen angle in [0, pi). Bodies with unequal balls keep their direction.
    if (view.nominal.shows_angle() && view.nominal.radius[0] == view.nominal.radius[1] &&
        (fit.pose.angle < 0.0 || fit.pose.angle >= std::numbers::pi)) {
      const double turns = std::floor(fit.pose.angle / std::numbers::pi);
      fit.pose.angle -= turns * std::numbers::pi;
      if (static_cast<long>(turns) % 2 != 0) std::swap(fit.balls[0], fit.balls[1]);
    }
    first[body] = fit;
    if (!view.spec.starts.empty()) {
      const auto& start = view.spec.starts[body];
      const double off = std::hypot(fit.pose.x - start.x, fit.pose.z - start.z);
      if (off > view.nominal.radius[0]) {
        summary.warn(fmt::format("Particle {} was found {:.0f} mm from its start place in frame 0.",
                                 body + 1,
                                 1.0e3 * off));
      }
    }
  }
  return first;
}

void look_for_more(const FilmView& view,
                   const cv::Mat& frame,
                   const EdgeImage& image,
                   const std::vector<BodyFit>& bodies,
                   TrackingSummary& summary) {
  const auto count = static_cast<std::size_t>(view.count);
  const auto more =
      choose_bodies(view.fits_in(frame, image, view.shape, tolerance, view.surroundings()),
                    view.shape,
                    count + 1);
  if (more.size() > count) {
    double weakest_known = 1.0e9;
    for (const BodyFit& fit : bodies) weakest_known = std::min(weakest_known, evidence_of(fit));
    double weakest = 1.0e9;
    for (const BodyFit& fit : more) weakest = std::min(weakest, evidence_of(fit));
    if (weakest > 0.6 * weakest_known)
      summary.warn(fmt::format(
          "Frame 0 seems to show more than the {} particles that the experiment states.", count));
  }
}

}  // namespace

std::vector<std::optional<BodyFit>> find_first_bodies(FilmView& view,
                                                      const cv::Mat& frame,
                                                      const EdgeImage& image,
                                                      const std::string& where,
                                                      TrackingSummary& summary) {
  const auto count = static_cast<std::size_t>(view.count);
  std::vector<BodyFit> bodies = find_at_any_size(view, frame, image, where);
  if (bodies.size() < count) add_hidden(view, frame, image, bodies);
  learn_sizes(view, image, bodies);
  std::vector<std::optional<BodyFit>> first = give_numbers(view, bodies, summary);
  if (bodies.size() < count) {
    summary.fail(fmt::format(
        "Frame 0 shows {} particles but the experiment says {}.", bodies.size(), count));
  } else {
    look_for_more(view, frame, image, bodies, summary);
  }
  return first;
}

}  // namespace graintruth::tracking
