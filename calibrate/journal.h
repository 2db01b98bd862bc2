// The record of simulations: one row each, committed to disk as it ends, so that no run is ever
// lost or repeated.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibrate/compare/simulated_run.h"
#include "calibrate/engines/simulation_spec.h"
#include "datasets/store/table.h"

namespace graintruth::calibrate {

// A row as it is kept. Objective and agreement are those of this single run, for the reader; the
// calibration computes its own from the channels.
struct JournalRow {
  std::int64_t id = 0;
  std::string fingerprint;  // of the whole simulation
  std::string problem;      // of everything but parameters, time step and seed
  std::string stage;
  ParameterSet parameters;
  double time_step_fraction = 0.0;
  std::uint64_t seed = 0;
  SimulatedRun run;
  double objective = 0.0;
  double agreement_percent = 0.0;  // NaN where no values are repeated by replicates
};

// SQLite behind one door (WAL, synchronous FULL: a committed row survives a power cut). Any thread
// may call it; calls are served one at a time. Every row has a checksum of all that it holds. A row
// that is damaged is refused by its number, in one sentence, and never read as something else.
class Journal {
 public:
  enum class Use { writing, reading };
  // Opens or makes the file; for reading it must be there and is left as it is. A journal of an
  // earlier version without checksums is given them. Throws datasets::InputError when it cannot be
  // opened or written, is damaged as a file, or is of another program or version.
  explicit Journal(const std::filesystem::path& file, Use use = Use::writing);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  // What was done to the file as it was opened, in sentences that the user should know.
  const std::vector<std::string>& notices() const { return notices_; }
  // Ties the file to a problem. Throws datasets::InputError that names what has changed when the
  // file was made for one of which a part of the same name was another.
  void belong_to(const SpecParts& parts);
  // The parts that it was tied to.
  SpecParts parts();
  // Throws datasets::InputError for the first row that is damaged, and for two rows of the same
  // simulation: before anything is simulated on top of them.
  void require_sound();
  // The numbers of the rows that are damaged, or of which another of the same simulation stands
  // before them.
  std::vector<std::int64_t> damaged();
  // The run of this very simulation, bit for bit as it was. None of a run that timed out: where it
  // stopped was somebody's limit and no property of the simulation. Throws datasets::InputError for
  // a row that is damaged.
  std::optional<SimulatedRun> find(const std::string& fingerprint);
  // Refuses the row of this simulation, because of what its reader says of it.
  [[noreturn]] void refuse(const std::string& fingerprint, const std::string& complaint);
  // Commits a row; returns when it is on disk. It takes the place of a run that timed out; of a
  // simulation that is there already nothing is changed. Throws datasets::InputError when the disk
  // refuses.
  void add(const JournalRow& row);
  // All rows, in the order of their commits. Throws datasets::InputError for one that is damaged.
  std::vector<JournalRow> rows();
  // The row of this simulation, whatever its status.
  std::optional<JournalRow> row_of(const std::string& fingerprint);
  // The numbers of the rows that did not complete; of those of one problem; of all. Damaged rows
  // count, by what they say.
  std::vector<std::int64_t> failed();
  std::vector<std::int64_t> of_problem(const std::string& problem);
  std::vector<std::int64_t> all();
  // Removes these rows, all or none; what is not there is passed over.
  void drop(std::span<const std::int64_t> ids);

 private:
  struct Database;
  void open_for_reading();
  void require_known_kind();
  void prepare_for_writing();
  void give_checksums();
  [[noreturn]] void refuse_row(std::int64_t id, const std::string& complaint) const;
  std::vector<std::int64_t> ids(const std::string& condition, const std::string& value);

  std::unique_ptr<Database> database_;
  std::vector<std::string> notices_;
};

// Whether two rows say the same of a simulation, apart from the time that it took.
bool is_same_result(const JournalRow& a, const JournalRow& b);

// The plain copy, without channels, in an order that does not depend on which thread was first.
datasets::Table journal_table(Journal& journal);
// journal.csv: that table.
void write_journal_csv(const std::filesystem::path& file, Journal& journal);

}  // namespace graintruth::calibrate
