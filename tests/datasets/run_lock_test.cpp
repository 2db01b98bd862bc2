#include "datasets/store/run_lock.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <memory>

#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::datasets {
namespace {

using tests::TemporaryFolder;

std::string refusal(const std::filesystem::path& root) {
  try {
    const RunLock lock(root, "graintruth report");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(RunLock, TellsTheSecondWhoIsAtWork) {
  const TemporaryFolder folder;
  auto first = std::make_unique<RunLock>(folder.path(), "graintruth calibrate");
  ASSERT_TRUE(first->holds());
  const std::string said = refusal(folder.path());
  EXPECT_NE(said.find("graintruth calibrate (process " + std::to_string(getpid()) + " on "),
            std::string::npos)
      << said;
  EXPECT_NE(said.find("is at work in this folder"), std::string::npos) << said;
  first.reset();
  EXPECT_EQ(refusal(folder.path()), "");
}

TEST(RunLock, LeavesNothing) {
  const TemporaryFolder folder;
  { const RunLock lock(folder.path(), "graintruth track"); }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

// What a process that was killed leaves is a file, and no lock.
TEST(RunLock, GoesWithAProcessThatIsKilled) {
  const TemporaryFolder folder;
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const RunLock lock(folder.path(), "graintruth calibrate");
    const char done = 1;
    if (write(ready[1], &done, 1) == 1)
      while (true) pause();
    _exit(1);
  }
  char done = 0;
  ASSERT_EQ(read(ready[0], &done, 1), 1);
  EXPECT_NE(refusal(folder.path()).find("(process " + std::to_string(child) + " on "),
            std::string::npos);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  close(ready[0]);
  close(ready[1]);
  EXPECT_TRUE(std::filesystem::exists(folder / ".lock"));
  EXPECT_EQ(refusal(folder.path()), "");
}

TEST(RunLock, RefusesAFolderThatIsNone) {
  const TemporaryFolder folder;
  EXPECT_NE(refusal(folder / "absent").find("cannot be written"), std::string::npos);
}

TEST(RemoveUnfinished, TakesWhatAKilledProcessHadBegun) {
  const TemporaryFolder folder;
  const RunFolder run = open_run_folder(folder.path());
  for (const char* name : {"result.json",
                           "result.json.unfinished",
                           "side_by_side.unfinished.mp4",
                           "tracks/a.csv",
                           "tracks/a.csv.unfinished",
                           "tracks/a.overlay.unfinished.mp4",
                           "tables/ranks.csv.unfinished"})
    folder.write(name, "x");
  remove_unfinished(run);
  std::vector<std::string> left;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path()))
    if (entry.is_regular_file()) left.push_back(entry.path().filename());
  std::sort(left.begin(), left.end());
  EXPECT_EQ(left, (std::vector<std::string>{"a.csv", "result.json"}));
}

}  // namespace
}  // namespace graintruth::datasets
