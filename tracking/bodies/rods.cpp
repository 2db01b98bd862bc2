#include "tracking/bodies/rods.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <queue>
#include <tuple>

#include "tracking/bodies/spots.h"

namespace graintruth::tracking {

namespace {

// Two pixels of one rod differ by less than this in colour, L* counted by half, because light and
// shade change it most.
constexpr float same_colour = 20.0F;
constexpr float lightness_weight = 0.5F;
constexpr int first_directions = 20;  // to rank seeds
constexpr int directions = 60;  // 3 degrees: an eighth of a width at the end of a typical half rod
constexpr double ground_gap = 2.0;     // px of bare ground that do not end a rod yet: noise
constexpr double hidden_widths = 4.0;  // how far a rod is followed behind others, in widths
constexpr double whole_pixel = 0.29;   // px, what rounding to whole pixels leaves: 1 / sqrt(12)
constexpr double least_coverage = 0.5;
constexpr double most_beside = 0.5;  // share of the strips beside a rod that may have its colour

float colour_distance(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  Eigen::Vector3f difference = a - b;
  difference.x() *= lightness_weight;
  return difference.norm();
}

// What a walk along a line found.
struct Reach {
  double back = 0.0, ahead = 0.0;  // px to the last pixel of the rod's colour
  int seen = 0;                    // pixels of it
  double length() const { return back + ahead; }
};

class RodFinder {
 public:
  RodFinder(const cv::Mat& frame, const RodOptions& options) : options_(options) {
    cv::Mat exact;
    frame.convertTo(exact, CV_32FC3, 1.0 / 255.0);
    cv::cvtColor(exact, colours_, cv::COLOR_BGR2Lab);
    cv::GaussianBlur(colours_, colours_, {3, 3}, 0.8);
    cv::Mat whole;  // numbers, which a median of large squares needs
    cv::cvtColor(frame, whole, cv::COLOR_BGR2Lab);
    const cv::Mat contrast = contrast_to_ground(whole, static_cast<int>(4.0 * options_.width_px));
    cv::Mat scaled;
    contrast.convertTo(scaled, CV_8U);
    cv::threshold(scaled, object_, 0.0, 255.0, cv::THRESH_BINARY | cv::THRESH_OTSU);
    if (!options_.region.empty()) {
      cv::Mat inside = cv::Mat::zeros(object_.size(), CV_8U);
      inside(options_.region & cv::Rect({}, object_.size())) = 255;
      object_ &= inside;
    }
    free_ = object_.clone();
  }

  std::vector<Rod> find(std::vector<Rod> expected) {
    std::vector<Rod> rods;
    // What is known is the best explanation, the longest first
    std::stable_sort(expected.begin(), expected.end(), [](const Rod& a, const Rod& b) {
      return a.length() > b.length();
    });
    for (const Rod& known : expected) {
      const std::optional<Rod> rod = refine(known.from, known.to, known.colour);
      if (!rod || !is_same(*rod, known)) continue;
      take(*rod);
      rods.push_back(*rod);
    }
    // What lies between two rods side by side is only seen once one of them is explained.
    for (std::size_t before = 1; before != rods.size();) {
      before = rods.size();
      explain(rods);
    }
    std::sort(rods.begin(), rods.end(), [](const Rod& a, const Rod& b) {
      return a.length() > b.length();
    });
    return rods;
  }

 private:
  // Adds the rods through the middle lines of what is not explained yet.
  void explain(std::vector<Rod>& rods) {
    // 1. How long a rod may be through each seed
    struct Seed {
      int seen = 0;
      cv::Point at;
      bool operator<(const Seed& other) const {
        return std::tuple(seen, at.y, at.x) < std::tuple(other.seen, other.at.y, other.at.x);
      }
    };
    std::priority_queue<Seed> seeds;
    cv::Mat depth, deepest;
    cv::distanceTransform(free_, depth, cv::DIST_L2, cv::DIST_MASK_3);
    cv::dilate(depth, deepest, cv::Mat());
    const auto least_depth = static_cast<float>(0.25 * options_.width_px);
    for (int row = 0; row < object_.rows; ++row) {
      for (int column = row % 2; column < object_.cols; column += 2) {
        const cv::Point at(column, row);
        const float here = depth.at<float>(at);
        if (here >= least_depth && here == deepest.at<float>(at))
          seeds.push({best_line(at, first_directions).first.seen, at});
      }
    }
    // 2. The longest first; what it explains is no other's
    const int least = static_cast<int>(std::lround(options_.width_px));
    while (!seeds.empty()) {
      Seed seed = seeds.top();
      seeds.pop();
      if (free_.at<std::uint8_t>(seed.at) == 0) continue;
      const auto [reach, angle] = best_line(seed.at, directions);
      if (reach.seen < least) continue;
      if (reach.seen < seed.seen) {
        seeds.push({reach.seen, seed.at});
        continue;
      }
      const std::optional<Rod> rod = refine(seed.at, angle, reach);
      if (rod) {
        take(*rod);
        rods.push_back(*rod);
      }
      free_.at<std::uint8_t>(seed.at) = 0;
    }
  }

