// graintruth track on a bin: what measured.json says of tracks whose discharge is known from
// elsewhere.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/read_rows.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::tests {
namespace {

const std::filesystem::path truth =
    std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "../shared/lab-videos/macro/truth";

constexpr const char* rig = R"(title = "A bin"
[particle]
count = 200
mass_g = 0.332
plate = {semi_major_mm = 6.9, semi_minor_mm = 5.3, thickness_mm = 2.3}
[material]
elastic_modulus_gpa = 3.5
poisson_ratio = 0.3
friction_particle_particle = 0.61
friction_particle_wall = 0.67
restitution = 0.74
[rig]
kind = "flat_bin_orifice"
bin_width_mm = 150
bin_height_mm = 210
front_back_gap_mm = 2.6
[camera]
frame_rate_hz = 100
fiducial_diameter_mm = 6
fiducials_mm = [[-112, -20], [112, -20], [-112, 190], [112, 190]]
[tune]
friction_particle_particle = {lower = 0.0, upper = 0.7}
)";

// Least-squares slope of the discharged mass over a window, kg/s.
double slope_between(const std::string& run, double from, double to) {
  double n = 0, t = 0, m = 0, tt = 0, tm = 0;
  for (const Row& row : read_rows(truth / (run + "_discharge.csv"))) {
    const double time = number(row, "time_s"), mass = number(row, "discharged_mass_kg");
    if (time < from || time > to) continue;
    n += 1, t += time, m += mass, tt += time * time, tm += time * mass;
  }
  return (n * tm - t * m) / (n * tt - t * t);
}

// The experiment above with a replicate a name: the true tracks of the lab's films.
std::string bin_of(const std::vector<std::pair<std::string, int>>& runs_and_widths_mm) {
  std::string text = rig;
  for (const auto& [run, width] : runs_and_widths_mm)
    text += "[[replicate]]\nname = \"" + run + "\"\ntracks = \"" +
            (truth / (run + "_tracks.csv")).string() +
            "\"\norifice_width_mm = " + std::to_string(width) + "\n";
  return text;
}

// What programs that drive ours are told of a bin.
TEST(Bulk, EvaluatesWhatFlows) {
  if (!std::filesystem::exists(truth)) GTEST_SKIP() << truth << " is not here";
  const TemporaryFolder folder;
  const auto experiment =
      folder.write("bin.toml", bin_of({{"orifice100_rep1", 100}, {"orifice100_rep2", 100}}));
  const auto evaluate = [&](const std::string& friction) {
    const auto parameters = folder.write("p.toml", "friction_particle_particle = " + friction);
    const ProgramOutcome outcome = run_program({"evaluate",
                                                experiment.string(),
                                                "--parameters",
                                                parameters.string(),
                                                "--out",
                                                (folder.path() / "out").string(),
                                                "--json"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  };
  const auto rough = evaluate("0.6"), smooth = evaluate("0");
  EXPECT_EQ(rough["parameters"]["friction_particle_particle"], 0.6);
  EXPECT_EQ(rough["parameters"]["friction_particle_wall"], 0.67);  // at its bench value
  EXPECT_EQ(rough["simulations"], 2);                              // one a film
  ASSERT_EQ(rough["orifices"].size(), 1U);
  const auto& orifice = rough["orifices"][0];
  const double filmed = 0.5 * (slope_between("orifice100_rep1", 0.2, 0.4) +
                               slope_between("orifice100_rep2", 0.2, 0.4));
  EXPECT_NEAR(orifice["filmed_kg_per_s"], filmed, 0.05 * filmed);
  EXPECT_LT(orifice["simulated_kg_per_s"], smooth["orifices"][0]["simulated_kg_per_s"]);
}

TEST(Bulk, RatesAreThoseOfTheDischargeCurves) {
  if (!std::filesystem::exists(truth)) GTEST_SKIP() << truth << " is not here";
  const TemporaryFolder folder;
  const auto experiment = folder.write(
      "bin.toml",
      bin_of({{"orifice050_rep1", 50}, {"orifice075_rep2", 75}, {"orifice100_rep3", 100}}));
  const std::filesystem::path out = folder.path() / "out";
  const ProgramOutcome outcome = run_program({"track", experiment.string(), "--out", out.string()});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  std::ifstream file(out / "measured.json");
  const auto measured = nlohmann::json::parse(file);
  ASSERT_EQ(measured["replicates"].size(), 3U);
  for (const auto& replicate : measured["replicates"]) {
    const std::string name = replicate["name"];
    const auto rows = read_rows(truth / (name + "_discharge.csv"));
    EXPECT_EQ(replicate["discharged"], number(rows.back(), "discharged_count")) << name;
    const double slope =
        slope_between(name, replicate["steady"]["from_s"], replicate["steady"]["to_s"]);
    EXPECT_NEAR(replicate["steady"]["rate_kg_per_s"], slope, 0.01 * slope) << name;
  }
  // Beverloo through three orifices, and the mass balance of every profile
  EXPECT_GT(measured["beverloo"]["C"], 0.4);
  EXPECT_LT(measured["beverloo"]["C"], 0.8);
  for (const auto& profile : measured["kinematic"])
    EXPECT_NEAR(profile["flux_over_rate"], 1.0, 0.1);
  // Without a second film of any orifice nobody knows how exactly a rate repeats.
  const ProgramOutcome refused =
      run_program({"calibrate", experiment.string(), "--out", (folder.path() / "c").string()});
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("has two replicates"), std::string::npos) << refused.err;
}

}  // namespace
}  // namespace graintruth::tests
