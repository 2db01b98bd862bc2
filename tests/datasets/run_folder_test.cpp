#include "datasets/store/run_folder.h"

#include <gtest/gtest.h>

#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::datasets {
namespace {

using tests::TemporaryFolder;

TEST(WriteWhole, ReplacesTheFileAndLeavesNothingElse) {
  const TemporaryFolder folder;
  write_whole(folder / "a.txt", "old");
  write_whole(folder / "a.txt", "new");
  EXPECT_EQ(read_whole(folder / "a.txt"), "new");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(WriteWhole, RefusesAFolderThatDoesNotExist) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_whole(folder / "absent" / "a.txt", "x"), InputError);
}

TEST(OpenRunFolder, RefusesAPlaceWhereAFileStands) {
  const TemporaryFolder folder;
  folder.write("taken", "x");
  EXPECT_THROW(open_run_folder(folder / "taken"), InputError);
}

}  // namespace
}  // namespace graintruth::datasets
