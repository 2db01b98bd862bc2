#include "calibrate/problem.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "calibrate/engines/scene_build.h"
#include "calibrate/observables/moments.h"
#include "calibrate/problem_scenes.h"
#include "datasets/parameters/apply.h"
#include "datasets/parameters/parameter.h"
#include "datasets/store/fingerprint.h"
#include "datasets/store/input_error.h"
#include "datasets/store/toml_section.h"

namespace graintruth::calibrate {

namespace {

using datasets::BeginsFrom;
using datasets::Experiment;
using datasets::InputError;
using datasets::Recording;

constexpr double arching_diameters = 6.0;  // openings narrower than this arch

// --- Recordings
// -----------------------------------------------------------------------------------

// A recording that every moment of the comparison lies in.
void check_span(const Experiment& experiment,
                const datasets::Replicate& replicate,
                const std::vector<double>& time) {
  const double last = experiment.measurement.last_time();
  if (spans(time, last)) return;
  throw InputError(
      fmt::format("{}: the recording spans {:.3f} to {:.3f} s from the start event, but the "
                  "comparison needs 0 to {:.3f} s; lower measure.frames or film for longer.",
                  replicate.file().string(),
                  time.empty() ? 0.0 : time.front(),
                  time.empty() ? 0.0 : time.back(),
                  last));
}

void check_fit(const Experiment& experiment, std::span<const Recording> recordings) {
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const datasets::Replicate& replicate = experiment.replicates[i];
    const auto& tracks = recordings[i].tracks;
    if (!tracks) continue;
    if (experiment.rig.begins_from == BeginsFrom::mean_of_replicates) {
      check_span(experiment, replicate, tracks->time);
    } else if (tracks->frames() < 2 || tracks->time.back() <= 0.0) {
      throw InputError(fmt::format(
          "{}: nothing is seen after the start event; film until the flow ends.", replicate.name));
    }
  }
}

// What a recording tells and cannot be.
void refuse_contradictions(const datasets::Replicate& replicate,
                           const Observables& observables,
                           const std::vector<Channel>& measured,
                           const Situation& situation) {
  for (std::size_t place = 0; place < measured.size(); ++place) {
    const std::string complaint =
        observables.all()[place]->contradiction(measured[place], situation);
    if (complaint.empty()) continue;
    const auto& file = replicate.curves.empty() ? replicate.file() : replicate.curves;
    throw InputError(fmt::format("{}: {}.", file.string(), complaint));
  }
}

Situation situation_of(const Experiment& experiment, const datasets::Replicate& replicate) {
  Situation situation{
      .particle = experiment.particle, .rig = replicate.rig, .measurement = experiment.measurement};
  situation.measurement.observables.clear();
  return situation;
}

// What is asked for and no recording gives.
void check_observables(const Problem& problem) {
  const Observables& observables = *problem.observables;
  for (const auto& [place, weight] : observables.compared()) {
    const Observable& observable = *observables.all()[place];
    std::vector<std::string> lacking;
    for (std::size_t i = 0; i < problem.measured.size(); ++i) {
      if (!problem.measured[i][place].is_known())
        lacking.push_back(problem.experiment.replicates[i].name);
    }
    // A law is of all conditions together
    if (lacking.empty() || (problem.all && problem.all->rule_of(observable.name()) != nullptr))
      continue;
    throw InputError(fmt::format("{}: '{}' cannot be compared: {} {} no such data. It needs {}.",
                                 problem.experiment.file.string(),
                                 observable.name(),
                                 fmt::join(lacking, ", "),
                                 lacking.size() == 1 ? "has" : "have",
                                 observable.lacking_words()));
  }
}

// Numbers and curves of the same quantity cannot be averaged.
void check_kinds_of_values(const Problem& problem) {
  for (const auto& [place, weight] : problem.observables->compared()) {
    std::optional<std::size_t> number, curve;
    for (std::size_t i = 0; i < problem.measured.size(); ++i) {
      const Channel& channel = problem.measured[i][place];
      if (channel.is_known()) (channel.values.size() == 1 ? number : curve) = i;
    }
    if (!number || !curve) continue;
    throw InputError(
        fmt::format("{}: '{}' is one number in {} and a curve in {}; give a column time_s in the "
                    "tables of all replicates, or in none.",
                    problem.experiment.file.string(),
                    problem.observables->all()[place]->name(),
                    problem.experiment.replicates[*number].name,
                    problem.experiment.replicates[*curve].name));
  }
}

// Simulations that end before the last moment of what is compared.
void check_durations(const Problem& problem) {
  const double last = problem.experiment.measurement.last_time();
  for (const auto& observable : problem.observables->all()) {
    if (!observable->needs_every_moment()) continue;
    for (const ProblemScene& scene : problem.scenes) {
      const datasets::SceneData& simulated = scene.spec.scene;
      double duration = 0.0;
      for (auto p = static_cast<std::size_t>(simulated.event_phase); p < simulated.phases.size();
           ++p)
        duration += simulated.phases[p].duration;
      if (duration >= last - 0.5 * simulated.phases.back().output_interval) continue;
      throw InputError(fmt::format(
          "{}: '{}' is compared until {:.4g} s after the start event, but the simulation of {} "
          "lasts {:.4g} s; lower measure.frames, or let the run of the rig last longer.",
          problem.experiment.file.string(),
          observable->name(),
          last,
          problem.experiment.replicates[scene.replicate].name,
          duration));
    }
  }
}

// What no simulation of the scene records.
void check_curves(const Experiment& experiment,
                  const Observables& observables,
                  const datasets::SceneData& scene,
                  const Engine& engine) {
  const std::vector<std::string> known =
      engine.curves({.scene = scene, .foreign = experiment.simulator.foreign});
  for (const auto& observable : observables.all()) {
    for (const std::string& curve : observable->curves()) {
      if (std::find(known.begin(), known.end(), curve) != known.end()) continue;
      throw InputError(
          fmt::format("{}: key 'measure.{}.engine_curve' names '{}', but the simulator records of "
                      "this rig {}.",
                      experiment.file.string(),
                      observable->name(),
                      curve,
                      known.empty() ? "no curve" : fmt::format("{}", fmt::join(known, ", "))));
    }
  }
}

// --- Conditions
// -----------------------------------------------------------------------------------

// Replicates with the same settings together.
std::vector<Condition> same_settings(const Experiment& experiment) {
  std::vector<Condition> conditions;
  for (std::size_t i = 0; i < experiment.replicates.size(); ++i) {
    const auto& settings = experiment.replicates[i].rig.settings;
    auto at = std::find_if(conditions.begin(), conditions.end(), [&](const Condition& one) {
      return one.settings == settings;
    });
    if (at == conditions.end()) at = conditions.insert(at, Condition{.settings = settings});
    at->replicates.push_back(i);
  }
  std::stable_sort(conditions.begin(), conditions.end(), [](const auto& a, const auto& b) {
    return std::lexicographical_compare(
        a.settings.begin(),
        a.settings.end(),
        b.settings.begin(),
        b.settings.end(),
        [](const auto& x, const auto& y) { return x.value < y.value; });
  });
  if (conditions.size() > 1) {
    for (Condition& condition : conditions) condition.name = words_on(condition.settings);
  }
  return conditions;
}

// What was fitted and what is predicted is never averaged.
void choose_held_out(const Experiment& experiment, std::vector<Condition>& conditions) {
  const bool is_stated = std::any_of(
      experiment.replicates.begin(), experiment.replicates.end(), [](const auto& replicate) {
        return replicate.held_out.has_value();
      });
  std::size_t wide = 0;
  for (Condition& condition : conditions) {
    const datasets::Replicate& first = experiment.replicates[condition.replicates.front()];
    const auto& opening = first.rig.opening;
    if (opening && opening->width() >= arching_diameters * experiment.particle.diameter) ++wide;
    if (!is_stated) continue;
    condition.held_out = first.held_out.value_or(false);
    for (const std::size_t r : condition.replicates) {
      if (experiment.replicates[r].held_out.value_or(false) == condition.held_out) continue;
      throw InputError(fmt::format(
          "{}: some replicates of {} are held out and some are not; hold out all of them, or none.",
          experiment.file.string(),
          condition.name.empty() ? std::string("one condition") : "the " + condition.name));
    }
  }
  if (is_stated || wide < 2) return;
  for (Condition& condition : conditions) {
    const auto& opening = experiment.replicates[condition.replicates.front()].rig.opening;
    condition.held_out =
        !opening || opening->width() < arching_diameters * experiment.particle.diameter;
  }
}

// --- The comparison
// -------------------------------------------------------------------------------

std::shared_ptr<const ChannelComparison> comparison_of(const Problem& problem,
                                                       bool with_held_out,
                                                       datasets::ObjectiveForm form) {
  ComparedExperiment compared{.observables = problem.observables,
                              .situations = problem.situations,
                              .measured = problem.measured};
  for (const Condition& condition : problem.conditions) {
    if (condition.held_out && !with_held_out) continue;
    ComparedCondition one{.name = condition.name, .replicates = condition.replicates};
    one.is_paired = problem.scenes[condition.scenes.front()].is_of_one_replicate;
    for (std::size_t k = 0; k < condition.scenes.size(); ++k)
      one.scenes.push_back(compared.layout.scenes++);
    compared.layout.conditions.push_back(std::move(one));
  }
  return std::make_shared<ChannelComparison>(std::vector{std::move(compared)}, form);
}

// Whether the recordings tell anything that is compared, of a replicate at least.
bool anything_is_measured(const Problem& problem) {
  for (const auto& [place, weight] : problem.observables->compared()) {
    for (const std::vector<Channel>& channels : problem.measured) {
      if (channels[place].is_known()) return true;
    }
  }
  return false;
}

void compare(Problem& problem) {
  const Experiment& experiment = problem.experiment;
  const auto refuse_scatter = [&] {
    require_repeats(experiment, problem.conditions);
    throw InputError(fmt::format(
        "{}: The replicates of a condition do not differ, or not in anything that is compared. "
        "Give independent recordings: the scatter between them is the measure of every "
        "difference.",
        experiment.file.string()));
  };
  try {
    problem.all = comparison_of(problem, true, datasets::ObjectiveForm::smooth);
  } catch (const std::invalid_argument&) {
    if (anything_is_measured(problem)) {
      check_observables(problem);
      refuse_scatter();
    }
    const Observable& observable = *problem.observables->all().front();
    throw InputError(fmt::format("{}: nothing can be compared; '{}' takes {}.",
                                 experiment.file.string(),
                                 observable.name(),
                                 observable.lacking_words()));
  }
  check_observables(problem);
  const auto refuse_form = [&] {
    throw InputError(fmt::format(
        "{}: tune.objective = \"requested\" compares Beverloo's C and k. That needs tracks of "
        "steady flow through at least two orifices that are not held out; use \"smooth\".",
        experiment.file.string()));
  };
  try {
    problem.calibrated = comparison_of(problem, false, experiment.objective);
  } catch (const std::invalid_argument&) {
    if (experiment.objective == datasets::ObjectiveForm::requested) refuse_form();
    refuse_scatter();
  }
}

// All that decides a simulation or its comparison, in parts that a person can name.
void add_parts(Problem& problem) {
  std::vector<std::pair<std::string, std::string>> texts;
  const auto append = [&](const std::string& name, const std::string& text) {
    for (auto& [known, all] : texts) {
      if (known != name) continue;
      all += text;
      return;
    }
    texts.emplace_back(name, text);
  };
  for (const ProblemScene& scene : problem.scenes) {
    for (const auto& [name, hash] : parts_of(scene.spec)) append(name, hash);
  }
  std::string values = measuring_text(problem.experiment);
  for (const std::vector<Channel>& channels : problem.measured) {
    for (const Channel& channel : channels) {
      for (const double value : channel.values) values += fmt::format("{};", value);
      for (const double error : channel.errors) values += fmt::format("{};", error);
    }
  }
  append("recordings or [measure]", values);
  for (const auto& [name, text] : texts)
    problem.parts.emplace_back(name, datasets::content_hash(text));
}

}  // namespace

