// validate: rigs without an orifice, experiments without an agreement, and what run.json says.
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/app/bad_input.h"
#include "tests/support/read_rows.h"

namespace graintruth::tests {
namespace {

using Json = nlohmann::ordered_json;

class Validate : public BadInput {
 protected:
  // The template of a scene, with curves of its load cell.
  std::string weighed_box() {
    run_program({"new", "scene", folder_ / "box"});
    for (int n = 1; n <= 3; ++n) {
      std::ofstream table(folder_ / ("box/cell" + std::to_string(n) + ".csv"));
      table << "time_s,mass_g\n";
      for (int reading = 0; reading <= 100; ++reading)
        table << 0.01 * reading << ',' << std::min(100.0, (2.4 + 0.1 * n) * reading) << '\n';
    }
    return folder_ / "box/experiment.toml";
  }

  std::string parameters() {
    return folder_.write("parameters.toml", "friction_particle_wall = 0.3\n");
  }

  ProgramOutcome validate(const std::string& experiment, std::vector<std::string> more = {}) {
    std::vector<std::string> command = {
        "validate", experiment, "--parameters", parameters(), "--out", out(), "--quiet"};
    command.insert(command.end(), more.begin(), more.end());
    return run_program(command);
  }
};

TEST_F(Validate, ARigWithoutAnOrificeHasAnExitAndEmptyCells) {
  const ProgramOutcome outcome = validate(weighed_box(), {"--runs", "1"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(contains(outcome.out, "Exit ")) << outcome.out;
  EXPECT_TRUE(contains(outcome.out, "curve inside the band of the replicates")) << outcome.out;
  for (const char* wrong : {"inf ", "Orifice ", "film"})
    EXPECT_FALSE(contains(outcome.out, wrong)) << wrong << " is in:\n" << outcome.out;
  for (const char* table : {"rate_comparison", "discharge_curves", "flow_rates", "discharge"}) {
    const auto rows = read_rows(folder_ / ("out/run/tables/" + std::string(table) + ".csv"));
    ASSERT_FALSE(rows.empty()) << table;
    for (const Row& row : rows) EXPECT_EQ(row.at("orifice_m"), "") << table;
  }
  const Json result = Json::parse(content_of(folder_ / "out/run/result.json"));
  EXPECT_TRUE(result["comparison"][0]["orifice_m"].is_null()) << result["comparison"];
  const std::string page = content_of(folder_ / "out/run/report.html");
  EXPECT_TRUE(contains(page, "the flow through the exit"));

  const Json run = Json::parse(content_of(folder_ / "out/run/run.json"));
  const Json& configuration = run["configuration"];
  EXPECT_EQ(configuration["rig"], "scene");
  EXPECT_EQ(configuration["measure"]["observables"],
            Json::parse(R"([{"name": "discharge_rate", "weight": 1.0},
                            {"name": "what_stays", "weight": 1.0}])"));
  EXPECT_EQ(configuration["conditions"],
            Json::parse(R"([{"settings": {}, "replicates": ["cell1", "cell2", "cell3"],
                             "held_out": false}])"));
}

TEST_F(Validate, AnAgreementThatNothingGivesIsRefusedBeforeAnythingIsSimulated) {
  expect_refusal(validate(weighed_box(), {"--require-agreement", "50"}),
                 {"experiment.toml", "no agreement", "heap_height", "--require-agreement"});
}

TEST_F(Validate, ASensorAloneHasNoAgreementEither) {
  const std::string experiment = weighed_box();
  std::string text = content_of(experiment);
  text = with(text,
              "observables = [\"discharge_rate\", \"what_stays\"]",
              "observables = [\"side_force\"]\n[measure.side_force]\ncolumn = \"force_n\"\n"
              "engine_curve = \"wall_force_box_left_x_n\"\nunit = \"N\"\n");
  for (int n = 1; n <= 3; ++n) {
    const std::string number = std::to_string(n);
    text = with(
        text, "discharge = \"cell" + number + ".csv\"", "curves = \"force" + number + ".csv\"");
    folder_.write("box/force" + number + ".csv", "force_n\n-0." + number + "\n");
  }
  text = with(text, "[measure]", "[measure]\nframe_interval_s = 0.04\nframes = 25\n");
  folder_.write("box/experiment.toml", text);
  expect_refusal(validate(experiment, {"--require-agreement", "50"}),
                 {"experiment.toml", "no agreement", "--require-agreement"});
  // A wall that nobody knows, before anything is simulated
  folder_.write("box/experiment.toml",
                with(text,
                     "\nengine_curve = \"wall_force_box_left_x_n",
                     "\nengine_curve = \"wall_force_lid_z_n"));
  expect_refusal(validate(experiment),
                 {"measure.side_force.engine_curve", "wall_force_lid_z_n", "wall_force_gate_z_n"});
  const ProgramOutcome check = run_program({"check", experiment, "--out", out()});
  EXPECT_EQ(check.status, 2);
  EXPECT_TRUE(contains(check.out, "wall_force_gate_z_n")) << check.out;
  EXPECT_FALSE(contains(check.out, "Ready")) << check.out;
}

TEST_F(Validate, TwoReplicatesAreTooFewToScoreOne) {
  write_tracks_of_truth(folder_);
  std::string text = track_experiment();
  for (int n = 3; n <= 5; ++n)
    text = with(text, "[[replicate]]\ntracks = \"rep" + std::to_string(n) + ".csv\"\n", "");
  const ProgramOutcome outcome = validate(folder_.write("experiment.toml", text), {"--runs", "2"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(contains(outcome.out, "2 replicates are too few to score one by the others"))
      << outcome.out;
  EXPECT_FALSE(contains(outcome.out, "nan")) << outcome.out;
}

}  // namespace
}  // namespace graintruth::tests
