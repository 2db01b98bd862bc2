// What the program can see to be impossible: the same sentence from check, track, calibrate and
// validate, with both numbers in it. And inputs of other laboratories that once failed.
#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/app/bad_input.h"
#include "tests/app/weighed_bin.h"

namespace graintruth::tests {
namespace {

class Contradictions : public BadInput {
 protected:
  // Every verb that reads the experiment says it; check does so in its list.
  void expect_everywhere(const std::string& text, const std::vector<std::string>& parts) {
    const auto file = folder_.write("experiment.toml", text);
    const auto parameters = folder_.write("p.toml", "friction_particle_wall = 0.3\n");
    expect_refusal(calibrate(text), parts);
    expect_refusal(run_program({"track", file.string(), "--out", out(), "--quiet"}), parts);
    expect_refusal(
        run_program(
            {"validate", file.string(), "--parameters", parameters.string(), "--out", out()}),
        parts);
    const ProgramOutcome check = run_program({"check", file.string(), "--out", out()});
    EXPECT_EQ(check.status, 2) << check.out;
    for (const std::string& part : parts)
      EXPECT_TRUE(contains(check.out + check.err, part)) << part << " is not in: " << check.out;
    std::filesystem::remove_all(folder_ / "out");
  }
  void expect_refused(const std::string& text, const std::vector<std::string>& parts) {
    expect_refusal(calibrate(text), parts);
  }
  std::string weighed(const std::string& from, const std::string& to) {
    write_curves(folder_);
    return with(weighed_bin(), from, to);
  }
};

TEST_F(Contradictions, AGrainIsWiderThanItsOpening) {
  expect_everywhere(weighed("orifice_width_mm = 75", "orifice_width_mm = 10"),
                    {"experiment.toml:", "orifice_width_mm", "10 mm", "10.6 mm"});
  expect_refused(
      weighed("semi_major_mm = 6.9, semi_minor_mm = 5.3", "semi_major_mm = 69, semi_minor_mm = 53"),
      {"experiment.toml:", "orifice_width_mm", "75 mm", "106 mm"});
  expect_refused(weighed("orifice_width_mm = 75", "orifice_width_mm = 160"),
                 {"experiment.toml:", "orifice_width_mm", "160 mm", "150 mm"});
  // A film or tracks of a hopper
  const std::string hopper = track_experiment();
  const std::size_t at = hopper.find("column_width_mm = ");
  ASSERT_NE(at, std::string::npos);
  const std::string key = hopper.substr(at, hopper.find('\n', at) - at);
  expect_refusal(calibrate(with(hopper, key, "column_width_mm = 4")),
                 {"experiment.toml:", "column_width_mm", "4 mm", "narrowest"});
}

TEST_F(Contradictions, NoSolidIsSoDense) {
  // Kilograms that were called grams, and grams that were called kilograms
  expect_everywhere(weighed("mass_g = 0.332", "mass_kg = 0.332"),
                    {"experiment.toml:", "particle.mass_kg", "332 g", "25000 kg/m3"});
  expect_refused(weighed("thickness_mm = 2.3", "thickness_mm = 0.0023"),
                 {"experiment.toml:", "particle.mass_g", "25000 kg/m3"});
  expect_refused(weighed("semi_major_mm = 6.9, semi_minor_mm = 5.3, thickness_mm = 2.3",
                         "semi_major_mm = 0.69, semi_minor_mm = 0.53, thickness_mm = 0.23"),
                 {"experiment.toml:", "particle.mass_g", "25000 kg/m3"});
}

TEST_F(Contradictions, ALightSolidIsTold) {
  const auto file =
      folder_.write("experiment.toml", weighed("mass_g = 0.332", "mass_g = 0.000332"));
  const ProgramOutcome check = run_program({"check", file.string(), "--out", out()});
  EXPECT_TRUE(contains(check.out, "particle.mass_g is 0.000332 g")) << check.out;
  EXPECT_TRUE(contains(check.out, "solids have 100 kg/m3 or more")) << check.out;
}

TEST_F(Contradictions, MoreLeavesThanWasFilled) {
  expect_everywhere(weighed("count = 30", "count = 20"),
                    {"narrow1.csv:", "'Mass (g)'", "all particles weigh 6.64 g"});
  write_curves(folder_);
  const std::string text = weighed_bin();
  std::string share = "time_s,discharged_percent\n";
  for (int i = 0; i <= 60; ++i) share += fmt::format("{},{}\n", 0.02 * i, std::max(0, i - 25) * 4);
  folder_.write("narrow1.csv", share);
  expect_refused(text, {"narrow1.csv:", "'discharged_percent'", "9.96 g"});
}

TEST_F(Contradictions, OfABalanceAreTheSameEverywhere) {
  constexpr int event = 25;  // the row of event_s
  std::string rows = "time_s,mass_g\n";
  for (int i = 0; i <= 60; ++i)
    rows += fmt::format("{},{}\n", 0.02 * i, 30.0 - 0.1 * std::max(0, i - event));
  const std::string text = weighed("name = \"narrow1\"", "name = \"narrow1\"");
  folder_.write("narrow1.csv", rows);
  expect_everywhere(text, {"narrow1.csv: column 'mass_g' falls by", "remaining_mass_g"});
}

// What had to be put right is told by all of them too.
TEST_F(Contradictions, WhatABalanceDidIsToldEverywhere) {
  write_curves(folder_);
  std::string rows = content_of(folder_ / "narrow1.csv");
  rows.replace(
      rows.find("0.80,"), rows.find('\n', rows.find("0.80,")) - rows.find("0.80,"), "0.80,83886");
  folder_.write("narrow1.csv", rows);
  const auto file = folder_.write("experiment.toml", weighed_bin());
  constexpr const char* words = "1 of 106 readings of column 'Mass (g)' stand out";
  const ProgramOutcome check = run_program({"check", file.string(), "--out", out()});
  EXPECT_EQ(check.status, 0) << check.err;
  EXPECT_TRUE(contains(check.out, words)) << check.out;
  const ProgramOutcome track = run_program({"track", file.string(), "--out", out(), "--quiet"});
  EXPECT_EQ(track.status, 0) << track.err;
  EXPECT_TRUE(contains(track.out, words)) << track.out;
  EXPECT_TRUE(contains(content_of(std::filesystem::path(out()) / "tracking.json"), words));
}

// --- Inputs of others

class SharedBalances : public BadInput {
 protected:
  void SetUp() override {
    cases_ = std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "../shared/cases";
    if (!std::filesystem::exists(cases_)) GTEST_SKIP() << cases_ << " is not here";
  }
  nlohmann::json measured(const std::string& experiment) {
    const ProgramOutcome outcome =
        run_program({"track", (cases_ / experiment).string(), "--out", out(), "--quiet"});
    EXPECT_EQ(outcome.status, 0) << experiment << outcome.err;
    std::ifstream stream(std::filesystem::path(out()) / "measured.json");
    return nlohmann::json::parse(stream, nullptr, false);
  }
  std::filesystem::path cases_;
};

TEST_F(SharedBalances, OneOddFirstReadingShiftsNothing) {
  for (const char* file : {"fail-09/spike_low/bin.toml", "fail-09/spike_high/bin.toml"}) {
    for (const auto& replicate : measured(file)["replicates"])
      EXPECT_EQ(replicate["discharged"], 24) << file;
  }
}

TEST_F(SharedBalances, NoiseOfAFifthOfAParticleIsNoMassThatReturns) {
  for (const auto& [file, allowed] :
       {std::pair("fail-16/quiet/bin.toml", 0.05), std::pair("fail-16/bin.toml", 0.1)}) {
    const auto json = measured(file);
    const std::map<std::string, double> rates = {
        {"narrow1", 21.56}, {"narrow2", 22.44}, {"wide1", 33.32}, {"wide2", 34.68}};
    ASSERT_EQ(json["replicates"].size(), 4U);
    for (const auto& replicate : json["replicates"]) {
      const double rate = rates.at(replicate["name"]);
      EXPECT_NEAR(1e3 * replicate["steady"]["rate_kg_per_s"].get<double>(), rate, allowed * rate)
          << file << replicate["name"];
      EXPECT_EQ(replicate["discharged"], 24) << file;
    }
  }
}

TEST_F(SharedBalances, TablesOfRates) {
  const auto fit = [&](const std::string& file) {
    return run_program(
        {"fit", "beverloo", (cases_ / file).string(), "--law", "circular", "--json"});
  };
  for (const char* file : {"fail-10/circ_se.csv", "fail-14/circ_Dd.csv"}) {
    const ProgramOutcome outcome = fit(file);
    ASSERT_EQ(outcome.status, 0) << file << outcome.err;
    const auto result = nlohmann::json::parse(outcome.out);
    EXPECT_NEAR(result["C"], 0.58, 0.002) << file;
    EXPECT_NEAR(result["k"], 1.4, 0.01) << file;
  }
  expect_refusal(fit("fail-10/circ_se_empty.csv"),
                 {"circ_se_empty.csv:7:", "q_se (g/s)", "missing"});
  expect_refusal(fit("fail-10/circ_se_zero.csv"), {"circ_se_zero.csv:7:", "q_se (g/s)", "is 0"});
  expect_refusal(fit("fail-10/circ_se_neg.csv"), {"circ_se_neg.csv:7:", "q_se (g/s)", "is -1"});
  expect_refusal(fit("fail-14/silo_D.csv"), {"silo_D.csv", "'D (mm)'", "silo"});
}

// A column that stood on the left and lies on the right: every verb says it, before anything else.
TEST_F(Contradictions, ABedAtRestIsMirrored) {
  run_program({"new", "column_collapse", folder_ / "tank"});
  for (int n = 1; n <= 2; ++n) {
    std::ofstream table(folder_ / fmt::format("tank/collapse{}.outline.csv", n));
    table << "time_s,column_m,height_m\n";
    for (int i = 0; i < 100; ++i) {
      const double x = 0.001 + 0.002 * i;
      const double wall = n == 1 ? 0.2 - x : x;
      const double height = 0.03 - 0.25 * wall + 0.0001 * n;
      if (height > 0.0) table << fmt::format("1,{},{}\n", x, height);
    }
  }
  const std::string file = folder_ / "tank/experiment.toml";
  const std::string words =
      "collapse1.outline: the bed at rest is higher on the right than where "
      "it stood before: the picture is mirrored";
  const ProgramOutcome track = run_program({"track", file, "--out", out(), "--quiet"});
  EXPECT_EQ(track.status, 0) << track.err;
  EXPECT_TRUE(contains(track.out, "Warning: " + words)) << track.out;
  EXPECT_FALSE(contains(track.out, "collapse2.outline: the bed at rest is")) << track.out;
}

}  // namespace
}  // namespace graintruth::tests
