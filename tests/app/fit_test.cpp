// graintruth fit, seen from outside.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
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

// Rates of  W = 0.58 rho sqrt(g) (D - k d)^2.5, rho = 1450 kg/m3, in the columns that `row` writes.
std::string rates_of(const std::string& header,
                     double k,
                     double d,
                     const std::function<std::string(double D, double W)>& row) {
  std::string text = header + "\n";
  for (const double D : {0.012, 0.015, 0.018, 0.022, 0.026, 0.030})
    text += row(D, 0.58 * 1450.0 * std::sqrt(9.81) * std::pow(D - k * d, 2.5)) + "\n";
  return text;
}

class FitTables : public testing::Test {
 protected:
  ProgramOutcome run(const std::vector<std::string>& arguments, const std::string& text) {
    std::vector<std::string> all = {"fit"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    all.push_back(folder_.write("table.csv", text).string());
    return run_program(all);
  }
  nlohmann::json result_of(std::vector<std::string> arguments, const std::string& text) {
    arguments.push_back("--json");
    const ProgramOutcome outcome = run(arguments, text);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out, nullptr, false);
  }
  void expect_refusal(const std::vector<std::string>& arguments,
                      const std::string& text,
                      const std::vector<std::string>& parts) {
    const ProgramOutcome outcome = run(arguments, text);
    EXPECT_EQ(outcome.status, 2) << text << outcome.out;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    for (const std::string& part : parts)
      EXPECT_NE(outcome.err.find(part), std::string::npos) << part << " is not in " << outcome.err;
  }
  const std::vector<std::string> circular_ = {"beverloo", "--law", "circular"};
  TemporaryFolder folder_;
};

// Papers write D or D0 for the orifice, d for the grain, and D beside D0 for the silo.
TEST_F(FitTables, CapitalsTellOrificeGrainAndSilo) {
  const auto as = [](const char* form) {
    return [form](double D, double W) {
      return fmt::format(fmt::runtime(form),
                         fmt::arg("D", 1e3 * D),
                         fmt::arg("W", 1e3 * W),
                         fmt::arg("cm", 1e2 * D));
    };
  };
  for (const auto& [header, form] :
       {std::pair("D (mm),W (g/s),rho (kg/m3),d (mm)", "{D},{W},1450,3"),
        std::pair("d_mm,D_cm,W_g_s,bulk_density_g_cm3", "3,{cm},{W},1.45"),
        std::pair("D0 (mm),W (g/s),bulk_density (kg/m3),D (mm),d (mm)", "{D},{W},1450,150,3"),
        std::pair("D_0 [mm];Q [g/s];rho_bulk [kg/m3];D [mm];d_p [mm]", "{D};{W};1450;150;3"),
        std::pair("silo_diameter_mm,orifice_mm,q_g_s,density_kg_m3,grain_size_mm",
                  "150,{D},{W},1450,3")}) {
    const auto result = result_of(circular_, rates_of(header, 1.4, 0.003, as(form)));
    EXPECT_NEAR(result["C"], 0.58, 1e-6) << header;
    EXPECT_NEAR(result["k"], 1.4, 1e-6) << header;
    EXPECT_EQ(result["warnings"].size(), 0U) << header;
  }
  expect_refusal(
      circular_,
      rates_of("D0 (mm),W (g/s),bulk_density (kg/m3),D (mm)", 1.4, 0.003, as("{D},{W},1450,150")),
      {"table.csv: no column tells the particles' diameter", "'D (mm)' is taken for the silo's"});
  const std::string grain_alone =
      rates_of("D0 (mm),W (g/s),bulk_density (kg/m3),d (mm)", 1.4, 0.003, as("{D},{W},1450,150"));
  expect_refusal(circular_, grain_alone, {"table.csv:2:", "150 mm", "12 mm", "none can flow out"});
  expect_refusal(
      circular_,
      rates_of("D0 (mm),W (g/s),bulk_density (kg/m3),d (mm)", 1.4, 0.003, as("{D},{W},1450,13")),
      {"table.csv:2:", "13 mm", "12 mm"});
  expect_refusal(circular_,
                 rates_of("D0 (mm),W (g/s),bulk_density (kg/m3),D (mm),d (mm)",
                          1.4,
                          0.003,
                          as("{D},{W},1450,20,3")),
                 {"table.csv:5:", "22 mm", "silo of 20 mm"});
}

