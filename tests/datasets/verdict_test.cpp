// The verdict by its rules, one after the other, on results that differ by what each rule looks at.
#include "datasets/verdict/verdict.h"

#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "datasets/verdict/warning.h"

namespace graintruth::datasets {
namespace {

using Json = nlohmann::ordered_json;

int words_in(const std::string& text) {
  std::istringstream stream(text);
  int count = 0;
  for (std::string word; stream >> word;) ++count;
  return count;
}

Json tuned(const char* lower_end, const char* upper_end) {
  return {{"value", 0.12},
          {"status", "tuned"},
          {"lower", 0.1},
          {"upper", 0.14},
          {"lower_end", lower_end},
          {"upper_end", upper_end}};
}

// Ten particles that score `percent` each, give or take 1.
Json agreement(double percent, int replicates = 5) {
  Json json = {{"percent_student_t", percent},
               {"ceiling_percent_student_t", 91.4},
               {"leave_one_out_percent_student_t", replicates < 3 ? Json() : Json(75.0)},
               {"replicates", replicates}};
  for (int i = 0; i < 10; ++i)
    json["per_particle"].push_back({{"percent_student_t", percent + (i % 2 == 0 ? 1.0 : -1.0)}});
  return json;
}

Json good() {
  return {{"kind", "calibration"},
          {"parameters",
           {{"friction_particle_particle", tuned("found", "found")},
            {"restitution", {{"value", 0.8}, {"status", "not_identified"}}}}},
          {"agreement", agreement(91.0)},
          {"first_line_warnings", Json::array()}};
}

// A channel of numbers in one condition each: 1 +- 0.1, simulated at these.
Json numbers_of(std::initializer_list<double> simulated, bool held_out = false) {
  Json channels = Json::array();
  for (const double value : simulated) {
    channels.push_back({{"observable", "bulk_density"},
                        {"title", "Bulk density"},
                        {"measured", {1.0}},
                        {"lower", {0.9}},
                        {"upper", {1.1}},
                        {"simulated", {value}},
                        {"held_out", held_out}});
  }
  return channels;
}

TEST(Verdict, AgreesAndNamesWhatTheDataDoNotDetermine) {
  const Verdict verdict = judge(good());
  EXPECT_EQ(verdict.mark, Mark::agrees);
  EXPECT_NE(verdict.reason.find("These data do not determine restitution."), std::string::npos);
  EXPECT_NE(verdict.reason.find("91 % of the simulated values"), std::string::npos);
}

TEST(Verdict, CannotBeJudgedWhereNothingWasCompared) {
  Json result = good();
  result.erase("agreement");
  EXPECT_EQ(judge(result).mark, Mark::cannot_be_judged);
  EXPECT_EQ(judge(Json::object()).mark, Mark::cannot_be_judged);
  result["channels"] = numbers_of({1.0});
  EXPECT_EQ(judge(result).mark, Mark::agrees);
  result["channels"][0]["lower"] = {nullptr};
  EXPECT_EQ(judge(result).mark, Mark::cannot_be_judged);
}

TEST(Verdict, CannotBeJudgedWhereMostSimulationsFailed) {
  Json result = good();
  result["failed"] = 5;
  result["simulations"] = 10;
  EXPECT_EQ(judge(result).mark, Mark::agrees);
  result["failed"] = 6;
  result["agreement"] = agreement(0.0);
  EXPECT_EQ(judge(result).mark, Mark::cannot_be_judged);
  EXPECT_EQ(judge(result).reason, "6 of 10 simulations failed.");
}

TEST(Verdict, DoesNotAgreeWhereAFurtherReplicateWouldAgreeMore) {
  Json result = good();
  result["agreement"] = agreement(74.0);
  Verdict verdict = judge(result);
  EXPECT_EQ(verdict.mark, Mark::does_not_agree);
  EXPECT_EQ(verdict.reason,
            "Only 74 % of the simulated values lie inside the replicates' interval (a further "
            "replicate: 75 %).");
  // What may be the cause is named
  add_warnings(std::array{first_line("Long.", "the film is another rig's", "Look at the rig")},
               result);
  verdict = judge(result);
  EXPECT_NE(verdict.reason.find("The film is another rig's."), std::string::npos);
  EXPECT_EQ(verdict.next_step, "Look at the rig");
}

// Particles differ by 1 from each other, so that their mean is known to 0.75.
TEST(Verdict, HasReservationsBetweenAFurtherReplicateAndAPerfectModel) {
  Json result = good();
  result["agreement"] = agreement(90.8);
  EXPECT_EQ(judge(result).mark, Mark::agrees);
  result["agreement"] = agreement(90.5);
  EXPECT_EQ(judge(result).mark, Mark::agrees_with_reservations);
}

TEST(Verdict, CannotBeJudgedByTwoReplicates) {
  Json result = good();
  result["agreement"] = agreement(95.0, 2);
  const Verdict verdict = judge(result);
  EXPECT_EQ(verdict.mark, Mark::cannot_be_judged);
  EXPECT_NE(verdict.reason.find("With 2 replicates"), std::string::npos);
}

TEST(Verdict, TellsAnEndedBudgetFromDataThatDoNotDetermine) {
  // 1. The budget ended: nothing is known, whatever the score
  Json result = good();
  result["parameters"] = {{"friction_particle_wall", tuned("budget_ended", "budget_ended")}};
  Verdict verdict = judge(result);
  EXPECT_EQ(verdict.mark, Mark::cannot_be_judged);
  EXPECT_NE(verdict.reason.find("The budget ended before the interval"), std::string::npos);
  EXPECT_NE(verdict.next_step.find("--budget"), std::string::npos);
  result["agreement"] = agreement(20.0);
  verdict = judge(result);
  EXPECT_EQ(verdict.mark, Mark::cannot_be_judged);
  EXPECT_NE(verdict.reason.find("The budget ended before the search did"), std::string::npos);
  // 2. It ended after a part of the intervals
  result = good();
  result["parameters"]["friction_particle_wall"] = tuned("found", "budget_ended");
  verdict = judge(result);
  EXPECT_EQ(verdict.mark, Mark::agrees_with_reservations);
  EXPECT_EQ(verdict.reason,
            "The budget ended before the interval of friction between particles and walls was "
            "found.");
  // 3. The data do not determine
  result["parameters"] = {{"restitution", {{"status", "not_identified"}}}};
  verdict = judge(result);
  EXPECT_EQ(verdict.mark, Mark::cannot_be_judged);
  EXPECT_EQ(verdict.reason.find("budget"), std::string::npos);
  EXPECT_NE(verdict.reason.find("these data do not determine it"), std::string::npos);
  // 4. An open end is what the data say
  result["parameters"] = {{"friction_particle_wall", tuned("found", "open")}};
  EXPECT_EQ(judge(result).mark, Mark::agrees);
}

TEST(Verdict, IsLoweredByWarningsOfTheFirstLineAlone) {
  Json result = good();
  add_warnings(std::array<Warning, 1>{Warning("An assumption.")}, result);
  EXPECT_EQ(judge(result).mark, Mark::agrees);
  EXPECT_EQ(result["warnings"], Json({"An assumption."}));
  const std::array all = {Warning("An assumption."),
                          first_line("Three of nine failed.", "3 of 9 simulations failed", "Look"),
                          first_line("The step.", "the time step is not resolved", "Refine"),
                          first_line("The film.", "a film is of another rig", "Check"),
                          first_line("The slope.", "the slope is another", "Measure")};
  add_warnings(all, result);
  EXPECT_EQ(result["warnings"][0], "Three of nine failed.");
  EXPECT_EQ(result["warnings"][4], "An assumption.");
  const Verdict verdict = judge(result);
  EXPECT_EQ(verdict.mark, Mark::agrees_with_reservations);
  EXPECT_EQ(verdict.reason,
            "3 of 9 simulations failed. The time step is not resolved. A film is of another rig. 1 "
            "more below.");
  EXPECT_EQ(verdict.next_step, "Look");
}

TEST(Verdict, NamesABoundOfTheSearch) {
  Json result = good();
  result["parameters"]["friction_particle_particle"]["status"] = "at_bound";
  const Verdict verdict = judge(result);
  EXPECT_EQ(verdict.mark, Mark::agrees_with_reservations);
  EXPECT_EQ(verdict.reason, "Friction between particles ended at a bound of the search.");
}

// 0.1 is half of the interval, so that 0.141 is allowed: both means scatter.
TEST(Verdict, AllowsNumbersTheScatterOfBothMeans) {
  Json result = good();
  result.erase("agreement");
  result["channels"] = numbers_of({1.14});
  EXPECT_EQ(judge(result).mark, Mark::agrees);
  result["channels"] = numbers_of({1.142});
  EXPECT_EQ(judge(result).mark, Mark::does_not_agree);
  // Of ten a single one is beyond by chance with 40 %, two with 9 %, three with 1 %
  result["channels"] = numbers_of({1, 1, 1, 1, 1, 1, 1, 1, 1.2, 1.2});
  EXPECT_EQ(judge(result).mark, Mark::agrees);
  result["channels"] = numbers_of({1, 1, 1, 1, 1, 1, 1, 1.2, 1.2, 1.2});
  EXPECT_EQ(judge(result).mark, Mark::agrees_with_reservations);
  EXPECT_EQ(judge(result).reason, "Bulk density: 3 of 10 values differ by more than chance.");
  // Columns that vary together differ together
  result["channels"][0]["independent_values"] = 2.0;
  EXPECT_EQ(judge(result).mark, Mark::agrees);
  result["channels"][0]["independent_values"] = 9.0;
  EXPECT_EQ(judge(result).mark, Mark::agrees_with_reservations);
}

TEST(Verdict, JudgesWhatWasPredictedByItself) {
  Json result = good();
  result["channels"] = numbers_of({1.0, 1.0, 1.0});
  result["channels"].push_back(numbers_of({1.5}, true)[0]);
  const Verdict verdict = judge(result);
  EXPECT_EQ(verdict.mark, Mark::does_not_agree);
  EXPECT_EQ(verdict.reason, "Bulk density (predicted, not fitted) differs by more than chance.");
}

TEST(Verdict, ComparesRatesByTheirOwnUncertainty) {
  Json result = good();
  result.erase("agreement");
  result["comparison"] = {{{"error_kg_per_s", 0.019}, {"validation_uncertainty_kg_per_s", 0.01}}};
  EXPECT_EQ(judge(result).mark, Mark::agrees);
  result["comparison"][0]["error_kg_per_s"] = -0.021;
  EXPECT_EQ(judge(result).mark, Mark::does_not_agree);
}

// A direction of 179 degrees is 2 degrees from one of 1.
TEST(Verdict, ComparesDirectionsOfTracksModuloHalfATurn) {
  Json result = good();
  result.erase("agreement");
  result["channels"] = {{{"observable", "tracks"},
                         {"unit", "m, m, rad"},
                         {"axis", {{"values", {0.0, 0.1}}}},
                         {"measured", {0, 0, 0.02, 0, 0, 0.02}},
                         {"lower", {-1, -1, -0.1, -1, -1, -0.1}},
                         {"upper", {1, 1, 0.14, 1, 1, 0.14}},
                         {"simulated", {0, 0, 3.12, 0, 0, 3.12}}}};
  EXPECT_EQ(judge(result).mark, Mark::agrees);
}

TEST(Verdict, OfSeveralExperimentsIsThatOfTheWorst) {
  Json result = good();
  result.erase("agreement");
  result["experiments"] = {{{"name", "piston"}, {"verdict", {{"mark", "agrees"}}}},
                           {{"name", "bin"}, {"verdict", {{"mark", "agrees_with_reservations"}}}}};
  EXPECT_EQ(judge(result).mark, Mark::agrees_with_reservations);
  EXPECT_NE(judge(result).reason.find("xperiment bin"), std::string::npos);
  result["experiments"][0]["verdict"]["mark"] = "does_not_agree";
  EXPECT_EQ(judge(result).mark, Mark::does_not_agree);
}

TEST(Verdict, OfAComparisonKnowsNothingOfParameters) {
  Json result = good();
  result["kind"] = "validation";
  result["parameters"] = {{"restitution", {{"value", 0.8}, {"status", "fixed"}}}};
  EXPECT_EQ(judge(result).mark, Mark::agrees);
}

// Whatever is said, it is said in a few words.
TEST(Verdict, IsShortWhateverThereIsToSay) {
  Json result = good();
  std::vector<Warning> warnings;
  for (int i = 0; i < 6; ++i)
    warnings.push_back(
        first_line("Long.",
                   "one two three four five six seven eight nine ten eleven twelve thirteen",
                   "one two three four five six seven eight nine ten eleven"));
  add_warnings(warnings, result);
  result["agreement"] = agreement(80.0);
  result["parameters"]["friction_particle_wall"] = tuned("budget_ended", "budget_ended");
  EXPECT_LE(words_in(sentence_of(judge(result))), 45) << sentence_of(judge(result));
  result["agreement"] = agreement(10.0);
  EXPECT_LE(words_in(sentence_of(judge(result))), 45) << sentence_of(judge(result));
  result["parameters"] = good()["parameters"];
  EXPECT_LE(words_in(sentence_of(judge(result))), 45) << sentence_of(judge(result));
}

TEST(Verdict, IsReadBackAsItWasWritten) {
  Json result = good();
  EXPECT_FALSE(verdict_in(result).has_value());
  add_verdict(result);
  const auto read = verdict_in(result);
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(sentence_of(*read), result["verdict"]["sentence"].get<std::string>());
}

}  // namespace
}  // namespace graintruth::datasets
