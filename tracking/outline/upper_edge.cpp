#include "tracking/outline/upper_edge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "tracking/median.h"

namespace graintruth::tracking {

namespace {

constexpr float unseen = std::numeric_limits<float>::quiet_NaN();

// What is narrower than this cannot be a grain.
constexpr double least_share_of_grain = 1.0 / 8.0;

// What a picture shows on both sides of a cut, and where it is between.
struct Sides {
  cv::Mat1f share;    // 0: as the ground beside, 1: as the grains beside
  cv::Mat1f level;    // of the share, where the edge is
  cv::Mat1f doubt;    // of that, one standard deviation of what both sides show
  cv::Mat1f noise;    // of the share, from the noise of a pixel
  cv::Mat1b is_near;  // 255: near the cut; elsewhere the share is 0 or 1
};

// Means of a picture over the cells of a mask, weighted by how near they are.
cv::Mat means_of(const cv::Mat& exact, const cv::Mat1b& mask, double reach, cv::Mat1f& weight) {
  cv::Mat3f kept(exact.size(), cv::Vec3f());
  exact.copyTo(kept, mask);
  mask.convertTo(weight, CV_32F, 1.0 / 255.0);
  cv::GaussianBlur(kept, kept, cv::Size(), reach);
  cv::GaussianBlur(weight, weight, cv::Size(), reach);
  return kept;
}

Sides sides_of(const cv::Mat& picture,
               const cv::Mat1b& grains,
               const cv::Mat1b& known,
               int window,
               double noise) {
  // 1. Cells within some way of the cut, but far enough for the lens, on either side
  cv::Mat1f inside, outside;
  const cv::Mat1b ground = 255 - grains;
  cv::distanceTransform(grains, inside, cv::DIST_L2, cv::DIST_MASK_5);
  cv::distanceTransform(ground, outside, cv::DIST_L2, cv::DIST_MASK_5);
  const auto side = [&](const cv::Mat1f& depth) {
    cv::Mat1b mask = (depth >= window) & (depth <= 3.0 * window);
    cv::bitwise_and(mask, known, mask);
    return mask;
  };
  const cv::Mat1b full = side(inside), empty = side(outside);
  // 2. Brightness, with it its square, and colours
  cv::Mat exact, grey;
  picture.convertTo(exact, CV_32FC3);
  cv::cvtColor(exact, grey, cv::COLOR_BGR2GRAY);
  cv::Mat squares;
  cv::merge(std::vector<cv::Mat>{grey, grey.mul(grey), grey}, squares);
  cv::Mat1f weight_full, weight_empty;
  const double reach = 1.5 * window;
  const cv::Mat3f lit_full = means_of(squares, full, reach, weight_full);
  const cv::Mat3f lit_empty = means_of(squares, empty, reach, weight_empty);
  const cv::Mat3f colour_full = means_of(exact, full, reach, weight_full);
  const cv::Mat3f colour_empty = means_of(exact, empty, reach, weight_empty);
  // 3. Between them
  Sides sides{cv::Mat1f(picture.size()),
              cv::Mat1f(picture.size(), 0.5F),
              cv::Mat1f(picture.size(), 0.0F),
              cv::Mat1f(picture.size(), 0.0F),
              cv::Mat1b(picture.size(), std::uint8_t{0})};
  // A step of brightness that stands out of its noise
  const auto plain = static_cast<float>(6.0 * noise);
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) {
      float& share = sides.share(row, column);
      share = grains(row, column) != 0 ? 1.0F : 0.0F;
      const float a = weight_full(row, column), b = weight_empty(row, column);
      if (a < 1.0e-3F || b < 1.0e-3F || inside(row, column) > 2.0F * static_cast<float>(window) ||
          outside(row, column) > 2.0F * static_cast<float>(window))
        continue;
      const cv::Vec3f light = lit_full(row, column) / a, dark = lit_empty(row, column) / b;
      const float step = light[0] - dark[0];
      float size = std::abs(step);
      if (size > plain) {
        share = (grey.at<float>(row, column) - dark[0]) / step;
      } else {
        const cv::Vec3f over = colour_empty(row, column) / b;
        const cv::Vec3f across = colour_full(row, column) / a - over;
        const float square = across.dot(across);
        if (square <= 0.0F) continue;
        size = std::sqrt(square);
        share = (exact.at<cv::Vec3f>(row, column) - over).dot(across) / square;
      }
      const float scatter = std::max(0.0F, light[1] - light[0] * light[0]) +
                            std::max(0.0F, dark[1] - dark[0] * dark[0]);
      sides.noise(row, column) = static_cast<float>(noise) / size;
      // Not down to where the ground's own noise is
      const float lowest = std::min(0.5F, std::max(0.25F, 3.0F * sides.noise(row, column)));
      sides.level(row, column) = std::max(lowest, 0.5F - 0.5F * std::sqrt(scatter) / size);
      sides.doubt(row, column) = 0.5F - sides.level(row, column);
      sides.is_near(row, column) = 255;
    }
  }
  // 4. Where pixels are noisy only several of them together tell
  std::vector<float> noises;
  for (int row = 0; row < picture.rows; row += 2)
    for (int column = 0; column < picture.cols; column += 2)
      if (sides.is_near(row, column) != 0) noises.push_back(sides.noise(row, column));
  const double blur = std::min(1.7 * static_cast<double>(median(noises)), 0.75 * window);
  constexpr double slightest = 0.3;
  if (blur > slightest) {
    cv::GaussianBlur(sides.share, sides.share, cv::Size(), blur);
    sides.noise *= 1.0 / (2.0 * std::sqrt(std::numbers::pi) * blur);
  }
  return sides;
}

