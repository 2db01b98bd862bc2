// Whole calibrations by the built program, on tracks: what they leave behind, that threads change
// nothing, and that neither kill -9 nor Ctrl-C loses or repeats a simulation.
#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <thread>
#include <tuple>

#include "calibrate/journal.h"
#include "tests/app/documented_tables.h"
#include "tests/app/laboratory.h"
#include "tests/support/run_program.h"

namespace graintruth::tests {
namespace {

using Json = nlohmann::json;

class CalibrationRun : public testing::Test {
 protected:
  void SetUp() override {
    write_tracks_of_truth(folder_);
    experiment_ = folder_.write("experiment.toml", track_experiment());
  }

  std::vector<std::string> calibrate(const std::string& out, int jobs = 2) const {
    return {"calibrate",
            experiment_,
            "--budget",
            "20",
            "--out",
            folder_ / out,
            "--jobs",
            std::to_string(jobs),
            "--quiet"};
  }

  Json json(const std::string& file) const { return Json::parse(content_of(folder_ / file)); }

  // result.json without what the clock put there.
  Json timeless_result(const std::string& out) const {
    Json result = json(out + "/result.json");
    result.erase("wall_time_s");
    for (Json& row : result["time_step"]["study"]) row.erase("cpu_seconds");
    return result;
  }

  // Everything that identifies a simulation, then what the first to run it wrote: its row number
  // and the seconds that it took.
  using Rows = std::map<std::string, std::pair<std::int64_t, double>>;  // by fingerprint
  Rows journal(const std::string& out) const {
    Rows rows;
    if (!std::filesystem::exists(folder_ / out / "journal.db")) return rows;
    calibrate::Journal journal(folder_ / out / "journal.db", calibrate::Journal::Use::reading);
    for (const calibrate::JournalRow& row : journal.rows()) {
      const bool is_new = rows.emplace(row.fingerprint, std::pair(row.id, row.run.seconds)).second;
      EXPECT_TRUE(is_new) << "a simulation stands twice in the journal";
    }
    return rows;
  }

  // Simulations in the journal of a program that runs; none before it made the journal its own.
  double rows_so_far(const std::string& out) const {
    if (!std::filesystem::exists(folder_ / out / "journal.db-wal")) return 0;
    return static_cast<double>(journal(out).size());
  }

  static void expect_kept(const Rows& before, const Rows& after) {
    for (const auto& [request, row] : before) {
      const auto found = after.find(request);
      ASSERT_NE(found, after.end());
      EXPECT_EQ(found->second, row);
    }
  }

  TemporaryFolder folder_;
  std::string experiment_;
};

TEST_F(CalibrationRun, LeavesWhatIsPromisedAndIsJudgedByIt) {
  // 1. The files
  std::vector<std::string> arguments = calibrate("run");
  arguments.push_back("--watch");
  const ProgramOutcome outcome = run_program(arguments);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  for (const char* gone : {"progress.json", "tables/evaluations.unfinished.csv"})
    EXPECT_FALSE(std::filesystem::exists(folder_ / "run" / gone)) << gone;
  EXPECT_EQ(content_of(folder_ / "run/report.html").find("http-equiv=\"refresh\""),
            std::string::npos);
  for (const char* file : {"run.json",
                           "tracking.json",
                           "measured.json",
                           "journal.db",
                           "journal.csv",
                           "result.json",
                           "report.html",
                           "tracks/rep1.csv",
                           "tracks/rep5.csv",
                           "tables/agreement.csv",
                           "tables/evaluations.csv"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_ / "run" / file)) << file;
  }
  for (const auto& file : std::filesystem::recursive_directory_iterator(folder_ / "run"))
    EXPECT_NE(file.path().extension(), ".unfinished") << file.path();

  EXPECT_EQ(undocumented_tables(folder_ / "run",
                                {"Tables of every run", "Tables of particles that are followed"}),
            std::vector<std::string>());

  // 2. The keys of result.json
  const Json result = json("run/result.json");
  for (const char* key : {"status",
                          "message",
                          "experiment",
                          "parameters",
                          "time_step",
                          "agreement",
                          "rms_position_m",
                          "evaluations",
                          "failed",
                          "wall_time_s",
                          "warnings"}) {
    EXPECT_TRUE(result.contains(key)) << key;
  }
  for (const char* name : {"friction_particle_particle", "friction_particle_wall", "restitution"}) {
    const Json& parameter = result["parameters"][name];
    EXPECT_TRUE(parameter["value"].is_number() && parameter["unit"] == "-") << name;
    const std::string status = parameter["status"];
    EXPECT_TRUE(status == "tuned" || status == "at_bound" || status == "not_identified") << status;
    EXPECT_EQ(parameter.contains("lower"), status != "not_identified") << name;
    EXPECT_EQ(parameter.contains("upper"), status != "not_identified") << name;
  }
  for (const char* key : {"fraction", "seconds", "discretisation_error"})
    EXPECT_TRUE(result["time_step"][key].is_number()) << key;
  for (const char* key : {"percent",
                          "percent_student_t",
                          "ceiling_percent",
                          "leave_one_out_percent",
                          "single_run_median_percent"}) {
    EXPECT_TRUE(result["agreement"][key].is_number()) << key;
  }
  EXPECT_EQ(result["agreement"]["seeds"], 10);
  EXPECT_EQ(result["agreement"]["per_particle"].size(), 10u);

