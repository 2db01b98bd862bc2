#include "sim/neighbours.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace graintruth::sim {
namespace {

// Cells beyond this many per body would be empty: the edge grows instead, so memory stays linear in
// bodies.
constexpr double kMostCellsPerBody = 4.0;

template <int D>
struct Grid {
  Vec<D> origin;
  double edge = 1.0;
  std::array<int, 3> size{1, 1, 1};

  std::array<int, 3> cell(const Vec<D>& point) const {
    std::array<int, 3> index{0, 0, 0};
    for (int axis = 0; axis < D; ++axis) {
      const double along = std::floor((point[axis] - origin[axis]) / edge);
      index[axis] = std::clamp(static_cast<int>(along), 0, size[axis] - 1);
    }
    return index;
  }
  int flat(const std::array<int, 3>& cell) const {
    return (cell[2] * size[1] + cell[1]) * size[0] + cell[0];
  }
};

// Cells at least as wide as the farthest apart two neighbours can be.
template <int D>
Grid<D> make_grid(const PointView<D>& centres, double smallest_edge) {
  Vec<D> low = centres[0], high = centres[0];
  for (std::size_t i = 1; i < centres.count; ++i) {
    low = low.cwiseMin(centres[i]);
    high = high.cwiseMax(centres[i]);
  }
  Grid<D> grid;
  grid.origin = low;
  grid.edge = smallest_edge;
  const double most = kMostCellsPerBody * static_cast<double>(centres.count) + 64.0;
  const auto cells_at = [&](double edge) {
    double count = 1.0;
    for (int axis = 0; axis < D; ++axis) count *= std::floor((high[axis] - low[axis]) / edge) + 1.0;
    return count;
  };
  while (cells_at(grid.edge) > most) grid.edge *= 1.25;
  for (int axis = 0; axis < D; ++axis) {
    grid.size[axis] = 1 + static_cast<int>((high[axis] - low[axis]) / grid.edge);
  }
  return grid;
}

}  // namespace

template <int D>
void visit_near_pairs(const PointView<D>& centres,
                      const RadiusView& radii,
                      double margin,
                      CellList& cells,
                      const std::function<void(std::span<const IndexPair>)>& visit) {
  const int count = static_cast<int>(centres.count);
  if (count < 2) return;

  // 1. Bodies into cells, in the order of their indices
  const double largest = *std::max_element(radii.radii.begin(), radii.radii.end());
  const Grid<D> grid = make_grid<D>(centres, 2.0 * largest + margin);
  const int cell_count = grid.size[0] * grid.size[1] * grid.size[2];
  cells.cell_of_body.resize(count);
  cells.bodies_by_cell.resize(count);
  cells.first_in_cell.assign(cell_count + 1, 0);
  for (int i = 0; i < count; ++i) {
    cells.cell_of_body[i] = grid.flat(grid.cell(centres[i]));
    ++cells.first_in_cell[cells.cell_of_body[i] + 1];
  }
  for (int c = 0; c < cell_count; ++c) cells.first_in_cell[c + 1] += cells.first_in_cell[c];
  for (int i = count - 1; i >= 0; --i) {
    // Filled from behind; afterwards first_in_cell[c + 1] is the first body of cell c
    cells.bodies_by_cell[--cells.first_in_cell[cells.cell_of_body[i] + 1]] = i;
  }
  const auto begin_of = [&](int cell) { return cells.first_in_cell[cell + 1]; };
  const auto end_of = [&](int cell) {
    return cell + 1 < cell_count ? cells.first_in_cell[cell + 2] : count;
  };

  // 2. Each body against the later ones in its own and the adjacent cells
  std::vector<IndexPair>& pairs = cells.pairs_of_body;
  for (int i = 0; i < count; ++i) {
    const std::array<int, 3> home = grid.cell(centres[i]);
    pairs.clear();
    const int below = D == 3 ? std::max(home[2] - 1, 0) : 0;
    const int above = D == 3 ? std::min(home[2] + 1, grid.size[2] - 1) : 0;
    for (int cz = below; cz <= above; ++cz) {
      for (int cy = std::max(home[1] - 1, 0); cy <= std::min(home[1] + 1, grid.size[1] - 1); ++cy) {
        for (int cx = std::max(home[0] - 1, 0); cx <= std::min(home[0] + 1, grid.size[0] - 1);
             ++cx) {
          const int cell = grid.flat({cx, cy, cz});
          for (int k = begin_of(cell); k < end_of(cell); ++k) {
            const int j = cells.bodies_by_cell[k];
            if (j <= i) continue;
            const double reach = radii[i] + radii[j] + margin;
            if ((centres[j] - centres[i]).squaredNorm() < reach * reach) pairs.push_back({i, j});
          }
        }
      }
    }
    if (pairs.empty()) continue;
    std::sort(pairs.begin(), pairs.end(), [](const IndexPair& a, const IndexPair& b) {
      return a.second < b.second;
    });
    visit(pairs);
  }
}

template <int D>
void find_near_pairs(std::span<const Vec<D>> centres,
                     std::span<const double> radii,
                     double margin,
                     CellList& cells,
                     std::vector<IndexPair>& pairs) {
  pairs.clear();
  if (centres.empty()) return;
  const PointView<D> view{centres.front().data(), D, centres.size()};
  visit_near_pairs<D>(
      view, RadiusView{radii}, margin, cells, [&](std::span<const IndexPair> of_body) {
        pairs.insert(pairs.end(), of_body.begin(), of_body.end());
      });
}

template void visit_near_pairs<2>(const PointView<2>&,
                                  const RadiusView&,
                                  double,
                                  CellList&,
                                  const std::function<void(std::span<const IndexPair>)>&);
template void visit_near_pairs<3>(const PointView<3>&,
                                  const RadiusView&,
                                  double,
                                  CellList&,
                                  const std::function<void(std::span<const IndexPair>)>&);

template void find_near_pairs<2>(
    std::span<const Vec<2>>, std::span<const double>, double, CellList&, std::vector<IndexPair>&);
template void find_near_pairs<3>(
    std::span<const Vec<3>>, std::span<const double>, double, CellList&, std::vector<IndexPair>&);

}  // namespace graintruth::sim