std::string measuring_text(const Experiment& experiment) {
  const datasets::Measurement& measurement = experiment.measurement;
  std::string text = fmt::format("{}; every {} s, {} times;",
                                 measuring_version,
                                 measurement.frame_interval,
                                 measurement.frames);
  for (const datasets::RequestedObservable& requested : measurement.observables) {
    text += requested.name + ";";
    // Objectives are computed anew from what was measured, and pages are written anew
    if (requested.settings) text += requested.settings->text_without({"weight", "title", "unit"});
  }
  return text;
}

std::vector<Condition> conditions_of(const Experiment& experiment) {
  std::vector<Condition> conditions = same_settings(experiment);
  choose_held_out(experiment, conditions);
  return conditions;
}

void complete_particle(Experiment& experiment) {
  if (!experiment.rig.brings_grains) return;
  const BuiltScene built = build_scene(experiment.rig.scene, experiment.file.string());
  double mass = 0.0;
  for (const sim::Clump& type : built.scene.types)
    mass += type.mass / static_cast<double>(built.scene.types.size());
  experiment.particle.mass = mass;
}

void require_comparable(const Experiment& experiment, const Engine& engine) {
  if (experiment.measurement.observables.empty()) {
    throw InputError(
        fmt::format("{}: nothing is compared; name it in [measure], observables = [...].",
                    experiment.file.string()));
  }
  const Observables observables(experiment);
  for (const datasets::Replicate& replicate : experiment.replicates)
    check_curves(experiment, observables, replicate.rig.scene, engine);
}

