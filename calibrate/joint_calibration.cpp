#include "calibrate/joint_calibration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "calibrate/joint_comparison.h"

namespace graintruth::calibrate {

namespace {

// The scene `times` over, each time with seeds of its own.
std::vector<Scene> repeated(const Scene& scene, int times) {
  std::vector<Scene> scenes = {scene};
  for (int time = 1; time < times; ++time) {
    const std::string problem = fmt::format("{}/{}", scene.problem, time);
    scenes.push_back({problem, [simulator = scene.simulator, problem](SimulationRequest request) {
                        request.seed = make_seeds(request.seed, problem, 1).front();
                        return simulator(request);
                      }});
  }
  return scenes;
}

std::shared_ptr<const Comparison> comparison_of(const JointMember& member) {
  if (member.tracks) return member.tracks->comparison;
  return member.bin->calibrated;
}

// Of the score of tracks, which is told as it is everywhere else.
CalibrationOptions tracks_options(const CalibrationOptions& options) {
  CalibrationOptions own = options;
  own.confirmation_seeds =
      std::max(options.confirmation_seeds, CalibrationOptions{}.confirmation_seeds);
  return own;
}

int simulations_of_confirmations(std::span<const JointMember> members,
                                 const CalibrationOptions& options) {
  int simulations = 0;
  for (const JointMember& member : members) {
    simulations += member.tracks ? simulations_of_confirmation(tracks_options(options))
                                 : simulations_of_bin_confirmation(*member.bin, options);
  }
  return simulations;
}

// What the search found, seen by one of the experiments.
SearchResult seen_by(const SearchResult& found,
                     const JointComparison& comparison,
                     std::span<const JointMember> members,
                     std::size_t i) {
  SearchResult own = found;
  for (Evaluation& evaluation : own.evaluations) evaluation = comparison.part_of(evaluation, i);
  std::vector<std::string> others;
  for (const JointMember& member : members) {
    if (member.name != members[i].name) others.push_back(member.name);
  }
  own.warnings = {fmt::format(
      "These parameters and their intervals were found together with {}; this page tells how they "
      "do in this experiment.",
      fmt::join(others, ", "))};
  return own;
}

}  // namespace

CalibrationOptions joint_options(std::span<const JointMember> members) {
  const bool any_bin = std::any_of(
      members.begin(), members.end(), [](const JointMember& one) { return one.bin.has_value(); });
  CalibrationOptions options = any_bin ? bin_options() : CalibrationOptions{};
  for (const JointMember& member : members)
    options.largest_time_step_fraction =
        std::min(options.largest_time_step_fraction, member.largest_time_step_fraction);
  return options;
}

ProblemParts parts_of(std::span<const JointMember> members) {
  ProblemParts all;
  for (const JointMember& member : members) {
    for (const auto& [name, hash] : member.tracks ? member.tracks->parts : member.bin->parts)
      all.emplace_back(fmt::format("{} of {}", name, member.name), hash);
  }
  return all;
}

JointCalibrationResult calibrate_jointly(const datasets::Experiment& common,
                                         std::span<const JointMember> members,
                                         Journal& journal,
                                         const CalibrationOptions& options) {
  // 1. All experiments as one
  const int repeats =
      std::max(1, CalibrationOptions{}.search_seeds / std::max(1, options.search_seeds));
  std::vector<ComparedExperiment> compared;
  std::vector<Scene> scenes;
  for (const JointMember& member : members) {
    std::size_t count = member.searched.size();
    if (member.tracks) {
      const std::vector<Scene> copies = repeated(member.searched.front(), repeats);
      scenes.insert(scenes.end(), copies.begin(), copies.end());
      count = copies.size();
    } else {
      scenes.insert(scenes.end(), member.searched.begin(), member.searched.end());
    }
    compared.push_back({comparison_of(member), count, member.weight});
  }
  const auto comparison = std::make_shared<JointComparison>(std::move(compared));
  Ensemble ensemble(std::move(scenes), journal, comparison, options.jobs);

  // 2. The search, and what its parameters mean to each experiment
  Search search(common, ensemble, options, simulations_of_confirmations(members, options));
  search.run();
  int simulated = ensemble.simulated();
  std::vector<std::optional<Confirmation>> confirmed(members.size());
  std::vector<std::optional<BinScore>> scored(members.size());
  for (std::size_t i = 0; i < members.size(); ++i) {
    const JointMember& member = members[i];
    if (member.tracks) {
      Ensemble alone(member.all, journal, member.tracks->comparison, options.jobs);
      confirmed[i] = confirm(*member.tracks, alone, tracks_options(options), search);
      simulated += alone.simulated();
    } else {
      Ensemble alone(member.all, journal, member.bin->all, options.jobs);
      scored[i] = confirm_bin(*member.bin, alone, options, search);
      simulated += alone.simulated();
    }
  }

  // 3. Put together
  JointCalibrationResult result{search.finish()};
  result.simulated = simulated;
  double variance = 0.0;
  for (std::size_t i = 0; i < members.size(); ++i) {
    const JointMember& member = members[i];
    JointMemberResult own;
    SearchResult seen = seen_by(result, *comparison, members, i);
    if (member.tracks) {
      own.tracks = conclude(
          *member.tracks, tracks_options(options), std::move(seen), std::move(*confirmed[i]));
      own.objective = own.tracks->score.evaluation.objective;
      own.tracks->time_step.time_step = own.tracks->score.evaluation.runs.front().time_step;
    } else {
      own.bin = conclude_bin(*member.bin, std::move(seen), std::move(*scored[i]));
      own.objective = member.bin->calibrated->objective(own.bin->score.calibrated_runs);
      own.bin->time_step.time_step = own.bin->score.evaluation.runs.front().time_step;
    }
    const SearchResult& of_member = own.tracks ? static_cast<const SearchResult&>(*own.tracks)
                                               : static_cast<const SearchResult&>(*own.bin);
    result.objective += member.weight * own.objective;
    variance += std::pow(member.weight * of_member.objective_noise, 2);
    // The first says that there are others, which here is no news
    for (std::size_t w = 1; w < of_member.warnings.size(); ++w)
      result.warnings.push_back(fmt::format("{}: {}", member.name, of_member.warnings[w]));
    result.members.push_back(std::move(own));
  }
  result.objective_noise = std::sqrt(variance);
  return result;
}

}  // namespace graintruth::calibrate
