#include "calibrate/calibration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "calibrate/knowledge/identifiability.h"

namespace graintruth::calibrate {

namespace {

constexpr int alternatives = 4;  // parameter sets that show what their uncertainty does

// A bed of which the outline is all that is seen is simulated with all of its grains.
bool simulates_outlines(const Problem& problem) {
  return std::any_of(problem.scenes.begin(), problem.scenes.end(), [](const ProblemScene& scene) {
    return !scene.spec.record.outlines.empty();
  });
}

// As a score is told everywhere: of the mean over as many runs, whatever else is calibrated with
// it. Outlines have no such score.
ConfirmationOptions confirmation_of(const Problem& problem, const CalibrationOptions& options) {
  ConfirmationOptions how{.seed = options.seed, .runs = options.confirmation_seeds, .halved = 1};
  if (problem.simulates_each_replicate()) return how;
  if (!simulates_outlines(problem))
    how.runs = std::max(how.runs, CalibrationOptions{}.confirmation_seeds);
  how.halved = how.runs;
  return how;
}

int simulations_of_confirmations(std::span<const CalibratedExperiment> experiments,
                                 const CalibrationOptions& options) {
  int simulations = 0;
  for (const CalibratedExperiment& one : experiments) {
    simulations +=
        simulations_of_confirmation(*one.problem, confirmation_of(*one.problem, options));
    if (one.problem->simulates_each_replicate())
      simulations += alternatives * static_cast<int>(one.problem->scenes.size());
  }
  return simulations;
}

// Times that a search for `count` experiments simulates each scene of this one: where it averages
// over seeds, over as many as alone.
int repeats_of(const CalibratedExperiment& one,
               std::size_t count,
               const CalibrationOptions& options) {
  if (count == 1 || one.problem->simulates_each_replicate()) return 1;
  const int alone = default_options({&one, 1}).search_seeds;
  return std::max(1, alone / std::max(1, options.search_seeds));
}

// All experiments as the search compares them, and the scenes that it simulates.
struct Searched {
  std::vector<ComparedExperiment> compared;
  std::vector<Scene> scenes;
};

void add_searched(const CalibratedExperiment& one,
                  int repeats,
                  const EngineOptions& engine_options,
                  Searched& searched) {
  ComparedExperiment compared = one.problem->calibrated->experiments().front();
  compared.weight = one.weight;
  const std::vector<Scene> scenes =
      scenes_of(*one.problem, one.problem->calibrated_scenes, engine_options);
  if (repeats > 1) {
    Layout repeated_layout = compared.layout;
    repeated_layout.scenes = 0;
    for (ComparedCondition& condition : repeated_layout.conditions) {
      std::vector<std::size_t> places;
      for (const std::size_t scene : condition.scenes) {
        for (Scene& copy : repeated(scenes[scene], repeats)) {
          places.push_back(repeated_layout.scenes++);
          searched.scenes.push_back(std::move(copy));
        }
      }
      condition.scenes = std::move(places);
    }
    compared.layout = std::move(repeated_layout);
  } else {
    searched.scenes.insert(searched.scenes.end(), scenes.begin(), scenes.end());
  }
  searched.compared.push_back(std::move(compared));
}

// What the search found, seen by one of several experiments.
SearchResult seen_by(const SearchResult& found,
                     const ChannelComparison& comparison,
                     std::span<const CalibratedExperiment> experiments,
                     std::size_t i) {
  SearchResult own = found;
  if (experiments.size() == 1) return own;
  for (Evaluation& evaluation : own.evaluations) evaluation = comparison.part_of(evaluation, i);
  std::vector<std::string> others;
  for (const CalibratedExperiment& one : experiments) {
    if (one.name != experiments[i].name) others.push_back(one.name);
  }
  own.warnings = {fmt::format(
      "These parameters and their intervals were found together with {}; this page tells how "
      "well they describe this experiment.",
      fmt::join(others, ", "))};
  return own;
}

void warn_of_step(const Problem& problem, ExperimentResult& result) {
  const auto check = half_step_of(problem, result.confirmed);
  if (!check) return;
  const auto& [change, noise, allowed] = check->objective;
  const std::string sizes = fmt::format(
      "half the time step changes the objective by {:.2g}, give or take {:.2g}, where {:.2g} would "
      "be little beside what other replicates could change",
      change,
      noise.half_width,
      allowed);
  if (check->objective.verdict() == StepVerdict::changes) {
    result.warnings.push_back(datasets::first_line(
        fmt::format("At the parameters found, {}: the result depends on the time step.", sizes),
        "at half the time step the result is another",
        "Look at the time-step study"));
  } else if (check->objective.verdict() == StepVerdict::not_resolved) {
    result.warnings.push_back(
        fmt::format("At the parameters found the time step is not resolved: {}. More fresh runs "
                    "would tell more.",
                    sizes));
  }
}

// Where one experiment leaves parameters together, another one that would tell them apart.
void name_second_experiment(const Problem& problem, ExperimentResult& result) {
  const bool is_open =
      !result.trade_offs.empty() ||
      !find_open_pairs(result.calibrated, result.trade_offs).empty() ||
      std::any_of(result.calibrated.begin(), result.calibrated.end(), [](const auto& parameter) {
        return parameter.status == ParameterStatus::not_identified;
      });
  if (!is_open || problem.experiment.rig.complement.empty()) return;
  result.warnings.push_back(
      fmt::format("Parameters that this experiment leaves together are told apart by {}; calibrate "
                  "both by one file with [[experiment]].",
                  problem.experiment.rig.complement));
}

}  // namespace

CalibrationOptions default_options(std::span<const CalibratedExperiment> experiments) {
  CalibrationOptions options;
  const bool each = std::any_of(experiments.begin(), experiments.end(), [](const auto& one) {
    return one.problem->simulates_each_replicate();
  });
  if (each) {
    options = {.budget = 60,
               .search_seeds = 1,
               .gate_seeds = 1,
               .most_gate_seeds = 4,
               .confirmation_seeds = 3,
               .choice_candidates = 3};
  }
  const bool outlines = std::any_of(experiments.begin(), experiments.end(), [](const auto& one) {
    return simulates_outlines(*one.problem);
  });
  if (outlines) {
    options = {.budget = 40,
               .search_seeds = 2,
               .gate_seeds = 2,
               .most_gate_seeds = 8,
               .confirmation_seeds = 4,
               .choice_candidates = 3};
  }
  options.largest_time_step_fraction = 1.0;
  for (const CalibratedExperiment& one : experiments) {
    options.largest_time_step_fraction =
        std::min(options.largest_time_step_fraction, one.problem->largest_time_step_fraction());
  }
  return options;
}

double expected_cost(std::span<const CalibratedExperiment> experiments,
                     const CalibrationOptions& options) {
  std::size_t scenes = 0;
  for (const CalibratedExperiment& one : experiments) {
    const int repeats = repeats_of(one, experiments.size(), options);
    scenes += one.problem->calibrated_scenes.size() * static_cast<std::size_t>(repeats);
  }
  return expected_cost(scenes, options) + simulations_of_confirmations(experiments, options);
}

ProblemParts parts_of(std::span<const CalibratedExperiment> experiments) {
  if (experiments.size() == 1) return experiments.front().problem->parts;
  ProblemParts all;
  for (const CalibratedExperiment& one : experiments) {
    for (const auto& [name, hash] : one.problem->parts)
      all.emplace_back(fmt::format("{} of {}", name, one.name), hash);
  }
  return all;
}

CalibrationResult calibrate(const datasets::Experiment& common,
                            std::span<const CalibratedExperiment> experiments,
                            Journal& journal,
                            Executor& executor,
                            const EngineOptions& engine_options,
                            const CalibrationOptions& options) {
  // 1. All experiments as one
  Searched searched;
  for (const CalibratedExperiment& one : experiments)
    add_searched(one, repeats_of(one, experiments.size(), options), engine_options, searched);
  const auto comparison = std::make_shared<ChannelComparison>(
      std::move(searched.compared), experiments.front().problem->calibrated->form());
  Ensemble ensemble(std::move(searched.scenes), journal, comparison, executor);
  // 2. The search
  Search search(common, ensemble, options, simulations_of_confirmations(experiments, options));
  search.run();
  int simulated = ensemble.simulated();
  // 3. What its parameters mean to each experiment
  std::vector<Confirmed> confirmed(experiments.size());
  search.timed("confirmation", [&] {
    for (std::size_t i = 0; i < experiments.size(); ++i) {
      const Problem& problem = *experiments[i].problem;
      ConfirmationOptions how = confirmation_of(problem, options);
      if (problem.simulates_each_replicate() && !common.tuned.empty()) {
        for (const Evaluation& evaluation : search.compatible_evaluations(alternatives))
          how.alternatives.push_back(evaluation.parameters);
      }
      Ensemble all(scenes_of(problem, problem.every_scene(), engine_options),
                   journal,
                   problem.all,
                   executor);
      confirmed[i] = confirm(
          problem, all, {search.parameters(), search.time_step_fraction()}, how, [&](double cost) {
            return search.reporter(cost);
          });
      search.count({&confirmed[i].runs, 1});
      search.count(confirmed[i].others());
      simulated += all.simulated();
    }
  });
  // 4. Put together
  CalibrationResult result{search.finish()};
  result.simulated = simulated;
  double variance = 0.0;
  for (std::size_t i = 0; i < experiments.size(); ++i) {
    const auto& [name, problem, weight] = experiments[i];
    ExperimentResult own{seen_by(result, *comparison, experiments, i), std::move(confirmed[i])};
    own.objective_noise = own.confirmed.noise;
    own.time_step.time_step = own.confirmed.runs.runs.front().time_step;
    own.influence = influence_of_each(*problem->calibrated, own.evaluations);
    warn_of_step(*problem, own);
    if (experiments.size() == 1) name_second_experiment(*problem, own);
    result.objective += weight * own.confirmed.objective;
    variance += std::pow(weight * own.objective_noise, 2);
    result.experiments.push_back(std::move(own));
  }
  result.objective_noise = std::sqrt(variance);
  return result;
}

}  // namespace graintruth::calibrate
