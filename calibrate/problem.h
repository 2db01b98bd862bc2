// One calibration problem: an experiment and its recordings, measured once, in the form that every
// stage works from; and what is simulated for it.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibrate/compare/channel_comparison.h"
#include "calibrate/compare/start_poses.h"
#include "calibrate/engines/engine.h"
#include "calibrate/ensemble.h"
#include "datasets/experiment/experiment.h"
#include "datasets/experiment/recording.h"
#include "datasets/verdict/warning.h"

namespace graintruth::calibrate {

// Replicates whose rig had the same settings.
struct Condition {
  std::string name;  // "orifice width 65 mm"; empty where there is only one condition
  std::vector<datasets::RigSetting> settings;
  std::vector<std::size_t> replicates;  // of the experiment
  std::vector<std::size_t> scenes;      // of the problem
  bool held_out = false;                // predicted, not calibrated on
};

// What is simulated: a condition, or one replicate of it from a start of its own.
struct ProblemScene {
  std::size_t condition = 0;
  std::size_t replicate = 0;  // the own one, or the first of the condition
  bool is_of_one_replicate = false;
  SimulationSpec spec;  // but for parameters, time step and seed
};

// What a problem is made of, part by part: the part's name as a person would say it, and a hash of
// its contents.
using ProblemParts = SpecParts;

struct Problem {
  datasets::Experiment experiment;
  std::shared_ptr<const Observables> observables;
  std::vector<Situation> situations;             // of the replicates
  std::vector<std::vector<Channel>> measured;    // of the replicates
  std::vector<Condition> conditions;             // rising in their settings
  std::vector<ProblemScene> scenes;              // in the order of the conditions' replicates
  std::vector<std::size_t> calibrated_scenes;    // those of conditions that are not held out
  std::shared_ptr<const ChannelComparison> all;  // of all scenes
  std::shared_ptr<const ChannelComparison> calibrated;  // of those
  ProblemParts parts;
  const Engine* engine = nullptr;
  double simulated_modulus = 0.0;  // Pa; below the bench's where grains are simulated softer
  std::vector<datasets::Warning> warnings;  // what some recordings do not tell

  // Whether every replicate is simulated from a start of its own, so that one simulation of each
  // makes an evaluation.
  bool simulates_each_replicate() const;
  SimulationSpec spec_of(std::size_t scene,
                         const ParameterSet& parameters,
                         double time_step_fraction,
                         std::uint64_t seed) const;
  // At which every contact has enough steps, in all scenes.
  double largest_time_step_fraction() const;
  std::vector<std::size_t> every_scene() const;
};

// The conditions of an experiment, without scenes. Held out is what the file says; where it says
// nothing, openings narrower than six grain diameters, whose flow arches (thesis 4.3.3), as long as
// two wider ones remain. Throws datasets::InputError where a part of a condition is held out.
std::vector<Condition> conditions_of(const datasets::Experiment& experiment);

// `recordings` are those of the replicates, in the order of the experiment file. Throws
// datasets::InputError where the recordings do not fit the experiment or each other, or do not tell
// what is to be compared.
Problem make_problem(const datasets::Experiment& experiment,
                     std::span<const datasets::Recording> recordings,
                     const Engine& engine = engine_named("embedded"));

// Conditions and scenes alone, of recordings that need not tell what is compared: films that have
// not been tracked, of which only starts and lengths are known.
Problem plan_problem(const datasets::Experiment& experiment,
                     std::span<const datasets::Recording> recordings,
                     const Engine& engine = engine_named("embedded"));

// Throws datasets::InputError where recordings do not fit the experiment, whether or not they tell
// what is to be compared.
void check_recordings(const datasets::Experiment& experiment,
                      std::span<const datasets::Recording> recordings);

// Whoever changes what an observable measures bumps it, so that old simulations are not read back
// with what was measured of them.
inline constexpr int measuring_version = 3;

// What decides, besides the recordings, what is measured of them: moments, observables, settings.
std::string measuring_text(const datasets::Experiment& experiment);

// The mass of a grain that a scene states by its density, which takes its shape. Throws
// datasets::InputError for a scene that cannot be built.
void complete_particle(datasets::Experiment& experiment);

// Throws datasets::InputError for an experiment that nothing can be compared of, or a curve that
// the engine does not record, before any film is tracked for nothing.
void require_comparable(const datasets::Experiment& experiment,
                        const Engine& engine = engine_named("embedded"));

// Throws datasets::InputError where no condition that is calibrated on has two replicates.
void require_repeats(const datasets::Experiment& experiment, std::span<const Condition> conditions);

// Of the replicates of a condition that `may_be`, the one whose values lie nearest to the mean of
// all where replicates repeat them, else the first. None where none may be.
std::optional<std::size_t> typical_replicate(const Problem& problem,
                                             const Condition& condition,
                                             const std::function<bool(std::size_t)>& may_be);

// The scenes of these places as an ensemble simulates them.
std::vector<Scene> scenes_of(const Problem& problem,
                             std::span<const std::size_t> places,
                             const EngineOptions& options);

}  // namespace graintruth::calibrate
