// What may happen to a run folder: a second process, a record that was damaged, a disk that is full
// or cannot be written. One sentence each, nothing half written, nothing lost.
#include <fmt/format.h>
#include <sqlite3.h>

#include <nlohmann/json.hpp>

#include "datasets/store/run_lock.h"
#include "tests/app/bad_input.h"
#include "tests/support/other_disk.h"

namespace graintruth::tests {
namespace {

namespace fs = std::filesystem;

class RunFolderFaults : public BadInput {
 protected:
  RunFolderFaults() {
    write_tracks_of_truth(folder_);
    experiment_ = folder_.write("experiment.toml", track_experiment());
    parameters_ = folder_.write("trial.toml", "friction_particle_particle = 0.12\n");
    run_ = folder_ / "run";
  }

  std::vector<std::string> evaluation(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> command = {"evaluate",
                                        experiment_,
                                        "--parameters",
                                        parameters_,
                                        "--runs",
                                        "2",
                                        "--out",
                                        run_,
                                        "--json",
                                        "--quiet"};
    command.insert(command.end(), more.begin(), more.end());
    return command;
  }

  void change_journal(const std::string& sql) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open((run_ / "journal.db").c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(database);
    sqlite3_close(database);
  }

  std::vector<std::string> unfinished_files(const fs::path& folder) const {
    std::vector<std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      if (contains(entry.path().filename(), ".unfinished")) found.push_back(entry.path());
    return found;
  }

  std::string experiment_, parameters_;
  fs::path run_;
};

TEST_F(RunFolderFaults, ASecondProcessIsToldWhoIsAtWork) {
  fs::create_directories(run_);
  const std::string self = "graintruth calibrate (process " + std::to_string(getpid()) + " on ";
  {
    const datasets::RunLock lock(run_, "graintruth calibrate");
    folder_.write("run/journal.db", "");
    const std::string run = run_;
    for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
             evaluation(),
             {"calibrate", experiment_, "--out", run, "--quiet"},
             {"validate", experiment_, "--parameters", parameters_, "--out", run, "--quiet"},
             {"track", experiment_, "--out", run, "--quiet"},
             {"report", run},
             {"journal", "drop", run, "--failed"},
             {"journal", "merge", run, run},
             {"journal", "export", run}})
      expect_refusal(run_program(command), {run + ": " + self, "is at work in this folder"});
  }
  EXPECT_EQ(run_program(evaluation()).status, 0);
  EXPECT_FALSE(fs::exists(run_ / ".lock"));
}

TEST_F(RunFolderFaults, ADamagedRowIsRefusedEverywhereAndCanBeDropped) {
  const ProgramOutcome whole = run_program(evaluation());
  ASSERT_EQ(whole.status, 0) << whole.err;
  change_journal("UPDATE simulation SET objective = 0.001 WHERE id = 2;");
  const std::vector<std::string> words = {
      "journal.db: row 2 is damaged: it was changed after it was written",
      "'graintruth journal drop " + run_.string() + " --damaged'"};
  for (const std::vector<std::string>& command :
       std::vector<std::vector<std::string>>{evaluation(),
                                             {"journal", "list", run_},
                                             {"journal", "show", run_, "1"},
                                             {"journal", "export", run_}})
    expect_refusal(run_program(command), words);
  const ProgramOutcome drop = run_program({"journal", "drop", run_, "--damaged"});
  EXPECT_EQ(drop.status, 0) << drop.err;
  EXPECT_EQ(drop.out, "1 simulations dropped, 1 left\n");
  const ProgramOutcome again = run_program(evaluation());
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(again.out, whole.out);
}

