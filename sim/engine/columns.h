// Columns of numbers and vectors, one array per component, so that loops can run along several rows
// at a time. `Numbers` is std::vector<double>, an array of fixed length, or a pointer to the first
// of somebody else's numbers (`Rows`): loops run along pointers best.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "sim/laws/motion.h"

namespace graintruth::sim {

template <class Numbers>
struct ScalarColumn {
  Numbers value;
  double at(int k) const { return value[k]; }
  void set(int k, double v) { value[k] = v; }
  void push_back(double v) { value.push_back(v); }
};

template <int D, class Numbers>
struct VectorColumn;

template <class Numbers>
struct VectorColumn<2, Numbers> {
  Numbers x, z;
  PlanarVector at(int k) const { return {x[k], z[k]}; }
  void set(int k, PlanarVector v) {
    x[k] = v.x;
    z[k] = v.z;
  }
  void push_back(PlanarVector v) {
    x.push_back(v.x);
    z.push_back(v.z);
  }
};

template <class Numbers>
struct VectorColumn<3, Numbers> {
  Numbers x, y, z;
  SpatialVector at(int k) const { return {x[k], y[k], z[k]}; }
  void set(int k, SpatialVector v) {
    x[k] = v.x;
    y[k] = v.y;
    z[k] = v.z;
  }
  void push_back(SpatialVector v) {
    x.push_back(v.x);
    y.push_back(v.y);
    z.push_back(v.z);
  }
};

// Tangential springs and spins: a number in the plane, a vector in space.
template <int D, class Numbers>
struct TangentColumnOf {
  using type = VectorColumn<3, Numbers>;
};
template <class Numbers>
struct TangentColumnOf<2, Numbers> {
  using type = ScalarColumn<Numbers>;
};
template <int D, class Numbers>
using TangentColumn = typename TangentColumnOf<D, Numbers>::type;

// The rows from `first` on.
using Rows = double*;

template <class Numbers>
ScalarColumn<Rows> rows(ScalarColumn<Numbers>& column, int first = 0) {
  return {column.value.data() + first};
}
template <class Numbers>
VectorColumn<2, Rows> rows(VectorColumn<2, Numbers>& column, int first = 0) {
  return {column.x.data() + first, column.z.data() + first};
}
template <class Numbers>
VectorColumn<3, Rows> rows(VectorColumn<3, Numbers>& column, int first = 0) {
  return {column.x.data() + first, column.y.data() + first, column.z.data() + first};
}

// Unit quaternions.
template <class Numbers>
struct RotationColumn {
  Numbers w, x, y, z;
  Rotation at(int k) const { return {w[k], x[k], y[k], z[k]}; }
  void set(int k, Rotation r) {
    w[k] = r.w;
    x[k] = r.x;
    y[k] = r.y;
    z[k] = r.z;
  }
  void push_back(Rotation r) {
    w.push_back(r.w);
    x.push_back(r.x);
    y.push_back(r.y);
    z.push_back(r.z);
  }
};
template <class Numbers>
RotationColumn<Rows> rows(RotationColumn<Numbers>& column, int first = 0) {
  return {column.w.data() + first,
          column.x.data() + first,
          column.y.data() + first,
          column.z.data() + first};
}

}  // namespace graintruth::sim