TEST_F(FitTables, UncertaintiesThatAreNoneAreRefusedWithTheirLine) {
  for (const auto& [header, bad] : {std::pair("q_se (g/s)", ""),
                                    std::pair("q_se (g/s)", "0"),
                                    std::pair("sigma_q_g_s", "-1"),
                                    std::pair("W_std_kg_per_h", "nan"),
                                    std::pair("flow_rate_uncertainty_g_per_s", "inf")}) {
    int number = 0;
    const auto row = [&, bad = bad](double D, double W) {
      return fmt::format("{},{},1450,3,{}", 1e3 * D, 1e3 * W, ++number == 4 ? bad : "0.5");
    };
    expect_refusal(
        circular_,
        rates_of(
            fmt::format("D0 (mm),W (g/s),bulk_density (kg/m3),d (mm),{}", header), 1.4, 0.003, row),
        {"table.csv:5:", header, "above 0"});
  }
  expect_refusal(circular_,
                 rates_of("D0 (mm),W (g/s),bulk_density (kg/m3),d (mm),q_se",
                          1.4,
                          0.003,
                          [](double D, double W) {
                            return fmt::format("{},{},1450,3,0.5", 1e3 * D, 1e3 * W);
                          }),
                 {"'q_se' has no unit"});
  for (const char* bad : {"", "0", "-0.1"}) {
    expect_refusal(
        {"kinematic", "--height-mm", "90", "--orifice-mm", "50"},
        fmt::format("x (mm),v (cm/s),v_se (cm/s)\n-40,12,1\n-20,31,1\n0,40,{}\n20,30,1\n40,11,1\n",
                    bad),
        {"table.csv:4:", "v_se (cm/s)", "above 0"});
  }
}

// The first line questions what cannot well be, with what was published.
TEST_F(FitTables, ImplausibleConstantsAreQuestionedFirst) {
  const auto row = [](double D, double W) {
    return fmt::format("{},{},1450,{}", 1e3 * D, 1e3 * W, 3);
  };
  const std::string header = "D0 (mm),W (g/s),bulk_density (kg/m3),d (mm)";
  struct Case {
    double k, d;
    const char* words;
  };
  // A diameter in cm that was called mm, one of another grain, and rates in kg/s called g/s
  for (const Case& one :
       {Case{0.14, 0.003, "k = 0.14"}, Case{0.4, 0.003, "k = 0.4"}, Case{3.9, 0.003, "k = 3.9"}}) {
    const ProgramOutcome outcome = run(circular_, rates_of(header, one.k, one.d, row));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const std::string first = outcome.out.substr(0, outcome.out.find('\n'));
    EXPECT_TRUE(first.starts_with("warning: ")) << first;
    for (const char* part : {one.words, "from 1 to 3", "Nedderman 1992"})
      EXPECT_NE(first.find(part), std::string::npos) << first;
  }
  const ProgramOutcome thousand =
      run(circular_, rates_of(header, 1.4, 0.003, [](double D, double W) {
            return fmt::format("{},{},1450,3", 1e3 * D, W);
          }));
  EXPECT_EQ(thousand.out.find("warning: C = 0.00058"), 0U) << thousand.out;
  const auto narrow =
      result_of({"kinematic", "--height-mm", "90", "--orifice-mm", "50", "--diameter-mm", "100"},
                "x (mm),v (cm/s)\n-40,12\n-20,31\n0,40\n20,30\n40,11\n");
  ASSERT_EQ(narrow["warnings"].size(), 1U);
  EXPECT_NE(narrow["warnings"][0].get<std::string>().find("1.3 to 3.5"), std::string::npos);
}

