#include "tracking/view/fiducials.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>

namespace graintruth::tracking {

namespace {

double bilinear(const cv::Mat& grey, double column, double row) {
  const double x = std::clamp(column, 0.0, grey.cols - 1.001),
               y = std::clamp(row, 0.0, grey.rows - 1.001);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const double fx = x - x0, fy = y - y0;
  const std::uint8_t* top = grey.ptr<std::uint8_t>(y0) + x0;
  const std::uint8_t* bottom = grey.ptr<std::uint8_t>(y0 + 1) + x0;
  return (1 - fy) * ((1 - fx) * top[0] + fx * top[1]) +
         fy * ((1 - fx) * bottom[0] + fx * bottom[1]);
}

// One correspondence fixes nothing, two fix a similarity: lab (x, z) to corrected pixels (a *
// column, -row).
struct Similarity {
  double real = 0.0, imaginary = 0.0;  // scale times cosine and sine of the turn
  Eigen::Vector2d shift;
  Eigen::Vector2d operator()(const Eigen::Vector2d& p) const {
    return shift +
           Eigen::Vector2d(real * p.x() - imaginary * p.y(), imaginary * p.x() + real * p.y());
  }
};

double largest_distance(const std::vector<datasets::Fiducial>& fiducials) {
  double largest = 0.0;
  for (const datasets::Fiducial& a : fiducials) {
    for (const datasets::Fiducial& b : fiducials)
      largest = std::max(largest, std::hypot(a.x - b.x, a.z - b.z));
  }
  return largest;
}

// Which dot each fiducial is.
struct Match {
  std::vector<int> dot_of;  // per fiducial, -1 unseen
  int count = 0;
  double misfit = 0.0;  // distances over the tolerance, summed

  bool operator<(const Match& other) const {
    return count < other.count || (count == other.count && misfit > other.misfit);
  }
};

// Explains dots by a layout. Lab coordinates are metres; corrected pixels have a square shape and
// count upwards.
class LayoutMatcher {
 public:
  // `slack`: how far off a similarity tilt and distortion may move a dot, px.
  LayoutMatcher(const std::vector<datasets::Fiducial>& fiducials,
                const std::vector<DarkDot>& dots,
                double pixel_aspect,
                double slack)
      : fiducials_(fiducials), dots_(dots), pixel_aspect_(pixel_aspect), slack_(slack) {}

  Match best() const;

 private:
  Eigen::Vector2d lab(std::size_t i) const { return {fiducials_[i].x, fiducials_[i].z}; }
  Eigen::Vector2d corrected(std::size_t k) const {
    return {pixel_aspect_ * dots_[k].centre.x(), -dots_[k].centre.y()};
  }
  // Diameter in corrected pixels: area scales with the aspect.
  double size(std::size_t k) const { return dots_[k].diameter * std::sqrt(pixel_aspect_); }
  std::optional<Similarity> similarity(std::size_t i,
                                       std::size_t j,
                                       std::size_t a,
                                       std::size_t b) const;
  template <typename Map, typename Scale>
  Match match_with(const Map& map, const Scale& scale, double tolerance, int to_beat) const;
  std::optional<cv::Matx33d> projective(const Match& match) const;
  Match grown(Match match) const;

