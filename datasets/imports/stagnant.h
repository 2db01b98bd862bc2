// Which part of a bed stands still while the rest runs out: one written rule for films, which show
// it, and for tracks, from which it is computed.
#pragma once

#include <span>
#include <vector>

namespace graintruth::datasets {

// A place stands still while what lies there is slower than this, m/s: a tenth of a particle's
// diameter in the time in which it would fall freely by a whole one,
//   v = 0.1 d / sqrt(2 d / g).
double stagnant_speed(double diameter, double gravity);

enum class Ground : char { empty, moving, still };

// Places of a bin: columns half a diameter wide, rows an eighth of one, from the floor up.
struct StagnantMap {
  std::vector<double> x, z;    // m, middles of the columns and rows
  std::vector<Ground> ground;  // column by column, each from the floor up

  Ground& at(std::size_t column, std::size_t row) { return ground[column * z.size() + row]; }
  Ground at(std::size_t column, std::size_t row) const { return ground[column * z.size() + row]; }
};

// All places empty. `height` is that of the bin, as far as it is looked at.
StagnantMap make_stagnant_map(double width, double height, double diameter);

// The top of what stands still in each column below anything that moves, m; NaN over the orifice.
// Holes of up to half a diameter are passed over.
std::vector<double> stagnant_heights(const StagnantMap& map, double orifice_width);

// Share of the places that stand still in one map or in both that do so in both (intersection over
// union); 1 where nothing stands still in either. The maps must be of one bin.
double stagnant_overlap(const StagnantMap& a, const StagnantMap& b);

// The same of the areas below two lines of stagnant heights over the same columns:
//   sum min(a, b) / sum max(a, b)
// over columns in which both are known; NaN where there are none, 1 where nothing stands still.
double stagnant_overlap(std::span<const double> a, std::span<const double> b);

}  // namespace graintruth::datasets
