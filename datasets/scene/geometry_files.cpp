#include "datasets/scene/geometry_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <set>
#include <span>
#include <sstream>
#include <string>
#include <string_view>

#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"
#include "datasets/store/text_file.h"

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

std::optional<double> number_of(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  // A number that is too small for a double is no place of its own.
  if (error == std::errc::result_out_of_range && word.find("e-") != std::string_view::npos)
    return 0.0;
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

// A line in small letters, taken apart at blanks.
std::vector<std::string_view> words_of(std::string& line) {
  std::vector<std::string_view> words;
  std::size_t begin = std::string::npos;
  for (std::size_t i = 0; i <= line.size(); ++i) {
    const bool is_blank = i == line.size() || line[i] == ' ' || line[i] == '\t';
    if (!is_blank && line[i] >= 'A' && line[i] <= 'Z') line[i] = static_cast<char>(line[i] + 32);
    if (!is_blank && begin == std::string::npos) begin = i;
    if (!is_blank || begin == std::string::npos) continue;
    words.push_back(std::string_view(line).substr(begin, i - begin));
    begin = std::string::npos;
  }
  return words;
}

// solid NAME, then facets: facet normal x y z, outer loop, three times vertex x y z, endloop,
// endfacet; endsolid. Normals are not read: both sides of a facet are solid.
class StlText {
 public:
  StlText(const std::filesystem::path& file, const std::string& text) : file_(file) {
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) {
      ++number_;
      std::vector<std::string_view> words = words_of(line);
      if (words.empty() || words[0].starts_with('#') || words[0].starts_with(';') ||
          words[0].starts_with("//"))
        continue;
      take(words);
    }
    if (is_in_facet_) complain("the file breaks off inside a facet");
    if (is_in_solid_) complain("the file breaks off: 'endsolid' is missing behind the last facet");
  }

  std::vector<Eigen::Vector3d> corners() && { return std::move(corners_); }

 private:
  [[noreturn]] void complain(std::string_view complaint) const {
    throw InputError(fmt::format("{}:{}: {}.", file_.string(), number_, complaint));
  }

  // Statements of a line; most files have one a line, some have more.
  void take(std::span<const std::string_view> words) {
    while (!words.empty()) {
      const std::string_view word = words[0];
      std::size_t taken = 1;
      if (word == "solid" || word == "endsolid") {
        if (is_in_facet_) complain(fmt::format("'{}' stands inside a facet", word));
        is_in_solid_ = word == "solid";
        return;  // its name may be anything
      }
      if (word == "facet") {
        if (is_in_facet_) complain("a facet begins before the one above it ends");
        is_in_facet_ = true;
        taken =
            words.size() > 1 && words[1] == "normal" ? std::min<std::size_t>(5, words.size()) : 1;
      } else if (word == "vertex") {
        corners_.push_back(corner(words));
        taken = 4;
      } else if (word == "endfacet") {
        const std::size_t held = corners_.size() - corners_at_end_;
        if (!is_in_facet_ || held != 3)
          complain(fmt::format("facet {} ends with {} corners, but every facet has three",
                               corners_at_end_ / 3 + 1,
                               held));
        corners_at_end_ = corners_.size();
        is_in_facet_ = false;
      } else if (word != "outer" && word != "loop" && word != "endloop") {
        complain(
            fmt::format("'{}' is no word of an STL file; facet, outer loop, vertex, endloop, "
                        "endfacet or endsolid is needed",
                        word.substr(0, 40)));
      }
      words = words.subspan(taken);
    }
  }

  Eigen::Vector3d corner(std::span<const std::string_view> words) const {
    if (!is_in_facet_) complain("a vertex stands outside of a facet");
    Eigen::Vector3d read;
    for (Eigen::Index i = 0; i < 3; ++i) {
      const auto at = static_cast<std::size_t>(i) + 1;
      const auto value = at < words.size() ? number_of(words[at]) : std::nullopt;
      if (!value) {
        complain(fmt::format("'vertex' of facet {} needs three numbers, with decimal points",
                             corners_at_end_ / 3 + 1));
      }
      read[i] = *value;
    }
    return read;
  }

  const std::filesystem::path& file_;
  int number_ = 0;  // of the line
  bool is_in_solid_ = false, is_in_facet_ = false;
  std::vector<Eigen::Vector3d> corners_;
  std::size_t corners_at_end_ = 0;  // of the last facet
};