// Where it stopped was the limit's doing: the next run simulates it whole.
TEST_F(RunFolderFaults, TooManyFailedSimulationsAreAStatusAndNeverReused) {
  const ProgramOutcome limited = run_program(evaluation({"--step-limit", "10"}));
  EXPECT_EQ(limited.status, 3);
  EXPECT_TRUE(contains(limited.err, "2 of 2 simulations failed (timed_out: it takes more than 10"))
      << limited.err;
  EXPECT_EQ(nlohmann::json::parse(limited.out)["failed"], 2);
  EXPECT_EQ(run_program(evaluation({"--step-limit", "10"})).out, limited.out);
  const ProgramOutcome whole = run_program(evaluation());
  EXPECT_EQ(whole.status, 0) << whole.err;
  EXPECT_EQ(nlohmann::json::parse(whole.out)["failed"], 0);
  // And a limit changes nothing that is known
  EXPECT_EQ(run_program(evaluation({"--step-limit", "10"})).out, whole.out);
}

// Of every size at which it may happen; with more room the same command goes on.
TEST_F(RunFolderFaults, AFullDiskIsOneSentenceAndLosesNothing) {
  if (!can_mount()) GTEST_SKIP() << "no file system may be mounted here";
  const ProgramOutcome whole = run_program(evaluation());
  ASSERT_EQ(whole.status, 0) << whole.err;
  std::string command = GRAINTRUTH_PROGRAM;
  for (const std::string& word : evaluation()) command += " '" + word + "'";
  int refused = 0;
  for (const int kilobytes : {8, 40, 120, 200}) {
    fs::remove_all(run_);
    fs::create_directories(run_);
    const std::string log = folder_ / "log";
    const ProgramOutcome outcome = run_with_own_mounts(
        fmt::format("cd / && mount -t tmpfs -o size={0}k none '{1}' && {2} >'{3}.out' 2>'{3}.err';"
                    "echo $? >'{3}.status'; find '{1}' -name '*unfinished*' >'{3}.left';"
                    "mount -o remount,size=20m '{1}' && {2}",
                    kilobytes,
                    run_.string(),
                    command,
                    log));
    EXPECT_EQ(outcome.status, 0) << kilobytes << ": " << outcome.err;
    EXPECT_EQ(outcome.out, whole.out) << kilobytes;
    EXPECT_EQ(content_of(log + ".left"), "") << kilobytes;
    if (content_of(log + ".status") == "0\n") continue;
    ++refused;
    EXPECT_EQ(content_of(log + ".status"), "2\n") << kilobytes;
    const std::string said = content_of(log + ".err");
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    EXPECT_TRUE(said.starts_with("graintruth: " + run_.string())) << said;
    EXPECT_EQ(content_of(log + ".out"), "") << kilobytes;
  }
  EXPECT_GE(refused, 2);
}

TEST_F(RunFolderFaults, AFolderThatCannotBeWrittenIsOneSentenceAndCanBeRead) {
  if (!can_mount()) GTEST_SKIP() << "no file system may be mounted here";
  ASSERT_EQ(run_program(evaluation()).status, 0);
  const auto run_read_only = [&](const std::vector<std::string>& words) {
    std::string command = GRAINTRUTH_PROGRAM;
    for (const std::string& word : words) command += " '" + word + "'";
    return run_with_own_mounts(
        fmt::format("mount --bind '{0}' '{0}' && mount -o remount,ro,bind '{0}' && {1}",
                    run_.string(),
                    command));
  };
  expect_refusal(run_read_only(evaluation()), {run_.string(), "cannot be written"});
  expect_refusal(run_read_only({"journal", "drop", run_, "--failed"}), {"cannot be written"});
  const ProgramOutcome list = run_read_only({"journal", "list", run_});
  EXPECT_EQ(list.status, 0) << list.err;
  EXPECT_TRUE(contains(list.out, "completed")) << list.out;
}

TEST_F(RunFolderFaults, WhatCannotBePrintedIsSaid) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  std::string command = GRAINTRUTH_PROGRAM;
  for (const std::string& word : evaluation()) command += " '" + word + "'";
  const ProgramOutcome outcome = run_program({"-c", command + " >/dev/full"}, "/bin/sh");
  EXPECT_EQ(outcome.status, 2);
  EXPECT_TRUE(contains(outcome.err, "No space left on device")) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
}

}  // namespace
}  // namespace graintruth::tests