void require_repeats(const Experiment& experiment, std::span<const Condition> conditions) {
  for (const Condition& condition : conditions) {
    if (!condition.held_out && condition.replicates.size() > 1) return;
  }
  throw InputError(fmt::format(
      "{}: No condition used for calibration has two replicates. Add one: the scatter between "
      "replicates is the measure of every difference.",
      experiment.file.string()));
}

bool Problem::simulates_each_replicate() const {
  return std::any_of(scenes.begin(), scenes.end(), [](const ProblemScene& scene) {
    return scene.is_of_one_replicate;
  });
}

std::vector<std::size_t> Problem::every_scene() const {
  std::vector<std::size_t> places(scenes.size());
  for (std::size_t i = 0; i < places.size(); ++i) places[i] = i;
  return places;
}

SimulationSpec Problem::spec_of(std::size_t scene,
                                const ParameterSet& parameters,
                                double time_step_fraction,
                                std::uint64_t seed) const {
  SimulationSpec spec = scenes[scene].spec;
  spec.parameters = parameters;
  spec.time_step_fraction = time_step_fraction;
  spec.seed = seed;
  datasets::apply_parameters(parameters, spec.scene);
  for (datasets::ScenePhase& phase : spec.scene.phases)
    phase.time_step_fraction = time_step_fraction;
  return spec;
}

