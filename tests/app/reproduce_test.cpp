// The verb reproduce: every verdict from the printed data, and what one changed digit does to it.
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/app/documented_tables.h"
#include "tests/app/laboratory.h"
#include "tests/support/read_rows.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::tests {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

const fs::path source = GRAINTRUTH_SOURCE_DIR;

// The program on a copy of the data, of which tests change cells.
class Reproduce : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "data/scenes");
    fs::copy(source / "datasets/thesis", folder_ / "data/thesis");
    setenv("GRAINTRUTH_DATA", (folder_ / "data").c_str(), 1);
  }
  void TearDown() override { unsetenv("GRAINTRUTH_DATA"); }

  // Replaces what must stand exactly once in a table.
  void change(const std::string& table, const std::string& what, const std::string& by) {
    const fs::path file = folder_ / "data/thesis" / (table + ".csv");
    std::string content = content_of(file);
    const auto place = content.find(what);
    ASSERT_NE(place, std::string::npos) << what;
    ASSERT_EQ(content.find(what, place + 1), std::string::npos) << what;
    content.replace(place, what.size(), by);
    std::ofstream(file, std::ios::binary) << content;
  }

  ProgramOutcome reproduce(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "reproduce");
    for (const std::string option : {"--quiet", "--json", "--out"}) arguments.push_back(option);
    arguments.push_back((folder_ / "run").string());
    return run_program(arguments);
  }

  // Verdict of a row; "" where there is none.
  static Json row_of(const ProgramOutcome& outcome, const std::string& where) {
    const Json result = Json::parse(outcome.out);
    for (const Json& target : result.at("targets")) {
      for (const Json& row : target.at("rows")) {
        if (row.at("where") == where) return row;
      }
    }
    return {{"verdict", ""}, {"simulated", nullptr}};
  }
  static std::string verdict(const ProgramOutcome& outcome, const std::string& where) {
    return row_of(outcome, where).at("verdict");
  }

  TemporaryFolder folder_;
};

