#include "calibrate/journal.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <bit>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>

#include "datasets/store/input_error.h"
#include "tests/calibrate/toy_experiment.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

using tests::TemporaryFolder;

JournalRow row_at(double friction, std::uint64_t seed) {
  const Problem problem = toy::problem({}, 2, 1);
  const SimulationSpec spec = problem.spec_of(0, toy::parameters(friction, 0.3, 0.8), 0.25, seed);
  return {.fingerprint = fingerprint_of(spec),
          .problem = "p",
          .stage = "design",
          .parameters = spec.parameters,
          .time_step_fraction = spec.time_step_fraction,
          .seed = seed,
          .run = toy::compared(problem, toy::run(spec.parameters, 0.01, seed)),
          .objective = 1.5};
}

TEST(Journal, GivesBackARunToTheLastBitAfterReopening) {
  const TemporaryFolder folder;
  JournalRow row = row_at(0.1, 7);
  row.run.channels[0].values[3] = std::nan("");
  row.run.channels[0].errors = {1e-300, -0.0, std::numeric_limits<double>::infinity()};
  row.run.channels[0].details = {{"times_s", {0.1, 0.2}}, {"grains", {}}};
  row.run.channels.emplace_back();  // what the simulation could not tell
  { Journal(folder / "j.db").add(row); }
  Journal journal(folder / "j.db");
  const auto found = journal.find(row.fingerprint);
  ASSERT_TRUE(found.has_value());
  ASSERT_EQ(found->channels.size(), 2U);
  const auto bits = [](const std::vector<double>& values) {
    std::vector<std::uint64_t> all;
    for (const double value : values) all.push_back(std::bit_cast<std::uint64_t>(value));
    return all;
  };
  EXPECT_EQ(bits(found->channels[0].values), bits(row.run.channels[0].values));
  EXPECT_EQ(bits(found->channels[0].errors), bits(row.run.channels[0].errors));
  EXPECT_EQ(found->channels[0].details, row.run.channels[0].details);
  EXPECT_FALSE(found->channels[1].is_known());
  EXPECT_EQ(journal.rows().front().parameters, row.parameters);
}

TEST(Journal, DoesNotKnowAnotherSimulation) {
  Journal journal(":memory:");
  journal.add(row_at(0.1, 7));
  EXPECT_TRUE(journal.find(row_at(0.1, 7).fingerprint).has_value());
  EXPECT_FALSE(journal.find(row_at(0.1, 8).fingerprint).has_value());
  EXPECT_FALSE(journal.find(row_at(0.10000000000000002, 7).fingerprint).has_value());
}

TEST(Journal, IsRefusedInOneSentenceWhereAnOlderProgramMadeIt) {
  const TemporaryFolder folder;
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "j.db").c_str(), &database), SQLITE_OK);
  // As of 90ba708
  ASSERT_EQ(sqlite3_exec(database,
                         "CREATE TABLE simulation (id INTEGER PRIMARY KEY, problem TEXT NOT NULL,"
                         " stage TEXT NOT NULL, friction_particle_particle REAL NOT NULL,"
                         " poses BLOB NOT NULL, bin BLOB);"
                         "CREATE TABLE problem_part (name TEXT PRIMARY KEY, hash TEXT NOT NULL);",
                         nullptr,
                         nullptr,
                         nullptr),
            SQLITE_OK);
  sqlite3_close(database);
  try {
    Journal journal(folder / "j.db");
    FAIL() << "nothing was thrown";
  } catch (const datasets::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("--out"), std::string::npos) << error.what();
  }
}

TEST(Journal, IsRefusedForAnotherProblemWithWhatHasChanged) {
  const TemporaryFolder folder;
  Journal(folder / "j.db").belong_to({{"particle", "a"}, {"rig", "b"}});
  Journal journal(folder / "j.db");
  journal.belong_to({{"rig", "b"}, {"particle", "a"}, {"a further film", "c"}});
  try {
    journal.belong_to({{"particle", "a"}, {"rig", "other"}});
    FAIL() << "nothing was thrown";
  } catch (const datasets::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("(rig changed since)"), std::string::npos)
        << error.what();
  }
}

