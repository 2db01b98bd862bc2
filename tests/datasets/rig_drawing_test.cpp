// The drawing of a rig as data: exact for other dimensions than those it was made of.
#include "datasets/rigs/rig_drawing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::datasets {
namespace {

// Where a corner is, by its terms.
Eigen::Vector2d place_of(const RigDrawing& drawing,
                         const std::map<std::string, double>& values,
                         std::size_t corner) {
  const auto sum = [&](const std::vector<DrawnTerm>& terms) {
    double total = 0.0;
    for (const DrawnTerm& term : terms) {
      double product = term.factor;
      for (const int i : {term.first, term.second}) {
        if (i < 0) continue;
        const DrawnDimension& dimension = drawing.dimensions[static_cast<std::size_t>(i)];
        const double value = values.at(dimension.stem);
        product *= dimension.form == "cot" ? 1.0 / std::tan(value) : value;
      }
      total += product;
    }
    return total;
  };
  return {sum(drawing.corners[corner].x), sum(drawing.corners[corner].z)};
}

const RigDrawing::Line& line_named(const RigDrawing& drawing, const std::string& name) {
  for (const RigDrawing::Line& line : drawing.lines)
    if (line.name == name) return line;
  throw std::logic_error(name);
}

RigDrawing draw(const std::string& rig, const std::vector<std::string>& settings = {}) {
  const TomlFile file = TomlFile::of_text("[rig]\n" + rig, "rig.toml");
  return draw_rig(file.root().section("rig"), settings, {});
}

constexpr const char* hopper =
    "kind = \"hopper_column_piston\"\nfront_back_gap_mm = 46\ncolumn_width_mm = 135\n"
    "column_depth_mm = 280\nslope_angle_deg = 60\nslope_height_mm = 300\n"
    "piston_speed_mm_per_s = 46\npiston_start_z_mm = 0\ngravity_m_per_s2 = 9.81\n";

void expect_at(const Eigen::Vector2d& found, double x, double z) {
  EXPECT_NEAR(found.x(), x, 1e-9);
  EXPECT_NEAR(found.y(), z, 1e-9);
}

TEST(RigDrawing, OfAHopperFollowsItsDimensions) {
  const RigDrawing drawing = draw(hopper);
  EXPECT_EQ(drawing.dimensions.size(), 5U);
  constexpr double angle = 40.0 * std::numbers::pi / 180.0;
  const std::map<std::string, double> values = {{"column_width", 0.2},
                                                {"column_depth", 0.1},
                                                {"slope_angle", angle},
                                                {"slope_height", 0.5},
                                                {"piston_start_z", -0.01}};
  const RigDrawing::Line& slope = line_named(drawing, "slope_right");
  expect_at(place_of(drawing, values, slope.from), 0.1, 0.0);
  expect_at(place_of(drawing, values, slope.to), 0.1 + 0.5 / std::tan(angle), 0.5);
  const RigDrawing::Line& column = line_named(drawing, "column_left");
  expect_at(place_of(drawing, values, column.from), -0.1, -0.1);
  const RigDrawing::Line& piston = line_named(drawing, "piston");
  expect_at(place_of(drawing, values, piston.from), -0.1, -0.01);
  EXPECT_EQ(
      drawing.optional_keys,
      std::vector<std::string>({"gravity_m_per_s2", "piston_speed_mm_per_s", "piston_start_z_mm"}));
}

TEST(RigDrawing, OfABinTakesTheOrificeOfItsReplicates) {
  const std::string bin =
      "kind = \"flat_bin_orifice\"\nfront_back_gap_mm = 3\nbin_width_cm = 15\nbin_height_mm = "
      "210\n";
  const RigDrawing drawing = draw(bin, {"held_out = true\norifice_width_mm = 75\n"});
  ASSERT_EQ(drawing.dimensions.size(), 3U);
  for (const DrawnDimension& dimension : drawing.dimensions)
    EXPECT_EQ(dimension.is_setting, dimension.stem == "orifice_width");
  const std::map<std::string, double> values = {
      {"bin_width", 0.2}, {"bin_height", 0.3}, {"orifice_width", 0.05}};
  const RigDrawing::Line& floor = line_named(drawing, "floor_right");
  expect_at(place_of(drawing, values, floor.from), 0.025, 0.0);
  expect_at(place_of(drawing, values, floor.to), 0.1, 0.0);
}

TEST(RigDrawing, OfWallsHasEveryEndByItself) {
  const RigDrawing drawing = draw(
      "kind = \"walls\"\nfront_back_gap_mm = 16\n"
      "wall = [{name = \"a\", from_x_mm = -30, from_z_mm = -150, to_x_mm = -30, to_z_mm = 100},"
      " {from_x_mm = 30, from_z_mm = 0, to_x_mm = 100, to_z_mm = 100}]\n");
  EXPECT_EQ(drawing.dimensions.size(), 8U);
  EXPECT_TRUE(drawing.dimensions[0].path[1].key.empty());
  EXPECT_EQ(drawing.dimensions[0].path[1].number, 0U);
  EXPECT_EQ(drawing.lines.size(), 2U);
}

// A scene has no dimensions of its own: it is drawn as it is, a drum as a circle.
TEST(RigDrawing, OfASceneShowsItsWalls) {
  const tests::TemporaryFolder folder;
  const std::filesystem::path bundled =
      std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "datasets/scenes/rotating_disk.toml";
  folder.write("drum.toml",
               read_whole(bundled) +
                   "\n[[wall]]\nname = \"drum\"\nmaterial = \"steel\"\nshape = \"cylinder\"\n"
                   "from_mm = [20, -50, 100]\nto_mm = [20, 50, 100]\nradius_mm = 80\n");
  const TomlFile file =
      TomlFile::of_text("[rig]\nkind = \"scene\"\nscene = \"drum.toml\"\n", "rig.toml");
  const RigDrawing drawing = draw_rig(file.root().section("rig"), {}, {.folder = folder.path()});
  EXPECT_TRUE(drawing.dimensions.empty());
  ASSERT_EQ(drawing.circles.size(), 1U);
  expect_at(place_of(drawing, {}, drawing.circles[0].centre), 0.02, 0.1);
  expect_at(place_of(drawing, {}, drawing.circles[0].rim), 0.1, 0.1);
}

TEST(RigDrawing, OfARigThatIsWrongIsRefused) {
  EXPECT_THROW(draw("kind = \"flat_bin_orifice\"\nfront_back_gap_mm = 3\n"), InputError);
}

}  // namespace
}  // namespace graintruth::datasets