TEST_F(Reproduce, EverythingPrintedHasAVerdictAndNoneFails) {
  const ProgramOutcome outcome = reproduce({"printed"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Json result = Json::parse(outcome.out);
  const std::set<std::string> words = {"reproduced", "misprint", "input", "not confirmed"};
  std::set<std::string> seen;
  for (const Json& target : result.at("targets")) {
    const std::string name = target.at("name");
    EXPECT_FALSE(target.at("rows").empty()) << name;
    EXPECT_EQ(read_rows(folder_ / ("run/tables/" + name + ".csv")).size(), target["rows"].size());
    for (const Json& row : target.at("rows")) {
      EXPECT_TRUE(words.contains(row.at("verdict"))) << name << ": " << row;
      if (row.at("verdict") == "misprint") {
        EXPECT_TRUE(row.at("errata").is_number()) << row;
      }
    }
    seen.insert(name);
  }
  for (const char* table : {"table-1.1",
                            "table-3.1",
                            "table-3.2",
                            "table-3.3",
                            "table-3.4",
                            "table-3.5",
                            "table-3.6",
                            "table-4.1",
                            "table-4.2",
                            "table-4.3",
                            "table-4.4",
                            "table-4.5",
                            "table-4.6",
                            "table-4.7",
                            "table-5.1",
                            "table-5.2"})
    EXPECT_TRUE(seen.contains(table)) << table;
  EXPECT_EQ(verdict(outcome, "mean agreement"), "misprint");
  EXPECT_EQ(verdict(outcome, "experiment: kd"), "reproduced");
  EXPECT_EQ(verdict(outcome, "k from 7.5 cm on: both pooled"), "misprint");
  EXPECT_EQ(verdict(outcome, "P value"), "reproduced");
  EXPECT_EQ(verdict(outcome, "D = 7.5 cm: experiment, mean speed"), "not confirmed");
  EXPECT_NE(content_of(folder_ / "run/report.html").find("Reproduction report"), std::string::npos);
}

// A rank of Table 4.2: its row follows no more, nor does the average.
TEST_F(Reproduce, AChangedRankFails) {
  change("table_4_2_agreement", "5,0,1,4,20,69", "5,0,2,3,20,69");
  const ProgramOutcome outcome = reproduce({"table-4.2"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(verdict(outcome, "particle 5: points"), "FAIL");
  EXPECT_EQ(verdict(outcome, "particle 4: points"), "reproduced");
}

// A printed digit that was a listed misprint: the errata are about other digits.
TEST_F(Reproduce, AChangedMisprintFails) {
  change("table_4_2_summary", "mean_agreement,82.13", "mean_agreement,82.23");
  const ProgramOutcome outcome = reproduce({"table-4.2"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(verdict(outcome, "mean agreement"), "FAIL");
  EXPECT_EQ(verdict(outcome, "mean points"), "misprint");
}

// A misprint put right in the data, but not in the errata.
TEST_F(Reproduce, AnErratumAboutRightDigitsFails) {
  change("table_4_2_agreement", "9,0,1,11,13,63,84", "9,0,1,11,13,62,82.7");
  const ProgramOutcome outcome = reproduce({"table-4.2"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(verdict(outcome, "particle 9: points"), "FAIL");
}

// A flow rate: C of its row, and the straight line through all.
TEST_F(Reproduce, AChangedRateFails) {
  change("table_4_4_beverloo_experiment", "5,52.91,", "5,57.91,");
  const ProgramOutcome outcome = reproduce({"table-4.4", "fig-4.17"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(verdict(outcome, "D = 5 cm: C"), "FAIL");
  EXPECT_EQ(verdict(outcome, "experiment: kd"), "FAIL");
  EXPECT_EQ(verdict(outcome, "D = 6.5 cm: C"), "reproduced");
}

// Studies are read back: the second run is the first, digit by digit.
TEST_F(Reproduce, SimulatesOnceAndRebuildsFromWhatIsStored) {
  const ProgramOutcome first = reproduce({"eq-3.7"});
  EXPECT_EQ(first.status, 0) << first.err;
  EXPECT_EQ(verdict(first, "velocity is kept"), "confirmed");
  EXPECT_EQ(undocumented_tables(folder_ / "run", {"Tables of a reproduction"}),
            std::vector<std::string>());
  const fs::path study = folder_ / "run/studies/eq-3.7.json";
  const auto written = fs::last_write_time(study);
  const ProgramOutcome second = reproduce({"eq-3.7"});
  EXPECT_EQ(second.out, first.out);
  EXPECT_EQ(fs::last_write_time(study), written);
  // What was changed by hand is not taken for a result
  std::string kept = content_of(study);
  const std::size_t digit = kept.find_first_of("12345678", kept.find("\"result\""));
  ++kept[digit];
  std::ofstream(study) << kept;
  EXPECT_EQ(reproduce({"eq-3.7"}).out, first.out);
  // Other inputs are simulated anew
  change("resimulation", "impulse,time,0.05", "impulse,time,0.04");
  EXPECT_EQ(reproduce({"eq-3.7"}).status, 0);
  EXPECT_NE(fs::last_write_time(study), written);
}

// Four runs are too few for the word, whatever the thesis-compatible one shows.
TEST_F(Reproduce, ContradictsWithFiveSeedsOnly) {
  const std::string held_back = "friction 0.3: tangential damping holds back the sliding";
  EXPECT_EQ(verdict(reproduce({"fig-3.7"}), held_back), "contradicted");
  change("resimulation", "sliding,seeds,5", "sliding,seeds,4");
  EXPECT_EQ(verdict(reproduce({"fig-3.7"}), held_back), "not confirmed");
}

// The study of friction, cut short: soft particles, few frames. Friction tells runs apart, and what
// is stored is not run again.
TEST_F(Reproduce, MicroStudyTellsFrictionsApartAndResumes) {
  fs::copy(source / "datasets/scenes/micro_thesis.toml", folder_ / "data/scenes/micro_thesis.toml");
  change("table_4_1_micro_properties", "elastic_modulus,6.89", "elastic_modulus,0.05");
  change("micro_experiment_setup", "frames_used,25", "frames_used,9");
  change("micro_experiment_setup", "\nreplicates,5", "\nreplicates,3");
  change("resimulation", "micro,step_fraction,1;0.1", "micro,step_fraction,2;1");
  const ProgramOutcome first = reproduce({"study-micro"});
  EXPECT_EQ(first.status, 0) << first.err;
  EXPECT_EQ(verdict(first, "experiment at 0.1, simulation at 0.35: farther than one at 0.1"),
            "confirmed");
  EXPECT_EQ(verdict(first, "friction 0.1: RMS change by a tenth of the time step"), "confirmed");
  const fs::path kept = folder_ / "run/studies/study-micro-friction-0.1-step-1.json";
  const auto written = fs::last_write_time(kept);
  fs::remove(folder_ / "run/studies/study-micro-friction-0.2-step-1.json");
  EXPECT_EQ(reproduce({"study-micro"}).out, first.out);
  EXPECT_EQ(fs::last_write_time(kept), written);
}

// The shape study with four small, soft beds.
class ReproduceShapes : public Reproduce {
 protected:
  void SetUp() override {
    Reproduce::SetUp();
    std::string scene = content_of(source / "datasets/scenes/shape_study.toml");
    scene = with(scene, "elastic_modulus_gpa = 3.5", "elastic_modulus_mpa = 100");
    scene = with(scene, "longest_s = 5.0", "longest_s = 1.5");
    scene = with(scene, "duration_s = 1.4", "duration_s = 0.3");
    std::ofstream(folder_ / "data/scenes/shape_study.toml") << scene;
    change("table_5_1_parameters", "\nparticles,5000", "\nparticles,40");
    change("table_5_1_parameters", "hopper_width,100", "hopper_width,20");
    change("resimulation", "shape,seeds,3", "shape,seeds,1");
    change("resimulation", "heap,grains,600", "heap,grains,30");
    change("resimulation", "heap,stream_width,20", "heap,stream_width,15");
  }
};

// Without friction the floor bears the whole weight, whatever the shape.
TEST_F(ReproduceShapes, RestTheirWholeWeightOnTheFloor) {
  const ProgramOutcome outcome = reproduce({"study-shape"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  // Grains whose motion has only just died down still press a little unevenly.
  for (const char* ratio : {"1", "2"}) {
    const Json row = row_of(
        outcome, std::string("aspect ratio ") + ratio + ": force on the bottom off the weight");
    ASSERT_TRUE(row.at("simulated").is_number()) << ratio;
    EXPECT_LT(row.at("simulated").get<double>(), 0.1) << "% of the weight, aspect ratio " << ratio;
  }
  EXPECT_FALSE(verdict(outcome, "aspect ratio 4: grains rotate less than spheres").empty());
  EXPECT_FALSE(verdict(outcome, "aspect ratio 2: a steeper heap than that of spheres").empty());
  // Each run is stored by itself: one that is missing is run again alone, with the same numbers.
  const fs::path studies = folder_ / "run/studies";
  const auto written = fs::last_write_time(studies / "study-shape-aspect-ratio-1-bed-1.json");
  fs::remove(studies / "study-shape-aspect-ratio-2-bed-1.json");
  EXPECT_EQ(reproduce({"study-shape"}).out, outcome.out);
  EXPECT_EQ(fs::last_write_time(studies / "study-shape-aspect-ratio-1-bed-1.json"), written);
}

// What is drawn of a bed: every grain in one square of the mesh, nine marked ones that have not
// turned at first, ten tenths of a wall, classes of speed of which the fastest is never empty.
TEST_F(ReproduceShapes, AreKeptAsTheyAreDrawn) {
  ASSERT_EQ(reproduce({"study-shape"}).status, 0);
  std::ifstream file(folder_ / "run/studies/study-shape-aspect-ratio-4-bed-1.json");
  const Json bed = Json::parse(file).at("result");
  double area = 0.0;  // of all grains, in squares of 10 cm
  for (const Json& fraction : bed.at("squares").at("fraction"))
    area += 0.01 * fraction.get<double>();
  EXPECT_NEAR(area, 40 * 4.98697e-4, 1e-7) << "m2; table eq-5.1, aspect ratio 4";
  for (const Json& x : bed.at("squares").at("x"))
    EXPECT_NEAR(std::abs(x.get<double>()), 0.05, 1e-9);
  ASSERT_EQ(bed.at("marked").size(), 9u);
  for (const Json& grain : bed.at("marked")) {
    EXPECT_EQ(grain.at("turned").front(), 0.0);
    EXPECT_EQ(grain.at("x").size(), grain.at("sideways").size());
  }
  EXPECT_EQ(bed.at("wall_history").at("tenths").size(), 10u);
  EXPECT_GT(bed.at("floor_contacts"), 0);
  std::set<int> classes;
  for (const Json& of : bed.at("speed_classes").at("class")) classes.insert(of.get<int>());
  EXPECT_TRUE(classes.contains(2)) << "the fastest grain is fast";
  EXPECT_LE(*classes.rbegin(), 2);
  // Each figure of single beds has a menu of the four
  const std::string page = content_of(folder_ / "run/report.html");
  for (const std::string id : {"shape-map", "shape-turns", "shape-bands", "shape-wall-history"}) {
    const auto figure = page.find("id=\"" + id + "\"");
    ASSERT_NE(figure, std::string::npos) << id;
    EXPECT_NE(page.substr(figure, 1000).find(">4</option>"), std::string::npos) << id;
  }
}

// Table 5.2 reads the beds that study-shape has left, whatever tolerances and more beds are asked
// for since; no bed is run for it.
TEST_F(ReproduceShapes, GiveTable52ItsSimulatedSide) {
  const std::string skewness = "aspect ratio 3: skewness";
  EXPECT_TRUE(row_of(reproduce({"table-5.2"}), skewness).at("simulated").is_null());
  const ProgramOutcome study = reproduce({"study-shape"});
  ASSERT_EQ(study.status, 0) << study.err;
  // Three beds a shape contradict nothing: that takes five
  const Json result = Json::parse(study.out);
  EXPECT_EQ(result.at("verdicts").at("contradicted"), 0);

  change("resimulation", "shape,fraction_tolerance,2", "shape,fraction_tolerance,3");
  change("resimulation", "shape,seeds,1", "shape,seeds,2");
  const fs::path studies = folder_ / "run/studies";
  fs::remove(studies / "study-shape-aspect-ratio-4-bed-1.json");
  const ProgramOutcome table = reproduce({"table-5.2"});
  EXPECT_EQ(table.status, 0) << table.err;
  EXPECT_FALSE(fs::exists(studies / "study-shape-aspect-ratio-4-bed-1.json"));
  std::ifstream file(studies / "study-shape-aspect-ratio-3-bed-1.json");
  const Json row = row_of(table, skewness);
  EXPECT_EQ(row.at("simulated"), Json::parse(file).at("result").at("skewness"));
  EXPECT_EQ(row.at("seeds"), 1);
  EXPECT_TRUE(row_of(table, "aspect ratio 4: skewness").at("simulated").is_null());
  // Each row stands once, whether it was run or not
  EXPECT_EQ(read_rows(folder_ / "run/tables/table-5.2.csv").size(), 9u);
}

TEST_F(Reproduce, NeedsItsData) {
  fs::remove(folder_ / "data/thesis/errata.csv");
  const ProgramOutcome outcome = reproduce({"table-4.2"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("errata.csv"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(folder_ / "run"));
}

// The bundled tables are those that were read from the thesis.
TEST(ThesisTables, AreUntouched) {
  const fs::path original = source / "../shared/thesis/tables";
  if (!fs::exists(original)) GTEST_SKIP() << "the thesis is not beside the source folder";
  int compared = 0;
  for (const auto& entry : fs::directory_iterator(original)) {
    if (entry.path().extension() != ".csv") continue;
    EXPECT_EQ(content_of(source / "datasets/thesis" / entry.path().filename()),
              content_of(entry.path()))
        << entry.path().filename();
    ++compared;
  }
  EXPECT_GT(compared, 30);
}

}  // namespace
}  // namespace graintruth::tests
