#include "sim/engine/neighbours.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace graintruth::sim {
namespace {

// Cells beyond this many per body would be empty: the edge grows instead, so memory stays linear in
// bodies.
constexpr double kMostCellsPerBody = 4.0;

template <int D>
Grid<D> make_grid(const PointView<D>& centres,
                  double smallest_edge,
                  const PeriodicCell<D>& periodic) {
  Vec<D> low = centres[0], high = centres[0];
  for (std::size_t i = 1; i < centres.count; ++i) {
    low = low.cwiseMin(centres[i]);
    high = high.cwiseMax(centres[i]);
  }
  Grid<D> grid;
  const Vec<D> cell_low = to_eigen(periodic.low), cell_length = to_eigen(periodic.length);
  for (int axis = 0; axis < D; ++axis) {
    grid.is_periodic[axis] = cell_length[axis] > 0.0;
    if (!grid.is_periodic[axis]) continue;
    low[axis] = cell_low[axis];
    high[axis] = cell_low[axis] + cell_length[axis];
  }
  grid.origin = low;
  const auto cells_along = [&](int axis, double edge) {
    const double whole = std::floor((high[axis] - low[axis]) / edge);
    return grid.is_periodic[axis] ? std::max(whole, 1.0) : whole + 1.0;
  };
  const double most = kMostCellsPerBody * static_cast<double>(centres.count) + 64.0;
  const auto cells_at = [&](double edge) {
    double count = 1.0;
    for (int axis = 0; axis < D; ++axis) count *= cells_along(axis, edge);
    return count;
  };
  double edge = smallest_edge;
  while (cells_at(edge) > most) edge *= 1.25;
  for (int axis = 0; axis < D; ++axis) {
    grid.size[axis] = static_cast<int>(cells_along(axis, edge));
    grid.edge[axis] = grid.is_periodic[axis] ? cell_length[axis] / grid.size[axis] : edge;
  }
  return grid;
}

// Runs [first, last] of cells side by side that are a cell and its neighbours along one axis.
struct CellRuns {
  int count;
  std::array<std::array<int, 2>, 2> run;
};
CellRuns runs_about(int home, int size, bool is_periodic) {
  const int before = std::max(home - 1, 0), after = std::min(home + 1, size - 1);
  const bool meets_ends = is_periodic && size > 3;
  if (meets_ends && home == 0) return {2, {{{0, after}, {size - 1, size - 1}}}};
  if (meets_ends && home == size - 1) return {2, {{{0, 0}, {before, home}}}};
  if (is_periodic && size <= 3) return {1, {{{0, size - 1}, {}}}};
  return {1, {{{before, after}, {}}}};
}

}  // namespace

template <int D>
std::array<int, 3> Grid<D>::cell(const Vec<D>& point) const {
  std::array<int, 3> index{0, 0, 0};
  for (int axis = 0; axis < D; ++axis) {
    double along = std::floor((point[axis] - origin[axis]) / edge[axis]);
    if (is_periodic[axis]) along -= size[axis] * std::floor(along / size[axis]);
    index[axis] = std::clamp(static_cast<int>(along), 0, size[axis] - 1);
  }
  return index;
}

template <int D>
void CellList<D>::sort(const PointView<D>& centres,
                       const RadiusView& radii,
                       double margin,
                       const PeriodicCell<D>& cell) {
  cell_ = cell;
  centres_ = centres;
  radii_ = radii;
  margin_ = margin;
  const int count = static_cast<int>(centres.count);
  if (count == 0) return;
  const double largest = *std::max_element(radii.radii.begin(), radii.radii.end());
  grid_ = make_grid<D>(centres, 2.0 * largest + margin, cell);
  cell_of_body_.resize(count);
  bodies_by_cell_.resize(count);
  const int cell_count = grid_.cell_count();
  first_in_cell_.assign(cell_count + 1, 0);
  for (int i = 0; i < count; ++i) {
    cell_of_body_[i] = grid_.flat(grid_.cell(centres[i]));
    ++first_in_cell_[cell_of_body_[i]];
  }
  for (int c = 0; c < cell_count; ++c) first_in_cell_[c + 1] += first_in_cell_[c];
  // From behind: in each cell in the order of their indices, and each end becomes a beginning
  for (int i = count - 1; i >= 0; --i) bodies_by_cell_[--first_in_cell_[cell_of_body_[i]]] = i;
}

template <int D>
void CellList<D>::visit_near_pairs(
    int begin,
    int end,
    std::vector<IndexPair>& pairs,
    const std::function<void(std::span<const IndexPair>)>& visit) const {
  // Each body against the later ones in its own and the adjacent cells
  const auto& size = grid_.size;
  for (int i = begin; i < end; ++i) {
    const std::array<int, 3> home = grid_.cell(centres_[i]);
    pairs.clear();
    const auto add_those_in = [&](int first_cell, int last_cell) {
      for (int k = first_in_cell_[first_cell]; k < first_in_cell_[last_cell + 1]; ++k) {
        const int j = bodies_by_cell_[k];
        if (j <= i) continue;
        const double reach = radii_[i] + radii_[j] + margin_;
        Vec<D> apart = centres_[j] - centres_[i];
        if (cell_.is_periodic) apart += to_eigen(shift_to_nearest(cell_, plain(apart)));
        if (apart.squaredNorm() < reach * reach) pairs.push_back({i, j});
      }
    };
    std::array<CellRuns, 3> runs;
    for (int axis = 0; axis < 3; ++axis)
      runs[axis] = runs_about(home[axis], size[axis], grid_.is_periodic[axis]);
    for (int rz = 0; rz < runs[2].count; ++rz) {
      for (int cz = runs[2].run[rz][0]; cz <= runs[2].run[rz][1]; ++cz) {
        for (int ry = 0; ry < runs[1].count; ++ry) {
          for (int cy = runs[1].run[ry][0]; cy <= runs[1].run[ry][1]; ++cy) {
            // The cells of a row lie side by side
            for (int rx = 0; rx < runs[0].count; ++rx) {
              const auto [first, last] = runs[0].run[rx];
              add_those_in(grid_.flat({first, cy, cz}), grid_.flat({last, cy, cz}));
            }
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
                     CellList<D>& cells,
                     std::vector<IndexPair>& pairs,
                     const PeriodicCell<D>& cell) {
  pairs.clear();
  if (centres.empty()) return;
  cells.sort({centres.front().data(), D, centres.size()}, RadiusView{radii}, margin, cell);
  std::vector<IndexPair> of_one;
  cells.visit_near_pairs(
      0, static_cast<int>(centres.size()), of_one, [&](std::span<const IndexPair> of_body) {
        pairs.insert(pairs.end(), of_body.begin(), of_body.end());
      });
}

template struct Grid<2>;
template struct Grid<3>;
template class CellList<2>;
template class CellList<3>;

template void find_near_pairs<2>(std::span<const Vec<2>>,
                                 std::span<const double>,
                                 double,
                                 CellList<2>&,
                                 std::vector<IndexPair>&,
                                 const PeriodicCell<2>&);
template void find_near_pairs<3>(std::span<const Vec<3>>,
                                 std::span<const double>,
                                 double,
                                 CellList<3>&,
                                 std::vector<IndexPair>&,
                                 const PeriodicCell<3>&);

}  // namespace graintruth::sim
