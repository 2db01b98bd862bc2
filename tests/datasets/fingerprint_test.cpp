#include "datasets/store/fingerprint.h"

#include <gtest/gtest.h>

#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::datasets {
namespace {

using tests::TemporaryFolder;

TEST(ContentHash, IsXxh3Of128Bits) {
  // What xxhsum -H2 says of nothing and of "a"
  EXPECT_EQ(content_hash(""), "99aa06d3014798d86001c324468d497f");
  EXPECT_EQ(content_hash("a"), "a96faf705af16834e6c632b61e964e1f");
}

TEST(FileHash, IsThatOfTheContent) {
  const TemporaryFolder folder;
  const std::string content(3 << 20, 'g');
  EXPECT_EQ(file_hash(folder.write("big", content)), content_hash(content));
}

TEST(FileHash, RefusesAFileThatIsNotThere) { EXPECT_THROW(file_hash("no-such-file"), InputError); }

}  // namespace
}  // namespace graintruth::datasets