double Problem::largest_time_step_fraction() const {
  // A contact of soft grains lasts fewer Rayleigh steps: E^-0.4 against E^-0.5
  ParameterSet softest = datasets::bench_parameters(experiment);
  for (const datasets::TunedParameter& tuned : experiment.tuned) {
    if (datasets::parameter_named(tuned.name).kind->sets_stiffness)
      softest.set(tuned.name, tuned.lower);
  }
  double largest = 1.0;
  for (std::size_t scene = 0; scene < scenes.size(); ++scene) {
    largest =
        std::min(largest, engine->largest_time_step_fraction(spec_of(scene, softest, 1.0, 0)));
  }
  return largest;
}

Problem plan_problem(const Experiment& experiment,
                     std::span<const Recording> recordings,
                     const Engine& engine) {
  require_comparable(experiment, engine);
  Problem problem{.experiment = experiment,
                  .observables = std::make_shared<Observables>(experiment),
                  .engine = &engine};
  problem.conditions = conditions_of(experiment);
  make_scenes(recordings, problem);
  check_durations(problem);
  for (const Condition& condition : problem.conditions) {
    if (condition.held_out) continue;
    problem.calibrated_scenes.insert(
        problem.calibrated_scenes.end(), condition.scenes.begin(), condition.scenes.end());
  }
  return problem;
}

void check_recordings(const Experiment& experiment, std::span<const Recording> recordings) {
  check_fit(experiment, recordings);
  plan_problem(experiment, recordings, engine_named(experiment.simulator.engine));
  const Observables observables(experiment);
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const datasets::Replicate& replicate = experiment.replicates[i];
    const Situation situation = situation_of(experiment, replicate);
    refuse_contradictions(
        replicate, observables, observables.measure(recordings[i], situation), situation);
  }
}

Problem make_problem(const Experiment& experiment,
                     std::span<const Recording> recordings,
                     const Engine& engine) {
  check_fit(experiment, recordings);
  // 1. What is simulated
  Problem problem = plan_problem(experiment, recordings, engine);
  say_what_is_prepared(recordings, problem);
  // 2. Every replicate measured
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const datasets::Replicate& replicate = experiment.replicates[i];
    Situation situation = situation_of(experiment, replicate);
    problem.measured.push_back(problem.observables->measure(recordings[i], situation));
    refuse_contradictions(replicate, *problem.observables, problem.measured.back(), situation);
    problem.situations.push_back(std::move(situation));
  }
  check_kinds_of_values(problem);
  // 3. How both are compared
  compare(problem);
  add_parts(problem);
  return problem;
}

std::optional<std::size_t> typical_replicate(const Problem& problem,
                                             const Condition& condition,
                                             const std::function<bool(std::size_t)>& may_be) {
  std::optional<std::size_t> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (const std::size_t replicate : condition.replicates) {
    if (!may_be(replicate)) continue;
    // As a run that shows what this replicate does
    const SimulatedRun as_a_run{.channels = problem.measured[replicate]};
    double distance = problem.all->score_run(as_a_run, condition.scenes.front()).objective;
    if (problem.scenes[condition.scenes.front()].is_of_one_replicate) distance = 0.0;
    if (nearest && !(distance < least)) continue;
    nearest = replicate;
    least = distance;
  }
  return nearest;
}

std::vector<Scene> scenes_of(const Problem& problem,
                             std::span<const std::size_t> places,
                             const EngineOptions& options) {
  std::vector<Scene> scenes;
  for (const std::size_t place : places) {
    const ProblemScene& scene = problem.scenes[place];
    scenes.push_back(
        {.problem = fingerprint_of(scene.spec),
         .engine = problem.engine,
         .options = options,
         .spec =
             [&problem, place](const ParameterSet& parameters, double fraction, auto seed) {
               return problem.spec_of(place, parameters, fraction, seed);
             },
         .measure =
             [&problem, replicate = scene.replicate](const Recording& recording) {
               return problem.observables->measure(
                   recording, problem.situations[replicate], &problem.measured[replicate]);
             }});
  }
  return scenes;
}

}  // namespace graintruth::calibrate