  // 3. The report can be made anew, the same to the byte
  const std::string report = content_of(folder_ / "run/report.html");
  EXPECT_EQ(run_program({"report", folder_ / "run"}).status, 0);
  EXPECT_EQ(content_of(folder_ / "run/report.html"), report);

  // 4. Its parameters, judged by a requirement
  const auto validate = [&](const std::string& required) {
    return run_program({"validate",
                        experiment_,
                        "--parameters",
                        folder_ / "run/result.json",
                        "--require-agreement",
                        required,
                        "--out",
                        folder_ / "validation",
                        "--quiet"});
  };
  const ProgramOutcome missed = validate("100");
  EXPECT_EQ(missed.status, 1);
  EXPECT_NE(missed.err.find("below the required 100.0 %"), std::string::npos) << missed.err;
  EXPECT_EQ(validate("0").status, 0);
  EXPECT_EQ(json("validation/result.json")["parameters"]["restitution"]["status"], "fixed");
}

TEST_F(CalibrationRun, EndsTheSameAfterBeingKilledAtAnyMomentAndOnAnyNumberOfThreads) {
  // 1. How it ends when nobody disturbs it
  const ProgramOutcome whole = run_program(calibrate("whole"));
  ASSERT_EQ(whole.status, 0) << whole.err;

  // 2. Killed again and again, each time a few ms after it got so far, then left alone
  Rows rows;
  std::mt19937 generator(7);
  std::uniform_int_distribution<int> more_milliseconds(0, 20);
  const auto whole_rows = static_cast<double>(journal("whole").size());
  for (const double share : {0.0, 0.02, 0.2, 0.45, 0.8}) {
    RunningProgram program(calibrate("killed"));
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (rows_so_far("killed") < share * whole_rows && std::chrono::steady_clock::now() < give_up)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    std::this_thread::sleep_for(std::chrono::milliseconds(more_milliseconds(generator)));
    program.send(SIGKILL);
    program.wait();
    const Rows now = journal("killed");
    expect_kept(rows, now);
    rows = now;
  }
  EXPECT_GT(rows.size(), 0u);
  EXPECT_LT(rows.size(), journal("whole").size());
  const ProgramOutcome last = run_program(calibrate("killed", 1));
  ASSERT_EQ(last.status, 0) << last.err;

  // 3. The same end; every committed simulation was read back, none was run again
  EXPECT_EQ(timeless_result("killed"), timeless_result("whole"));
  const Rows end = journal("killed");
  expect_kept(rows, end);
  EXPECT_EQ(end.size(), journal("whole").size());
  EXPECT_EQ(json("killed/run.json")["simulations_run"], end.size() - rows.size());

  // 4. Once more on the complete journal: nothing is left to simulate
  ASSERT_EQ(run_program(calibrate("killed")).status, 0);
  EXPECT_EQ(json("killed/run.json")["simulations_run"], 0);
  EXPECT_EQ(timeless_result("killed"), timeless_result("whole"));
}

TEST_F(CalibrationRun, EndsSoonAfterCtrlCAndResumes) {
  RunningProgram program(calibrate("run"));
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (rows_so_far("run") < 5 && std::chrono::steady_clock::now() < give_up)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const auto sent = std::chrono::steady_clock::now();
  program.send(SIGINT);
  const ProgramOutcome outcome = program.wait();
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - sent;
  EXPECT_EQ(outcome.status, 130) << outcome.err;
  EXPECT_LT(taken.count(), 2.0);
  EXPECT_NE(outcome.err.find("run the same command again to resume"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "run/result.json"));
  const Rows rows = journal("run");
  EXPECT_GT(rows.size(), 0u);

  const ProgramOutcome resumed = run_program(calibrate("run"));
  EXPECT_EQ(resumed.status, 0) << resumed.err;
  expect_kept(rows, journal("run"));
}

// One evaluation for a program that drives ours, and the journal that it leaves.
constexpr const char* reload = "<meta http-equiv=\"refresh\"";

TEST_F(CalibrationRun, ThePageFollowsTheRunWhileItIsWatched) {
  const auto page = [&] { return content_of(folder_ / "run/report.html"); };
  std::vector<std::string> arguments = calibrate("run");
  arguments.push_back("--watch");
  RunningProgram program(arguments);
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!std::filesystem::exists(folder_ / "run/report.html") &&
         std::chrono::steady_clock::now() < give_up)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const std::string early = page();  // whole, as it is renamed into place
  EXPECT_NE(early.find(reload), std::string::npos);
  EXPECT_NE(early.find("This run is under way"), std::string::npos);
  EXPECT_NE(early.find("</html>"), std::string::npos);
  program.send(SIGINT);
  EXPECT_EQ(program.wait().status, 130);
  EXPECT_EQ(page().find(reload), std::string::npos);
  EXPECT_NE(page().find("This run has no result yet"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "run/progress.json"));
}

