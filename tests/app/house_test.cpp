// What must hold of the house: kinds are data, and folders of runs made before still serve.
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <regex>

#include "tests/app/bad_input.h"

namespace graintruth::tests {
namespace {

namespace fs = std::filesystem;

// A kind of rig, grain or several experiments together has its own files; nobody else asks which it
// is.
TEST(House, NobodyAsksForTheKindOfARigOrAGrain) {
  const std::regex asks(R"(rig\.(bin|piston)\b|\.plate\b|dynamic_cast|std::variant|std::visit)"),
      old_name("(bin|joint)_");
  const fs::path source = GRAINTRUTH_SOURCE_DIR;
  int files = 0;
  for (const char* folder : {"app", "calibrate", "reports", "tracking", "datasets"}) {
    for (const auto& entry : fs::recursive_directory_iterator(source / folder)) {
      const fs::path& file = entry.path();
      if (file.extension() != ".cpp" && file.extension() != ".h") continue;
      ++files;
      if (std::string(folder) == "calibrate")
        EXPECT_FALSE(std::regex_search(file.filename().string(), old_name)) << file;
      const std::string place = file.lexically_relative(source).generic_string();
      if (place.starts_with("tracking/plates/")) continue;  // the tracker of that grain
      const std::string text = content_of(file);
      std::smatch found;
      EXPECT_FALSE(std::regex_search(text, found, asks)) << place << ": " << found.str();
    }
  }
  EXPECT_GT(files, 300);
}

using OldRun = BadInput;

fs::path old_run(const std::string& name) {
  return fs::path(GRAINTRUTH_SOURCE_DIR) / "tests/reports/run_90ba708" / name;
}

TEST_F(OldRun, IsReportedAndExported) {
  for (const char* name : {"balls", "bin"}) {
    const fs::path folder = folder_ / name;
    fs::copy(old_run(name), folder, fs::copy_options::recursive);
    const ProgramOutcome report = run_program({"report", folder});
    EXPECT_EQ(report.status, 0) << report.err;
    EXPECT_GT(fs::file_size(folder / "report.html"), 100000U);
    for (const char* target : {"liggghts", "lammps", "yade", "csv"}) {
      const ProgramOutcome deck = run_program({"export", folder, "--to", target});
      EXPECT_EQ(deck.status, 0) << name << ' ' << target << deck.err;
      EXPECT_GT(fs::file_size(folder / "export" / target / "README.md"), 500U);
    }
  }
}

TEST_F(OldRun, IsNotContinued) {
  write_tracks_of_truth(folder_);
  const auto file = folder_.write("experiment.toml", track_experiment());
  const fs::path run = folder_ / "run";
  fs::create_directories(run);
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((run / "journal.db").c_str(), &database), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(database,
                         "CREATE TABLE simulation (id INTEGER PRIMARY KEY, problem TEXT, stage "
                         "TEXT, friction_particle_particle REAL, tracks BLOB);",
                         nullptr,
                         nullptr,
                         nullptr),
            SQLITE_OK);
  sqlite3_close(database);
  expect_refusal(run_program({"calibrate", file.string(), "--out", run.string(), "--quiet"}),
                 {"journal.db", "earlier version", "another folder with --out"});
}

}  // namespace
}  // namespace graintruth::tests
