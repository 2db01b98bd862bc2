// Runs a scene from its first particle to its last phase. What is kept on the way is up to those
// who derive from it: scene_run.h keeps everything that `simulate` writes, embedded.cpp what a
// calibration compares.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "calibrate/engines/scene_fill.h"

namespace graintruth::calibrate {

struct SceneRunOptions {
  std::uint64_t seed = 1;
  int threads = 1;              // at most; small beds use one. The result does not depend on it
  std::int64_t step_limit = 0;  // more end the run as timed out; 0: the next line counts
  // The same as a multiple of the steps that filling and phases take where nothing waits; 0: no
  // limit
  double step_allowance = 0.0;
  std::function<bool()> stop;  // asked now and then; true ends the run with what it has
  // What is done, of what share of it.
  std::function<void(const std::string& job, double share, const std::string& detail)> progress;
};

struct PhaseRecord {
  std::string name;
  double start = 0.0, end = 0.0;  // s, as simulated
  std::int64_t steps = 0;
  double time_step = 0.0;  // s
  bool came_to_rest = false;
};

class SceneRunner {
 public:
  // `scene` and `options` must outlive it; `origin` is named in sentences. Throws
  // datasets::InputError for a scene that cannot be built.
  SceneRunner(const datasets::SceneData& scene,
              const std::string& origin,
              const SceneRunOptions& options);
  virtual ~SceneRunner() = default;
  SceneRunner(const SceneRunner&) = delete;
  SceneRunner& operator=(const SceneRunner&) = delete;

 protected:
  // All phases. Throws datasets::InputError where the scene cannot start.
  void run_phases();

  // What is looked at: each frame of a phase that has an output interval; the event before it.
  virtual void on_frame(const sim::State& state) = 0;
  virtual void on_event() {}
  // Of the simulation, before it begins.
  virtual void choose(sim::SimulationOptions&) const {}
  // Puts the bodies in that are there at the start. False, with the reason in message_, where they
  // cannot be.
  virtual bool fill();

  bool goes_on() const { return status_ == sim::RunStatus::completed; }
  double coordination_now() const;
  // Of the bodies that are in, which of the filling's they are.
  const std::vector<std::size_t>& numbers() const { return numbers_; }
  // Of that one: a place in the built scene's types.
  int type_of(std::size_t number) const;
  // Of those that were taken out.
  const std::vector<std::size_t>& taken_out() const { return taken_out_; }

  const datasets::SceneData& scene_;
  const SceneRunOptions& options_;
  Generator generator_;
  BuiltScene built_;
  std::unique_ptr<sim::Simulation> simulation_;
  sim::RunStatus status_ = sim::RunStatus::completed;
  std::string message_;
  double event_time_ = 0.0;  // s, as simulated
  bool reached_event_ = false;
  double last_step_ = 0.0;  // s
  std::vector<PhaseRecord> phases_;
  std::vector<std::string> warnings_;

 private:
  void start_simulation(std::size_t particles);
  void add_drop(int type);
  void rain();
  void run_phase(int index);
  void settle(const datasets::ScenePhase& phase, PhaseRecord& record);
  bool is_still() const;
  void advance(double duration, double interval, PhaseRecord& record);
  void advance_taking_out(const datasets::ScenePhase& phase, PhaseRecord& record);
  bool take_out();
  void run_until(double time, const sim::Sampling& sampling, PhaseRecord& record);
  void allow_steps(std::size_t next_phase, double filling);
  void show_progress(double time);
  void report(const std::string& job, double share, const std::string& detail) const;
  [[noreturn]] void refuse_rain(std::size_t fallen, std::size_t wanted) const;

  std::vector<int> types_;  // of all counted particles
  std::vector<std::size_t> numbers_, taken_out_;
  bool is_empty_ = false;     // every body has been taken out
  std::int64_t steps_ = 0;    // of all phases so far
  std::int64_t allowed_ = 0;  // of these; 0 for any number
  std::string job_;
  double job_start_ = 0.0, job_length_ = 1.0;  // s
};

}  // namespace graintruth::calibrate
