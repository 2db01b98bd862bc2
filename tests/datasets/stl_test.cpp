// Meshes as other programs write them: what is one floor must be read as one floor, and what cannot
// be read must be told with its line or its facet.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <vector>

#include "datasets/scene/geometry_files.h"
#include "datasets/scene/scene_file.h"
#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::datasets {
namespace {

using tests::TemporaryFolder;
using Facet = std::array<std::array<float, 3>, 3>;

const std::vector<Facet> floor_facets = {{{{-60, -60, 0}, {60, -60, 0}, {60, 60, 0}}},
                                         {{{-60, -60, 0}, {60, 60, 0}, {-60, 60, 0}}}};

std::string text_of(const std::vector<Facet>& facets) {
  std::string text = "solid floor\n";
  for (const Facet& facet : facets) {
    text += " facet normal 0 0 1\n  outer loop\n";
    for (const auto& c : facet) text += fmt::format("   vertex {} {} {}\n", c[0], c[1], c[2]);
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid floor\n";
}

std::string binary_of(const std::vector<Facet>& facets,
                      std::uint32_t count,
                      const std::string& title = "made by a program") {
  std::string bytes = title;
  bytes.resize(80, '\0');
  bytes.append(reinterpret_cast<const char*>(&count), 4);
  for (const Facet& facet : facets) {
    const float normal[3] = {0, 0, 1};
    bytes.append(reinterpret_cast<const char*>(normal), sizeof normal);
    bytes.append(reinterpret_cast<const char*>(facet.data()), sizeof facet);
    bytes.append(2, '\0');
  }
  return bytes;
}

std::string replaced(std::string text, const std::string& old, const std::string& by) {
  for (std::size_t at = text.find(old); at != std::string::npos;
       at = text.find(old, at + by.size()))
    text.replace(at, old.size(), by);
  return text;
}

std::string in_capitals(std::string text) {
  for (char& letter : text) letter = static_cast<char>(std::toupper(letter));
  return text;
}

std::string in_utf_16(const std::string& text) {
  std::string wide = "\xff\xfe";
  for (const char letter : text) (wide += letter) += '\0';
  return wide;
}

TEST(Stl, IsOneFloorInEveryForm) {
  const TemporaryFolder folder;
  const std::string text = text_of(floor_facets), binary = binary_of(floor_facets, 2);
  const std::string files[] = {
      text,
      in_capitals(text),
      "\n\n  " + text,
      "\xef\xbb\xbf" + text,
      "\xef\xbb\xbf\r\n" + replaced(text, "\n", "\r\n"),
      replaced(text, "\n", "\r"),
      replaced(text, "\n", "\n\n"),
      replaced(text, "\n  ", " "),  // several words of STL on a line
      replaced(text, "vertex", "\tVertex\t"),
      replaced(text, " 60 ", " +6.0E+01 "),
      replaced(text, "0 0 1", "nan nan nan"),  // normals are not read
      replaced(text, " normal 0 0 1", ""),
      replaced(text, "solid floor", "solid"),
      "# a comment\n" + replaced(text, " outer", "; another\n// a third\n outer"),
      text_of({floor_facets[0]}) + "\n" + text_of({floor_facets[1]}),  // two solids
      text + std::string(40, '\0'),
      in_utf_16(text),
      binary,
      binary_of(floor_facets, 2, "solid floor, in binary"),
      binary_of(floor_facets, 2, "SOLID")};
  const std::string files_with_more[] = {
      binary + "end",
      binary + std::string(700, '\0'),
      binary_of(floor_facets, 2, "solid floor, in binary") + "\n"};
  const auto expect_floor = [&](const std::string& content, bool is_said) {
    const Mesh mesh = read_stl(folder.write("floor.stl", content), 1e-3);
    ASSERT_EQ(mesh.corners.size(), 6U) << content;
    for (std::size_t i = 0; i < 6; ++i) {
      const auto& c = floor_facets[i / 3][i % 3];
      EXPECT_LT((mesh.corners[i] - 1e-3 * Eigen::Vector3d(c[0], c[1], c[2])).norm(), 1e-12);
    }
    EXPECT_EQ(mesh.note.find("bytes behind the last facet") != std::string::npos, is_said)
        << mesh.note;
  };
  for (const std::string& content : files) expect_floor(content, false);
  for (const std::string& content : files_with_more) expect_floor(content, true);
}

TEST(Stl, FacetsThatAreThereTwiceAreOneAndSaid) {
  const TemporaryFolder folder;
  const auto corners_of = [](Facet facet, std::array<int, 3> order) {
    return Facet{facet[static_cast<std::size_t>(order[0])],
                 facet[static_cast<std::size_t>(order[1])],
                 facet[static_cast<std::size_t>(order[2])]};
  };
  Facet signed_zero = floor_facets[1];
  for (auto& corner : signed_zero) corner[2] = -0.0F;
  for (const Facet& again : {floor_facets[0],
                             corners_of(floor_facets[0], {1, 2, 0}),
                             corners_of(floor_facets[0], {2, 1, 0}),  // the other way round
                             signed_zero}) {
    std::vector<Facet> facets = floor_facets;
    facets.push_back(again);
    for (const std::string& content : {text_of(facets), binary_of(facets, 3)}) {
      const Mesh mesh = read_stl(folder.write("dup.stl", content), 1e-3);
      EXPECT_EQ(mesh.corners.size(), 6U);
      EXPECT_EQ(
          mesh.note,
          (folder / "dup.stl").string() +
              ": left out 1 facets with the same corners as an earlier one; 2 facets remain.");
    }
  }
  // One corner elsewhere is another facet.
  std::vector<Facet> facets = floor_facets;
  facets.push_back(floor_facets[0]);
  facets.back()[0][2] = 1e-3F;
  EXPECT_EQ(read_stl(folder.write("near.stl", text_of(facets)), 1e-3).corners.size(), 9U);
}

TEST(Stl, FacetsWithoutAreaAreLeftOutAndSaid) {
  const TemporaryFolder folder;
  std::vector<Facet> facets = floor_facets;
  facets.push_back({{{0, 0, 0}, {0, 0, 0}, {1, 0, 0}}});
  facets.push_back({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}});
  facets.push_back(floor_facets[1]);
  const Mesh mesh = read_stl(folder.write("flat.stl", text_of(facets)), 1e-3);
  EXPECT_EQ(mesh.corners.size(), 6U);
  EXPECT_NE(mesh.note.find("2 facets without area and 1 facets with the same corners"),
            std::string::npos)
      << mesh.note;
}

TEST(Stl, WhatCannotBeReadIsRefusedWithItsPlace) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& content, const std::vector<std::string>& words) {
    std::string sentence = "nothing was refused";
    try {
      read_stl(folder.write("bad.stl", content), 1e-3);
    } catch (const InputError& error) {
      sentence = error.what();
    }
    for (const std::string& word : words)
      EXPECT_NE(sentence.find(word), std::string::npos) << word << " is not in: " << sentence;
    EXPECT_TRUE(sentence.ends_with('.')) << sentence;
  };
  const std::string text = text_of(floor_facets), binary = binary_of(floor_facets, 2);
  // Corners that are no place
  for (const char* word : {"nan", "inf", "-inf", "1e30"})
    refused(replaced(text, "vertex -60 60 0", std::string("vertex 1 2 ") + word),
            {"facet 2", "no place"});
  std::vector<Facet> facets = floor_facets;
  facets[1][2][0] = std::nanf("");
  refused(binary_of(facets, 2), {"facet 2", "no place"});
  facets[1][2][0] = INFINITY;
  refused(binary_of(facets, 2), {"facet 2", "no place"});
  // What breaks off, or is not what it says
  refused(text.substr(0, text.rfind(" vertex")), {"bad.stl:", "breaks off inside a facet"});
  refused(replaced(text, "endsolid floor\n", ""), {"'endsolid' is missing"});
  refused(binary.substr(0, 150), {"2 facets", "that of 1"});
  refused(binary_of(floor_facets, 5), {"5 facets", "that of 2"});
  refused(binary_of(floor_facets, 1), {"1 facets", "that of 2"});
  refused(binary_of(floor_facets, 0, "solid"), {"0 facets", "that of 2"});
  refused(binary_of({}, 0), {"holds no facet"});
  refused("", {"no STL file"});
  refused("an essay\n", {"no STL file"});
  refused(std::string(300, 'x'), {"no STL file"});
  refused("PK\x03\x04 3D/3dmodel.model", {"a zip archive", "unpack"});
  refused("solid a\nendsolid a\n", {"holds no facet"});
  // Statements
  refused(replaced(text, "vertex 60 -60 0", "vertex 60,5 -60 0"),
          {"bad.stl:5:", "facet 1", "decimal points"});
  refused(replaced(text, "vertex 60 -60 0", "vertex 60 -60"), {"bad.stl:5:", "three numbers"});
  refused(replaced(text, "   vertex -60 60 0\n", ""), {"bad.stl:14:", "facet 2", "2 corners"});
  refused(replaced(text, "vertex -60 60 0", "vertex -60 60 0\nvertex 0 0 0"),
          {"facet 2", "4 corners"});
  refused(replaced(text, " endfacet\n facet", " facet"), {"begins before"});
  refused(replaced(text, "outer loop", "outer lop"), {"bad.stl:3:", "'lop'"});
  refused("solid\nvertex 1 2 3\n", {"bad.stl:2:", "outside of a facet"});
}