TEST_F(CalibrationRun, EvaluationsAreRecordedAndTheirRecordCanBeLookedAfter) {
  const auto evaluate = [&](const std::string& friction, const std::string& out) {
    const auto parameters =
        folder_.write("trial.toml", "friction_particle_particle = " + friction + "\n");
    return run_program({"evaluate",
                        experiment_,
                        "--parameters",
                        parameters,
                        "--out",
                        folder_ / out,
                        "--json",
                        "--quiet"});
  };
  const auto journal_verb = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "journal");
    const ProgramOutcome outcome = run_program(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.out;
  };
  const std::string run = folder_ / "run";

  // 1. The same bits again, from the journal; another friction gives another number
  const ProgramOutcome first = evaluate("0.12", "run");
  ASSERT_EQ(first.status, 0) << first.err;
  const Json answer = Json::parse(first.out);
  EXPECT_EQ(answer["parameters"]["friction_particle_particle"], 0.12);
  EXPECT_EQ(answer["parameters"]["restitution"], 0.83);
  EXPECT_EQ(answer["simulations"], 6);
  EXPECT_EQ(answer["failed"], 0);
  for (const char* key :
       {"objective", "agreement_percent", "agreement_percent_student_t", "rms_position_m"}) {
    EXPECT_TRUE(answer[key].is_number()) << key;
  }
  EXPECT_EQ(evaluate("0.12", "run").out, first.out);
  EXPECT_EQ(journal("run").size(), 6u);
  EXPECT_GT(Json::parse(evaluate("0.5", "other").out)["objective"], answer["objective"]);

  // 2. List, show, export
  EXPECT_NE(journal_verb({"list", run}).find("evaluation"), std::string::npos);
  EXPECT_NE(journal_verb({"show", run, "3"}).find("friction_particle_particle   0.12"),
            std::string::npos);
  const std::string table = journal_verb({"export", run, "--out", "-"});
  EXPECT_TRUE(table.starts_with("problem,stage,friction_particle_particle,")) << table;
  journal_verb({"export", run});
  EXPECT_EQ(content_of(folder_ / "run/journal.csv"), table);

  // 3. Merge and drop
  EXPECT_TRUE(journal_verb({"merge", run, folder_ / "other"}).starts_with("6 simulations added"));
  EXPECT_TRUE(journal_verb({"merge", run, folder_ / "other"}).starts_with("0 simulations added"));
  EXPECT_EQ(journal("run").size(), 12u);
  // A machine that reckons otherwise: the same simulation with another result
  std::filesystem::copy(
      folder_ / "other", folder_ / "third", std::filesystem::copy_options::recursive);
  {
    calibrate::Journal third(folder_ / "third/journal.db");
    calibrate::JournalRow row = third.rows().front();
    third.drop(std::vector<std::int64_t>{row.id});
    row.run.channels.front().values.front() += 1e-15;
    third.add(row);
  }
  const ProgramOutcome disagrees = run_program({"journal", "merge", run, folder_ / "third"});
  EXPECT_EQ(disagrees.status, 2);
  EXPECT_NE(disagrees.err.find("are of the same simulation and have different results"),
            std::string::npos)
      << disagrees.err;
  EXPECT_TRUE(journal_verb({"drop", run, "--failed"}).starts_with("0 simulations dropped, 12"));
  EXPECT_TRUE(journal_verb({"drop", run, "--id", "2", "5"}).starts_with("2 simulations dropped"));
  EXPECT_EQ(evaluate("0.12", "run").out, first.out);  // what was dropped is run anew
  EXPECT_EQ(journal("run").size(), 12u);
  const std::string problem = calibrate::Journal(folder_ / "run/journal.db").rows().front().problem;
  EXPECT_TRUE(
      journal_verb({"drop", run, "--problem", problem}).starts_with("12 simulations dropped, 0"));
  EXPECT_EQ(run_program({"journal", "show", run, "3"}).status, 2);
}

}  // namespace
}  // namespace graintruth::tests
