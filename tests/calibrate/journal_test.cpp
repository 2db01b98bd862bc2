#include "calibrate/journal.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <bit>
#include <cmath>
#include <fstream>
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
  row.run.status = RunStatus::unstable;
  row.run.message = "a particle moved too far";
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

}  // namespace
}  // namespace graintruth::calibrate
