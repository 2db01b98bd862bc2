// Which bodies are near each other: a cell list over bounding spheres, linear in the number of
// bodies.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "sim/engine/periodic_cell.h"
#include "sim/laws/motion.h"

namespace graintruth::sim {

struct IndexPair {
  int first, second;  // first < second
  bool operator==(const IndexPair&) const = default;
};

// Points that lie `stride` numbers apart, as members of longer records.
template <int D>
struct PointView {
  const double* first;
  std::size_t stride;
  std::size_t count;
  Vec<D> operator[](std::size_t i) const { return Vec<D>(first + i * stride); }
};

// Radii of bodies, each of which is of a kind; without kinds each has its own.
struct RadiusView {
  std::span<const double> radii;
  const int* kind = nullptr;
  double operator[](std::size_t i) const { return radii[kind != nullptr ? kind[i] : i]; }
};

// Cells at least as wide as the farthest apart two neighbours can be; along a periodic axis as many
// as fit, the first and the last of them side by side.
template <int D>
struct Grid {
  Vec<D> origin = Vec<D>::Zero();
  Vec<D> edge = Vec<D>::Ones();  // m
  std::array<int, 3> size{1, 1, 1};
  std::array<bool, 3> is_periodic{};

  std::array<int, 3> cell(const Vec<D>& point) const;
  int flat(const std::array<int, 3>& cell) const {
    return (cell[2] * size[1] + cell[1]) * size[0] + cell[0];
  }
  int cell_count() const { return size[0] * size[1] * size[2]; }
};

// Bodies in the cells of a grid. Its memory lives from one search to the next.
template <int D>
class CellList {
 public:
  // Sorts bodies whose bounding spheres have these centres and radii; both must last as long as
  // pairs are looked for. Bodies are near when their spheres are less than `margin` (m) apart.
  void sort(const PointView<D>& centres,
            const RadiusView& radii,
            double margin,
            const PeriodicCell<D>& cell);

  // Shows all near pairs of which one of the bodies [begin, end) is the first, body after body,
  // each body's sorted by the second. `pairs` is a buffer: several threads, each with its own, may
  // look at the same time.
  void visit_near_pairs(int begin,
                        int end,
                        std::vector<IndexPair>& pairs,
                        const std::function<void(std::span<const IndexPair>)>& visit) const;

 private:
  PointView<D> centres_{};
  RadiusView radii_;
  double margin_ = 0.0;  // m
  PeriodicCell<D> cell_;
  Grid<D> grid_;
  std::vector<int> cell_of_body_;
  std::vector<int> first_in_cell_;  // and one past the last cell's
  std::vector<int> bodies_by_cell_;
};

// All near pairs as one list, sorted by first and then second.
template <int D>
void find_near_pairs(std::span<const Vec<D>> centres,
                     std::span<const double> radii,
                     double margin,
                     CellList<D>& cells,
                     std::vector<IndexPair>& pairs,
                     const PeriodicCell<D>& cell = {});

}  // namespace graintruth::sim
