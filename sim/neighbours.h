// Which bodies are near each other: a cell list over bounding spheres, linear in the number of
// bodies.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "sim/motion.h"

namespace graintruth::sim {

struct IndexPair {
  int first, second;  // first < second
  bool operator==(const IndexPair&) const = default;
};

// Buffers that live from one search to the next.
struct CellList {
  std::vector<int> cell_of_body;
  std::vector<int> first_in_cell;
  std::vector<int> bodies_by_cell;
  std::vector<IndexPair> pairs_of_body;
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

// Shows all pairs whose bounding spheres are less than `margin` (m) apart, body after body: those
// of which it is the first, sorted by the second.
template <int D>
void visit_near_pairs(const PointView<D>& centres,
                      const RadiusView& radii,
                      double margin,
                      CellList& cells,
                      const std::function<void(std::span<const IndexPair>)>& visit);

// The same as one list, sorted by first and then second.
template <int D>
void find_near_pairs(std::span<const Vec<D>> centres,
                     std::span<const double> radii,
                     double margin,
                     CellList& cells,
                     std::vector<IndexPair>& pairs);

}  // namespace graintruth::sim