TEST(Journal, KeepsTheStatusOfARunThatFailed) {
  const TemporaryFolder folder;
  Journal journal(folder / "j.db");
  JournalRow row = row_at(0.1, 7);
  row.run = {.status = RunStatus::unstable, .message = "a particle moved too far"};
  journal.add(row);
  EXPECT_EQ(journal.find(row.fingerprint)->status, RunStatus::unstable);
  EXPECT_EQ(journal.rows().front().run.message, "a particle moved too far");
}

TEST(Journal, ItsPlainCopyDoesNotDependOnTheOrderOfCommits) {
  const TemporaryFolder folder;
  Journal forward(folder / "a.db");
  Journal backward(folder / "b.db");
  const std::vector<JournalRow> rows = {row_at(0.1, 1), row_at(0.1, 2), row_at(0.3, 1)};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    forward.add(rows[i]);
    backward.add(rows[rows.size() - 1 - i]);
  }
  write_journal_csv(folder / "a.csv", forward);
  write_journal_csv(folder / "b.csv", backward);
  std::ifstream a(folder / "a.csv");
  std::ifstream b(folder / "b.csv");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(a), {}),
            std::string(std::istreambuf_iterator<char>(b), {}));
}

TEST(Journal, RefusesWhatIsNoDatabase) {
  const TemporaryFolder folder;
  EXPECT_THROW(
      Journal(folder.write("j.db", "this is text, and long enough to be no header of a database")),
      datasets::InputError);
  EXPECT_THROW(Journal(folder / "absent" / "j.db"), datasets::InputError);
}

// What a refusal says; empty where nothing was refused.
std::string refusal(const std::function<void()>& work) {
  try {
    work();
  } catch (const datasets::InputError& error) {
    return error.what();
  }
  return "";
}

// A journal of three simulations, of which a test damages the second.
class DamagedJournal : public testing::Test {
 protected:
  DamagedJournal() {
    Journal journal(file_);
    for (const std::uint64_t seed : {1, 2, 3}) journal.add(row_at(0.1, seed));
  }

  void change(const std::string& sql) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(file_.c_str(), &database), SQLITE_OK);
    char* message = nullptr;
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &message), SQLITE_OK)
        << message;
    sqlite3_free(message);
    sqlite3_close(database);
  }

  // Refused by its number wherever it is met, never read; the others serve, and it can be dropped.
  void expect_row_two_refused(const std::string& words) const {
    {
      Journal journal(file_);
      const std::vector<std::function<void()>> ways = {
          [&] { journal.require_sound(); },
          [&] { journal.rows(); },
          [&] { journal.find(row_at(0.1, 2).fingerprint); }};
      for (const auto& way : ways) {
        const std::string said = refusal(way);
        for (const std::string& part : {std::string("j.db: row 2 is damaged: "),
                                        words,
                                        std::string("graintruth journal drop"),
                                        std::string("--damaged")})
          EXPECT_NE(said.find(part), std::string::npos) << part << " is not in: " << said;
      }
      EXPECT_TRUE(journal.find(row_at(0.1, 1).fingerprint).has_value());
      EXPECT_EQ(journal.damaged(), std::vector<std::int64_t>({2}));
      journal.drop(journal.damaged());
    }
    Journal journal(file_);
    journal.require_sound();
    EXPECT_EQ(journal.rows().size(), 2U);
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "j.db";
};

TEST_F(DamagedJournal, ByAnEditedNumber) {
  change("UPDATE simulation SET objective = 0.5 WHERE id = 2;");
  expect_row_two_refused("it was changed after it was written");
}

TEST_F(DamagedJournal, ByANumberThatIsNone) {
  change("UPDATE simulation SET objective = NULL WHERE id = 2;");
  expect_row_two_refused("it was changed after it was written");
}

TEST_F(DamagedJournal, ByATextInPlaceOfANumber) {
  change("UPDATE simulation SET objective = 'nan' WHERE id = 2;");
  expect_row_two_refused("its objective holds a text, but a number is needed");
}

TEST_F(DamagedJournal, ByATimeBelowZero) {
  change("UPDATE simulation SET time_step_s = -1e-5 WHERE id = 2;");
  expect_row_two_refused("its time_step_s is -1e-05, which cannot be");
}

TEST_F(DamagedJournal, ByResultsThatWereCutOff) {
  change("UPDATE simulation SET channels = substr(channels, 1, 100) WHERE id = 2;");
  expect_row_two_refused("its channels are cut off");
}

