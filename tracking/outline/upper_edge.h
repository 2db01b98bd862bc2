// Where grains end upwards in one plane picture: a cut of least cost through what speaks for grains
// and what against them, then the edge itself to a part of a cell.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace graintruth::tracking {

struct GrainEvidence {
  cv::Mat1f ratio;    // of each cell: log of how much likelier grains are; 0 where nothing is known
  cv::Mat1b known;    // 255: shows grains, or what is behind them; 0: what may hide grains
  float limit = 1.0;  // no cell says more than this, either way
};

struct EdgeOptions {
  double grain = 1.0;  // cells, diameter
  int floor = 0;       // row; nothing below it counts
  double noise = 1.0;  // grey levels, one standard deviation of a pixel
};

// Of every column of cells, in cells from the middle of the first row; NaN: no grain.
struct UpperEdge {
  std::vector<float> row;
  // By how much it would lie otherwise if grains at the edge were a standard deviation of what
  // grains near it show nearer to the ground, or farther.
  std::vector<float> doubt;
  std::vector<float> noise;  // cells, one standard deviation from the noise of pixels
  std::vector<char> hidden;  // the edge lies behind something
};

// Labels every column as empty down to some row and full of grains below it, so that the evidence
// for grains below less that above is largest, and neighbours differ little: a structure narrower
// than an eighth of a grain costs more than it gains. Dynamic programming finds the best labels of
// all columns together. Grains that fly above them are added where they are as thick as grains.
std::vector<int> cut_along_columns(const GrainEvidence& evidence, const EdgeOptions& options);

// The cut, moved across itself to where the picture is half way between what it shows on both
// sides; of the grains, what those show that differ less from the ground than others, by a standard
// deviation: else the dim ones would be lost, while bright ones gain little. Brightness decides
// where it can: films keep colours half as sharp.
UpperEdge find_upper_edge(const cv::Mat& picture,
                          const GrainEvidence& evidence,
                          const EdgeOptions& options);

}  // namespace graintruth::tracking
