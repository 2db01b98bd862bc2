// Scene files, decks and the geometry files that they name: what is read, and what is refused how.
#include "datasets/scene/scene_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>

#include "datasets/scene/geometry_files.h"
#include "datasets/store/input_error.h"
#include "tests/support/read_rows.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::datasets {
namespace {

using tests::TemporaryFolder;

const std::filesystem::path source = GRAINTRUTH_SOURCE_DIR;

std::string content_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

std::string with(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

// The sentence with which a scene is refused; empty when it is read.
std::string refusal(const std::filesystem::path& file) {
  try {
    load_scene(file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(SceneFile, AllBundledScenesAreRead) {
  int read = 0;
  for (const auto& entry : std::filesystem::directory_iterator(source / "datasets/scenes")) {
    if (entry.path().extension() != ".toml") continue;
    const SceneFile scene = load_scene(entry.path());
    EXPECT_FALSE(scene.title.empty()) << entry.path();
    EXPECT_FALSE(scene.walls.empty()) << entry.path();
    ++read;
  }
  EXPECT_EQ(read, 9);
}

TEST(SceneFile, ConvertsToSiAtTheDoor) {
  const SceneFile scene = load_scene(source / "datasets/scenes/rotating_disk.toml");
  EXPECT_FALSE(scene.is_planar);
  EXPECT_DOUBLE_EQ(scene.materials[0].elastic_modulus, 50e6);
  EXPECT_DOUBLE_EQ(*scene.particles[0].density, 1200.0);
  EXPECT_DOUBLE_EQ(scene.particles[0].spheres[0].radius, 0.012);
  EXPECT_NEAR(scene.walls[0].drag.angular_velocity.z(), 3.0 * 3.14159265358979, 1e-12);
  EXPECT_DOUBLE_EQ(scene.walls[0].points[0].z(), 0.1);
  // A box without its lid has five sides
  EXPECT_EQ(scene.walls.size(), 2u + 5u);
  EXPECT_EQ(scene.event_phase, 1);
}

struct BadScene {
  const char* from;
  const char* to;
  const char* said;
};

class SceneDoor : public testing::TestWithParam<BadScene> {};

TEST_P(SceneDoor, RefusesInOneSentenceWithFileLineAndKey) {
  const TemporaryFolder folder;
  const std::string good = content_of(source / "datasets/scenes/macro_bin.toml");
  const auto file = folder.write("scene.toml", with(good, GetParam().from, GetParam().to));
  const std::string sentence = refusal(file);
  EXPECT_NE(sentence.find("scene.toml:"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find(GetParam().said), std::string::npos) << sentence;
  EXPECT_EQ(sentence.find('\n'), std::string::npos) << sentence;
}

INSTANTIATE_TEST_SUITE_P(
    All,
    SceneDoor,
    testing::Values(
        BadScene{"dimensions = 2", "dimensions = 4", "'dimensions'"},
        BadScene{"dimensions = 2", "dimensions = tr", "not valid TOML"},
        BadScene{"title =", "titel =", "'title'"},
        BadScene{"poisson_ratio = 0.30", "poisson_ratio = 0.6", "'material.poisson_ratio' is 0.6"},
        BadScene{"elastic_modulus_mpa", "elastic_modulus_psi", "has no unit that fits"},
        BadScene{"first = \"button\"", "first = \"buton\"", "names 'buton'"},
        BadScene{"friction = 0.2\n", "friction = -0.2\n", "-0.2"},
        BadScene{"second = \"perspex\"", "second = \"button\"", "'button' on 'perspex'"},
        BadScene{"count = 200", "count = 2.5", "a whole number"},
        BadScene{"count = 200", "count = 100000000", "a whole number from 0 to"},
        BadScene{"chords = 8", "chords = 1", "from 2 to 200"},
        BadScene{"mass_g = 0.332", "mass_g = 0", "'particle.mass_g' is 0"},
        BadScene{"mass_g = 0.332\n", "", "'particle.density_kg_per_m3' is needed"},
        BadScene{"inertia_g_mm2 = [2.33, 6.28", "inertia_g_mm2 = [6.28", "a list of 3 numbers"},
        BadScene{"profile =",
                 "radius_mm = 5\nprofile =",
                 "'particle.profile' is one of 2 shapes; exactly one of"},
        BadScene{"profile = {", "#", "'particle.radius_m' is missing; exactly one of"},
        BadScene{"shape = \"segment\"", "shape = \"segmnt\"", "'segmnt'"},
        BadScene{"to_mm = [-75, 400]", "to_mm = [-75, -200]", "the same point"},
        BadScene{"name = \"right\"", "name = \"left\"", "a second wall called 'left'"},
        BadScene{"opens_s = 0.0", "opens_s = -1.0", "a time from 0"},
        BadScene{"method = \"lattice\"", "method = \"pour\"", "'lattice' or 'rain'"},
        BadScene{"method = \"lattice\"",
                 "method = \"lattice\"\njitter_mm = 100",
                 "'fill.jitter_mm' is 100 mm, but particles would touch"},
        BadScene{"method = \"lattice\"",
                 "method = \"rain\"\ninterval_s = 0.1\njitter_mm = 0",
                 "'fill.jitter_mm' is only known of a lattice"},
        BadScene{"high_mm = [75, 400]", "high_mm = [-75, 400]", "above and to the right"},
        BadScene{"[fill]", "[filling]", "'fill'"},
        BadScene{"duration_s = 1.5", "duration_s = inf", "a time above 0"},
        BadScene{"output_interval_s = 0.01", "output_interval_s = 1e-9", "100000 frames"},
        BadScene{"longest_s = 2.0", "longest_s = \"2.0\"", "holds text"},
        BadScene{"exit_height_mm = 0", "exit_hight_mm = 0", "did you mean 'exit_height_mm'"},
        BadScene{"title =", "title = [", "not valid TOML"}));

TEST(GeometryFiles, BinaryAndTextStlAreTheSame) {
  const TemporaryFolder folder;
  const auto text = folder.write("text.stl",
                                 "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"
                                 "vertex 2 0 0\nvertex 0 3 1\nendloop\nendfacet\n"
                                 "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 0 0\n"
                                 "vertex 0 3 1\nendloop\nendfacet\nendsolid one\n");
  std::string binary(80, ' ');
  const std::uint32_t count = 1;
  binary.append(reinterpret_cast<const char*>(&count), 4);
  const float numbers[12] = {0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3, 1};
  binary.append(reinterpret_cast<const char*>(numbers), sizeof numbers);
  binary.append(2, '\0');
  const auto from_text = read_stl(text, 1e-3).corners;
  const auto from_binary = read_stl(folder.write("binary.stl", binary), 1e-3).corners;
  ASSERT_EQ(from_text.size(), 3u);  // the facet without area is left out
  ASSERT_EQ(from_binary.size(), 3u);
  for (int i = 0; i < 3; ++i) EXPECT_LT((from_text[i] - from_binary[i]).norm(), 1e-15);
  EXPECT_DOUBLE_EQ(from_text[1].x(), 2e-3);
  EXPECT_THROW(read_stl(folder.write("cut.stl", binary.substr(0, 120)), 1.0), InputError);
  EXPECT_THROW(read_stl(folder.write("empty.stl", ""), 1.0), InputError);
  EXPECT_THROW(read_stl(folder.write("word.stl", "solid\nvertex 1 two 3\n"), 1.0), InputError);
}

TEST(GeometryFiles, SphereListIsXYZR) {
  const TemporaryFolder folder;
  const auto spheres =
      read_sphere_list(folder.write("clump.txt", "# x y z r\n0 0 0 5\n\n1,2,3,4\r\n"), 1e-3);
  ASSERT_EQ(spheres.size(), 2u);
  EXPECT_DOUBLE_EQ(spheres[1].centre.z(), 3e-3);
  EXPECT_DOUBLE_EQ(spheres[1].radius, 4e-3);
  for (const char* bad : {"1 2 3\n", "1 2 3 4 5\n", "1 2 3 0\n", "1 2 x 4\n", "# nothing\n"}) {
    EXPECT_THROW(read_sphere_list(folder.write("bad.txt", bad), 1.0), InputError) << bad;
  }
}

// A deck of our own in the language of the thesis.
constexpr const char* deck_text =
    "START 40.0 20.0 40.0 500 18 4 2 10\n"
    "FOUR PAIRS ON TWO BELTS\n"
    "BOT 20.0 10.0 1.0 18.0 10.0\n"
    "RAD 1.0 1\n"
    "RAD 1.5 2\n"
    "PRO 1.0 0.5\n"
    "DENS 2.0\n"
    "FRIC 0.0 0.1\n"
    "FRAC 1.0\n"
    "DAMP 0.0 0.5\n"
    "GRA 0.0 0.0 -9.81\n"
    "CYC 1000 1 10\n"
    "FRIC 0.3 0.4\n"
    "MOV 25.0 -20.0\n"
    "CYC 2000 10 10\n"
    "STOP\n";
constexpr const char* beside_text =
    "elastic_modulus_mpa = 100\npoisson_ratio = 0.3\nwalls = \"rigid\"\ndimensions = 3\n"
    "length_unit = \"cm\"\nspeed_unit = \"cm_per_s\"\ndensity_unit = \"g_per_cm3\"\n"
    "acceleration_unit = \"m_per_s2\"\nmoving = \"upper_lower\"\norifice = \"open\"\n";

TEST(Deck, IsReadWithItsUnitsAndPhases) {
  const TemporaryFolder folder;
  folder.write("deck.toml", beside_text);
  const SceneFile scene = load_scene(folder.write("deck.txt", deck_text));
  EXPECT_EQ(scene.title, "FOUR PAIRS ON TWO BELTS");
  ASSERT_EQ(scene.particles.size(), 1u);
  EXPECT_EQ(scene.particles[0].count, 4);
  EXPECT_DOUBLE_EQ(*scene.particles[0].density, 2000.0);
  ASSERT_EQ(scene.particles[0].spheres.size(), 2u);
  EXPECT_DOUBLE_EQ(scene.particles[0].spheres[0].centre.x(), -0.01);
  ASSERT_EQ(scene.phases.size(), 2u);
  EXPECT_EQ(scene.event_phase, 1);
  EXPECT_DOUBLE_EQ(*scene.phases[0].friction_with_walls, 0.1);
  EXPECT_DOUBLE_EQ(*scene.phases[1].friction_between_particles, 0.3);
  // Steps of R_min sqrt(rho/G)/(0.1631 nu + 0.8766), G = E/(2 (1 + nu))
  const double step = 0.01 * std::sqrt(2000.0 * 2.0 * 1.3 / 100e6) / (0.1631 * 0.3 + 0.8766);
  EXPECT_NEAR(scene.phases[1].duration, 2000 * step, 1e-12);
  EXPECT_NEAR(scene.phases[1].output_interval, 200 * step, 1e-12);
  // Floor and left strip run against each other; no panel in the orifice; a right strip is left
  std::vector<std::string> names;
  for (const SceneWall& wall : scene.walls) {
    names.push_back(wall.name);
    const double speed = wall.name == "floor" ? -0.2 : (wall.name == "left_strip" ? 0.25 : 0.0);
    EXPECT_DOUBLE_EQ(wall.drag.velocity.x(), speed) << wall.name;
  }
  EXPECT_EQ(names,
            (std::vector<std::string>{"left",
                                      "right",
                                      "front",
                                      "back",
                                      "floor",
                                      "left_strip",
                                      "right_strip",
                                      "front_strip",
                                      "back_strip"}));
}

// FAN turns the panel's surface about the middle of the orifice; FLO opens it after so many
// seconds.
TEST(Deck, FanTurnsAndFlowOpensThePanel) {
  const TemporaryFolder folder;
  folder.write("deck.toml",
               with(with(beside_text, "moving = \"upper_lower\"\n", "turning_unit = \"rpm\"\n"),
                    "\"open\"",
                    "\"closed\""));
  const SceneFile scene =
      load_scene(folder.write("deck.txt", with(deck_text, "MOV 25.0 -20.0", "FAN 30\nFLO 0.5")));
  EXPECT_EQ(scene.event_phase, 1);
  const SceneWall& panel = scene.walls.back();
  EXPECT_EQ(panel.name, "orifice_panel");
  EXPECT_DOUBLE_EQ(panel.opens_at, 0.5);
  EXPECT_NEAR(panel.drag.angular_velocity.z(), 3.14159265358979, 1e-12);
  EXPECT_LT((panel.drag.pivot - Eigen::Vector3d(0.25, 0.1, 0.1)).norm(), 1e-12);
}

// CON: slopes from the sides of the workspace to a column with a piston (micro-geometry, readings A
// and B).
TEST(Deck, HopperColumnAndPiston) {
  const TemporaryFolder folder;
  const std::string text =
      with(with(with(deck_text, "BOT 20.0 10.0 1.0 18.0 10.0", "CON 15.0 12.0 10.0 38.0 18.0"),
                "18 4 2 10",
                "16 4 2 8"),
           "MOV 25.0 -20.0",
           "MOV -4.55");
  const std::string beside =
      with(with(with(beside_text, "upper_lower", "piston"), "dimensions = 3", "dimensions = 2"),
           "orifice = \"open\"\n",
           "");
  for (const auto& [reading, top] :
       {std::pair{"A", 0.38}, std::pair{"B", 0.12 + 0.15 * 0.781286}}) {
    folder.write("deck.toml", beside + "con_reading = \"" + reading + "\"\n");
    const SceneFile scene = load_scene(folder.write("deck.txt", text));
    ASSERT_EQ(scene.walls.size(), 8u);
    EXPECT_EQ(scene.walls[2].name, "slope_left");
    EXPECT_NEAR(scene.walls[2].points[0].z(), top, 1e-6) << reading;
    EXPECT_NEAR(scene.walls[2].points[1].x(), 0.15, 1e-12);
    EXPECT_NEAR(scene.walls[7].motion.velocity.z(), -0.0455, 1e-12);
  }
}

// PRO has no signs: the side changes where the distances begin to grow (errata 26).
TEST(Deck, DistancesGetTheirSignsFromTheTurn) {
  const TemporaryFolder folder;
  folder.write("deck.toml", beside_text);
  for (const auto& [printed, first, last] : {std::tuple{"PRO 1.0 0.5", -0.01, -0.005},
                                             std::tuple{"PRO 0.5 1.0", -0.005, 0.01},
                                             std::tuple{"PRO 0.7 0.7", -0.007, 0.007}}) {
    const SceneFile scene =
        load_scene(folder.write("deck.txt", with(deck_text, "PRO 1.0 0.5", printed)));
    EXPECT_DOUBLE_EQ(scene.particles[0].spheres[0].centre.x(), first) << printed;
    EXPECT_DOUBLE_EQ(scene.particles[0].spheres[1].centre.x(), last) << printed;
  }
}

TEST(Deck, NamesAllThatTheFileBesideItLacks) {
  const TemporaryFolder folder;
  const auto file = folder.write("deck.txt", deck_text);
  for (const bool is_there : {false, true}) {
    if (is_there) folder.write("deck.toml", "poisson_ratio = 0.3\n");
    const std::string sentence = refusal(file);
    for (const char* key : {"deck.toml lacks",
                            "elastic_modulus",
                            "walls",
                            "dimensions",
                            "length_unit",
                            "speed_unit",
                            "moving",
                            "orifice"}) {
      EXPECT_NE(sentence.find(key), std::string::npos) << sentence;
    }
    EXPECT_EQ(sentence.find(" poisson_ratio") == std::string::npos, is_there) << sentence;
    EXPECT_EQ(sentence.find("turning_unit"), std::string::npos) << sentence;
  }
}

class DeckDoor : public testing::TestWithParam<BadScene> {};

TEST_P(DeckDoor, RefusesInOneSentenceWithFileAndLine) {
  const TemporaryFolder folder;
  folder.write("deck.toml", beside_text);
  const auto file = folder.write("deck.txt", with(deck_text, GetParam().from, GetParam().to));
  const std::string sentence = refusal(file);
  EXPECT_NE(sentence.find("deck.txt:"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find(GetParam().said), std::string::npos) << sentence;
}

INSTANTIATE_TEST_SUITE_P(All,
                         DeckDoor,
                         testing::Values(BadScene{"START", "BEGIN", "must begin with START"},
                                         BadScene{"18 4 2 10", "19 4 2 10", "make 18"},
                                         BadScene{"40.0 500", "4o.0 500", "'4o.0' is no number"},
                                         BadScene{"RAD 1.5 2", "RAD 1.5 3", "sphere 2 is next"},
                                         BadScene{"PRO 1.0 0.5", "PRO 1.0", "PRO 1"},
                                         BadScene{"DENS 2.0", "DENS -2.0", "above 0"},
                                         BadScene{"FRIC 0.0 0.1", "FRIC 0.0", "FRI has 1 numbers"},
                                         BadScene{"DAMP 0.0 0.5", "DAMP 0.0 1.5", "beta in [0, 1)"},
                                         BadScene{"GRA", "GRAV 1.0", "GRA has 4 numbers"},
                                         BadScene{"MOV 25.0", "MVE 25.0", "'MVE' is no command"},
                                         BadScene{
                                             "BOT 20.0", "BOT 35.0", "larger than the workspace"},
                                         BadScene{"CYC 1000 1 10", "CYC 0 1 10", "at least 1"}));

// The identity of deck_start.csv: the fifth number is particles times spheres plus walls.
TEST(Deck, AllSixOfTheThesisAreRead) {
  const std::filesystem::path decks = source / "../shared/thesis/decks";
  if (!std::filesystem::exists(decks)) GTEST_SKIP() << "the thesis is not beside the source folder";
  const TemporaryFolder folder;
  int read = 0;
  for (const auto& entry : std::filesystem::directory_iterator(decks)) {
    const std::string stem = entry.path().stem().string();
    if (!stem.starts_with("D_")) continue;
    folder.write(stem + ".toml", content_of(source / "datasets/scenes/decks" / (stem + ".toml")));
    const SceneFile scene = load_scene(folder.write(stem + ".txt", content_of(entry.path())));
    for (const auto& row : tests::read_rows(source / "datasets/thesis/deck_start.csv")) {
      if (row.at("deck") != stem.substr(0, 3)) continue;
      EXPECT_EQ(scene.particles[0].count, std::stoi(row.at("npar"))) << stem;
      EXPECT_EQ(scene.particles[0].spheres.size(), std::stoul(row.at("ntype"))) << stem;
    }
    for (const auto& row : tests::read_rows(source / "datasets/thesis/deck_spheres.csv")) {
      if (row.at("deck") != stem) continue;
      const SceneSphere& sphere = scene.particles[0].spheres[std::stoul(row.at("sphere")) - 1];
      EXPECT_NEAR(sphere.radius, 0.01 * tests::number(row, "radius_cm"), 1e-12);
      EXPECT_NEAR(
          sphere.centre.x(), 0.01 * tests::number(row, "axial_coordinate_cm_sign_inferred"), 1e-12)
          << stem;
    }
    ++read;
  }
  EXPECT_EQ(read, 6);
}

}  // namespace
}  // namespace graintruth::datasets
