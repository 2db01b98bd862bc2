// Interlaced films: two fields, taken one after the other, woven into one frame row by row. Found
// by which rows of neighbouring frames follow each other, which slow motion shows as well as fast,
// and taken apart again.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

namespace graintruth::tracking {

// How the rows of a frame were taken: all at once, or the rows 0, 2, 4, ... before or after the
// others.
enum class Scan { progressive, even_rows_first, odd_rows_first };

// Looks at frame after frame until it is sure.
class ScanDetector {
 public:
  void add(const cv::Mat& frame);
  bool is_sure() const;
  // Progressive where too little moved to tell.
  Scan scan() const;

 private:
  cv::Mat previous_;  // brightness
  // Votes of pixels that moved: is a frame's even row nearer to the odd rows of the frame before,
  // or its odd row to the even rows? The later field of a frame and the earlier one of the next are
  // closest in time; where all rows are taken at once neither wins.
  long odd_to_even_ = 0, even_to_odd_ = 0;
  long moved_ = 0;
};

// Reads the beginning of a film, as it is stored, until something has moved. Single pictures are
// taken to be progressive.
Scan detect_scan(const std::filesystem::path& film);

// The rows 0, 2, 4, ... (parity 0) or 1, 3, 5, ... (parity 1) of a frame, the others filled in
// between their neighbours, so that places in the picture stay what they were.
cv::Mat field_of(const cv::Mat& frame, int parity);

}  // namespace graintruth::tracking
