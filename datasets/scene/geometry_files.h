// Shapes that other programs wrote: triangle meshes (STL) and lists of spheres (x y z r).
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace graintruth::datasets {

// Three corners a facet, in the file's own unit times `unit` (m). ASCII or binary STL; facets
// without area are left out. Throws InputError where the file is neither, breaks off, or holds no
// facet.
std::vector<Eigen::Vector3d> read_stl(const std::filesystem::path& file, double unit);

struct ListedSphere {
  Eigen::Vector3d centre;
  double radius;
};

// One sphere a line, `x y z r` apart by blanks or commas, in the unit (m) given; lines that start
// with # or are empty are skipped. Throws InputError with file and line for anything else.
std::vector<ListedSphere> read_sphere_list(const std::filesystem::path& file, double unit);

}  // namespace graintruth::datasets
