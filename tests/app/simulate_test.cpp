// The verb simulate as a user meets it: what it leaves, how it stops, what it refuses.
#include <chrono>
#include <nlohmann/json.hpp>
#include <regex>
#include <thread>

#include "tests/app/bad_input.h"
#include "tests/app/documented_tables.h"
#include "tests/app/small_scene.h"
#include "tests/support/read_rows.h"

namespace graintruth::tests {
namespace {

using Json = nlohmann::json;

class Simulate : public BadInput {
 protected:
  // In the plane, without settling: a hundredth of a second of three falling balls.
  static std::string planar_scene() {
    std::string text = with(small_scene(), "dimensions = 3", "dimensions = 2");
    text =
        with(text,
             "shape = \"box\"\nlow_mm = [-35, -35, 0]\nhigh_mm = [35, 35, 200]\nopen = \"top\"\n",
             "shape = \"segment\"\nfrom_mm = [-35, 0]\nto_mm = [35, 0]\n");
    text = with(text,
                "low_mm = [-35, -35, 0]\nhigh_mm = [35, 35, 200]",
                "low_mm = [-35, 20]\nhigh_mm = [35, 200]");
    return with(with(text, "[settle]\nlongest_s = 2.0\nrestitution = 0.2\n", ""),
                "count = 27",
                "count = 3");
  }
  ProgramOutcome simulate(const std::string& text, std::vector<std::string> more = {}) {
    const auto file = folder_.write("scene.toml", text);
    std::vector<std::string> arguments = {"simulate", file.string(), "--out", out(), "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }
  std::filesystem::path in_run(const std::string& name) const {
    return std::filesystem::path(out()) / name;
  }
};

TEST_F(Simulate, LeavesTracksTablesAndResult) {
  const ProgramOutcome outcome = simulate(planar_scene(), {"--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Json result = Json::parse(outcome.out);
  EXPECT_EQ(result["status"], "completed");
  EXPECT_EQ(result["particles"], 3);
  EXPECT_EQ(Json::parse(content_of(in_run("result.json"))), result);
  const Json record = Json::parse(content_of(in_run("run.json")));
  EXPECT_EQ(record["verb"], "simulate");
  EXPECT_TRUE(record["input_hashes"].contains("scene.toml"));
  // The columns of every track file
  const std::string tracks = content_of(in_run("tracks/simulation.csv"));
  EXPECT_TRUE(tracks.starts_with("frame,time_s,particle,x_m,z_m,angle_rad")) << tracks;
  const auto rows = read_rows(in_run("tracks/simulation.csv"));
  ASSERT_EQ(rows.size(), 3u * 3u);
  EXPECT_NEAR(number(rows[6], "z_m") - number(rows[0], "z_m"), -0.5 * 9.81 * 0.02 * 0.02, 1e-5);
  EXPECT_EQ(read_rows(in_run("tables/energy.csv")).size(), 3u);
  EXPECT_EQ(
      undocumented_tables(out(), {"Tables of a simulated scene", "Tracks of a scene in a plane"}),
      std::vector<std::string>());
  EXPECT_EQ(read_rows(in_run("tables/bed.csv")).size(), 3u);
  EXPECT_EQ(read_rows(in_run("tables/wall_forces.csv")).size(), 3u);
}

TEST_F(Simulate, DrawsAndExportsEveryFrame) {
  const ProgramOutcome outcome =
      simulate(planar_scene(), {"--render", "--povray", "--paraview", "--ovito", "--seed", "3"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_GT(std::filesystem::file_size(in_run("simulation.mp4")), 1000u);
  EXPECT_TRUE(content_of(in_run("simulation.png")).starts_with("\x89PNG"));
  const std::string vtp = content_of(in_run("paraview/spheres_00002.vtp"));
  EXPECT_TRUE(contains(vtp, "NumberOfPoints=\"3\""));
  EXPECT_TRUE(contains(content_of(in_run("paraview/spheres.pvd")), "spheres_00002.vtp"));
  EXPECT_TRUE(contains(content_of(in_run("paraview/walls_00000.vtp")), "NumberOfPolys=\"1\""));
  const std::string dump = content_of(in_run("dump.lammpstrj"));
  std::size_t snapshots = 0;
  for (std::size_t at = 0; (at = dump.find("ITEM: TIMESTEP", at)) != std::string::npos; ++at) {
    ++snapshots;
  }
  EXPECT_EQ(snapshots, 3u);
  EXPECT_TRUE(contains(dump, "ITEM: ATOMS id mol type x y z radius vx vy vz"));
}

// POV-Ray's y is up and its z away: x, z and y of the tracks.
TEST_F(Simulate, PovRaySeesEverySphereWhereItIs) {
  ASSERT_EQ(
      simulate(with(small_scene(), "longest_s = 2.0", "longest_s = 0.01"), {"--povray"}).status, 0);
  const std::string scene = content_of(in_run("povray/frame_00001.pov"));
  EXPECT_TRUE(contains(scene, "#include \"scene.inc\""));
  EXPECT_TRUE(contains(content_of(in_run("povray/scene.inc")), "camera {"));
  const std::regex sphere("sphere \\{ <([^,]+), ([^,]+), ([^>]+)>, ([^ ]+) texture");
  std::size_t particle = 0;
  const std::vector<Row> rows = read_rows(in_run("tracks/simulation.csv"));
  for (std::sregex_iterator at(scene.begin(), scene.end(), sphere), end; at != end; ++at) {
    const Row& row = rows.at(27 + particle++);  // 27 balls a frame
    EXPECT_EQ(std::stod((*at)[1]), number(row, "x_m"));
    EXPECT_EQ(std::stod((*at)[2]), number(row, "z_m"));
    EXPECT_EQ(std::stod((*at)[3]), number(row, "y_m"));
    EXPECT_EQ(std::stod((*at)[4]), 0.01);
  }
  EXPECT_EQ(particle, 27u);
}

TEST_F(Simulate, SpatialScenesAreDrawnAndTrackedToo) {
  const ProgramOutcome outcome =
      simulate(with(small_scene(), "longest_s = 2.0", "longest_s = 0.01"), {"--render"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(contains(outcome.out, "did not come to rest")) << outcome.out;
  EXPECT_EQ(
      undocumented_tables(out(), {"Tables of a simulated scene", "Tracks of a scene in space"}),
      std::vector<std::string>());
  EXPECT_TRUE(std::filesystem::exists(in_run("simulation.png")));
}

TEST_F(Simulate, RefusesBadScenes) {
  expect_refusal(simulate(with(small_scene(), "radius_mm = 10", "radius_mm = -10")),
                 {"scene.toml:", "particle.radius_mm"});
  expect_refusal(simulate(with(small_scene(), "count = 27", "count = 500")),
                 {"scene.toml", "500 particles", "make it larger"});
  expect_refusal(run_program({"simulate", (folder_ / "none.toml").string(), "--out", out()}),
                 {"none.toml"});
  expect_refusal(run_program({"simulate", (folder_ / "none.txt").string(), "--out", out()}),
                 {"none.txt"});
  expect_refusal(simulate(small_scene(), {"--time-limit", "-1"}), {"--time-limit"});
}

std::string endless_scene() { return with(small_scene(), "duration_s = 0.02", "duration_s = 500"); }

// One ball falls a centimetre onto the floor.
constexpr const char* falling_deck =
    "START 10.0 10.0 10.0 100 6 1 1 5\nONE BALL\nRAD 1.0 1\nPRO 0.0\nDENS 1.0\nFRIC 0.1 0.1\n"
    "FRAC 1.0\nDAMP 0.5 0.5\nGRA 0.0 0.0 -9.81\nCYC 100 1 10\nSTOP\n";
constexpr const char* what_it_leaves_out =
    "elastic_modulus_mpa = 100\npoisson_ratio = 0.3\nwalls = \"rigid\"\ndimensions = 2\n"
    "length_unit = \"cm\"\ndensity_unit = \"g_per_cm3\"\nacceleration_unit = \"m_per_s2\"\n";

TEST_F(Simulate, ADeckTakesWhatItLeavesOutFromTheNamedFile) {
  const std::string deck = folder_.write("ball.txt", falling_deck).string();
  const auto sidecar = folder_.write("units.toml", what_it_leaves_out);
  const auto run = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"simulate", deck, "--out", out(), "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  };
  const ProgramOutcome without = run({});
  EXPECT_EQ(without.status, 2);
  EXPECT_NE(without.err.find("ball.toml lacks elastic_modulus_gpa"), std::string::npos)
      << without.err;
  const ProgramOutcome wrong = run({"--sidecar", sidecar.string() + "x"});
  EXPECT_EQ(wrong.status, 2);
  EXPECT_NE(wrong.err.find("no such file"), std::string::npos) << wrong.err;
  const ProgramOutcome outcome = run({"--sidecar", sidecar.string()});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(Json::parse(content_of(in_run("run.json")))["input_hashes"].contains("units.toml"));
}

TEST_F(Simulate, ADeckOfTheThesisTakesTheBundledFileOfItsName) {
  const std::string deck = folder_.write("D_a_conical_single.txt", falling_deck).string();
  const ProgramOutcome outcome = run_program({"simulate", deck, "--out", out(), "--quiet"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("bundled scenes/decks/D_a_conical_single.toml"), std::string::npos)
      << outcome.out;
}

TEST_F(Simulate, EndsAtItsTimeLimitWithWhatItHas) {
  const ProgramOutcome outcome = simulate(endless_scene(), {"--time-limit", "1"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(Json::parse(content_of(in_run("result.json")))["status"], "stopped");
}

TEST_F(Simulate, InterruptedKeepsWhatItHas) {
  const auto file = folder_.write("scene.toml", endless_scene());
  RunningProgram program({"simulate", file.string(), "--out", out(), "--quiet"});
  for (int i = 0; i < 200 && !std::filesystem::exists(out()); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  program.send(SIGINT);
  const ProgramOutcome outcome = program.wait();
  EXPECT_EQ(outcome.status, 130) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_EQ(Json::parse(content_of(in_run("result.json")))["status"], "stopped");
}

// A spring too soft for its load is found out, said, and is not a success.
TEST_F(Simulate, SaysWhenItCannotBeTrusted) {
  const ProgramOutcome outcome =
      simulate(with(small_scene(), "elastic_modulus_mpa = 20", "elastic_modulus_kpa = 2"));
  EXPECT_EQ(outcome.status, 3) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "cannot be trusted")) << outcome.err;
}

// The program of README and docs/scene.md, built with everything else.
TEST(Example, SimulatorInTenLinesLandsOnItsFloor) {
  const std::filesystem::path program =
      std::filesystem::path(GRAINTRUTH_PROGRAM).parent_path() / "examples/simulator_in_ten_lines";
  std::FILE* pipe = ::popen(program.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  char line[200] = "";
  EXPECT_NE(std::fgets(line, sizeof line, pipe), nullptr);
  EXPECT_EQ(::pclose(pipe), 0);
  EXPECT_STREQ(line, "after 0.5 s at z = 0.0100 m\n");
}

}  // namespace
}  // namespace graintruth::tests