  Eigen::Vector3f colour(const cv::Point& at) const {
    const auto& value = colours_.at<cv::Vec3f>(at);
    return {value[0], value[1], value[2]};
  }
  static cv::Point pixel(const Eigen::Vector2d& at) {
    return {static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y()))};
  }
  bool inside(const cv::Point& at) const {
    return at.x >= 0 && at.y >= 0 && at.x < object_.cols && at.y < object_.rows;
  }
  bool is_own(const cv::Point& at, const Eigen::Vector3f& own) const {
    return inside(at) && free_.at<std::uint8_t>(at) != 0 &&
           colour_distance(colour(at), own) < same_colour;
  }

  // Walks until bare ground, or until too long behind others; returns how far its colour was seen.
  double walk(const Eigen::Vector2d& from,
              const Eigen::Vector2d& direction,
              const Eigen::Vector3f& own,
              int& seen) const {
    double last = 0.0, bare = 0.0;
    for (double along = 1.0; along <= options_.longest_px; along += 1.0) {
      const cv::Point at = pixel(from + along * direction);
      if (!inside(at)) break;
      if (is_own(at, own)) {
        last = along;
        bare = 0.0;
        ++seen;
        continue;
      }
      if (object_.at<std::uint8_t>(at) == 0) bare += 1.0;
      if (bare > ground_gap || along - last > hidden_widths * options_.width_px) break;
    }
    return last;
  }

  Reach reach(const Eigen::Vector2d& from, double angle, const Eigen::Vector3f& own) const {
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    Reach result{.seen = 1};
    result.ahead = walk(from, direction, own, result.seen);
    result.back = walk(from, -direction, own, result.seen);
    return result;
  }

  std::pair<Reach, double> best_line(const cv::Point& at, int count) const {
    std::pair<Reach, double> best;
    for (int i = 0; i < count; ++i) {
      const double angle = std::numbers::pi * i / count;
      const Reach found = reach({at.x, at.y}, angle, colour(at));
      if (found.seen > best.first.seen) best = {found, angle};
    }
    return best;
  }

  struct Ribbon {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    Eigen::Vector2d direction = Eigen::Vector2d::Zero();
    Eigen::Vector3f colour = Eigen::Vector3f::Zero();
    int pixels = 0;
  };

  // Axis and colour of the own pixels within a width of the line.
  Ribbon ribbon(const Eigen::Vector2d& from,
                const Eigen::Vector2d& to,
                const Eigen::Vector3f& own,
                double half_width) const {
    const Eigen::Vector2d axis = (to - from).normalized();
    const double length = (to - from).norm();
    Ribbon result;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
    for_pixels(from, to, half_width + 1.0, [&](const cv::Point& at) {
      const Eigen::Vector2d place(at.x, at.y);
      const double along = axis.dot(place - from);
      const double across = axis.x() * (place - from).y() - axis.y() * (place - from).x();
      if (along < -1.0 || along > length + 1.0 || std::abs(across) > half_width) return;
      if (!is_own(at, own)) return;
      ++result.pixels;
      sum += place;
      squares += place * place.transpose();
      result.colour += colour(at);
    });
    if (result.pixels < 3) return result;
    result.centre = sum / result.pixels;
    result.colour /= static_cast<float>(result.pixels);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> spread(
        squares / result.pixels - result.centre * result.centre.transpose());
    result.direction = spread.eigenvectors().col(1);
    return result;
  }

  template <typename Visit>
  void for_pixels(const Eigen::Vector2d& from,
                  const Eigen::Vector2d& to,
                  double margin,
                  const Visit& visit) const {
    const Eigen::Vector2d low = from.cwiseMin(to).array() - margin;
    const Eigen::Vector2d high = from.cwiseMax(to).array() + margin;
    for (int row = std::max(0, static_cast<int>(low.y()));
         row <= std::min(object_.rows - 1, static_cast<int>(high.y()) + 1);
         ++row) {
      for (int column = std::max(0, static_cast<int>(low.x()));
           column <= std::min(object_.cols - 1, static_cast<int>(high.x()) + 1);
           ++column)
        visit(cv::Point(column, row));
    }
  }

