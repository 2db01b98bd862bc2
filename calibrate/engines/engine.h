// A simulator as the calibration sees it: a spec in, a recording out. An engine is one file of this
// folder; one line of kinds.def makes it known by its name.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "calibrate/engines/simulation_spec.h"
#include "datasets/experiment/recording.h"

namespace graintruth::calibrate {

// How a simulation ended. Only a completed one is compared with the experiment; the others are
// counted, and scored as a model in which nothing moves.
enum class RunStatus { completed, unstable, timed_out };
std::string_view name_of(RunStatus status);

struct EngineRun {
  RunStatus status = RunStatus::completed;
  std::string message;  // one sentence where the run did not complete, or not at the step asked for
  datasets::Recording recording;  // empty after a bad end
  double time_step = 0.0;         // s
  double seconds = 0.0;           // processor time spent
};

// Limits go by counts and never by a clock: the same spec ends the same on every machine.
struct EngineOptions {
  // Steps, beyond which a run counts as timed out; 0: many times those that its filling and phases
  // let expect. The journal never gives such a run back, so that another limit may end it
  // otherwise.
  std::int64_t step_limit = 0;
  std::function<bool()> stop;  // asked now and then; true: throw Interrupted
  // Of engines that are other programs
  double time_limit = 0.0;        // s, as step_limit; 0: none
  std::filesystem::path scratch;  // for their files; empty: the system's folder for such
  std::filesystem::path folder;   // that a command's files are looked for in
};

struct Interrupted : std::runtime_error {
  Interrupted() : std::runtime_error("interrupted; run the same command again to resume") {}
};

class Engine {
 public:
  virtual ~Engine() = default;
  virtual std::string_view name() const = 0;
  // Changes whenever the engine gives other numbers for the same spec.
  virtual std::string version() const = 0;
  // Whether [simulation] says more of it than its name.
  virtual bool is_another_program() const { return false; }
  // What it can record of the spec's scene beside tracks and discharge: the names of all curves.
  virtual std::vector<std::string> curves(const SimulationSpec& spec) const = 0;
  // The largest fraction of the Rayleigh step that gives every contact of the spec enough steps.
  // Throws datasets::InputError for a scene that cannot be simulated.
  virtual double largest_time_step_fraction(const SimulationSpec& spec) const = 0;
  // Deterministic in the spec. Throws Interrupted, and nothing else, when the user wants to stop.
  virtual EngineRun run(const SimulationSpec& spec, const EngineOptions& options) const = 0;
};

// The engine of this name. Throws datasets::InputError that names those that are known.
const Engine& engine_named(std::string_view name);
std::vector<std::string_view> engine_names();
// Makes an engine known that is not one of the program's own: a study's, or a test's.
void make_known(const Engine& (*engine)());

// A run that becomes unstable is tried once more at half the time step.
EngineRun run_with_retry(const Engine& engine,
                         const SimulationSpec& spec,
                         const EngineOptions& options);

}  // namespace graintruth::calibrate
