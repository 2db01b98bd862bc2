// The executor 'slurm', on commands that run the tasks as processes of this machine.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

#include "calibrate/executors/canary.h"
#include "calibrate/executors/executor.h"
#include "calibrate/executors/run_task.h"
#include "calibrate/executors/slurm_queue.h"
#include "calibrate/executors/task_folder.h"
#include "datasets/store/fingerprint.h"
#include "datasets/store/input_error.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

namespace fs = std::filesystem;
using tests::run_program;
using tests::TemporaryFolder;

std::string content_of(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// The version that the built program tells of itself.
std::string program_version() {
  std::string version = run_program({"--version"}).out;
  version.erase(version.find_last_not_of('\n') + 1);
  return version;
}

class Cluster : public testing::Test {
 protected:
  Cluster() {
    fs::create_directories(queue());
    const fs::path commands = fs::path(GRAINTRUTH_SOURCE_DIR) / "tests/support/fake_slurm";
    ::setenv("PATH", (commands.string() + ":" + path_).c_str(), 1);
    ::setenv("FAKE_SLURM", queue().c_str(), 1);
    setup_.execution.grace_seconds = 0.4;
    setup_.folder = folder_ / "tasks";
    setup_.program = GRAINTRUTH_PROGRAM;
    static const std::string version = program_version();
    setup_.program_version = version;
    setup_.say = [this](const std::string& sentence) { said_ += sentence + "\n"; };
    for (int i = 0; i < 4; ++i) tasks_.push_back({&engine_named("embedded"), spec_of(i)});
  }
  ~Cluster() override {
    run_program({"--name=none"}, GRAINTRUTH_SOURCE_DIR "/tests/support/fake_slurm/squeue");
    for (const std::string& task : files_of(queue() / "tasks"))
      run_program({task}, GRAINTRUTH_SOURCE_DIR "/tests/support/fake_slurm/scancel");
    ::setenv("PATH", path_.c_str(), 1);
  }

  fs::path queue() const { return folder_ / "queue"; }
  // How often jobs were submitted.
  long submissions() const {
    const std::string calls = content_of(queue() / "calls");
    return std::count(calls.begin(), calls.end(), '\n');
  }

  int submitted_tasks() const {
    int count = 0;
    std::istringstream calls(content_of(queue() / "calls"));
    const std::string before = "--array=0-";
    for (std::string word; calls >> word;) {
      if (word.starts_with(before)) count += std::stoi(word.substr(before.size())) + 1;
    }
    return count;
  }

  static SimulationSpec spec_of(int seed) {
    SimulationSpec spec = canary_spec();
    spec.seed = static_cast<std::uint64_t>(100 + seed);
    spec.scene.phases.front().duration = 0.01;
    spec.scene.phases.front().output_interval = 0.005;
    return spec;
  }

  // The bits of all runs, in the order of the tasks.
  std::vector<std::string> run(std::string_view executor) {
    std::vector<std::string> bits(tasks_.size());
    make_executor(executor, setup_)->run(tasks_, {}, [&](std::size_t task, EngineRun run) {
      EXPECT_TRUE(bits[task].empty()) << "task " << task << " came twice";
      bits[task] = bits_of(run);
    });
    return bits;
  }

  // The first process that comes by does this.
  void once(const std::string& what) {
    setup_.execution.set_up.push_back("mkdir " + (folder_ / "once").string() + " 2>/dev/null && " +
                                      what);
  }

  TemporaryFolder folder_;
  std::string path_ = std::getenv("PATH");
  ExecutorSetup setup_;
  std::vector<SimulationTask> tasks_;
  std::string said_;
};

TEST_F(Cluster, GivesTheSameAsThreadsAndLeavesNothing) {
  setup_.execution.grace_seconds = 10.0;  // no straggler among them
  EXPECT_EQ(run("slurm"), run("threads"));
  EXPECT_FALSE(fs::exists(setup_.folder));
  EXPECT_EQ(submissions(), 1);
  EXPECT_TRUE(said_.starts_with("Slurm: 4 tasks in job 1")) << said_;
}

TEST_F(Cluster, RepeatsATaskThatWasLost) {
  once("exit 1");
  EXPECT_EQ(run("slurm"), run("threads"));
  // On a busy machine a task may be taken for a straggler before it is missed
  EXPECT_TRUE(said_.find("has left the queue without a result") != std::string::npos ||
              said_.find("another does the same beside it") != std::string::npos)
      << said_;
  EXPECT_GE(submissions(), 2);
}

TEST_F(Cluster, GivesUpAfterThreeTriesAndNamesTheTasks) {
  setup_.execution.set_up = {"exit 1"};
  try {
    run("slurm");
    FAIL() << "nothing was lost";
  } catch (const TasksFailed& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("4 of 4 simulations were lost 3 times each"), std::string::npos) << what;
    EXPECT_NE(what.find(fingerprint_of(tasks_.front().spec)), std::string::npos) << what;
    EXPECT_NE(what.find("/log/graintruth-"), std::string::npos) << what;
  }
  EXPECT_EQ(submitted_tasks(), 12);
}