// Grains in flight: what speaks for grains above the cut, and is as thick as seven tenths of one.
void add_flying(const cv::Mat1f& ratio, const EdgeOptions& options, std::vector<int>& top) {
  cv::Mat1b above(ratio.size(), std::uint8_t{0});
  for (int column = 0; column < ratio.cols; ++column) {
    for (int row = 0; row < top[static_cast<std::size_t>(column)]; ++row)
      if (ratio(row, column) > 0.0F) above(row, column) = 255;
  }
  cv::Mat1f depth;
  cv::distanceTransform(above, depth, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::Mat1i label;
  const int count = cv::connectedComponents(above, label, 4, CV_32S);
  std::vector<float> thickest(static_cast<std::size_t>(count), 0.0F);
  for (int row = 0; row < above.rows; ++row)
    for (int column = 0; column < above.cols; ++column) {
      float& most = thickest[static_cast<std::size_t>(label(row, column))];
      most = std::max(most, depth(row, column));
    }
  const auto needed = static_cast<float>(0.35 * options.grain);
  for (int column = 0; column < above.cols; ++column) {
    int& highest = top[static_cast<std::size_t>(column)];
    for (int row = 0; row < highest; ++row) {
      if (above(row, column) == 0 ||
          thickest[static_cast<std::size_t>(label(row, column))] < needed)
        continue;
      highest = row;
    }
  }
}

}  // namespace

std::vector<int> cut_along_columns(const GrainEvidence& evidence, const EdgeOptions& options) {
  cv::Mat1f ratio;
  // Noise of single cells says nothing of grains
  cv::GaussianBlur(evidence.ratio, ratio, cv::Size(), std::max(0.3, options.grain / 16.0));
  const int columns = ratio.cols, rows = std::clamp(options.floor, 1, ratio.rows);
  const auto states = static_cast<std::size_t>(rows) + 1;
  const auto jump =
      static_cast<float>(evidence.limit * std::max(1.0, least_share_of_grain * options.grain));
  // 1. Cost of each column's top, and the best one of all columns up to it
  std::vector<float> best(states, 0.0F), next(states);
  std::vector<std::vector<int>> from(static_cast<std::size_t>(columns), std::vector<int>(states));
  // Where nothing tells there is no grain
  const float slight = 1.0e-4F * evidence.limit;
  for (int column = 0; column < columns; ++column) {
    std::vector<int>& origin = from[static_cast<std::size_t>(column)];
    for (std::size_t s = 0; s < states; ++s) origin[s] = static_cast<int>(s);
    for (std::size_t s = 1; s < states; ++s) {
      if (best[s - 1] + jump >= best[s]) continue;
      best[s] = best[s - 1] + jump;
      origin[s] = origin[s - 1];
    }
    for (std::size_t s = states - 1; s-- > 0;) {
      if (best[s + 1] + jump >= best[s]) continue;
      best[s] = best[s + 1] + jump;
      origin[s] = origin[s + 1];
    }
    float cost = 0.0F;
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t s = 0; s < states; ++s) {
      next[s] = best[s] + cost;
      least = std::min(least, next[s]);
      if (s + 1 < states) cost += 2.0F * ratio(static_cast<int>(s), column) - slight;
    }
    for (std::size_t s = 0; s < states; ++s) best[s] = next[s] - least;
  }
  // 2. Back along the best
  std::vector<int> top(static_cast<std::size_t>(columns));
  auto state = static_cast<int>(std::min_element(best.begin(), best.end()) - best.begin());
  for (int column = columns - 1; column >= 0; --column) {
    top[static_cast<std::size_t>(column)] = state;
    state = from[static_cast<std::size_t>(column)][static_cast<std::size_t>(state)];
  }
  add_flying(ratio, options, top);
  return top;
}

