#include "datasets/store/table.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <functional>

#include "datasets/store/input_error.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::datasets {
namespace {

using tests::TemporaryFolder;

std::string complaint(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(Table, ReadsNumbersToTheLastBit) {
  const TemporaryFolder folder;
  const Table table = read_csv(folder.write("t.csv", "a,b\n0.3,1e-300\n-2.5, 7 \n"));
  EXPECT_EQ(table.number(0, "a"), 0.3);
  EXPECT_EQ(table.number(0, "b"), 1e-300);
  EXPECT_EQ(table.integer(1, "b"), 7);
}

TEST(Table, AnEmptyCellAndTheWordNanAreMissingValues) {
  const TemporaryFolder folder;
  const Table table = read_csv(folder.write("t.csv", "a,b\n,nan\n"));
  EXPECT_TRUE(std::isnan(table.number(0, "a")));
  EXPECT_TRUE(std::isnan(table.number(0, "b")));
}

TEST(Table, SkipsCommentsAndBlankLinesAndUnderstandsQuotes) {
  const TemporaryFolder folder;
  const Table table =
      read_csv(folder.write("t.csv", "# origin\nname,value\n\n\"a, \"\"b\"\"\",1\n\n"));
  ASSERT_EQ(table.rows(), 1U);
  EXPECT_EQ(table.text(0, "name"), "a, \"b\"");
}

TEST(Table, TextInANumberColumnIsNamedWithFileLineAndColumn) {
  const TemporaryFolder folder;
  const Table table = read_csv(folder.write("t.csv", "time_s,x_m\n0,1\n0.1,abc\n"));
  const std::string sentence = complaint([&] { table.number(1, "x_m"); });
  EXPECT_NE(sentence.find("t.csv:3"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("'x_m'"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("'abc'"), std::string::npos) << sentence;
}

TEST(Table, ARowOfTheWrongLengthIsNamedWithItsLine) {
  const TemporaryFolder folder;
  const auto file = folder.write("t.csv", "a,b\n1,2\n3\n");
  EXPECT_NE(complaint([&] { read_csv(file); }).find("t.csv:3"), std::string::npos);
}

TEST(Table, AMissingColumnIsNamedBesideThoseThatExist) {
  const TemporaryFolder folder;
  const Table table = read_csv(folder.write("t.csv", "mass_kg\n1\n"));
  const std::string sentence = complaint([&] { table.number(0, "time_s"); });
  EXPECT_NE(sentence.find("time_s"), std::string::npos);
  EXPECT_NE(sentence.find("mass_kg"), std::string::npos);
}

TEST(Table, MissingAndEmptyFilesAreRefused) {
  const TemporaryFolder folder;
  EXPECT_THROW(read_csv(folder / "absent.csv"), InputError);
  EXPECT_THROW(read_csv(folder.write("empty.csv", "")), InputError);
}

RC_GTEST_PROP(Table, WhatIsWrittenReadsBackTheSame, (const std::vector<double>& values)) {
  // Cells of what makes CSV hard, between full stops because blanks around a cell are not kept.
  const std::string text =
      "." + *rc::gen::container<std::string>(rc::gen::elementOf(std::string("a,\"# ;'"))) + ".";
  Table table({"value", "text"});
  for (const double value : values) table.add({number_text(value), text});
  const auto file = std::filesystem::temp_directory_path() /
                    ("graintruth-table-" + std::to_string(getpid()) + ".csv");
  write_csv(file, table);
  const Table back = read_csv(file);
  std::filesystem::remove(file);
  RC_ASSERT(back.rows() == values.size());
  for (std::size_t row = 0; row < values.size(); ++row) {
    RC_ASSERT(back.number(row, "value") == values[row]);
    RC_ASSERT(back.text(row, "text") == text);
  }
}

}  // namespace
}  // namespace graintruth::datasets
