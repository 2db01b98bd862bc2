// Two experiments calibrated together by the program as users run it: particles followed in a rig,
// and curves of what ran out of a bin.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/app/laboratory.h"
#include "tests/app/weighed_bin.h"
#include "tests/support/run_program.h"

namespace graintruth::tests {
namespace {

nlohmann::json json_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return nlohmann::json::parse(stream);
}

TEST(JointRun, FindsOneSetOfParametersAndAReportForEveryExperiment) {
  const TemporaryFolder folder;
  write_tracks_of_truth(folder);
  write_curves(folder);
  folder.write("balls.toml", track_experiment());
  // The same grains and walls, as far as the model knows them
  std::string bin = weighed_bin();
  for (const auto& [from, to] :
       {std::pair("friction_particle_particle = 0.4", "friction_particle_particle = 0.36"),
        std::pair("friction_particle_wall = 0.4", "friction_particle_wall = 0.35"),
        std::pair("restitution = 0.7", "restitution = 0.83")})
    bin = with(bin, from, to);
  folder.write("bin.toml", bin);
  const auto file = folder.write("both.toml", R"(title = "Balls and a bin"
[[experiment]]
file = "balls.toml"
[[experiment]]
file = "bin.toml"
weight = 2
[tune]
friction_particle_particle = {lower = 0.0, upper = 0.4}
friction_particle_wall = {lower = 0.05, upper = 0.5}
)");
  const std::filesystem::path out = folder / "out";
  const std::vector<std::string> command = {
      "calibrate", file.string(), "--out", out.string(), "--budget", "20", "--json"};
  const ProgramOutcome outcome = run_program(command);
  ASSERT_EQ(outcome.status, 0) << outcome.err;

  // 1. One answer, which both experiments repeat
  const nlohmann::json result = json_of(out / "result.json");
  EXPECT_EQ(nlohmann::json::parse(outcome.out), result);
  EXPECT_EQ(result["kind"], "calibration");
  EXPECT_EQ(result["parameters"]["restitution"]["status"], "fixed");
  double sum = 0.0;
  ASSERT_EQ(result["experiments"].size(), 2U);
  for (const auto& experiment : result["experiments"]) {
    const std::string name = experiment["name"];
    sum += experiment["weight"].get<double>() * experiment["objective"].get<double>();
    const nlohmann::json own = json_of(out / name / "result.json");
    EXPECT_EQ(own["part_of"], "Balls and a bin");
    EXPECT_EQ(own["evaluations"], result["evaluations"]);
    EXPECT_EQ(own["time_step"]["fraction"], result["time_step"]["fraction"]);
    for (const char* parameter : {"friction_particle_particle", "friction_particle_wall"})
      EXPECT_EQ(own["parameters"][parameter], result["parameters"][parameter]) << name;
    const std::string page = content_of(out / name / "report.html");
    EXPECT_NE(page.find("were found together with"), std::string::npos);
    EXPECT_EQ(page.find("lacks journal"), std::string::npos);
  }
  EXPECT_NEAR(result["objective"]["best"].get<double>(), sum, 1e-12 * sum);
  EXPECT_TRUE(json_of(out / "balls" / "result.json")["agreement"].is_object());
  EXPECT_FALSE(json_of(out / "bin" / "result.json")["comparison"].empty());

  // 2. A page that leads to both, and repeats that films are synthetic
  const std::string page = content_of(out / "report.html");
  for (const char* link : {"href=\"balls/report.html\"", "href=\"bin/report.html\""})
    EXPECT_NE(page.find(link), std::string::npos) << link;
  EXPECT_NE(page.find("ynthetic"), std::string::npos);
  EXPECT_EQ(page.find("No agreement with tracks"), std::string::npos);
  EXPECT_EQ(page.find("run folder lacks"), std::string::npos);

  // 3. Its decks are those of an experiment, not of the whole
  const ProgramOutcome deck = run_program({"export", out.string(), "--to", "lammps"});
  EXPECT_EQ(deck.status, 2);
  EXPECT_NE(deck.err.find("folder of one of them"), std::string::npos) << deck.err;
  EXPECT_EQ(run_program({"export", (out / "balls").string(), "--to", "lammps"}).status, 0);

  // 4. Run again, nothing is simulated, and a changed experiment is not mixed with old simulations
  ASSERT_EQ(run_program(command).status, 0);
  EXPECT_EQ(json_of(out / "run.json")["simulations_run"], 0);
  EXPECT_EQ(json_of(out / "result.json")["parameters"], result["parameters"]);
  folder.write("bin.toml", with(bin, "elastic_modulus_mpa = 20", "elastic_modulus_mpa = 21"));
  const ProgramOutcome changed = run_program(command);
  EXPECT_EQ(changed.status, 2);
  EXPECT_NE(changed.err.find(" of bin"), std::string::npos) << changed.err;
}

}  // namespace
}  // namespace graintruth::tests