TEST_F(DamagedJournal, ByResultsOfAnotherSimulation) {
  change(
      "UPDATE simulation SET channels = (SELECT channels FROM simulation WHERE id = 3)"
      " WHERE id = 2;");
  expect_row_two_refused("it was changed after it was written");
}

TEST_F(DamagedJournal, ByABlobThatIsNoResult) {
  change("UPDATE simulation SET channels = x'a16161f5' WHERE id = 2;");  // {"a": true}
  expect_row_two_refused("its channels cannot be read");
}

TEST_F(DamagedJournal, ByAStatusThatNobodyKnows) {
  change("UPDATE simulation SET status = 'complete' WHERE id = 2;");
  expect_row_two_refused("its status is 'complete', with which no simulation ends");
}

TEST_F(DamagedJournal, ByAFailureThatHasResults) {
  change("UPDATE simulation SET status = 'unstable' WHERE id = 2;");
  expect_row_two_refused("its status is 'unstable', but it has results");
}

TEST_F(DamagedJournal, ByParametersThatAreNone) {
  change("UPDATE simulation SET parameters = '{\"friction' WHERE id = 2;");
  expect_row_two_refused("its parameters are cut off");
}

TEST_F(DamagedJournal, ByAParameterThatNobodyKnows) {
  change("UPDATE simulation SET parameters = '{\"stickiness\":0.1}' WHERE id = 2;");
  expect_row_two_refused("there is no parameter 'stickiness'");
}

// Every bit counts: of any column, in any direction.
TEST_F(DamagedJournal, ByAnyChangeOfAnyColumn) {
  for (const char* change_of : {"problem = 'q'",
                                "stage = 'polish'",
                                "parameters = replace(parameters, '0.3', '0.4')",
                                "time_step_fraction = time_step_fraction * 1.0000000001",
                                "seed = seed + 1",
                                "message = 'all well'",
                                "agreement_percent = 99",
                                "seconds = seconds + 1",
                                "checksum = ''"}) {
    change(fmt::format("UPDATE simulation SET {} WHERE id = 2;", change_of));
    EXPECT_EQ(Journal(file_).damaged(), std::vector<std::int64_t>({2})) << change_of;
    Journal journal(file_);
    journal.drop(std::vector<std::int64_t>{2});
    change("UPDATE simulation SET id = 2 WHERE id = 3;");
    EXPECT_TRUE(journal.damaged().empty()) << "a row's number is no part of it";
    journal.add(row_at(0.1, 2));
  }
}

// Which of the two is right nobody knows.
TEST_F(DamagedJournal, ByTwoRowsOfOneSimulation) {
  change(
      "CREATE TABLE other AS SELECT * FROM simulation; DROP TABLE simulation;"
      "ALTER TABLE other RENAME TO simulation;"
      "UPDATE simulation SET fingerprint = (SELECT fingerprint FROM simulation WHERE id = 1)"
      " WHERE id = 2;");
  Journal journal(file_);
  EXPECT_EQ(journal.damaged(), std::vector<std::int64_t>({1, 2}));
  journal.drop(journal.damaged());
  journal.require_sound();
  EXPECT_EQ(journal.rows().size(), 1U);
}

TEST_F(DamagedJournal, ByARowThatStandsTwice) {
  change(
      "CREATE TABLE other AS SELECT * FROM simulation; DROP TABLE simulation;"
      "ALTER TABLE other RENAME TO simulation;"
      "INSERT INTO simulation SELECT 9, fingerprint, problem, stage, parameters,"
      " time_step_fraction, seed, status, message, objective, agreement_percent, time_step_s,"
      " seconds, channels, checksum FROM simulation WHERE id = 2;");
  Journal journal(file_);
  EXPECT_NE(refusal([&] {
              journal.require_sound();
            }).find("row 9 is damaged: row 2 is of the same simulation"),
            std::string::npos);
}

