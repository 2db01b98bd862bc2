#include "tracking/film/fields.h"

#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "tracking/film/film_file.h"
#include "tracking/film/single_pictures.h"

namespace graintruth::tracking {

namespace {

constexpr int moved_level = 24;     // grey levels of change at a pixel: well above camera noise
constexpr long convincing = 20000;  // moved pixels
// Votes below which nothing is said: those of one rim are alike, and a few rims agree by chance
constexpr long fewest_votes = 400;
constexpr double one_sided =
    2.0;  // films taken all at once give 1.00 +- 0.05, woven ones 3 or more
constexpr int longest_look = 400;  // frames

}  // namespace

void ScanDetector::add(const cv::Mat& frame) {
  // Brightness alone: films store colour for pairs of rows, whatever the scan
  cv::Mat grey;
  cv::cvtColor(frame, grey, cv::COLOR_BGR2GRAY);
  if (!previous_.empty() && previous_.size() == grey.size()) {
    constexpr int stride = 2;  // columns; even, and so are the rows below
    for (int row = 2; row + 3 < grey.rows; ++row) {
      const bool even = row % 2 == 0;
      const auto* before = previous_.ptr<std::uint8_t>(row);
      const auto* before_next = previous_.ptr<std::uint8_t>(row + 1);
      const auto* here = grey.ptr<std::uint8_t>(row);
      const auto* next = grey.ptr<std::uint8_t>(row + 1);
      const auto* before_above = previous_.ptr<std::uint8_t>(row - 1);
      const auto* before_second = previous_.ptr<std::uint8_t>(row + 2);
      for (int column = 0; column < grey.cols; column += stride) {
        if (std::abs(here[column] - before[column]) < moved_level &&
            std::abs(next[column] - before_next[column]) < moved_level)
          continue;
        ++moved_;
        const int upper = std::abs(2 * here[column] - before_above[column] - before_next[column]);
        const int lower = std::abs(2 * next[column] - before[column] - before_second[column]);
        if (2 * upper < lower) ++(even ? odd_to_even_ : even_to_odd_);
        if (2 * lower < upper) ++(even ? even_to_odd_ : odd_to_even_);
      }
    }
  }
  previous_ = grey;
}

bool ScanDetector::is_sure() const { return moved_ > convincing; }

Scan ScanDetector::scan() const {
  const double odd_then_even = static_cast<double>(odd_to_even_) + 1.0;
  const double even_then_odd = static_cast<double>(even_to_odd_) + 1.0;
  if (odd_to_even_ + even_to_odd_ < fewest_votes) return Scan::progressive;
  if (odd_then_even > one_sided * even_then_odd) return Scan::even_rows_first;
  if (even_then_odd > one_sided * odd_then_even) return Scan::odd_rows_first;
  return Scan::progressive;
}

Scan detect_scan(const std::filesystem::path& film) {
  ScanDetector detector;
  if (!single_pictures(film).empty()) return detector.scan();
  FilmFile file(film);
  StoredPicture stored;
  for (int number = 0; number < longest_look && !detector.is_sure() && file.read(stored); ++number)
    detector.add(stored.picture);
  return detector.scan();
}

cv::Mat field_of(const cv::Mat& frame, int parity) {
  cv::Mat field = frame.clone();
  for (int row = 1 - parity; row < frame.rows; row += 2) {
    const int above = row > 0 ? row - 1 : row + 1;
    const int below = row + 1 < frame.rows ? row + 1 : row - 1;
    cv::Mat between = field.row(row);
    cv::addWeighted(frame.row(above), 0.5, frame.row(below), 0.5, 0.0, between);
  }
  return field;
}

}  // namespace graintruth::tracking