UpperEdge find_upper_edge(const cv::Mat& picture,
                          const GrainEvidence& evidence,
                          const EdgeOptions& options) {
  const std::vector<int> top = cut_along_columns(evidence, options);
  const auto count = top.size();
  const int floor = std::clamp(options.floor, 1, picture.rows);
  UpperEdge edge{std::vector<float>(count, unseen),
                 std::vector<float>(count, 0.0F),
                 std::vector<float>(count, 0.0F),
                 std::vector<char>(count, 0)};
  // 1. Only the rows about the cut matter
  const int window = std::max(2, static_cast<int>(std::lround(options.grain / 6.0)));
  const int highest = *std::min_element(top.begin(), top.end());
  if (highest >= floor) return edge;
  const int first = std::max(0, highest - 6 * window);
  const int last = std::min(picture.rows, floor + 6 * window);
  const cv::Mat seen = picture.rowRange(first, last);
  cv::Mat1b grains(seen.size(), std::uint8_t{0});
  for (int column = 0; column < seen.cols; ++column)
    for (int row = top[static_cast<std::size_t>(column)] - first; row < seen.rows; ++row)
      grains(std::max(0, row), column) = 255;
  // 2. How far each cell is from the ground's colour towards the grains'
  cv::Mat1b known = evidence.known.rowRange(first, last).clone();
  known.rowRange(std::min(floor - first, known.rows), known.rows).setTo(0);
  Sides sides;
  for (int round = 0; round < 2; ++round) {
    sides = sides_of(seen, grains, known, window, options.noise);
    for (int row = 0; row < seen.rows; ++row)
      for (int column = 0; column < seen.cols; ++column)
        if (sides.is_near(row, column) != 0)
          grains(row, column) = sides.share(row, column) >= sides.level(row, column) ? 255 : 0;
  }
  // 3. Down each column to where that is half way, with a cell below that says so as well
  // `aside`: by how many standard deviations of what grains show the level is moved
  const auto crossing = [&](int column, int from, float aside, float* slope) {
    for (int row = std::max(1, from); row + 1 < std::min(seen.rows, floor - first + 1); ++row) {
      const float level = sides.level(row, column) + aside * sides.doubt(row, column);
      const float here = sides.share(row, column);
      if (evidence.known(row + first, column) == 0 || here < level ||
          sides.share(row + 1, column) < level)
        continue;
      const float before = sides.share(row - 1, column);
      if (before >= level) return static_cast<float>(row) - 0.5F;
      if (slope) *slope = here - before;
      return static_cast<float>(row) - (here - level) / (here - before);
    }
    return unseen;
  };
  for (std::size_t k = 0; k < count; ++k) {
    if (top[k] >= floor) continue;
    const auto column = static_cast<int>(k);
    const int from = top[k] - first - 3 * window;
    float slope = 1.0F;
    const float row = crossing(column, from, 0.0F, &slope);
    if (!std::isfinite(row)) continue;
    const auto at = static_cast<int>(std::lround(row));
    const float upper = crossing(column, from, -0.5F, nullptr);
    const float lower = crossing(column, from, 0.5F, nullptr);
    const auto shift = static_cast<float>(first);
    edge.row[k] = row + shift;
    edge.doubt[k] = (std::isfinite(lower) ? lower : row) - (std::isfinite(upper) ? upper : row);
    edge.noise[k] = sides.noise(at, column) / std::max(slope, 0.05F);
    for (int near = std::max(0, at - 2); near <= std::min(seen.rows - 1, at + 1); ++near)
      if (evidence.known(near + first, column) == 0) edge.hidden[k] = 1;
  }
  return edge;
}

}  // namespace graintruth::tracking
