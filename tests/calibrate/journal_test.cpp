#include "calibrate/journal.h"

#include <gtest/gtest.h>

#include "datasets/input_error.h"
#include "tests/calibrate/toy_experiment.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

using tests::TemporaryFolder;

JournalRow row_at(double friction, std::uint64_t seed) {
  const SimulationRequest request{{friction, 0.3, 0.8}, 0.25, seed};
  return {.problem = "p",
          .stage = "design",
          .request = request,
          .run = toy::simulator(0.01)(request),
          .objective = 1.5};
}

TEST(Journal, GivesBackARunToTheLastBitAfterReopening) {
  const TemporaryFolder folder;
  const JournalRow row = row_at(0.1, 7);
  { Journal(folder / "j.db").add(row); }
  Journal journal(folder / "j.db");
  const auto found = journal.find("p", row.request);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->trajectories.time, row.run.trajectories.time);
  for (std::size_t i = 0; i < row.run.trajectories.poses.size(); ++i) {
    EXPECT_EQ(found->trajectories.poses[i].x, row.run.trajectories.poses[i].x);
    EXPECT_EQ(found->trajectories.poses[i].angle, row.run.trajectories.poses[i].angle);
  }
}

TEST(Journal, GivesBackWhatWasMeasuredOfABin) {
  const TemporaryFolder folder;
  JournalRow row = row_at(0.1, 7);
  row.run.bin.discharge = {.particles = 5, .over_orifice = 1, .to = 2.0, .times = {0.5, 0.75}};
  row.run.bin.flowing_density = 6.0;
  row.run.bin.profile.samples = {{0.01, 0.2, 0.0}, {0.02, 0.1, 0.0}};
  row.run.bin.stagnant_heights = {0.03, 0.01, 0.02};
  { Journal(folder / "j.db").add(row); }
  const auto found = Journal(folder / "j.db").find("p", row.request);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->bin.discharge.times, row.run.bin.discharge.times);
  EXPECT_EQ(found->bin.flowing_density, 6.0);
  ASSERT_EQ(found->bin.profile.samples.size(), 2U);
  EXPECT_EQ(found->bin.profile.samples[1].velocity, 0.1);
  EXPECT_EQ(found->bin.stagnant_heights, row.run.bin.stagnant_heights);
}

TEST(Journal, DoesNotKnowAnotherProblemOrRequest) {
  const TemporaryFolder folder;
  Journal journal(folder / "j.db");
  const JournalRow row = row_at(0.1, 7);
  journal.add(row);
  EXPECT_FALSE(journal.find("q", row.request).has_value());
  SimulationRequest other = row.request;
  other.seed = 8;
  EXPECT_FALSE(journal.find("p", other).has_value());
  other = row.request;
  other.time_step_fraction = 0.125;
  EXPECT_FALSE(journal.find("p", other).has_value());
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
  EXPECT_EQ(journal.find("p", row.request)->status, RunStatus::unstable);
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
