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
std::array<int, 3> Grid<D>::cell(const Vec<D>& point) const {
  std::array<int, 3> index{0, 0, 0};
  for (int axis = 0; axis < D; ++axis) {
    const double along = std::floor((point[axis] - origin[axis]) / edge);
    index[axis] = std::clamp(static_cast<int>(along), 0, size[axis] - 1);
  }
  return index;
}

template <int D>
void CellList<D>::sort(const PointView<D>& centres, const RadiusView& radii, double margin) {
  centres_ = centres;
  radii_ = radii;
  margin_ = margin;
  const int count = static_cast<int>(centres.count);
  if (count == 0) return;
  const double largest = *std::max_element(radii.radii.begin(), radii.radii.end());
  grid_ = make_grid<D>(centres, 2.0 * largest + margin);
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
    const int below = D == 3 ? std::max(home[2] - 1, 0) : 0;
    const int above = D == 3 ? std::min(home[2] + 1, size[2] - 1) : 0;
    for (int cz = below; cz <= above; ++cz) {
      for (int cy = std::max(home[1] - 1, 0); cy <= std::min(home[1] + 1, size[1] - 1); ++cy) {
        // The cells of a row lie side by side
        const int first = grid_.flat({std::max(home[0] - 1, 0), cy, cz});
        const int last = grid_.flat({std::min(home[0] + 1, size[0] - 1), cy, cz});
        for (int k = first_in_cell_[first]; k < first_in_cell_[last + 1]; ++k) {
          const int j = bodies_by_cell_[k];
          if (j <= i) continue;
          const double reach = radii_[i] + radii_[j] + margin_;
          if ((centres_[j] - centres_[i]).squaredNorm() < reach * reach) pairs.push_back({i, j});
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
                     std::vector<IndexPair>& pairs) {
  pairs.clear();
  if (centres.empty()) return;
  cells.sort({centres.front().data(), D, centres.size()}, RadiusView{radii}, margin);
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
                                 std::vector<IndexPair>&);
template void find_near_pairs<3>(std::span<const Vec<3>>,
                                 std::span<const double>,
                                 double,
                                 CellList<3>&,
                                 std::vector<IndexPair>&);

}  // namespace graintruth::sim