TEST_F(Cluster, SubmitsAgainWhatIsHeld) {
  std::ofstream(queue() / "hold") << "";
  EXPECT_EQ(run("slurm"), run("threads"));
  EXPECT_NE(said_.find("will not start (JobHeldUser)"), std::string::npos) << said_;
}

TEST_F(Cluster, ThrowsADamagedResultAway) {
  const std::string key = fingerprint_of(tasks_[1].spec);
  once("head -c 100 " + (setup_.folder / "specs" / key).string() + " >" +
       (setup_.folder / "done" / key).string());
  EXPECT_EQ(run("slurm"), run("threads"));
  EXPECT_NE(said_.find("is thrown away: its checksum is wrong"), std::string::npos) << said_;
}

TEST_F(Cluster, ReportsResultsWithOtherBits) {
  make_task_folder({setup_.folder});
  const std::string key = fingerprint_of(tasks_[2].spec);
  TaskResult result{.key = key, .node = "n1"};
  EXPECT_TRUE(put_result({setup_.folder}, result));
  result.run.seconds = 3.0;
  EXPECT_TRUE(put_result({setup_.folder}, result)) << "the time that it took is no bit of a result";
  result.run.time_step = std::nextafter(0.0, 1.0);
  result.node = "n2";
  EXPECT_FALSE(put_result({setup_.folder}, result));
  try {
    run("slurm");
    FAIL() << "nothing was reported";
  } catch (const TasksFailed& error) {
    EXPECT_NE(std::string(error.what()).find("gave other bits"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("conflict/" + key + ".n2."), std::string::npos);
  }
}

TEST_F(Cluster, TakesUpWhatAKilledDriverBegan) {
  setup_.execution.set_up = {"sleep 0.5"};
  setup_.execution.grace_seconds = 10.0;  // no straggler among them
  const pid_t child = ::fork();
  if (child == 0) {
    run("slurm");
    ::_exit(0);
  }
  while (files_of(queue() / "tasks").size() < tasks_.size())
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_EQ(run("slurm"), run("threads"));
  EXPECT_EQ(submissions(), 1) << said_;
  EXPECT_NE(said_.find("takes up array"), std::string::npos) << said_;
}

TEST_F(Cluster, WaitsForACommandThatFailsAndSaysSo) {
  once("echo 'Unable to contact slurm controller' >" + (queue() / "squeue_fails").string() +
       " && (sleep 1; rm " + (queue() / "squeue_fails").string() + ") &");
  setup_.execution.set_up.push_back("sleep 0.3");
  EXPECT_EQ(run("slurm"), run("threads"));
  EXPECT_NE(said_.find("squeue does not answer (Unable to contact slurm controller); waiting"),
            std::string::npos)
      << said_;
  EXPECT_EQ(said_.find("has left the queue without a result"), std::string::npos) << said_;
}

TEST_F(Cluster, RefusesWhatSlurmNeverTakes) {
  std::ofstream(queue() / "sbatch_fails")
      << "sbatch: error: invalid partition specified: nowhere\n";
  try {
    run("slurm");
    FAIL() << "nothing was refused";
  } catch (const datasets::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("invalid partition specified: nowhere"),
              std::string::npos)
        << error.what();
  }
}

TEST_F(Cluster, GivesAStragglerOneDuplicate) {
  once("sleep 100");
  EXPECT_EQ(run("slurm"), run("threads"));
  EXPECT_NE(said_.find("another does the same beside it"), std::string::npos) << said_;
  // On a busy machine one of the others may be a straggler, and get its duplicate
  EXPECT_GE(submissions(), 2);
  EXPECT_TRUE(files_of(queue() / "tasks").empty() || !fs::exists(setup_.folder));
}

TEST_F(Cluster, LeavesOutANodeThatGivesOtherBits) {
  once("array=$(ls -d " + (setup_.folder / "graintruth-*").string() + ") && touch " +
       (setup_.folder / "refused").string() + "/${array##*/}.$SLURM_ARRAY_TASK_ID.bad && exit 1");
  EXPECT_EQ(run("slurm"), run("threads"));
  EXPECT_NE(said_.find("node bad is left out"), std::string::npos) << said_;
  EXPECT_NE(content_of(queue() / "calls").find("--exclude=bad"), std::string::npos);
}

// --- One task

class Task : public Cluster {
 protected:
  Task() {
    const TaskFolder folder{setup_.folder};
    make_task_folder(folder);
    manifest_.program_version = setup_.program_version;
    key_ = fingerprint_of(tasks_.front().spec);
    manifest_.tasks = {{key_}};
    std::ofstream(folder.spec(key_)) << to_text(tasks_.front().spec);
  }
  // How the program ends with the manifest as it is now.
  tests::ProgramOutcome outcome(const std::string& index = "0") {
    const fs::path array = setup_.folder / "graintruth-test";
    fs::create_directories(array);
    std::ofstream(array / "manifest.json") << to_text(manifest_);
    return run_program({"run-task", array.string(), index});
  }
  void expect_refusal(const tests::ProgramOutcome& outcome, const std::string& words) {
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
    EXPECT_FALSE(fs::exists(setup_.folder / "done" / key_));
  }
  TaskManifest manifest_;
  std::string key_;
};

