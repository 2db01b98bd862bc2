#include "datasets/scene/geometry_files.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>
#include <string_view>

#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"

namespace graintruth::datasets {

namespace {

// Coordinates beyond this (m) are no laboratory's.
constexpr double largest_coordinate = 1e6;

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& complaint) {
  throw InputError(fmt::format("{}: {}.", file.string(), complaint));
}

// Binary STL: 80 bytes of header, the number of facets, then 50 bytes a facet: normal and three
// corners as floats, two bytes of attributes; little-endian.
constexpr std::size_t header_size = 84, facet_size = 50;

std::size_t declared_facets(std::string_view content) {
  std::uint32_t count = 0;
  std::memcpy(&count, content.data() + 80, sizeof count);
  return count;
}

std::vector<Eigen::Vector3d> read_binary(std::string_view content) {
  std::vector<Eigen::Vector3d> corners;
  for (std::size_t facet = 0; facet < declared_facets(content); ++facet) {
    const char* numbers = content.data() + header_size + facet * facet_size + 3 * sizeof(float);
    for (int corner = 0; corner < 3; ++corner) {
      float xyz[3];
      std::memcpy(xyz, numbers + corner * sizeof xyz, sizeof xyz);
      corners.emplace_back(xyz[0], xyz[1], xyz[2]);
    }
  }
  return corners;
}

std::vector<Eigen::Vector3d> read_text(const std::filesystem::path& file,
                                       const std::string& content) {
  std::vector<Eigen::Vector3d> corners;
  std::istringstream stream(content);
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    std::istringstream words(line);
    std::string word;
    if (!(words >> word) || word != "vertex") continue;
    Eigen::Vector3d corner;
    if (!(words >> corner.x() >> corner.y() >> corner.z())) {
      throw InputError(fmt::format("{}:{}: 'vertex' needs three numbers.", file.string(), number));
    }
    corners.push_back(corner);
  }
  if (corners.size() % 3 != 0) fail(file, "breaks off inside a facet");
  return corners;
}

}  // namespace

std::vector<Eigen::Vector3d> read_stl(const std::filesystem::path& file, double unit) {
  const std::string content = read_whole(file);
  const bool is_binary = content.size() >= header_size &&
                         content.size() == header_size + facet_size * declared_facets(content);
  if (!is_binary && !content.starts_with("solid")) {
    fail(file, "is no STL file: neither text that begins with 'solid' nor whole binary facets");
  }
  const std::vector<Eigen::Vector3d> read =
      is_binary ? read_binary(content) : read_text(file, content);
  std::vector<Eigen::Vector3d> corners;
  for (std::size_t i = 0; i + 2 < read.size(); i += 3) {
    for (std::size_t c = i; c < i + 3; ++c) {
      if (!((unit * read[c]).cwiseAbs().maxCoeff() <= largest_coordinate)) {
        fail(file,
             fmt::format("facet {} has a corner that is no place in a laboratory", i / 3 + 1));
      }
    }
    const Eigen::Vector3d first = read[i + 1] - read[i], second = read[i + 2] - read[i];
    const double side = std::max(first.squaredNorm(), second.squaredNorm());
    if (!(first.cross(second).norm() > 1e-9 * side)) continue;
    for (std::size_t c = i; c < i + 3; ++c) corners.push_back(unit * read[c]);
  }
  if (corners.empty()) fail(file, "holds no facet");
  return corners;
}

std::vector<ListedSphere> read_sphere_list(const std::filesystem::path& file, double unit) {
  std::istringstream stream(read_whole(file));
  std::vector<ListedSphere> spheres;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (line.empty() || line.front() == '#') continue;
    for (char& letter : line) letter = letter == ',' ? ' ' : letter;
    std::istringstream words(line);
    ListedSphere sphere;
    std::string rest;
    const bool is_read = static_cast<bool>(words >> sphere.centre.x() >> sphere.centre.y() >>
                                           sphere.centre.z() >> sphere.radius);
    if (!is_read && line.find_first_not_of(" \t\r") == std::string::npos) continue;
    if (!is_read || words >> rest || !(sphere.radius > 0.0) ||
        !((unit * sphere.centre).cwiseAbs().maxCoeff() <= largest_coordinate)) {
      throw InputError(fmt::format(
          "{}:{}: a line must be 'x y z r', four numbers with r above 0.", file.string(), number));
    }
    sphere.centre *= unit;
    sphere.radius *= unit;
    spheres.push_back(sphere);
  }
  if (spheres.empty()) fail(file, "holds no sphere; a line is 'x y z r'");
  return spheres;
}

}  // namespace graintruth::datasets
