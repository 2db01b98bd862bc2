#include "tracking/outline/turning.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "tracking/median.h"

namespace graintruth::tracking {

namespace {

constexpr int angles = 720;
constexpr int rings = 12;
// A rim is rarely wider than a quarter of the radius
constexpr double widest_rim = 1.25;

// Correlation of b turned back by a whole number of steps with a.
double correlation(const cv::Mat1f& a, const cv::Mat1f& b, int shift) {
  shift = ((shift % angles) + angles) % angles;
  double sum = 0.0;
  for (int ring = 0; ring < a.rows; ++ring) {
    const float* from = a.ptr<float>(ring);
    const float* to = b.ptr<float>(ring);
    for (int k = 0; k < angles; ++k)
      sum += from[k] * to[k + shift < angles ? k + shift : k + shift - angles];
  }
  return sum;
}

// By how many steps, to a part of one, b is turned against a: the highest correlation between two
// shifts. Its height over that of the others, in their standard deviations, goes to `clarity`.
double shift_between(const std::vector<std::pair<const cv::Mat1f*, const cv::Mat1f*>>& pairs,
                     int from,
                     int to,
                     double* clarity) {
  std::vector<double> values;
  for (int shift = from - 1; shift <= to + 1; ++shift) {
    double sum = 0.0;
    for (const auto& [a, b] : pairs) sum += correlation(*a, *b, shift);
    values.push_back(sum);
  }
  std::size_t best = 1;
  for (std::size_t i = 1; i + 1 < values.size(); ++i)
    if (values[i] > values[best]) best = i;
  const double curvature = values[best - 1] - 2.0 * values[best] + values[best + 1];
  const double offset =
      curvature < 0.0
          ? std::clamp(0.5 * (values[best - 1] - values[best + 1]) / curvature, -1.0, 1.0)
          : 0.0;
  if (clarity) {
    std::vector<double> sizes;
    for (const double value : values) sizes.push_back(std::abs(value));
    *clarity = values[best] / std::max(median(sizes) / 0.6745, 1.0e-12);
  }
  return from - 1 + static_cast<double>(best) + offset;
}

}  // namespace

TurningWatcher::TurningWatcher(const datasets::SeenOutline::Drum& drum,
                               const Camera& camera,
                               const cv::Rect& region)
    : map_x_(rings, angles, CV_32F), map_y_(rings, angles, CV_32F) {
  for (int ring = 0; ring < rings; ++ring) {
    const double radius = drum.radius * (1.0 + (widest_rim - 1.0) * (ring + 1.0) / rings);
    for (int k = 0; k < angles; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / angles;
      const Eigen::Vector2d pixel = camera.project(drum.centre.x() + radius * std::cos(angle),
                                                   drum.centre.y() + radius * std::sin(angle));
      const bool is_seen = pixel.x() >= region.x && pixel.y() >= region.y &&
                           pixel.x() <= region.br().x - 1 && pixel.y() <= region.br().y - 1;
      map_x_.at<float>(ring, k) = is_seen ? static_cast<float>(pixel.x()) : -10.0F;
      map_y_.at<float>(ring, k) = is_seen ? static_cast<float>(pixel.y()) : -10.0F;
    }
  }
}

void TurningWatcher::look(const cv::Mat& grey, double time) {
  cv::Mat1b rim;
  cv::remap(grey, rim, map_x_, map_y_, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  pictures_.push_back(rim);
  times_.push_back(time);
}

std::optional<Turning> TurningWatcher::turning() const {
  const std::size_t count = pictures_.size();
  constexpr std::size_t fewest = 8;
  if (count < fewest) return std::nullopt;
  // 1. What stands still is taken out
  std::vector<cv::Mat1f> moving(count);
  for (cv::Mat1f& one : moving) one.create(rings, angles);
  std::vector<std::uint8_t> values(count);
  for (int ring = 0; ring < rings; ++ring)
    for (int k = 0; k < angles; ++k) {
      for (std::size_t i = 0; i < count; ++i) values[i] = pictures_[i](ring, k);
      const auto still = static_cast<float>(median(values));
      for (std::size_t i = 0; i < count; ++i) moving[i](ring, k) = values[i] - still;
    }
  // 2. The shift from each picture to the next, then over twice as many, and so on
  const auto pairs_apart = [&](std::size_t lag, std::size_t from, std::size_t to) {
    std::vector<std::pair<const cv::Mat1f*, const cv::Mat1f*>> pairs;
    for (std::size_t i = from; i + lag < to; ++i) pairs.emplace_back(&moving[i], &moving[i + lag]);
    return pairs;
  };
  double clarity = 0.0;
  double shift = shift_between(pairs_apart(1, 0, count), -angles / 2, angles / 2, &clarity);
  // The largest of so many shifts of mere noise is some four standard deviations high
  constexpr double plain = 7.0;
  if (clarity < plain) return std::nullopt;
  std::size_t lag = 1;
  constexpr int about = 6;  // steps
  while (8 * lag <= count) {
    lag *= 2;
    const int expected = static_cast<int>(std::lround(2.0 * shift));
    shift = shift_between(pairs_apart(lag, 0, count), expected - about, expected + about, nullptr);
  }
  // 3. Its scatter over parts of the film that share no picture
  const std::size_t parts = std::max<std::size_t>(2, std::min<std::size_t>(8, count / (2 * lag)));
  const double step = 2.0 * std::numbers::pi / angles;
  const double interval = (times_.back() - times_.front()) / static_cast<double>(count - 1);
  const double rate = shift * step / (static_cast<double>(lag) * interval);
  double square = 0.0;
  int used = 0;
  const int expected = static_cast<int>(std::lround(shift));
  for (std::size_t part = 0; part < parts; ++part) {
    const auto pairs = pairs_apart(lag, part * count / parts, (part + 1) * count / parts);
    if (pairs.empty()) continue;
    square +=
        std::pow(shift_between(pairs, expected - about, expected + about, nullptr) - shift, 2);
    ++used;
  }
  const double scatter = used > 1 ? std::sqrt(square / (used - 1) / used) : 0.5;  // steps
  // No better than a tenth of a step over the whole film
  const double sigma = std::hypot(scatter, 0.1) * step / (static_cast<double>(lag) * interval);
  // What is left of still things peaks at no shift
  if (std::abs(rate) < 3.0 * sigma) return std::nullopt;
  return Turning{rate, sigma};
}

}  // namespace graintruth::tracking
