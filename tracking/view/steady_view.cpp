#include "tracking/view/steady_view.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "tracking/median.h"

namespace graintruth::tracking {

namespace {

constexpr std::size_t fewest = 3;

// Pixels of the first picture to pixels of this one:
//   (column', row') = (a column - b row, b column + a row) + shift
struct Motion {
  double a = 1.0, b = 0.0;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();

  Eigen::Vector2d operator()(const Eigen::Vector2d& p) const {
    return shift + Eigen::Vector2d(a * p.x() - b * p.y(), b * p.x() + a * p.y());
  }
};

using Pairs = std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>>;

Motion fit_motion(const Pairs& pairs) {
  // Least squares, about the dots' mean: there shift and turn do not depend on each other
  Eigen::Vector2d mean = Eigen::Vector2d::Zero(), mean_now = Eigen::Vector2d::Zero();
  for (const auto& [first, now] : pairs) {
    mean += first / static_cast<double>(pairs.size());
    mean_now += now / static_cast<double>(pairs.size());
  }
  double square = 0.0, along = 0.0, across = 0.0;
  for (const auto& [first, now] : pairs) {
    const Eigen::Vector2d p = first - mean, q = now - mean_now;
    square += p.squaredNorm();
    along += p.dot(q);
    across += p.x() * q.y() - p.y() * q.x();
  }
  Motion motion;
  motion.a = along / square;
  motion.b = across / square;
  motion.shift = mean_now - Motion{motion.a, motion.b, Eigen::Vector2d::Zero()}(mean);
  return motion;
}

// The motion that most dots agree on: those that lie off by much more than the others are left out.
std::optional<Motion> agreed_motion(Pairs pairs) {
  for (int round = 0; round < 3; ++round) {
    if (pairs.size() < fewest) return std::nullopt;
    const Motion motion = fit_motion(pairs);
    const auto miss = [&](const auto& pair) { return (pair.second - motion(pair.first)).norm(); };
    std::vector<double> misses;
    for (const auto& pair : pairs) misses.push_back(miss(pair));
    const double limit = std::max(0.3, 4.0 * median(misses));
    const auto before = pairs.size();
    std::erase_if(pairs, [&](const auto& pair) { return miss(pair) > limit; });
    if (pairs.size() == before) return motion;
  }
  return pairs.size() < fewest ? std::nullopt : std::optional(fit_motion(pairs));
}

}  // namespace

SteadyView::SteadyView(std::vector<FiducialSighting> first)
    : first_(std::move(first)), last_(first_) {}

// The fiducials as seen from where they were last, moved by `jump`.
SteadyView::Pairs SteadyView::pairs_near(const cv::Mat& grey, const Eigen::Vector2d& jump) const {
  Pairs pairs;
  for (std::size_t i = 0; i < first_.size(); ++i) {
    FiducialSighting now = last_[i];
    now.pixel += jump;
    if (!refine_fiducial(grey, now)) continue;
    if (std::abs(now.diameter_px / first_[i].diameter_px - 1.0) > 0.2) continue;
    pairs.emplace_back(first_[i].pixel, now.pixel);
  }
  return pairs;
}

// Looks about for fiducials that jumped further than their own radius: in squares of growing size.
SteadyView::Pairs SteadyView::pairs_about(const cv::Mat& grey) const {
  constexpr int squares = 8;
  Pairs most;
  if (first_.empty()) return most;
  const double stride = 0.5 * first_.front().diameter_px;
  for (int square = 1; square <= squares; ++square) {
    for (int i = -square; i <= square; ++i) {
      for (int j = -square; j <= square; ++j) {
        if (std::max(std::abs(i), std::abs(j)) != square) continue;
        Pairs pairs = pairs_near(grey, Eigen::Vector2d(i * stride, j * stride));
        if (pairs.size() > most.size()) most = std::move(pairs);
      }
    }
    if (3 * most.size() >= 2 * first_.size()) break;
  }
  return most;
}

void SteadyView::hold(cv::Mat& frame, int number) {
  cv::Mat grey;
  cv::cvtColor(frame, grey, cv::COLOR_BGR2GRAY);
  Pairs pairs = pairs_near(grey, Eigen::Vector2d::Zero());
  if (2 * pairs.size() < first_.size()) pairs = pairs_about(grey);
  const std::optional<Motion> motion = agreed_motion(std::move(pairs));
  if (!motion) {
    ++unchecked_frames_;
    return;
  }
  double shift = 0.0;
  for (std::size_t i = 0; i < first_.size(); ++i) {
    last_[i].pixel = (*motion)(first_[i].pixel);
    shift = std::max(shift, (last_[i].pixel - first_[i].pixel).norm());
  }
  // Less is what light, noise and compression do to the dots.
  constexpr double visible = 0.15;  // px
  if (shift < visible) return;
  if (shift > largest_shift_px_) {
    largest_shift_px_ = shift;
    frame_of_largest_shift_ = number;
  }
  const cv::Matx23d first_to_now(
      motion->a, -motion->b, motion->shift.x(), motion->b, motion->a, motion->shift.y());
  cv::Mat held;
  cv::warpAffine(frame,
                 held,
                 first_to_now,
                 frame.size(),
                 cv::INTER_CUBIC | cv::WARP_INVERSE_MAP,
                 cv::BORDER_REPLICATE);
  frame = held;
}

}  // namespace graintruth::tracking
