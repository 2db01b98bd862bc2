// Shapes that other programs wrote: triangle meshes (STL) and lists of spheres (x y z r).
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace graintruth::datasets {

struct Mesh {
  std::vector<Eigen::Vector3d> corners;  // three a facet, m
  std::string note;                      // a sentence on facets that were left out; or empty
};

// STL, as text or binary; the file's own unit is `unit` (m). All solids of the file are one mesh.
// Text may have capitals, blanks, empty lines and lines that begin with #, ; or //; bytes behind
// the last facet of a binary file are no facet. Facets without area are left out, and so are those
// with the same three corners as an earlier one, whichever way round: one surface is one contact.
// Throws InputError where the file is neither, breaks off, holds another number of facets than it
// says, a corner that is no place in a laboratory, or no facet.
Mesh read_stl(const std::filesystem::path& file, double unit);

struct ListedSphere {
  Eigen::Vector3d centre;
  double radius;
};

// One sphere a line, `x y z r` apart by blanks, tabs or commas, in the unit (m) given; lines that
// start with # or are empty are skipped. Throws InputError with file and line for anything else.
std::vector<ListedSphere> read_sphere_list(const std::filesystem::path& file, double unit);

}  // namespace graintruth::datasets
