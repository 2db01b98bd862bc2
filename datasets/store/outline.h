// The outline of a bed: its free surface in time, as a camera sees it against what is behind. Film
// and simulation give the same. A rig may have several surfaces, each with a name.
#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace graintruth::datasets {

// Where the picture plane is seen from, in its own frame: x right, z up, y away from the camera, so
// that the eye has a negative y. At infinity the lines of sight are parallel.
struct Eye {
  double x = 0.0, z = 0.0;                                    // m
  double distance = std::numeric_limits<double>::infinity();  // m from the plane of the scale
  bool operator==(const Eye&) const = default;
};

// For columns of the picture plane of equal width: the height of the upper edge of the grains'
// silhouette, averaged over the column. What stands nearer than the plane, or farther, is seen
// where its line of sight meets the plane.
struct Outline {
  std::vector<double> column;  // m, x of the middle of each column, rising in equal steps
  std::vector<double> time;    // s from the start event, rising
  std::vector<double> height;  // m, times x columns; NaN where nothing is seen
  std::vector<double> sigma;   // m, standard uncertainty, same shape; empty where none is known
  Eye eye;
  std::string surface = {};  // its name; empty where the rig has one surface

  std::size_t index(std::size_t moment, std::size_t place) const {
    return moment * column.size() + place;
  }
};

// tracks/<replicate>.outline.csv: time_s,column_m,height_m,sigma_m, one row for each column seen,
// and before these a column `surface` where surfaces have names. One surface stands after the
// other. Written whole, then renamed; numbers are the shortest that read back to the same bits.
void write_outlines(const std::filesystem::path& file, std::span<const Outline> outlines);

// The surfaces in the order of their first rows; one, without a name, where the file does not name
// any. The columns are those that are seen at any time and those between them. The eye stands in no
// such file: lines of sight are parallel until somebody says more. Throws InputError with file and
// line for what cannot be.
std::vector<Outline> read_outlines(const std::filesystem::path& file);

}  // namespace graintruth::datasets
