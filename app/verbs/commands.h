// The verbs of the program, each with what its command line says. main.cpp parses; the file that
// bears a verb's name does it and returns the exit status: 0 done, 1 a requirement is not met.
// Unusable input is thrown as datasets::InputError.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace graintruth::app {

// What every verb understands.
struct CommonOptions {
  std::filesystem::path out;  // empty: out/<experiment name>
  int jobs = 0;               // 0: all cores
  std::uint64_t seed = 1;
  bool quiet = false;
  bool json = false;
  std::int64_t step_limit = 0;  // of a simulation that is compared; 0: the engine's own
  std::string engine;           // that simulates; empty: as the experiment file says
  std::string executor;         // where simulations run; empty: as the experiment file says
  std::string command_line;     // as typed, for run.json
};

// Threads to use: as many as asked for, or else as there are cores.
int threads_of(const CommonOptions& options);

struct CalibrateCommand {
  CommonOptions common;
  std::filesystem::path experiment;
  int budget = 0;                  // evaluations; 0: the default
  double time_limit = 0.0;         // s; 0: none
  bool watch = false;              // the report follows the run
  bool use_failed_tracks = false;  // films whose tracking was graded "fail" count as well
};
int run_calibrate(const CalibrateCommand& command);

struct TrackCommand {
  CommonOptions common;
  std::filesystem::path experiment;
};
int run_track(const TrackCommand& command);

struct ValidateCommand {
  CommonOptions common;
  std::filesystem::path experiment;
  std::filesystem::path parameters;
  std::optional<double> require_agreement;  // percent, Student form
  int runs = 10;                            // whose mean is scored
};
int run_validate(const ValidateCommand& command);

struct ReproduceCommand {
  CommonOptions common;
  std::vector<std::string> targets;  // empty: all-quick
  bool list = false;
};
int run_reproduce(const ReproduceCommand& command);

struct FitCommand {
  CommonOptions common;  // out, json
  std::filesystem::path data;
  double diameter = 0.0;            // m, of a particle; 0: a column of the table
  double gravity = 9.81;            // m/s2
  std::string law = "slot";         // or circular
  std::string form = "default";     // or thesis
  std::optional<double> imposed_k;  // for the coefficient of each row
  double height = 0.0;              // m, of a velocity profile above the orifice
  double orifice = 0.0;             // m
  double bin_width = 0.0;           // m, of the bin of a profile; 0: not known
};
int run_fit_beverloo(const FitCommand& command);
int run_fit_kinematic(const FitCommand& command);

struct ReportCommand {
  std::filesystem::path run_folder;
  bool pdf = false;
};
int run_report(const ReportCommand& command);

struct ExportCommand {
  std::filesystem::path run_folder;
  std::string to;             // liggghts, lammps, yade or csv
  std::filesystem::path out;  // empty: RUN_DIR/export/<to>
};
int run_export(const ExportCommand& command);

struct EvaluateCommand {
  CommonOptions common;
  std::filesystem::path experiment;
  std::filesystem::path parameters;
  int runs = 0;  // seeds; 0: as many as an evaluation of the search has
};
int run_evaluate(const EvaluateCommand& command);

struct CheckCommand {
  CommonOptions common;
  std::filesystem::path experiment;
  int budget = 0;  // evaluations, for the estimate of the time; 0: the default
};
int run_check(const CheckCommand& command);

struct AnnotateCommand {
  CommonOptions common;                       // out
  std::vector<std::filesystem::path> inputs;  // an experiment file, or films
  std::string rig;                            // of films alone: the kind of their rig
  std::filesystem::path apply;                // an annotation to be put in place; empty: none
};
int run_annotate(const AnnotateCommand& command);

struct NewCommand {
  std::string kind;  // micro, macro, walls or scene
  std::filesystem::path folder;
};
int run_new(const NewCommand& command);

struct SimulateCommand {
  CommonOptions common;
  std::filesystem::path scene;    // .toml, or a deck .txt
  std::filesystem::path sidecar;  // of a deck; empty: beside it, or the bundled one of its name
  double time_limit = 0.0;        // s; 0: none
  bool render = false;
  bool povray = false;
  bool paraview = false;
  bool ovito = false;
};
int run_simulate(const SimulateCommand& command);

// One task of a batch system. Users never type it.
struct RunTaskCommand {
  std::filesystem::path folder;  // of one job array
  int index = 0;
};
int run_run_task(const RunTaskCommand& command);

enum class JournalAction { list, show, export_rows, drop, merge };
struct JournalCommand {
  JournalAction action = JournalAction::list;
  std::filesystem::path run_folder;
  std::vector<std::int64_t> ids;  // show: one; drop: any number
  bool failed = false;            // drop
  bool damaged = false;           // drop
  std::string problem;            // drop; a hash
  std::filesystem::path other;    // merge; a run folder
  std::filesystem::path out;      // export; empty: journal.csv of the run, "-": stdout
};
int run_journal(const JournalCommand& command);

}  // namespace graintruth::app
