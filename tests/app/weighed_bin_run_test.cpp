// A calibration on load-cell curves alone, by the program as users run it.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/app/documented_tables.h"
#include "tests/app/weighed_bin.h"
#include "tests/support/read_rows.h"
#include "tests/support/run_program.h"

namespace graintruth::tests {
namespace {

TEST(WeighedBinRun, IsCalibratedOnItsRatesAndOnWhatStays) {
  const TemporaryFolder folder;
  write_curves(folder);
  const auto file = folder.write("bin.toml", weighed_bin());
  const std::filesystem::path out = folder / "out";
  const ProgramOutcome outcome =
      run_program({"calibrate", file.string(), "--out", out.string(), "--budget", "20"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(undocumented_tables(out, {"Tables of every run", "Tables of a bin"}),
            std::vector<std::string>({"tracks/<film>.csv was not written"}));
  std::ifstream stream(out / "result.json");
  const auto result = nlohmann::json::parse(stream);

  // 1. Rates of both, from the same function; nothing of what only tracks tell
  int of_experiment = 0, of_simulation = 0;
  for (const auto& flow : result["discharge"]) {
    const bool measured = flow["source"] == "experiment";
    (measured ? of_experiment : of_simulation) += 1;
    if (!measured) continue;
    const double rate = flow["orifice_m"] == 0.075 ? 0.022 : 0.034;
    EXPECT_NEAR(flow["rate_kg_per_s"], rate, 0.01 * rate);
  }
  EXPECT_EQ(of_experiment, 2);
  EXPECT_GE(of_simulation, 1);
  if (result.contains("kinematic")) {
    for (const auto& fit : result["kinematic"]) EXPECT_EQ(fit["source"], "simulation");
  }
  EXPECT_FALSE(result["objective"]["shares"].contains("velocity_profile"));

  // 2. Said to the user, in the result and on the report
  bool said = false;
  for (const std::string warning : result["warnings"])
    said |= warning.find("narrow1, narrow2, wide1, wide2: A discharge curve does not show") !=
            std::string::npos;
  EXPECT_TRUE(said) << result["warnings"];
  EXPECT_TRUE(std::filesystem::exists(out / "report.html"));

  // 3. Its plate goes to other programs, although no spheres were given
  const ProgramOutcome tables = run_program({"export", out.string(), "--to", "csv"});
  ASSERT_EQ(tables.status, 0) << tables.err;
  EXPECT_EQ(read_rows(out / "export/csv/particle_spheres.csv").size(), 7u);
  EXPECT_EQ(read_rows(out / "export/csv/parameters.csv").size(), 3u);
  const ProgramOutcome deck = run_program({"export", out.string(), "--to", "lammps"});
  EXPECT_EQ(deck.status, 0) << deck.err;

  // 4. Friction slows the flow of this bin: a parameter that makes a difference was compared
  const auto& row = result["comparison"][0];
  EXPECT_GT(row["simulated_kg_per_s"], 0.0);
  EXPECT_GT(row["validation_uncertainty_kg_per_s"], 0.0);
  EXPECT_EQ(row["filmed_jams"]["runs"], 0);  // a curve cannot tell
}

}  // namespace
}  // namespace graintruth::tests
