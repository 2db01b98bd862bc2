#include "calibrate/influence.h"

#include <fmt/format.h>

#include <algorithm>

namespace graintruth::calibrate {

namespace {

constexpr double worth_a_look = 5.0;  // times the lowest objective; what is higher cannot win
constexpr std::size_t enough = 3;     // of a kind: what is left still has a spread

datasets::Trajectories without_particle(const datasets::Trajectories& tracks,
                                        std::size_t left_out) {
  datasets::Trajectories rest =
      datasets::make_trajectories(tracks.frames(), tracks.particles - 1, !tracks.sigmas.empty());
  rest.time = tracks.time;
  const auto particles = static_cast<std::size_t>(tracks.particles);
  for (std::size_t frame = 0; frame < tracks.frames(); ++frame) {
    for (std::size_t particle = 0; particle + 1 < particles; ++particle) {
      const std::size_t to = frame * (particles - 1) + particle;
      const std::size_t from = frame * particles + particle + (particle >= left_out ? 1 : 0);
      rest.poses[to] = tracks.poses[from];
      if (!tracks.sigmas.empty()) rest.sigmas[to] = tracks.sigmas[from];
      if (!tracks.scores.empty()) rest.scores[to] = tracks.scores[from];
    }
  }
  return rest;
}

// Mean tracks of the evaluations that may win, so that seeds are averaged once.
struct Candidate {
  const Evaluation* evaluation;
  datasets::Trajectories mean;
};

InfluenceRow best_without(std::string left_out,
                          const TrackComparison& rest,
                          const std::vector<Candidate>& candidates) {
  InfluenceRow row{std::move(left_out), {}, 0.0};
  bool is_first = true;
  for (const Candidate& candidate : candidates) {
    const double value = objective(rest.target().mean, rest.target().widths, candidate.mean);
    if (!is_first && value >= row.objective) continue;
    is_first = false;
    row.best = candidate.evaluation->parameters;
    row.objective = value;
  }
  return row;
}

}  // namespace

std::vector<InfluenceRow> influence_of_each(const TrackComparison& comparison,
                                            std::span<const Evaluation> evaluations) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Evaluation& evaluation : evaluations) lowest = std::min(lowest, evaluation.objective);
  std::vector<Candidate> candidates;
  for (const Evaluation& evaluation : evaluations) {
    if (evaluation.objective > worth_a_look * lowest) continue;
    datasets::Trajectories mean = mean_of_runs(evaluation.runs);
    if (!mean.poses.empty()) candidates.push_back({&evaluation, std::move(mean)});
  }
  std::vector<InfluenceRow> rows;
  if (candidates.empty()) return rows;

  const std::vector<datasets::Trajectories>& replicates = comparison.replicates();
  if (replicates.size() >= enough) {
    for (std::size_t i = 0; i < replicates.size(); ++i) {
      std::vector<datasets::Trajectories> rest = replicates;
      rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
      rows.push_back(best_without(fmt::format("replicate {}", i + 1),
                                  TrackComparison(std::move(rest), comparison.form()),
                                  candidates));
    }
  }
  const auto particles = static_cast<std::size_t>(replicates.front().particles);
  if (particles >= enough) {
    for (std::size_t particle = 0; particle < particles; ++particle) {
      std::vector<datasets::Trajectories> rest;
      for (const datasets::Trajectories& replicate : replicates)
        rest.push_back(without_particle(replicate, particle));
      std::vector<Candidate> reduced;
      for (const Candidate& candidate : candidates)
        reduced.push_back({candidate.evaluation, without_particle(candidate.mean, particle)});
      rows.push_back(best_without(fmt::format("particle {}", particle + 1),
                                  TrackComparison(std::move(rest), comparison.form()),
                                  reduced));
    }
  }
  return rows;
}

}  // namespace graintruth::calibrate
