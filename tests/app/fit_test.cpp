// graintruth fit, seen from outside.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::tests {
namespace {

std::string thesis_table(const std::string& name) {
  return std::string(GRAINTRUTH_SOURCE_DIR) + "/datasets/thesis/" + name + ".csv";
}

nlohmann::json fitted(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "fit");
  arguments.push_back("--json");
  const ProgramOutcome outcome = run_program(arguments);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  return nlohmann::json::parse(outcome.out);
}

TEST(FitBeverloo, OfTheThesissTables) {
  const auto joint = fitted(
      {"beverloo", thesis_table("table_4_4_beverloo_experiment"), "--diameter-mm", "12.0948"});
  EXPECT_NEAR(joint["C"], 0.497, 0.005);
  EXPECT_NEAR(joint["k"], 0.928, 0.005);
  EXPECT_NEAR(joint["line"]["k"], 0.735, 5e-4);
  const auto thesis = fitted({"beverloo",
                              thesis_table("table_4_5_beverloo_simulation"),
                              "--diameter-mm",
                              "12",
                              "--form",
                              "thesis"});
  EXPECT_EQ(thesis["form"], "thesis");
  EXPECT_NEAR(thesis["k"], 1.753, 5e-4);
}

TEST(FitKinematic, TakesEitherSignAndAnyUnit) {
  const TemporaryFolder folder;
  const auto up =
      folder.write("up.csv", "x (mm),v (cm/s)\n-40,-12\n-20,-31\n0,-40\n20,-30\n40,-11\n");
  const auto down = folder.write(
      "down.csv", "x_m,velocity_m_per_s\n-0.04,0.12\n-0.02,0.31\n0,0.4\n0.02,0.3\n0.04,0.11\n");
  const std::vector<std::string> rest = {"--height-mm", "90", "--orifice-mm", "50"};
  std::vector<std::string> first = {"kinematic", up.string()},
                           second = {"kinematic", down.string()};
  first.insert(first.end(), rest.begin(), rest.end());
  second.insert(second.end(), rest.begin(), rest.end());
  const double B = fitted(first)["B_m"];
  EXPECT_NEAR(B, fitted(second)["B_m"], 1e-9 * B);
}

struct BadTable {
  const char* what;
  const char* text;
  std::vector<std::string> arguments;
  const char* complaint;
};

TEST(Fit, RefusesWithOneSentence) {
  const TemporaryFolder folder;
  const BadTable tables[] = {
      {"a missing column",
       "orifice_cm,rho_g_cm2\n5,1\n6,1\n7,1\n",
       {"beverloo", "--diameter-mm", "2"},
       "no column tells the flow rate; call it 'flow_rate_kg_per_s' or"},
      {"a negative rate",
       "orifice_cm,q_g_s,rho_g_cm2\n5,1,1\n6,-1,1\n7,1,1\n",
       {"beverloo", "--diameter-mm", "2"},
       ":3: the flow rate is"},
      {"two rates",
       "orifice_cm,q_g_s,W_g_min,rho_g_cm2\n5,1,1,1\n6,1,1,1\n7,1,1,1\n",
       {"beverloo", "--diameter-mm", "2"},
       "'q_g_s' and 'W_g_min' could both be the flow rate"},
      {"no diameter",
       "orifice_cm,q_g_s,rho_g_cm2\n5,1,1\n6,1,1\n7,1,1\n",
       {"beverloo"},
       "--diameter-mm"},
      {"one width",
       "orifice_cm,q_g_s,rho_g_cm2\n5,1,1\n5,1,1\n5,1,1\n",
       {"beverloo", "--diameter-mm", "2"},
       "all rows have the same orifice"},
      {"too few samples",
       "x_cm,v_cm_s\n0,1\n1,2\n",
       {"kinematic", "--height-mm", "90", "--orifice-mm", "50"},
       "needs at least 4 rows"},
      {"no orifice",
       "x_cm,v_cm_s\n0,1\n1,2\n2,1\n3,1\n",
       {"kinematic", "--height-mm", "90"},
       "--orifice-mm is missing"},
  };
  for (const BadTable& table : tables) {
    std::vector<std::string> arguments = table.arguments;
    arguments.insert(arguments.begin(), "fit");
    arguments.push_back(folder.write("table.csv", table.text).string());
    const ProgramOutcome outcome = run_program(arguments);
    EXPECT_EQ(outcome.status, 2) << table.what;
    EXPECT_EQ(outcome.out, "") << table.what;
    EXPECT_NE(outcome.err.find(table.complaint), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

}  // namespace
}  // namespace graintruth::tests