TEST_F(Task, LeavesItsResult) {
  manifest_.canary = to_text(canary_spec());
  manifest_.canary_bits = bits_of(engine_named("embedded").run(canary_spec(), {}));
  EXPECT_EQ(outcome().status, 0);
  std::string complaint;
  const auto result = read_result(setup_.folder / "done" / key_, key_, complaint);
  ASSERT_TRUE(result) << complaint;
  EXPECT_EQ(bits_of(result->run), bits_of(engine_named("embedded").run(tasks_.front().spec, {})));
}

TEST_F(Task, RefusesAnotherVersionOfTheProgram) {
  manifest_.program_version = "0.0.1";
  expect_refusal(outcome(), "was written by version 0.0.1");
}

TEST_F(Task, RefusesAnotherVersionOfTheEngine) {
  SimulationSpec spec = tasks_.front().spec;
  spec.engine_version = "1";
  const std::string key = fingerprint_of(spec);
  std::ofstream(setup_.folder / "specs" / key) << to_text(spec);
  manifest_.tasks = {{key}};
  expect_refusal(outcome(), "is for version 1 of the engine 'embedded'");
}

TEST_F(Task, RefusesASpecOfAnotherFingerprint) {
  SimulationSpec spec = tasks_.front().spec;
  spec.seed = 5;
  std::ofstream(setup_.folder / "specs" / key_) << to_text(spec);
  expect_refusal(outcome(), "has the fingerprint " + fingerprint_of(spec));
}

TEST_F(Task, RefusesAnIndexThatThereIsNot) {
  expect_refusal(outcome("1"), "has the tasks 0 to 0, but none of index 1");
}

TEST_F(Task, RefusesANodeWithOtherBits) {
  manifest_.canary = to_text(canary_spec());
  manifest_.canary_bits = "other";
  expect_refusal(outcome(), "gives other bits for the known simulation");
  EXPECT_EQ(files_of(setup_.folder / "refused").size(), 1U);
}

// --- Another processor

// What the C library gives for many numbers; run by the next test, with and without its mask.
TEST(Processor, PrintsWhatTheCLibraryGives) {
  std::string values;
  for (int i = 1; i <= 200000; ++i) {
    const double x = 1e-4 * i;
    for (const double value : {std::exp(x), std::log(x), std::sin(x), std::cos(x)})
      values.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  std::printf("libm %s\n", datasets::content_hash(values).c_str());
}

TEST_F(Task, GivesTheSameBitsWithoutFusedMultiplyAdd) {
  const auto of_the_library = [] {
    const std::string out =
        run_program({"--gtest_filter=Processor.PrintsWhatTheCLibraryGives"}, "/proc/self/exe").out;
    return out.substr(out.find("libm "), 37);
  };
  const std::string usual = of_the_library();
  ::setenv("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-AVX2,-FMA", 1);
  const std::string masked = of_the_library();
  manifest_.canary = to_text(canary_spec());
  manifest_.canary_bits = bits_of(engine_named("embedded").run(canary_spec(), {}));
  const tests::ProgramOutcome task = outcome();
  ::unsetenv("GLIBC_TUNABLES");
  EXPECT_NE(usual, masked) << "the mask does nothing here, so this test shows nothing";
  EXPECT_EQ(task.status, 0) << task.err;
  std::string complaint;
  const auto result = read_result(setup_.folder / "done" / key_, key_, complaint);
  ASSERT_TRUE(result) << complaint;
  EXPECT_EQ(bits_of(result->run), bits_of(engine_named("embedded").run(tasks_.front().spec, {})));
}

// --- What Slurm prints

TEST(SlurmQueue, ReadsTimesAndStates) {
  EXPECT_EQ(seconds_of("0:07"), 7.0);
  EXPECT_EQ(seconds_of("1-02:03:04"), 93784.0);
  EXPECT_EQ(seconds_of("INVALID"), 0.0);
  const auto tasks = read_queue(
      "a|17|0|R|None|1:05\na|17|1|PD|Resources|0:00\na|17|2|PD|JobHeldAdmin|0:00\n"
      "a|17|3|PD|launch failed requeued held|0:00\na|17|[4-9]|PD|Priority|0:00\n");
  ASSERT_EQ(tasks.size(), 4U);
  EXPECT_TRUE(tasks[0].runs);
  EXPECT_EQ(tasks[0].elapsed, 65.0);
  EXPECT_EQ(tasks[0].id, "17_0");
  EXPECT_FALSE(tasks[1].is_stuck);
  EXPECT_TRUE(tasks[2].is_stuck);
  EXPECT_TRUE(tasks[3].is_stuck);
}

}  // namespace
}  // namespace graintruth::calibrate
