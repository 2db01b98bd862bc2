#include "calibrate/score.h"

#include <algorithm>
#include <limits>

namespace graintruth::calibrate {

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

ScoreContext score_context(const Problem& problem, int runs) {
  const int replicates = static_cast<int>(problem.comparison->replicates().size());
  return {ceiling_percent(replicates, runs, Critical::thesis_196),
          ceiling_percent(replicates, runs, Critical::student_t),
          leave_one_out_percent(problem.comparison->replicates(), Critical::thesis_196),
          leave_one_out_percent(problem.comparison->replicates(), Critical::student_t)};
}

Score score(const Problem& problem,
            Ensemble& ensemble,
            const std::string& stage,
            const EvaluationPoint& point,
            std::span<const std::uint64_t> seeds,
            const SimulationProgress& progress) {
  Score scored{.evaluation = ensemble.evaluate(stage, {&point, 1}, seeds, progress).front()};
  const Band& band = problem.comparison->target().replicates;
  datasets::Trajectories mean = mean_of_runs(scored.evaluation.runs);
  // Where no run completed there is no mean: every test fails.
  if (mean.poses.empty()) {
    mean = datasets::make_trajectories(band.frames(), band.particles, false);
    mean.time = band.time;
  }
  scored.thesis = agreement(band, mean, Critical::thesis_196);
  scored.student = agreement(band, mean, Critical::student_t);
  scored.thesis_without_first_frame = agreement(band, mean, Critical::thesis_196, 1).percent;
  scored.student_without_first_frame = agreement(band, mean, Critical::student_t, 1).percent;
  std::vector<double> thesis_single;
  std::vector<double> student_single;
  for (const datasets::Trajectories& track : completed_tracks(scored.evaluation.runs)) {
    thesis_single.push_back(agreement(band, track, Critical::thesis_196).percent);
    student_single.push_back(agreement(band, track, Critical::student_t).percent);
  }
  scored.thesis_single_run_median = median(std::move(thesis_single));
  scored.student_single_run_median = median(std::move(student_single));
  scored.rms_position = rms_position(mean, mean_track(band));
  return scored;
}

}  // namespace graintruth::calibrate