TEST(Stl, ASceneSaysWhatWasLeftOut) {
  const TemporaryFolder folder;
  std::vector<Facet> facets = floor_facets;
  facets.insert(facets.end(), floor_facets.begin(), floor_facets.end());
  folder.write("floor.stl", text_of(facets));
  const auto file = folder.write("scene.toml", R"(title = "Ball on a floor"
dimensions = 3
[[material]]
name = "pea"
elastic_modulus_mpa = 20
poisson_ratio = 0.3
[[surfaces]]
first = "pea"
second = "pea"
friction = 0.3
restitution = 0.5
[[particle]]
name = "ball"
material = "pea"
radius_mm = 5
density_g_per_cm3 = 1.1
[[wall]]
name = "floor"
material = "pea"
shape = "mesh"
file = "floor.stl"
file_unit = "mm"
[[place]]
particle = "ball"
x_mm = 10
y_mm = -20
z_mm = 25
[run]
duration_s = 0.6
output_interval_s = 0.005
)");
  const SceneFile scene = load_scene(file);
  ASSERT_EQ(scene.walls.size(), 1U);
  EXPECT_EQ(scene.walls[0].points.size(), 6U);
  ASSERT_EQ(scene.warnings.size(), 1U);
  EXPECT_NE(scene.warnings[0].find("2 facets with the same corners"), std::string::npos);
}

TEST(SphereList, IsReadInEveryEncoding) {
  const TemporaryFolder folder;
  const std::string list = "# x y z r\n0 0 0 5\n1\t2\t3\t4\n";
  for (const std::string& content : {list,
                                     "\xef\xbb\xbf" + list,
                                     replaced(list, "\n", "\r"),
                                     replaced(list, "\n", "\r\n"),
                                     in_utf_16(list)}) {
    const auto spheres = read_sphere_list(folder.write("clump.txt", content), 1e-3);
    ASSERT_EQ(spheres.size(), 2U) << content;
    EXPECT_DOUBLE_EQ(spheres[1].radius, 4e-3);
  }
}

}  // namespace
}  // namespace graintruth::datasets
