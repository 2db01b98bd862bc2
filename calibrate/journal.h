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
// may call it; calls are served one at a time.
class Journal {
 public:
  // Opens or makes the file. Throws datasets::InputError when it cannot be opened or written, or is
  // of a program that kept other journals.
  explicit Journal(const std::filesystem::path& file);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  // Ties the file to a problem. Throws datasets::InputError that names what has changed when the
  // file was made for one of which a part of the same name was another.
  void belong_to(const SpecParts& parts);
  // The run of this very simulation, bit for bit as it was.
  std::optional<SimulatedRun> find(const std::string& fingerprint);
  // Commits a row; returns when it is on disk. Throws datasets::InputError when the disk refuses.
  void add(const JournalRow& row);
  // All rows, in the order of their commits.
  std::vector<JournalRow> rows();
  // Removes these rows, all or none; what is not there is passed over.
  void drop(std::span<const std::int64_t> ids);
  // Problem hashes that occur in the file.
  std::vector<std::string> problems();

 private:
  struct Database;
  std::unique_ptr<Database> database_;
};

// The plain copy, without channels, in an order that does not depend on which thread was first.
datasets::Table journal_table(Journal& journal);
// journal.csv: that table.
void write_journal_csv(const std::filesystem::path& file, Journal& journal);

}  // namespace graintruth::calibrate
