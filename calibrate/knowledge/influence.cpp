#include "calibrate/knowledge/influence.h"

#include <fmt/format.h>

#include <limits>

namespace graintruth::calibrate {

namespace {

constexpr double worth_a_look = 5.0;   // times the lowest objective; what is higher cannot win
constexpr std::size_t enough = 3;      // particles: what is left still has a spread
constexpr std::size_t quantities = 3;  // x, z and angle of a particle

InfluenceRow best_without(std::string left_out,
                          const Comparison& rest,
                          const std::vector<Evaluation>& candidates) {
  InfluenceRow row{std::move(left_out), {}, 0.0};
  bool is_first = true;
  for (const Evaluation& candidate : candidates) {
    const double value = rest.objective(candidate.runs);
    if (!is_first && value >= row.objective) continue;
    is_first = false;
    row.best = candidate.parameters;
    row.objective = value;
  }
  return row;
}

std::vector<double> without_particle(const std::vector<double>& values,
                                     std::size_t particles,
                                     std::size_t left_out) {
  std::vector<double> rest;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i / quantities % particles != left_out) rest.push_back(values[i]);
  }
  return rest;
}

Channel without_particle(const Channel& channel, std::size_t particles, std::size_t left_out) {
  Channel rest = channel;
  rest.values = without_particle(channel.values, particles, left_out);
  rest.errors = without_particle(channel.errors, particles, left_out);
  return rest;
}

void leave_out_particles(const ChannelComparison& comparison,
                         const std::vector<Evaluation>& candidates,
                         std::vector<InfluenceRow>& rows) {
  const ComparedExperiment& whole = comparison.experiments().front();
  const auto place = whole.observables->find("tracks");
  if (!place || comparison.rule_of("tracks") == nullptr) return;
  const auto moments = static_cast<std::size_t>(whole.situations.front().measurement.frames);
  const std::size_t particles = whole.measured.front()[*place].values.size() / moments / quantities;
  if (particles < enough) return;
  for (std::size_t particle = 0; particle < particles; ++particle) {
    ComparedExperiment rest = whole;
    for (std::vector<Channel>& channels : rest.measured)
      channels[*place] = without_particle(channels[*place], particles, particle);
    std::vector<Evaluation> reduced = candidates;
    for (Evaluation& candidate : reduced) {
      for (SimulatedRun& run : candidate.runs) {
        if (run.status == RunStatus::completed)
          run.channels[*place] = without_particle(run.channels[*place], particles, particle);
      }
    }
    rows.push_back(best_without(fmt::format("particle {}", particle + 1),
                                ChannelComparison({std::move(rest)}, comparison.form()),
                                reduced));
  }
}

}  // namespace

std::vector<InfluenceRow> influence_of_each(const ChannelComparison& comparison,
                                            std::span<const Evaluation> evaluations) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Evaluation& evaluation : evaluations) lowest = std::min(lowest, evaluation.objective);
  std::vector<Evaluation> candidates;
  for (const Evaluation& evaluation : evaluations) {
    if (evaluation.objective > worth_a_look * lowest) continue;
    if (!comparison.residuals(evaluation.runs).empty()) candidates.push_back(evaluation);
  }
  std::vector<InfluenceRow> rows;
  if (candidates.empty()) return rows;
  const std::size_t replicates = comparison.experiments().front().measured.size();
  for (std::size_t i = 0; i < replicates; ++i) {
    if (const auto rest = comparison.without_replicate(0, i))
      rows.push_back(best_without(fmt::format("replicate {}", i + 1), *rest, candidates));
  }
  leave_out_particles(comparison, candidates, rows);
  return rows;
}

}  // namespace graintruth::calibrate