TEST_F(DamagedJournal, AsAFile) {
  const auto size = std::filesystem::file_size(file_);
  for (const std::uintmax_t kept : {size / 2, std::uintmax_t{150}, std::uintmax_t{40}}) {
    const auto cut = folder_ / "cut.db";
    std::filesystem::copy_file(file_, cut, std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(cut, kept);
    const std::string said = refusal([&] { Journal(cut).require_sound(); });
    EXPECT_NE(said.find("cut.db: the journal"), std::string::npos) << kept << ": " << said;
    EXPECT_NE(said.find("remove the file, and its simulations are run anew"), std::string::npos)
        << kept << ": " << said;
  }
  // Bytes in the middle of a page
  std::fstream bytes(file_, std::ios::in | std::ios::out | std::ios::binary);
  bytes.seekp(static_cast<std::streamoff>(size / 2));
  bytes << std::string(2000, 'x');
  bytes.close();
  EXPECT_NE(refusal([&] { Journal(file_).require_sound(); }), "");
}

TEST(Journal, SaysThatItWasEmptyAndIsUsedAsNew) {
  const TemporaryFolder folder;
  Journal journal(folder.write("j.db", ""));
  ASSERT_EQ(journal.notices().size(), 1U);
  EXPECT_NE(journal.notices().front().find("the journal is empty"), std::string::npos);
  journal.add(row_at(0.1, 7));
  EXPECT_EQ(journal.rows().size(), 1U);
  EXPECT_TRUE(Journal(folder / "j.db").notices().empty());
}

TEST_F(DamagedJournal, IsRefusedWhereANewerProgramMadeIt) {
  change("PRAGMA user_version = 3;");
  for (const auto use : {Journal::Use::writing, Journal::Use::reading})
    EXPECT_NE(refusal([&] {
                Journal(file_, use);
              }).find("made by a newer program (layout 3, this program knows 2)"),
              std::string::npos);
}

TEST_F(DamagedJournal, IsRefusedWhereItIsOfAnotherProgram) {
  change("PRAGMA application_id = 12345;");
  EXPECT_NE(refusal([&] { Journal{file_}; }).find("another program"), std::string::npos);
  const auto foreign = folder_ / "foreign.db";
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(foreign.c_str(), &database), SQLITE_OK);
  sqlite3_exec(database, "CREATE TABLE addresses (name TEXT);", nullptr, nullptr, nullptr);
  sqlite3_close(database);
  EXPECT_NE(refusal([&] { Journal{foreign}; }).find("another program"), std::string::npos);
}

TEST_F(DamagedJournal, IsRefusedWhereAColumnIsMissing) {
  change("ALTER TABLE simulation DROP COLUMN seconds;");
  EXPECT_NE(refusal([&] { Journal{file_}; }).find("no column 'seconds'"), std::string::npos);
}

// As before checksums came: read as it is, and given them; a row that cannot be read stays refused.
TEST_F(DamagedJournal, OfAnEarlierVersionIsGivenChecksums) {
  change(
      "ALTER TABLE simulation DROP COLUMN checksum; PRAGMA user_version = 0;"
      "PRAGMA application_id = 0; UPDATE simulation SET status = 'done' WHERE id = 2;");
  EXPECT_EQ(refusal([&] {
              Journal(file_, Journal::Use::reading).require_sound();
            }).find("its status is 'done'") == std::string::npos,
            false);
  {
    Journal journal(file_);
    ASSERT_EQ(journal.notices().size(), 1U);
    EXPECT_NE(journal.notices().front().find("its 2 simulations"), std::string::npos);
  }
  expect_row_two_refused("its status is 'done'");
  change("UPDATE simulation SET seed = 5 WHERE id = 3;");
  EXPECT_EQ(Journal(file_).damaged(), std::vector<std::int64_t>({3}));
}

// Where somebody's limit ended a simulation says nothing of the simulation.
TEST(Journal, NeverGivesBackARunThatTimedOut) {
  const TemporaryFolder folder;
  Journal journal(folder / "j.db");
  JournalRow row = row_at(0.1, 7);
  const JournalRow whole = row;
  row.run = {.status = RunStatus::timed_out, .message = "more than 10 steps"};
  journal.add(row);
  EXPECT_EQ(journal.rows().front().run.status, RunStatus::timed_out);
  EXPECT_FALSE(journal.find(row.fingerprint).has_value());
  journal.add(whole);
  ASSERT_EQ(journal.rows().size(), 1U);
  EXPECT_EQ(journal.find(row.fingerprint)->status, RunStatus::completed);
  journal.add(row);  // what is known stays known
  EXPECT_EQ(journal.find(row.fingerprint)->status, RunStatus::completed);
}

}  // namespace
}  // namespace graintruth::calibrate