// Text begins with 'solid', whatever its encoding, capitals and blanks; so do some binary files, of
// which the rest is no text.
bool is_stl_text(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\n");
  if (begin == std::string::npos) return false;
  std::string word = text.substr(begin, 5);
  words_of(word);
  return word == "solid" || word.starts_with('#') || word.starts_with("//") ||
         word.starts_with(';');
}

// The corners of all facets in the file's unit; `extra` is how many bytes stand behind the last.
std::vector<Eigen::Vector3d> read_corners(const std::filesystem::path& file,
                                          const std::string& content,
                                          std::size_t& extra) {
  const std::size_t size = content.size();
  const std::size_t declared = size >= header_size ? declared_facets(content) : 0;
  const std::size_t held = size >= header_size ? (size - header_size) / facet_size : 0;
  // 1. Binary of the very size that it tells, even if it begins with 'solid'
  if (size >= header_size && size == header_size + declared * facet_size)
    return read_binary(content);
  // 2. Text; binary files hold zero bytes, and no text does
  try {
    const std::string text = decode_text(file, content, "export the mesh as STL").text;
    if (is_stl_text(text)) return StlText(file, text).corners();
  } catch (const InputError&) {
    const bool has_zeros = content.find('\0') != std::string::npos;
    if (known_format(content) || !has_zeros || size < header_size) throw;
  }
  if (size < header_size || content.find('\0') == std::string::npos)
    fail(file, "is no STL file: neither text that begins with 'solid' nor binary facets");
  // 3. Binary of another size
  const std::size_t end = std::min(size, header_size + declared * facet_size);
  extra = size - end;
  if (held < declared ||
      (extra >= facet_size && content.find_first_not_of('\0', end) != std::string::npos)) {
    fail(file,
         fmt::format("says that it has {} facets, but its size is that of {}: it broke off, or is "
                     "no STL file",
                     declared,
                     held));
  }
  return read_binary(content);
}

// The corners of a facet, in an order that does not depend on the way round.
using Corner = std::array<double, 3>;
std::array<Corner, 3> sorted_corners(const Eigen::Vector3d* corners) {
  std::array<Corner, 3> sorted;
  // + 0.0 makes -0 and 0 one number.
  for (std::size_t i = 0; i < 3; ++i)
    sorted[i] = {corners[i].x() + 0.0, corners[i].y() + 0.0, corners[i].z() + 0.0};
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

}  // namespace

Mesh read_stl(const std::filesystem::path& file, double unit) {
  std::size_t extra = 0;
  const std::vector<Eigen::Vector3d> read = read_corners(file, read_whole(file), extra);
  Mesh mesh;
  std::set<std::array<Corner, 3>> known;
  std::size_t flat = 0, again = 0;
  for (std::size_t i = 0; i + 2 < read.size(); i += 3) {
    for (std::size_t c = i; c < i + 3; ++c) {
      if (!((unit * read[c]).cwiseAbs().maxCoeff() <= largest_coordinate) || read[c].hasNaN()) {
        fail(file,
             fmt::format("facet {} has a corner that is no place in a laboratory: ({}, {}, {})",
                         i / 3 + 1,
                         read[c].x(),
                         read[c].y(),
                         read[c].z()));
      }
    }
    const Eigen::Vector3d first = read[i + 1] - read[i], second = read[i + 2] - read[i];
    const double side = std::max(first.squaredNorm(), second.squaredNorm());
    if (!(first.cross(second).norm() > 1e-9 * side)) {
      ++flat;
    } else if (!known.insert(sorted_corners(&read[i])).second) {
      ++again;
    } else {
      for (std::size_t c = i; c < i + 3; ++c) mesh.corners.push_back(unit * read[c]);
    }
  }
  if (mesh.corners.empty()) fail(file, "holds no facet with an area");
  std::vector<std::string> left_out;
  if (flat > 0) left_out.push_back(fmt::format("{} facets without area", flat));
  if (again > 0)
    left_out.push_back(fmt::format("{} facets with the same corners as an earlier one", again));
  if (extra > 0) left_out.push_back(fmt::format("{} bytes behind the last facet", extra));
  if (!left_out.empty()) {
    mesh.note = fmt::format("{}: left out {}; {} facets remain.",
                            file.string(),
                            fmt::join(left_out, " and "),
                            mesh.corners.size() / 3);
  }
  return mesh;
}

std::vector<ListedSphere> read_sphere_list(const std::filesystem::path& file, double unit) {
  std::istringstream stream(read_text(file, "write lines of 'x y z r'").text);
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
