#include "reports/report.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"
#include "fixture_run.h"

namespace graintruth::reports {
namespace {

using Json = nlohmann::ordered_json;
using tests::occurrences;
using tests::spoken;

// Each test has its own run folder, removed at its end.
class Report : public testing::Test {
 protected:
  void SetUp() override {
    root_ = tests::empty_folder(testing::UnitTest::GetInstance()->current_test_info()->name());
    folder_ = tests::write_fixture_run(root_);
  }
  void TearDown() override { std::filesystem::remove_all(root_); }

  Json read(const std::filesystem::path& file) { return Json::parse(datasets::read_whole(file)); }
  void write(const std::filesystem::path& file, const Json& json) {
    datasets::write_whole(file, json.dump());
  }

  std::filesystem::path root_;
  datasets::RunFolder folder_;
};

// The page without its scripts: what a reader reads.
std::string without_scripts(std::string page) {
  for (auto begin = page.find("<script"); begin != std::string::npos; begin = page.find("<script"))
    page.erase(begin, page.find("</script>", begin) + 9 - begin);
  return page;
}

TEST_F(Report, HasEverySectionInOrder) {
  const std::string page = build_report(folder_);
  std::size_t place = 0;
  for (const char* id : {"verdict",
                         "parameters",
                         "film-and-simulation",
                         "compared",
                         "agreement",
                         "tracks",
                         "search",
                         "time-step",
                         "films",
                         "method",
                         "provenance"}) {
    const std::size_t found = page.find(fmt::format("<section id=\"{}\"", id));
    ASSERT_NE(found, std::string::npos) << id;
    EXPECT_GT(found, place) << id;
    place = found;
  }
}

TEST_F(Report, CallsACalibrationACalibration) {
  const std::string page = build_report(folder_);
  EXPECT_NE(page.find("<title>Calibration report: Fixture"), std::string::npos);
  EXPECT_NE(page.find("a calibration and not a validation"), std::string::npos);
}

TEST_F(Report, CallsAComparisonAComparison) {
  Json result = read(folder_.result());
  result["kind"] = "validation";
  write(folder_.result(), result);
  const std::string page = build_report(folder_);
  EXPECT_NE(page.find("<title>Comparison at given parameters: Fixture"), std::string::npos);
  EXPECT_EQ(page.find("a calibration and not a validation"), std::string::npos);
}

TEST_F(Report, StatesTheParametersWithTheirIntervalsInASentence) {
  EXPECT_NE(spoken(build_report(folder_))
                .find("a friction between particles of 0.123 (95 % interval 0.104 to 0.140) and a "
                      "friction between particles "
                      "and walls of 0.171 (95 % interval 0.148 to 0.196)"),
            std::string::npos);
}

TEST_F(Report, SaysThatRestitutionIsNotIdentified) {
  EXPECT_NE(build_report(folder_).find("The restitution is not identified"), std::string::npos);
}

TEST_F(Report, TellsPriorsFromWhatTheFilmsSayAlone) {
  Json result = read(folder_.result());
  Json& wall = result["parameters"]["friction_particle_wall"];
  wall["prior"] = {{"mean", 0.31}, {"standard_uncertainty", 0.02}};
  wall["bench_standard_uncertainty"] = 0.02;
  wall["bench_deviation"] = -5.5;
  wall["data_alone"] = {{"value", 0.161}, {"lower", 0.132}, {"upper", 0.190}};
  Json& restitution = result["parameters"]["restitution"];
  restitution["prior"] = {{"mean", 0.83}, {"standard_uncertainty", 0.02}};
  restitution["lower"] = 0.791;
  restitution["upper"] = 0.869;
  write(folder_.result(), result);
  const std::string page = spoken(build_report(folder_));
  for (const char* words :
       {"Films and priors together give",
        "0.171 (95 % interval 0.148 to 0.196 with priors, 0.132 to 0.190 from the films alone)",
        "The restitution is not identified: what was compared hardly changes with it. Its value "
        "0.830 and its interval 0.791 to 0.869 rest on priors.",
        "0.31 ± 0.02",
        "0.35 ± 0.02",
        "Bench tests beside the films",
        "−5.5"})
    EXPECT_NE(page.find(words), std::string::npos) << words;
}

TEST_F(Report, PutsOtherScoresBesideTheAgreement) {
  const std::string page = spoken(build_report(folder_));
  EXPECT_NE(page.find("88.7 % of all values"), std::string::npos);
  EXPECT_NE(page.find("averaged over M = 10 runs would score 91.4 % on average. A sixth real "
                      "replicate would score 75.0 %"),
            std::string::npos);
  EXPECT_NE(
      page.find("2.7 points below that of a perfect model and above that of one more replicate"),
      std::string::npos);
  // The thesis's form has its place in the appendix, and nowhere else
  const auto appendix = page.find("<section id=\"thesis\"");
  ASSERT_NE(appendix, std::string::npos);
  for (const char* score : {"77.9 %", "81.5 %", "55.5 %"})
    EXPECT_GT(page.find(score), appendix) << score;
}

TEST_F(Report, ExplainsAScoreAboveThatOfAPerfectModel) {
  Json result = read(folder_.result());
  result["agreement"]["percent_student_t"] = 97.0;
  write(folder_.result(), result);
  EXPECT_NE(build_report(folder_).find("5.6 points above what a perfect model reaches on average. "
                                       "This is no contradiction"),
            std::string::npos);
}

TEST_F(Report, ShowsEveryNumberThatARunLeavesBehind) {
  const std::string page = without_scripts(spoken(build_report(folder_)));
  for (const char* number :
       {"0.123",       "0.104 to 0.140", "0.171",       "0.36",
        "0 to 0.6",  // parameters
        "90.2 %",      "79.1 %",         "66.2 %",      "51.3 %",
        "7.34 mm",                                                        // agreement
        "of 780",      "0.2389",         "0.0058",      "predicts 96 %",  // search
        "1.25 × 10⁻⁵", "0.2413",         "−0.00090",    "25 s",
        "0.0092",
        "0.0031",                                                         // time step
        "1.103",       "98.4 %",         "0.31",        "0.200 ± 0.006",  // films
        "112",         "1136",           "12 min 34 s", "0123456789abcdef",
        "9 min 58 s"})  // provenance
    EXPECT_NE(page.find(number), std::string::npos) << number;
}

TEST_F(Report, ShowsTheNoteTheWarningsAndTheCommand) {
  const std::string page = build_report(folder_);
  EXPECT_NE(page.find("a test wrote these numbers"), std::string::npos);
  EXPECT_NE(page.find("Fixture warning: the two frictions trade off"), std::string::npos);
  EXPECT_NE(page.find("rep3: Particle 9 is hidden for 4 frames."), std::string::npos);
  EXPECT_NE(page.find("graintruth calibrate fixture.toml --budget 112 --seed 7"),
            std::string::npos);
}

TEST_F(Report, EmbedsTheAnnotatedFrames) {
  EXPECT_EQ(occurrences(build_report(folder_), "<img src=\"data:image/jpeg;base64,/9j/"),
            10 + 3);  // and of film and simulation
}

TEST_F(Report, DoesNotFollowPicturesOutOfTheRunFolder) {
  const std::filesystem::path secret = root_.string() + ".outside.jpg";
  datasets::write_whole(secret, "outside");
  Json tracking = read(folder_.tracking());
  tracking["replicates"][0]["annotated_frames"] = {"../" + secret.filename().string(),
                                                   secret.string()};
  write(folder_.tracking(), tracking);
  const std::string page = build_report(folder_);
  std::filesystem::remove(secret);
  EXPECT_EQ(page.find("b3V0c2lkZQ=="), std::string::npos);  // "outside" in base 64
  EXPECT_NE(page.find("does not hold"), std::string::npos);
}

TEST_F(Report, EscapesHostileText) {
  const std::string hostile =
      "</script><script>alert('owned')</script><img src=x onerror=alert(1)>{{{style}}}";
  Json result = read(folder_.result());
  for (const char* key : {"title", "note", "experiment", "message", "status"})
    result[key] = hostile;
  result["warnings"] = {hostile};
  result["parameters"][hostile] = result["parameters"]["restitution"];
  write(folder_.result(), result);
  Json run = read(folder_.run());
  run["command"] = hostile;
  run["configuration"] = {{"key", hostile}};
  run["input_hashes"] = {{hostile, hostile}};
  write(folder_.run(), run);
  Json tracking = read(folder_.tracking());
  for (const char* key : {"name", "film", "grade"}) tracking["replicates"][0][key] = hostile;
  write(folder_.tracking(), tracking);

  const std::string page = build_report(folder_);
  EXPECT_EQ(page.find("<script>alert"), std::string::npos);
  EXPECT_EQ(page.find("<img src=x"), std::string::npos);
  EXPECT_NE(page.find("&lt;script&gt;alert(&apos;owned&apos;)"), std::string::npos);
  EXPECT_EQ(occurrences(page, ":root {"), 1) << "the template was expanded twice";
}

TEST_F(Report, SaysSoWhereAnOptionalFileIsAbsent) {
  std::filesystem::remove_all(root_ / "tables");
  std::filesystem::remove(folder_.tracking());
  std::filesystem::remove(folder_.measured());
  const std::string page = build_report(folder_);
  for (const char* sentence : {"(tables/ranks.csv) are absent",
                               "(tables/agreement.csv) is absent",
                               "(tables/bands.csv) are absent",
                               "(tables/evaluations.csv) is absent",
                               "no profiles (tables/profile.csv)",
                               "tracking.json is absent, empty or cannot be read"})
    EXPECT_NE(page.find(sentence), std::string::npos) << sentence;
  EXPECT_EQ(occurrences(page, "<figure class=\"plot\""), 2);  // parameters, time step
}

TEST_F(Report, IsMadeFromRunJsonAlone) {
  std::filesystem::remove_all(root_ / "tables");
  for (const auto& file : {folder_.tracking(), folder_.measured(), folder_.result()})
    std::filesystem::remove(file);
  const std::string page = build_report(folder_);
  EXPECT_NE(page.find("This run has no result yet"), std::string::npos);
  EXPECT_EQ(occurrences(page, "<figure class=\"plot\""), 0);
}

TEST_F(Report, SaysSoWhereTheTimeStepDidNotConverge) {
  Json result = read(folder_.result());
  result["time_step"]["converged"] = false;
  write(folder_.result(), result);
  EXPECT_NE(build_report(folder_).find("the results depend on the time step"), std::string::npos);
}

TEST_F(Report, LivesThroughNullNumbers) {
  Json result = read(folder_.result());
  for (auto& [key, value] : result["agreement"].items()) value = nullptr;
  for (auto& channel : result["channels"])
    for (const char* key : {"measured", "lower", "upper", "simulated"})
      for (auto& value : channel[key]) value = nullptr;
  for (auto& [name, parameter] : result["parameters"].items())
    for (auto& [key, value] : parameter.items()) value = nullptr;
  for (auto& row : result["time_step"]["study"]) row = {{"fraction", nullptr}};
  write(folder_.result(), result);
  EXPECT_EQ(without_scripts(build_report(folder_)).find(">nan"), std::string::npos);
}

TEST_F(Report, RefusesAFolderThatHoldsNoRun) {
  const datasets::RunFolder empty{root_ / "empty"};
  EXPECT_THROW(build_report(empty), datasets::InputError);
}

TEST_F(Report, NamesTheFileThatIsNotJson) {
  datasets::write_whole(folder_.result(), "{\"status\": ");
  const std::string page = build_report(folder_);
  EXPECT_NE(page.find("result.json is not valid JSON near byte"), std::string::npos);
  EXPECT_NE(page.find("result.json cannot be read"), std::string::npos);
  EXPECT_GT(occurrences(page, "<figure class=\"plot\""), 5);  // the tables are as good as before
}

TEST_F(Report, FollowsARunThatIsUnderWay) {
  write(folder_.progress(),
        {{"stage", "polish"},
         {"evaluations", 45},
         {"budget", 100},
         {"share", 0.52},
         {"best", 0.31},
         {"seconds", 250.0}});
  std::filesystem::copy(folder_.table("evaluations"), folder_.unfinished_table("evaluations"));
  const std::string page = build_report(folder_);
  EXPECT_NE(page.find("http-equiv=\"refresh\" content=\"10\""), std::string::npos);
  EXPECT_NE(spoken(page).find("45 of 100 evaluations, about 52.0 % done after 4 min 10 s. Lowest "
                              "objective so far: 0.31"),
            std::string::npos);
  EXPECT_EQ(page.find("0.1234"), std::string::npos) << "shows the result of an earlier run";
  EXPECT_EQ(occurrences(page, "<figure class=\"plot\""), 2);  // both of the search
  EXPECT_EQ(page.find("<section id=\"agreement\""), std::string::npos);
  EXPECT_EQ(page.find("What the intervals rest on"), std::string::npos);

  std::filesystem::remove(folder_.unfinished_table("evaluations"));
  EXPECT_NE(build_report(folder_).find("No evaluation has ended yet."), std::string::npos);
  datasets::remove_progress(folder_);
  EXPECT_EQ(build_report(folder_).find("http-equiv=\"refresh\""), std::string::npos);
}

TEST_F(Report, OneBadCellCostsOneSection) {
  const int figures = occurrences(build_report(folder_), "<figure class=\"plot\"");
  const std::string table = datasets::read_whole(folder_.table("evaluations"));
  datasets::write_whole(folder_.table("evaluations"), table + "113,x,x,x,x,x,x,x,x,x\n");
  const std::string page = build_report(folder_);
  EXPECT_NE(page.find("This section cannot be made"), std::string::npos);
  EXPECT_NE(page.find("evaluations.csv"), std::string::npos);
  EXPECT_EQ(occurrences(page, "<figure class=\"plot\""), figures - 3);
}

// Every file that a run leaves behind, by its path in the run folder
std::vector<std::filesystem::path> files_of(const std::filesystem::path& root) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

bool is_page(const std::string& page) { return page.find("</html>") != std::string::npos; }

TEST_F(Report, SaysWhichFileIsMissing) {
  for (const std::filesystem::path& file : files_of(root_)) {
    const std::string content = datasets::read_whole(file);
    std::filesystem::remove(file);
    const std::string page = build_report(folder_);
    EXPECT_TRUE(is_page(page)) << file;
    EXPECT_NE(page.find(file.filename().string()), std::string::npos) << file;
    datasets::write_whole(file, content);
  }
}

TEST_F(Report, ShowsFilmAndSimulationOnOneClock) {
  std::string page = build_report(folder_);
  for (const char* moment : {"0.00\u00a0s", "2.40\u00a0s", "4.80\u00a0s"})
    EXPECT_NE(page.find(fmt::format("data-moment=\"{}\"", moment)), std::string::npos) << moment;
  EXPECT_NE(page.find("Left: the film rep2"), std::string::npos);
  EXPECT_NE(page.find("starts from the mean of all films"), std::string::npos);
  EXPECT_NE(page.find("A particle has the same colour"), std::string::npos);
  std::string beside = datasets::read_whole(folder_.side_by_side_list());
  beside.insert(beside.find('{') + 1, "\"shows\": \"outline\", ");
  datasets::write_whole(folder_.side_by_side_list(), beside);
  page = build_report(folder_);
  EXPECT_NE(page.find("The line over it is the outline of the film."), std::string::npos);
  EXPECT_EQ(page.find("A particle has the same colour"), std::string::npos);
  const std::string content = datasets::read_whole(folder_.side_by_side_still(1));
  datasets::write_whole(folder_.side_by_side_still(1), content.substr(0, content.size() / 2));
  std::filesystem::remove(folder_.side_by_side_still(2));
  page = build_report(folder_);
  EXPECT_NE(page.find("missing or cut off: side_by_side/01.jpg and side_by_side/02.jpg."),
            std::string::npos);
  EXPECT_EQ(page.find("2.40\u00a0s\""), std::string::npos);
  std::filesystem::remove(folder_.side_by_side_list());
  page = build_report(folder_);
  EXPECT_NE(page.find("No film was shown beside a simulation"), std::string::npos);
}

TEST_F(Report, SaysWhichPictureOrJournalIsCutOff) {
  const std::string before = build_report(folder_);
  EXPECT_EQ(before.find("cut off"), std::string::npos);
  const std::filesystem::path picture = root_ / "tracks/rep1.first.jpg";
  const std::string content = datasets::read_whole(picture);
  datasets::write_whole(picture, content.substr(0, content.size() / 2));
  // Two pages of 4096 bytes, says the head
  std::string journal("SQLite format 3\0\x10\0", 18);
  journal.resize(2 * 4096);
  journal[31] = 2;
  datasets::write_whole(folder_.journal(), journal);
  std::string page = build_report(folder_);
  EXPECT_NE(page.find("Annotated frames that were cut off: tracks/rep1.first.jpg."),
            std::string::npos);
  EXPECT_EQ(page.find("journal.db was cut off"), std::string::npos);
  journal.resize(5000);
  datasets::write_whole(folder_.journal(), journal);
  page = build_report(folder_);
  EXPECT_NE(page.find("journal.db was cut off"), std::string::npos);
}

// Where no difference is allowed to a compatible value, there is no limit to draw.
TEST_F(Report, DrawsAProfileWithoutALimit) {
  const std::filesystem::path file = root_ / "tables/profile.csv";
  EXPECT_NE(build_report(folder_).find("Values below the dashed line"), std::string::npos);
  datasets::write_whole(file,
                        "parameter,value,objective,excess,allowed_excess,compatible\n"
                        "friction_particle_wall,0.1,1.5,0.5,0,0\n"
                        "friction_particle_wall,0.2,1,0,0,1\n");
  const std::string page = build_report(folder_);
  EXPECT_EQ(page.find("Values below the dashed line"), std::string::npos);
  EXPECT_NE(page.find("explain none of these differences"), std::string::npos);
}

// Cut off, emptied, or with bytes that nobody wrote: a page all the same.
TEST_F(Report, LivesThroughDamageToAnyFile) {
  const std::vector<std::filesystem::path> files = files_of(root_);
  ASSERT_GE(files.size(), 12u);
  std::mt19937 random(2000);
  for (const std::filesystem::path& file : files) {
    if (file.extension() == ".jpg" && file.filename() != "rep1.first.jpg") continue;
    const std::string content = datasets::read_whole(file);
    std::vector<std::string> damaged = {"", content.substr(0, content.size() / 2), "[]"};
    for (const char* letters : {"\x00\xff{}[]\",:", "0123456789-.e", "xyz,\n"}) {
      const std::string_view alphabet(letters, letters[0] == '\0' ? 10 : std::strlen(letters));
      std::string garbled = content;
      for (std::size_t i = 0; i < 1 + garbled.size() / 50; ++i)
        garbled[random() % garbled.size()] = alphabet[random() % alphabet.size()];
      damaged.push_back(garbled);
    }
    for (const std::string& bytes : damaged) {
      datasets::write_whole(file, bytes);
      EXPECT_NO_THROW(EXPECT_TRUE(is_page(build_report(folder_)))) << file << "\n" << bytes;
    }
    datasets::write_whole(file, content);
  }
}

// Every value and every part of a JSON file, as its path from the root.
std::vector<Json::json_pointer> places_in(const Json& json,
                                          const Json::json_pointer& root = Json::json_pointer()) {
  std::vector<Json::json_pointer> all;
  const auto add = [&](const Json::json_pointer& place, const Json& value) {
    all.push_back(place);
    const auto inner = places_in(value, place);
    all.insert(all.end(), inner.begin(), inner.end());
  };
  if (json.is_object()) {
    for (const auto& [name, value] : json.items()) add(root / name, value);
  } else if (json.is_array()) {
    for (std::size_t i = 0; i < json.size(); ++i) add(root / i, json[i]);
  }
  return all;
}

// Valid JSON that says what cannot be, where somebody edited a file or another program wrote it.
TEST_F(Report, LivesThroughImpossibleValuesInAnyFile) {
  constexpr int changes = 8;  // of each file
  const std::vector<Json> impossible = {nullptr,
                                        "text",
                                        -1,
                                        0,
                                        1e308,
                                        -1e308,
                                        std::numeric_limits<std::uint64_t>::max(),
                                        Json::array(),
                                        Json::object(),
                                        {{"value", nullptr}},
                                        Json::array({Json::array({1, "text"})}),
                                        true};
  std::mt19937 random(21);
  for (const auto& file :
       {folder_.result(), folder_.run(), folder_.measured(), folder_.tracking()}) {
    const Json whole = read(file);
    const std::vector<Json::json_pointer> places = places_in(whole);
    for (int i = 0; i < changes; ++i) {
      Json changed = whole;
      const Json::json_pointer& place = places[random() % places.size()];
      const std::size_t how = random() % (impossible.size() + 2);
      if (how < impossible.size()) {
        changed[place] = impossible[how];
      } else if (Json& parent = changed[place.parent_pointer()]; parent.is_array()) {
        parent.push_back("more");
      } else if (how == impossible.size()) {
        parent.erase(place.back());
      } else {
        parent["more"] = 1e308;
      }
      write(file, changed);
      EXPECT_NO_THROW(EXPECT_TRUE(is_page(build_report(folder_))))
          << file << " " << place.to_string() << ": " << changed.dump().substr(0, 400);
    }
    write(file, whole);
  }
}

// In the order of the run's files, under the names and with the units of the registry.
TEST_F(Report, ListsWhateverParametersTheRunHas) {
  const std::string piston = "friction_particle_piston";
  datasets::write_whole(folder_.table("influence"),
                        "left_out," + piston + ",hardness_of_rain,objective\nrep1,0.25,7.5,0.3\n");
  datasets::write_whole(folder_.table("evaluations"),
                        "evaluation,stage,restitution," + piston +
                            ",hardness_of_rain,objective,best,agreement_percent,failed,seconds\n"
                            "1,design,0.8,0.1,3,2,2,,0,1\n2,design,0.8,0.2,5,1,1,,0,1\n");
  Json result = read(folder_.result());
  result["parameters"]["hardness_of_rain"] = result["parameters"]["restitution"];
  result["parameters"]["hardness_of_rain"]["unit"] = "N/m2";
  for (auto& row : result["time_step"]["study"]) row = {{piston, 0.3125}, {"fraction", 0.1}};
  for (const char* form : {"smooth", "requested"})
    result["objective"]["by_form"].push_back(
        {{"form", form}, {"parameters", {{"hardness_of_rain", 4.75}, {piston, 0.375}}}});
  write(folder_.result(), result);
  const std::string page = build_report(folder_);
  // Tables: influence, forms of the objective, time step
  const std::string title = ">Friction, particle to piston<";
  EXPECT_NE(page.find("7.50"), std::string::npos);
  EXPECT_NE(page.find("0.3125"), std::string::npos);
  EXPECT_NE(page.find("4.75"), std::string::npos);
  EXPECT_EQ(occurrences(page, title), 3);
  EXPECT_LT(page.find(">hardness of rain<", page.find("The best evaluation by either form")),
            page.find(title, page.find("The best evaluation by either form")));
  // Figures: the plane of the two that were moved, intervals by unit
  EXPECT_NE(page.find("\"xaxis\":{\"title\":{\"text\":\"Friction, particle to piston\"}}"),
            std::string::npos);
  EXPECT_NE(page.find("\"yaxis\":{\"title\":{\"text\":\"hardness of rain\"}}"), std::string::npos);
  EXPECT_NE(page.find("\"Value (N/m²)\""), std::string::npos);
  EXPECT_NE(page.find("\"Value (dimensionless)\""), std::string::npos);
}

// One parameter that the search moved: against the objective.
TEST_F(Report, DrawsTheSearchOfASingleParameter) {
  datasets::write_whole(folder_.table("evaluations"),
                        "evaluation,stage,restitution,objective,best,failed\n"
                        "1,design,0.8,2,2,0\n2,design,0.9,1,1,0\n");
  const std::string page = build_report(folder_);
  EXPECT_NE(page.find("\"yaxis\":{\"title\":{\"text\":\"Objective\"}}"), std::string::npos);
  EXPECT_NE(page.find("\"text\":\"Restitution\"}}"), std::string::npos);
  EXPECT_EQ(page.find("A long dark valley"), std::string::npos);
}

TEST_F(Report, IsTheSameBytesForTheSameFolder) {
  EXPECT_EQ(build_report(folder_), build_report(folder_));
}

TEST_F(Report, IsWrittenIntoTheRunFolder) {
  write_report(folder_);
  EXPECT_EQ(datasets::read_whole(folder_.report()), build_report(folder_));
}

TEST_F(Report, ForbidsAndNeedsNoNetwork) {
  const std::string page = build_report(folder_);
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
  const std::string read_by_browser = without_scripts(page);
  for (const char* address : {"http://", "https://", "url(", "@import", "src=\"/", "<link"})
    EXPECT_EQ(read_by_browser.find(address), std::string::npos) << address;
}

// The page without its style and its scripts.
std::string body_of(const std::string& page) {
  const auto first = page.find("<body>");
  return page.substr(first, page.find("</main>") - first);
}

// What stands between `before` and the next quotation mark, wherever `before` occurs.
std::vector<std::string> quoted_after(const std::string& page, const std::string& before) {
  std::vector<std::string> all;
  for (auto at = page.find(before); at != std::string::npos; at = page.find(before, at + 1)) {
    const auto first = at + before.size();
    all.push_back(page.substr(first, page.find('"', first) - first));
  }
  return all;
}

TEST_F(Report, ContentsLeadToSectionsThatAreThere) {
  const std::string page = body_of(build_report(folder_));
  const std::vector<std::string> links = quoted_after(page, "<a href=\"#");
  EXPECT_GE(links.size(), 9u);
  for (const std::string& id : links) EXPECT_EQ(occurrences(page, " id=\"" + id + "\""), 1) << id;
}

// All that can be operated can be reached by keyboard, and has words for who cannot see it.
TEST_F(Report, CanBeOperatedAndReadWithoutAMouseAndWithoutAPicture) {
  const std::string page = body_of(build_report(folder_));
  EXPECT_EQ(occurrences(page, "class=\"table-box\""),
            occurrences(page, "class=\"table-box\" tabindex=\"0\""));
  EXPECT_EQ(occurrences(page, "<table"),
            occurrences(page, "<table aria-label=\"") +
                occurrences(page, "<table class=\"wide\" aria-label=\""));
  for (const std::string& id : quoted_after(page, "<select id=\""))
    EXPECT_EQ(occurrences(page, "<label for=\"" + id + "\">"), 1) << id;
  EXPECT_EQ(
      occurrences(page, "<button type=\"button\""),
      occurrences(page, "aria-label=\"Next\"") + occurrences(page, "aria-label=\"Previous\""));
  const std::vector<std::string> described = quoted_after(page, "\" alt=\"");
  EXPECT_EQ(occurrences(page, "<img src="), static_cast<int>(described.size()));
  for (const std::string& words : described) EXPECT_NE(words, "");
}

// Web Content Accessibility Guidelines 2.1, 1.4.3 and 1.4.11: text stands out from what is behind
// it by 4.5, what is drawn by 3.
double contrast(const std::string& style, const std::string& front, const std::string& back) {
  const auto luminance = [&](const std::string& name) {
    const auto at = style.find("--" + name + ": #");
    if (at == std::string::npos) throw std::out_of_range("no colour " + name);
    const std::string digits = style.substr(at + name.size() + 5, 6);
    double sum = 0.0;
    constexpr double weights[] = {0.2126, 0.7152, 0.0722};
    for (int i = 0; i < 3; ++i) {
      const double part = std::stoi(digits.substr(2 * i, 2), nullptr, 16) / 255.0;
      sum += weights[i] * (part <= 0.04045 ? part / 12.92 : std::pow((part + 0.055) / 1.055, 2.4));
    }
    return sum;
  };
  const double a = luminance(front), b = luminance(back);
  return (std::max(a, b) + 0.05) / (std::min(a, b) + 0.05);
}

TEST_F(Report, StandsOutFromItsGroundByDayAndByNight) {
  const std::string page = build_report(folder_);
  const std::string style = page.substr(page.find("<style>"), page.find("</style>"));
  const auto night = style.find("prefers-color-scheme: dark");
  ASSERT_NE(night, std::string::npos);
  for (const std::string& colours : {style.substr(0, night), style.substr(night)}) {
    const std::string when = colours.size() == night ? " by day" : " by night";
    for (const char* text : {"ink", "muted", "accent", "warn", "good", "bad"}) {
      for (const char* ground : {"paper", "panel"})
        EXPECT_GE(contrast(colours, text, ground), 4.5) << text << " on " << ground << when;
    }
    EXPECT_GE(contrast(colours, "ink", "warn-panel"), 4.5) << when;
    for (const char* drawn : {"measured-strong",
                              "simulated",
                              "stage0",
                              "stage1",
                              "stage2",
                              "stage3",
                              "stage4",
                              "stage5"})
      EXPECT_GE(contrast(colours, drawn, "paper"), 3.0) << drawn << when;
  }
}

TEST(FlowReport, TellsWhatWasPredictedFromWhatWasFitted) {
  const std::filesystem::path root = tests::empty_folder("FlowReport");
  const std::string page = build_report(tests::write_fixture_flow_run(root / "run"));
  std::filesystem::remove_all(root);
  EXPECT_NE(page.find("Calibration and validation report"), std::string::npos);
  EXPECT_NE(page.find("Predicted, not fitted: the flow through 50\u00a0mm"), std::string::npos);
  EXPECT_NE(page.find("Fitted to the flow through 100\u00a0mm"), std::string::npos);
  // |E| = 6 g/s against 2 u_val = 4.24 g/s; and 2 against 12
  EXPECT_NE(page.find("differs"), std::string::npos);
  EXPECT_NE(page.find("no difference shown"), std::string::npos);
  EXPECT_NE(page.find("not bounded"), std::string::npos);
  EXPECT_EQ(page.find("id=\"agreement\""), std::string::npos);
  EXPECT_EQ(page.find("id=\"tracks\""), std::string::npos);
}

TEST(FlowReport, CallsTheWayOutAnExitWhereThereIsNoOrifice) {
  const std::filesystem::path root = tests::empty_folder("FlowReport");
  const datasets::RunFolder folder = tests::write_fixture_flow_run(root / "run");
  Json result = Json::parse(datasets::read_whole(folder.result()));
  Json row = result["comparison"][1];
  row["orifice_m"] = nullptr;
  result["comparison"] = Json::array({row});
  result.erase("kinematic");
  result.erase("beverloo");
  datasets::write_whole(folder.result(), result.dump());
  datasets::write_whole(
      folder.table("discharge_curves"),
      "orifice_m,time_s,filmed_count,filmed_lower,filmed_upper,simulated_count,"
      "simulated_lower,simulated_upper\n,0,0,0,0,0,0,0\n,0.1,17,16,18,17,15,19\n");
  const std::string page = build_report(folder);
  std::filesystem::remove_all(root);
  EXPECT_NE(page.find("Fitted to the flow through the exit"), std::string::npos);
  EXPECT_NE(page.find("id=\"flow-curves\""), std::string::npos);
  EXPECT_EQ(page.find("id=\"flow-beverloo\""), std::string::npos);
  for (const char* wrong : {"inf\u00a0mm", "nan\u00a0mm"})
    EXPECT_EQ(page.find(wrong), std::string::npos) << wrong;
}

}  // namespace
}  // namespace graintruth::reports