  std::optional<Rod> refine(const cv::Point& seed, double angle, const Reach& first) const {
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle)), at(seed.x, seed.y);
    return refine(at - first.back * direction, at + first.ahead * direction, colour(seed));
  }

  std::optional<Rod> refine(Eigen::Vector2d from, Eigen::Vector2d to, Eigen::Vector3f own) const {
    Eigen::Vector2d direction;
    Ribbon found;
    constexpr int rounds = 4;
    for (int round = 0; round < rounds; ++round) {
      // A wide look first, because the seed may lie at the rod's edge
      const double half_width = options_.width_px * (round == 0 ? 1.0 : 0.65);
      found = ribbon(from, to, own, half_width);
      if (found.pixels < 3) return std::nullopt;
      own = found.colour;
      direction = found.direction;
      // Ends: the median of three parallel walks
      std::array<double, 3> back{}, ahead{};
      for (int lane = -1; lane <= 1; ++lane) {
        const Eigen::Vector2d across(-direction.y(), direction.x());
        const Eigen::Vector2d start = found.centre + 0.25 * lane * options_.width_px * across;
        int seen = 0;
        ahead[static_cast<std::size_t>(lane + 1)] = walk(start, direction, own, seen);
        back[static_cast<std::size_t>(lane + 1)] = walk(start, -direction, own, seen);
      }
      std::sort(back.begin(), back.end());
      std::sort(ahead.begin(), ahead.end());
      from = found.centre - back[1] * direction;
      to = found.centre + ahead[1] * direction;
    }
    Rod rod{.from = from, .to = to, .colour = own};
    rod.from_sigma_px = end_sigma(from, -direction);
    rod.to_sigma_px = end_sigma(to, direction);
    // Both sides are seen in whole pixels, which round alike over about half a width
    rod.across_sigma_px =
        whole_pixel / std::sqrt(2.0 * std::max(1.0, 2.0 * rod.length() / options_.width_px));
    if (rod.length() < options_.width_px || rod.length() > options_.longest_px) return std::nullopt;
    rod.coverage = std::min(1.0, found.pixels / (rod.length() * options_.width_px));
    // One line of pixels is no rod; nor is a part of a wider patch.
    if (rod.coverage < least_coverage || beside(rod) > most_beside) return std::nullopt;
    return rod;
  }

  // Before bare ground an end is where its colour ends, to a pixel. Before anything else it may lie
  // behind it, by up to the thickness of another rod.
  double end_sigma(const Eigen::Vector2d& end, const Eigen::Vector2d& outwards) const {
    const cv::Point beyond = pixel(end + (ground_gap + 1.0) * outwards);
    const bool is_bare = inside(beyond) && object_.at<std::uint8_t>(beyond) == 0;
    return is_bare ? whole_pixel : 0.5 * options_.width_px;
  }

  // Whether what was found about a known rod's place is that rod.
  bool is_same(const Rod& rod, const Rod& known) const {
    constexpr double most_turn = 0.26;  // rad, 15 degrees: about what neighbours differ by
    constexpr double least_left = 0.7;  // of its length
    const Eigen::Vector2d off = rod.centre() - known.centre();
    return std::abs(std::remainder(rod.angle() - known.angle(), std::numbers::pi)) < most_turn &&
           off.norm() < std::max(options_.width_px, 0.25 * known.length()) &&
           rod.length() > least_left * known.length();
  }

  // The share of its colour in strips a width away from its middle line.
  double beside(const Rod& rod) const {
    const Eigen::Vector2d axis = (rod.to - rod.from).normalized();
    const Eigen::Vector2d across(-axis.y(), axis.x());
    int all = 0, own = 0;
    for (double along = 0.0; along <= rod.length(); along += 1.0) {
      for (const double away : {-1.0, 1.0}) {
        const cv::Point at = pixel(rod.from + along * axis + away * options_.width_px * across);
        if (!inside(at)) continue;
        ++all;
        own += object_.at<std::uint8_t>(at) != 0 &&
                       colour_distance(colour(at), rod.colour) < same_colour
                   ? 1
                   : 0;
      }
    }
    return all == 0 ? 0.0 : static_cast<double>(own) / all;
  }

  void take(const Rod& rod) {
    const Eigen::Vector2d axis = (rod.to - rod.from).normalized();
    const double length = rod.length();
    const double half_width = 0.5 * options_.width_px + 1.5;
    for_pixels(rod.from, rod.to, half_width + 1.0, [&](const cv::Point& at) {
      const Eigen::Vector2d place = Eigen::Vector2d(at.x, at.y) - rod.from;
      const double along = axis.dot(place);
      const double across = axis.x() * place.y() - axis.y() * place.x();
      if (along < -2.0 || along > length + 2.0 || std::abs(across) > half_width) return;
      // Its blurred rim has no colour of its own.
      const bool rim = std::abs(across) > 0.5 * options_.width_px - 1.0;
      if (rim || colour_distance(colour(at), rod.colour) < 1.5F * same_colour)
        free_.at<std::uint8_t>(at) = 0;
    });
  }

  RodOptions options_;
  cv::Mat colours_;  // L*a*b*, CV_32FC3
  cv::Mat object_;   // 255 where something lies on the ground
  cv::Mat free_;     // 255 where that is not explained yet
};

}  // namespace

double Rod::angle() const {
  const Eigen::Vector2d axis = to - from;
  const double angle = std::atan2(-axis.y(), axis.x());
  return angle < 0.0 ? angle + std::numbers::pi : angle >= std::numbers::pi ? 0.0 : angle;
}

std::vector<Rod> locate_rods(const cv::Mat& frame,
                             const RodOptions& options,
                             const std::vector<Rod>& expected) {
  return RodFinder(frame, options).find(expected);
}

}  // namespace graintruth::tracking