TEST_F(FitTables, DensitiesThatCannotBeAreRefusedOrTold) {
  const auto density = [](const char* columns) {
    return [columns](double D, double W) {
      return fmt::format("{},{},3,{}", 1e3 * D, 1e3 * W, columns);
    };
  };
  // kg/m3 that was called g/cm3
  expect_refusal(
      circular_,
      rates_of("D0 (mm),W (g/s),d (mm),bulk_density (g/cm3)", 1.4, 0.003, density("1450")),
      {"table.csv:2:", "1.45e+06 kg/m3", "25000 kg/m3"});
  expect_refusal(circular_,
                 rates_of("D0 (mm),W (g/s),d (mm),bulk_density (kg/m3),particle_density (kg/m3)",
                          1.4,
                          0.003,
                          density("1450,1200")),
                 {"table.csv:2:", "1450 kg/m3", "1200 kg/m3"});
  const ProgramOutcome light =
      run(circular_,
          rates_of("D0 (mm),W (g/s),d (mm),bulk_density (kg/m3)", 1.4, 0.003, density("1.45")));
  EXPECT_EQ(light.out.find("warning: "), 0U) << light.out;
  EXPECT_NE(light.out.find("1.45 kg/m3, is less than 30 kg/m3"), std::string::npos) << light.out;
}

// No numbers follow a fit that failed; a k that is stated needs none.
TEST_F(FitTables, WhatDoesNotConvergeIsRefused) {
  const std::string header = "D0 (mm),W (g/s),bulk_density (kg/m3),d (mm)\n";
  for (const char* rows : {"12,50,1450,3\n15,50,1450,3\n18,50,1450,3\n",
                           "12,90,1450,3\n15,60,1450,3\n18,30,1450,3\n22,10,1450,3\n",
                           "12,1,1450,3\n12,1.1,1450,3\n30,0.9,1450,3\n"}) {
    expect_refusal(circular_, header + rows, {"table.csv: ", "did not converge"});
    std::vector<std::string> with_k = circular_;
    with_k.insert(with_k.end(), {"--k", "1.4"});
    const ProgramOutcome outcome = run(with_k, header + rows);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.out.find("did not converge"), std::string::npos) << outcome.out;
  }
  const std::vector<std::string> kinematic = {
      "kinematic", "--height-mm", "90", "--orifice-mm", "50"};
  expect_refusal(kinematic,
                 "x_mm,v_cm_s\n-40,10\n-20,10\n0,10\n20,10\n40,10\n",
                 {"did not converge", "too flat"});
  expect_refusal(kinematic, "x_mm,v_cm_s\n-40,0\n-20,0\n0,0\n20,0\n", {"every velocity is 0"});
}

TEST_F(FitTables, PlacesBesideTheOrificeOrTheBinAreRefused) {
  std::vector<std::string> kinematic = {"kinematic", "--height-mm", "90", "--orifice-mm", "50"};
  // Counted from the left wall of a bin of 150 mm; from another point; in another unit
  expect_refusal(kinematic,
                 "x_mm,v_cm_s\n5,2\n35,12\n65,38\n75,40\n85,37\n115,12\n145,2\n",
                 {"table.csv: ", "mm/s above the orifice", "beside it", "middle of the orifice"});
  expect_refusal(kinematic,
                 "x_mm,v_cm_s\n100,12\n120,31\n140,40\n160,30\n180,11\n",
                 {"table.csv: every place lies beside the orifice, which is 50 mm wide", "100 mm"});
  expect_refusal(
      kinematic, "x_cm,v_cm_s\n-40,12\n-30,31\n-26,40\n26,30\n40,11\n", {"260 mm from its middle"});
  kinematic.insert(kinematic.end(), {"--bin-width-mm", "70"});
  expect_refusal(kinematic,
                 "x_mm,v_cm_s\n-40,12\n-20,31\n0,40\n20,30\n40,11\n",
                 {"table.csv:2:", "-40 mm", "35 mm to either side"});
}

}  // namespace
}  // namespace graintruth::tests