  const std::vector<datasets::Fiducial>& fiducials_;
  const std::vector<DarkDot>& dots_;
  double pixel_aspect_;
  double slack_;
};

// The similarity that takes fiducials i and j to dots a and b, if it goes with their sizes and the
// camera stands about upright.
std::optional<Similarity> LayoutMatcher::similarity(std::size_t i,
                                                    std::size_t j,
                                                    std::size_t a,
                                                    std::size_t b) const {
  constexpr double largest_roll =
      0.44;  // rad, 25 degrees: beyond that a symmetric layout could be taken turned
  const Eigen::Vector2d between = lab(j) - lab(i), seen = corrected(b) - corrected(a);
  const double scale = seen.norm() / between.norm();
  const double ratio_a = size(a) / (scale * fiducials_[i].diameter);
  const double ratio_b = size(b) / (scale * fiducials_[j].diameter);
  if (std::min(ratio_a, ratio_b) < 0.7 || std::max(ratio_a, ratio_b) > 1.4) return std::nullopt;
  const double real = between.dot(seen) / between.squaredNorm();
  const double imaginary =
      (between.x() * seen.y() - between.y() * seen.x()) / between.squaredNorm();
  if (std::abs(std::atan2(imaginary, real)) > largest_roll) return std::nullopt;
  Similarity map{real, imaginary, Eigen::Vector2d::Zero()};
  map.shift = corrected(a) - map(lab(i));
  return map;
}

// `map`: lab to corrected pixels; `scale`: corrected pixels a metre there. Gives up where fewer
// than `to_beat` can be matched.
template <typename Map, typename Scale>
Match LayoutMatcher::match_with(const Map& map,
                                const Scale& scale,
                                double tolerance,
                                int to_beat) const {
  Match match;
  match.dot_of.assign(fiducials_.size(), -1);
  std::vector<char> taken(dots_.size(), 0);
  for (std::size_t i = 0; i < fiducials_.size(); ++i) {
    const Eigen::Vector2d expected = map(lab(i));
    const double diameter = scale(lab(i)) * fiducials_[i].diameter;
    double nearest = tolerance;
    int best = -1;
    for (std::size_t k = 0; k < dots_.size(); ++k) {
      const double size_ratio = size(k) / diameter;
      if (taken[k] || size_ratio < 0.65 || size_ratio > 1.5) continue;
      const double distance = (corrected(k) - expected).norm();
      if (distance < nearest) {
        nearest = distance;
        best = static_cast<int>(k);
      }
    }
    if (best < 0) {
      const auto left = static_cast<int>(fiducials_.size() - i) - 1;
      if (match.count + left < to_beat) break;
      continue;
    }
    taken[static_cast<std::size_t>(best)] = 1;
    match.dot_of[i] = best;
    ++match.count;
    match.misfit += nearest / tolerance;
  }
  return match;
}

// Least squares through what matched: affine, or projective from six dots on; nothing where they
// lie on a line.
std::optional<cv::Matx33d> LayoutMatcher::projective(const Match& match) const {
  std::vector<cv::Point2d> from, to;
  Eigen::MatrixXd design(match.count, 3), target(match.count, 2);
  for (std::size_t i = 0; i < fiducials_.size(); ++i) {
    if (match.dot_of[i] < 0) continue;
    const Eigen::Vector2d pixel = corrected(static_cast<std::size_t>(match.dot_of[i]));
    const auto row = static_cast<Eigen::Index>(from.size());
    design.row(row) << fiducials_[i].x, fiducials_[i].z, 1.0;
    target.row(row) = pixel.transpose();
    from.emplace_back(fiducials_[i].x, fiducials_[i].z);
    to.emplace_back(pixel.x(), pixel.y());
  }
  constexpr int least_for_tilt = 6;
  if (match.count >= least_for_tilt) {
    const cv::Mat found = cv::findHomography(from, to);
    if (!found.empty()) return cv::Matx33d(found);
  }
  const auto solver = design.colPivHouseholderQr();
  if (solver.rank() < 3) return std::nullopt;
  const Eigen::MatrixXd affine = solver.solve(target);
  return cv::Matx33d(affine(0, 0),
                     affine(1, 0),
                     affine(2, 0),
                     affine(0, 1),
                     affine(1, 1),
                     affine(2, 1),
                     0.0,
                     0.0,
                     1.0);
}

// What matches a similarity, and then the tilted view through that: outer dots too.
Match LayoutMatcher::grown(Match match) const {
  for (int pass = 0; pass < 4 && match.count >= 4; ++pass) {
    const std::optional<cv::Matx33d> found = projective(match);
    if (!found) break;
    const cv::Matx33d& h = *found;
    const auto depth = [&](const Eigen::Vector2d& p) {
      return h(2, 0) * p.x() + h(2, 1) * p.y() + h(2, 2);
    };
    const auto map = [&](const Eigen::Vector2d& p) {
      return Eigen::Vector2d((h(0, 0) * p.x() + h(0, 1) * p.y() + h(0, 2)) / depth(p),
                             (h(1, 0) * p.x() + h(1, 1) * p.y() + h(1, 2)) / depth(p));
    };
    // |d(column, row)/d(x, z)| = det H / depth^3
    const auto scale = [&](const Eigen::Vector2d& p) {
      return std::sqrt(std::abs(cv::determinant(h) / std::pow(depth(p), 3)));
    };
    const Match next = match_with(map, scale, slack_, 0);
    if (next.count < match.count) break;
    match = next;
  }
  return match;
}

// Every far pair of fiducials against every pair of dots that agrees with it in size and
// uprightness. What they explain is compared only when grown: a grid of dots that is taken one row
// off matches three quarters of itself, and an upright one less of a tilted view.
Match LayoutMatcher::best() const {
  Match best;
  std::set<std::vector<int>> tried;
  const double widest = largest_distance(fiducials_);
  const int all = static_cast<int>(fiducials_.size());
  for (std::size_t i = 0; i < fiducials_.size(); ++i) {
    for (std::size_t j = 0; j < fiducials_.size(); ++j) {
      const Eigen::Vector2d between = lab(j) - lab(i);
      if (i == j || between.norm() < 0.4 * widest ||
          (between.x() < 0 || (between.x() == 0 && between.y() < 0)))
        continue;
      for (std::size_t a = 0; a < dots_.size(); ++a) {
        for (std::size_t b = 0; b < dots_.size(); ++b) {
          const std::optional<Similarity> map = a == b ? std::nullopt : similarity(i, j, a, b);
          if (!map) continue;
          const double scale = std::hypot(map->real, map->imaginary);
          // Half of what is known to be possible: growing does the rest.
          const Match match = match_with(
              *map,
              [&](const Eigen::Vector2d&) { return scale; },
              std::max(slack_, 0.5 * scale * fiducials_[i].diameter),
              (best.count + 1) / 2);
          if (2 * match.count < best.count || !tried.insert(match.dot_of).second) continue;
          best = std::max(best, grown(match));
        }
      }
      if (best.count == all) return best;
    }
  }
  return best;
}

}  // namespace

std::vector<DarkDot> find_dark_dots(const cv::Mat& grey,
                                    const std::vector<datasets::Fiducial>& fiducials) {
  cv::Mat smooth;
  cv::GaussianBlur(grey, smooth, cv::Size(3, 3), 0.0);
  double darkest = 0.0, lightest = 0.0;
  cv::minMaxLoc(smooth, &darkest, &lightest);
  constexpr int levels = 24;
  // As large as a dot looks where the layout is twice as wide as the picture
  double widest_dot = 0.0;
  for (const datasets::Fiducial& fiducial : fiducials)
    widest_dot = std::max(widest_dot, fiducial.diameter);
  const double largest =
      2.0 * std::hypot(grey.cols, grey.rows) * widest_dot / largest_distance(fiducials);
  const double largest_area = 0.25 * std::numbers::pi * largest * largest;
  struct Group {
    DarkDot sum;
    int members = 0;
  };
  std::vector<Group> groups;
  for (int level = 1; level < levels; ++level) {
    const double threshold = darkest + (lightest - darkest) * level / levels;
    cv::Mat dark;
    cv::threshold(smooth, dark, threshold, 255.0, cv::THRESH_BINARY_INV);
    std::vector<std::vector<cv::Point>> contours;
    cv::findContours(dark, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
    for (const auto& contour : contours) {
      // A contour runs through pixel centres: add half a pixel all round to get the patch's own
      // area.
      const double area =
          cv::contourArea(contour) + 0.5 * static_cast<double>(contour.size()) + 1.0;
      const double smallest = 12.0;  // px^2: below 4 px across a dot has no measurable shape
      if (area < smallest || area > largest_area) continue;
      const cv::Rect box = cv::boundingRect(contour);
      if (std::max(box.width, box.height) > 1.6 * std::min(box.width, box.height) + 1.0) continue;
      // A disc fills pi/4 of its box.
      const double fill = area / (static_cast<double>(box.width) * box.height);
      if (fill < 0.66 || fill > 0.93) continue;
      const cv::Moments moments = cv::moments(contour);
      if (moments.m00 <= 0.0) continue;
      const Eigen::Vector2d centre(moments.m10 / moments.m00, moments.m01 / moments.m00);
      const double diameter = std::sqrt(4.0 * area / std::numbers::pi);
      // Dark inside, light all round, whatever the absolute levels.
      const double inside = bilinear(smooth, centre.x(), centre.y());
      if (inside > threshold) continue;
      int light = 0;
      constexpr int around = 16;
      for (int k = 0; k < around; ++k) {
        const double angle = 2.0 * std::numbers::pi * k / around;
        const double reach = 0.5 * diameter * 1.25 + 1.0;
        light += bilinear(smooth,
                          centre.x() + reach * std::cos(angle),
                          centre.y() + reach * std::sin(angle)) > threshold;
      }
      if (light < around - 1) continue;
      bool merged = false;
      for (Group& group : groups) {
        const Eigen::Vector2d mean = group.sum.centre / group.members;
        const double mean_diameter = group.sum.diameter / group.members;
        if ((mean - centre).norm() < 0.25 * mean_diameter &&
            std::abs(mean_diameter - diameter) < 0.4 * diameter) {
          group.sum.centre += centre;
          group.sum.diameter += diameter;
          ++group.members;
          merged = true;
          break;
        }
      }
      if (!merged) groups.push_back({{centre, diameter}, 1});
    }
  }
  std::vector<DarkDot> dots;
  for (const Group& group : groups) {
    // A printed dot is dark over a good part of the picture's range; texture separates at one level
    // only.
    if (group.members >= 2)
      dots.push_back({group.sum.centre / group.members, group.sum.diameter / group.members});
  }
  return dots;
}

std::vector<FiducialSighting> find_fiducials(const cv::Mat& grey,
                                             const std::vector<datasets::Fiducial>& fiducials,
                                             double pixel_aspect) {
  std::vector<DarkDot> dots = find_dark_dots(grey, fiducials);
  // Printed dots are larger than the texture of what was filmed: they are tried first.
  std::stable_sort(dots.begin(), dots.end(), [](const DarkDot& a, const DarkDot& b) {
    return a.diameter > b.diameter;
  });
  const LayoutMatcher matcher(fiducials, dots, pixel_aspect, 0.02 * grey.cols);
  const Match best = matcher.best();
  std::vector<FiducialSighting> sightings;
  if (best.count < 3) return sightings;
  for (std::size_t i = 0; i < fiducials.size(); ++i) {
    if (best.dot_of[i] < 0) continue;
    const DarkDot& dot = dots[static_cast<std::size_t>(best.dot_of[i])];
    FiducialSighting sighting{static_cast<int>(i), dot.centre, dot.diameter};
    if (refine_fiducial(grey, sighting)) sightings.push_back(sighting);
  }
  return sightings;
}

bool refine_fiducial(const cv::Mat& grey, FiducialSighting& sighting) {
  constexpr int rays = 48;
  constexpr double step = 0.25;  // px
  for (int pass = 0; pass < 3; ++pass) {
    const double radius = 0.5 * sighting.diameter_px;
    const double outer = radius * 1.45 + 1.5;  // tabs are about twice as wide as their dots
    if (sighting.pixel.x() < outer + 1 || sighting.pixel.y() < outer + 1 ||
        sighting.pixel.x() > grey.cols - outer - 2 || sighting.pixel.y() > grey.rows - outer - 2)
      return false;
    std::vector<double> reach, cosine, sine;
    for (int k = 0; k < rays; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / rays;
      const double c = std::cos(angle), s = std::sin(angle);
      const auto at = [&](double r) {
        return bilinear(grey, sighting.pixel.x() + r * c, sighting.pixel.y() + r * s);
      };
      // Plateaus inside and just outside this ray's own edge, so that uneven light cancels
      double dark = 0.0, light = 0.0;
      constexpr int samples = 4;
      for (int i = 0; i < samples; ++i) {
        dark += at(radius * (0.25 + 0.1 * i)) / samples;
        light += at(radius * (1.25 + 0.05 * i) + 0.75) / samples;
      }
      if (light - dark < 8.0) continue;  // grey levels: no edge here
      const double half = 0.5 * (light + dark);
      double previous = at(0.5 * radius);
      for (double r = 0.5 * radius + step; r < outer; r += step) {
        const double value = at(r);
        if (previous < half && value >= half) {
          reach.push_back(r - step * (value - half) / (value - previous));
          cosine.push_back(c);
          sine.push_back(s);
          break;
        }
        previous = value;
      }
    }
    if (reach.size() < rays * 3 / 4) return false;
    // r(angle) = r0 + x cos + y sin + the two terms of an ellipse; rays far off the fit are left
    // out once
    std::vector<char> use(reach.size(), 1);
    Eigen::Matrix<double, 5, 1> shape;
    for (int round = 0; round < 2; ++round) {
      Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
      Eigen::Matrix<double, 5, 1> right = Eigen::Matrix<double, 5, 1>::Zero();
      const auto row_of = [&](std::size_t i) {
        const double c = cosine[i], s = sine[i];
        return Eigen::Matrix<double, 5, 1>(1.0, c, s, c * c - s * s, 2.0 * c * s);
      };
      for (std::size_t i = 0; i < reach.size(); ++i) {
        if (!use[i]) continue;
        normal += row_of(i) * row_of(i).transpose();
        right += row_of(i) * reach[i];
      }
      shape = normal.ldlt().solve(right);
      std::vector<double> misses;
      for (std::size_t i = 0; i < reach.size(); ++i)
        misses.push_back(std::abs(row_of(i).dot(shape) - reach[i]));
      std::vector<double> sorted = misses;
      std::sort(sorted.begin(), sorted.end());
      const double limit = std::max(0.15, 4.0 * sorted[sorted.size() / 2]);
      for (std::size_t i = 0; i < reach.size(); ++i) use[i] = misses[i] < limit;
    }
    if (!shape.allFinite() || std::hypot(shape[1], shape[2]) > radius) return false;
    sighting.pixel += Eigen::Vector2d(shape[1], shape[2]);
    sighting.diameter_px = 2.0 * shape[0];
  }
  return true;
}

}  // namespace graintruth::tracking
