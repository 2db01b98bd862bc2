#include "calibrate/observables/track_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/compare/agreement.h"
#include "calibrate/compare/repeated_rule.h"
#include "calibrate/flow/median.h"
#include "calibrate/observables/moments.h"

namespace graintruth::calibrate {

namespace {

using datasets::number_text;
using datasets::Table;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// The quantities of a body, as files call them.
std::vector<std::string> quantities_of(const ChannelShape& shape) {
  return shape.difference.size() == 3 ? std::vector<std::string>{"x", "z", "angle"}
                                      : std::vector<std::string>{"z"};
}

struct Compared {
  const RepeatedRule& rule;
  std::size_t condition = 0;  // of the comparison of all
  std::size_t channel = 0;
  std::vector<double> moments;            // s
  std::vector<const SimulatedRun*> runs;  // that completed
  std::vector<double> mean;               // of them; empty where most failed
};

Compared compared_of(std::string_view observable,
                     const Problem& problem,
                     const Confirmed& confirmed) {
  const auto& rule = static_cast<const RepeatedRule&>(*problem.all->rule_of(observable));
  Compared compared{.rule = rule, .channel = *problem.observables->find(observable)};
  while (compared.condition + 1 < problem.conditions.size() &&
         problem.conditions[compared.condition].held_out)
    ++compared.condition;
  const Condition& condition = problem.conditions[compared.condition];
  compared.moments = problem.observables->all()[compared.channel]->axis(
      problem.situations[condition.replicates.front()]);
  const std::size_t seeds = confirmed.runs.runs.size() / problem.scenes.size();
  for (const std::size_t scene : condition.scenes) {
    for (std::size_t seed = 0; seed < seeds; ++seed) {
      const SimulatedRun& run = confirmed.runs.runs[scene * seeds + seed];
      if (run.status == RunStatus::completed) compared.runs.push_back(&run);
    }
  }
  compared.mean = rule.simulated_mean(*rule.digest(confirmed.runs.runs), compared.condition);
  return compared;
}

std::size_t bodies_of(const ChannelShape& shape) { return shape.series / shape.difference.size(); }

void add_agreement_table(const Agreement& thesis, const Agreement& student, Results& results) {
  Table table({"particle",
               "rank0",
               "rank1",
               "rank2",
               "rank3",
               "points",
               "possible",
               "percent",
               "percent_student_t"});
  for (std::size_t i = 0; i < thesis.per_particle.size(); ++i) {
    const ParticleAgreement& row = thesis.per_particle[i];
    std::vector<std::string> cells = {std::to_string(row.particle)};
    for (const int frames : row.frames_of_rank) cells.push_back(std::to_string(frames));
    cells.push_back(std::to_string(row.points));
    cells.push_back(std::to_string(row.possible));
    cells.push_back(number_text(row.percent));
    cells.push_back(number_text(student.per_particle[i].percent));
    table.add(std::move(cells));
  }
  results.tables["agreement"] = std::move(table);
}

void add_ranks(const Compared& compared,
               const Agreement& thesis,
               const Agreement& student,
               Results& results) {
  Table table({"frame", "time_s", "particle", "rank", "rank_student_t"});
  const std::size_t bodies = bodies_of(compared.rule.shape());
  for (std::size_t i = 0; i < thesis.ranks.size(); ++i) {
    if (thesis.ranks[i] < 0) continue;
    table.add({std::to_string(i / bodies),
               number_text(compared.moments[i / bodies]),
               std::to_string(i % bodies + 1),
               std::to_string(thesis.ranks[i]),
               std::to_string(student.ranks[i])});
  }
  results.tables["ranks"] = std::move(table);
}

// Replicates' mean and 95 % intervals beside the simulated mean and the standard deviation of its
// single runs.
void add_bands(const Compared& compared, Results& results) {
  const ChannelShape& shape = compared.rule.shape();
  std::vector<const Channel*> channels;
  for (const SimulatedRun* run : compared.runs)
    channels.push_back(&run->channels[compared.channel]);
  const std::vector<Spread> simulated = spreads_of(channels, shape);
  const std::vector<std::string> quantities = quantities_of(shape);
  Table table({"frame",
               "time_s",
               "particle",
               "quantity",
               "replicate_mean",
               "lower_196",
               "upper_196",
               "lower_t",
               "upper_t",
               "simulated_mean",
               "simulated_lower",
               "simulated_upper"});
  const std::vector<Spread>& spreads = compared.rule.target(compared.condition).spreads;
  for (std::size_t i = 0; i < spreads.size(); ++i) {
    const std::size_t moment = i / shape.series, series = i % shape.series;
    const Spread& measured = spreads[i];
    const double error = measured.standard_deviation / std::sqrt(std::max(1, measured.count));
    const double z = critical_value(Critical::thesis_196, measured.count) * error;
    const double t =
        measured.count < 2 ? nan : critical_value(Critical::student_t, measured.count) * error;
    Spread model{.mean = nan, .standard_deviation = nan};
    if (!simulated.empty()) model = simulated[i];
    // Drawn on the branch of the measured angle.
    const double mean =
        measured.mean + difference(shape.difference_of(i), model.mean, measured.mean);
    table.add({std::to_string(moment),
               number_text(compared.moments[moment]),
               std::to_string(series / quantities.size() + 1),
               quantities[series % quantities.size()],
               number_text(measured.mean),
               number_text(measured.mean - z),
               number_text(measured.mean + z),
               number_text(measured.mean - t),
               number_text(measured.mean + t),
               number_text(mean),
               number_text(mean - model.standard_deviation),
               number_text(mean + model.standard_deviation)});
  }
  results.tables["bands"] = std::move(table);
}

// Each replicate less the simulated mean: one replicate that stands out shows here.
void add_residuals(const Compared& compared, const Problem& problem, Results& results) {
  const ChannelShape& shape = compared.rule.shape();
  const std::vector<std::string> quantities = quantities_of(shape);
  Table table({"frame", "time_s", "particle", "quantity", "replicate", "residual"});
  const Condition& condition = problem.conditions[compared.condition];
  for (const std::size_t replicate : condition.replicates) {
    const std::vector<double>& values = problem.measured[replicate][compared.channel].values;
    for (std::size_t i = 0; i < std::min(values.size(), compared.mean.size()); ++i) {
      const double residual = difference(shape.difference_of(i), values[i], compared.mean[i]);
      if (!std::isfinite(residual)) continue;
      const std::size_t moment = i / shape.series, series = i % shape.series;
      table.add({std::to_string(moment),
                 number_text(compared.moments[moment]),
                 std::to_string(series / quantities.size() + 1),
                 quantities[series % quantities.size()],
                 problem.experiment.replicates[replicate].name,
                 number_text(residual)});
    }
  }
  results.tables["residuals"] = std::move(table);
}

// The quantities that some body has an interval of: tracks may tell no angles.
Json compared_quantities(const std::vector<Spread>& spreads, const ChannelShape& shape) {
  const std::vector<std::string> names = quantities_of(shape);
  Json compared = Json::array();
  for (std::size_t q = 0; q < names.size(); ++q) {
    bool is_measured = false;
    for (std::size_t i = q; i < spreads.size(); i += names.size())
      is_measured = is_measured || spreads[i].count >= 2;
    if (is_measured) compared.push_back(names[q]);
  }
  return compared;
}

Json per_particle_json(const Agreement& thesis, const Agreement& student) {
  Json per_particle = Json::array();
  for (std::size_t i = 0; i < thesis.per_particle.size(); ++i) {
    const ParticleAgreement& row = thesis.per_particle[i];
    per_particle.push_back({{"particle", row.particle},
                            {"rank0", row.frames_of_rank[0]},
                            {"rank1", row.frames_of_rank[1]},
                            {"rank2", row.frames_of_rank[2]},
                            {"rank3", row.frames_of_rank[3]},
                            {"points", row.points},
                            {"possible", row.possible},
                            {"percent", row.percent},
                            {"percent_student_t", student.per_particle[i].percent}});
  }
  return per_particle;
}

// What the terminal tells of the agreement.
std::string score_line(
    double student, double thesis, double ceiling, double leave_one_out, int replicates) {
  return fmt::format(
      "Agreement {:.1f} % (Student t; a perfect model scores {:.1f} % on average, {}), {:.1f} % in "
      "the thesis's form",
      student,
      ceiling,
      std::isnan(leave_one_out)
          ? fmt::format("{} replicates are too few to score one by the others", replicates)
          : fmt::format("a further replicate {:.1f} %", leave_one_out),
      thesis);
}

}  // namespace

ChannelShape shape_of_tracks(std::size_t grains) {
  return {.widths = Widths::own_replicates,
          .series = 3 * grains,
          .difference = {Difference::plain, Difference::plain, Difference::half_turn},
          // Far below any camera's
          .least_error = {1.0e-5, 1.0e-5, 1.0e-4}};  // m, m, rad
}

double rms_position(const std::vector<double>& a,
                    const std::vector<double>& b,
                    const ChannelShape& shape) {
  const std::size_t step = shape.difference.size();
  double squares = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i + step <= std::min(a.size(), b.size()); i += step) {
    double square = 0.0;
    for (std::size_t q = 0; q < std::min<std::size_t>(step, 2); ++q) {
      const double apart = a[i + q] - b[i + q];
      square += apart * apart;
    }
    if (!std::isfinite(square)) continue;
    squares += square;
    ++count;
  }
  return count == 0 ? nan : std::sqrt(squares / static_cast<double>(count));
}

void conclude_agreement(std::string_view observable,
                        const Problem& problem,
                        const Confirmed& confirmed,
                        Results& results) {
  if (problem.observables->of_agreement()->name() != observable) return;
  const Compared compared = compared_of(observable, problem, confirmed);
  const ChannelShape& shape = compared.rule.shape();
  const RepeatedRule::Target& target = compared.rule.target(compared.condition);
  const auto score = [&](const std::vector<double>& values, Critical critical, std::size_t first) {
    return agreement(target.spreads, shape, values, critical, first);
  };
  // 1. Of the mean over all runs, and of single ones
  const Agreement thesis = score(compared.mean, Critical::thesis_196, 0),
                  student = score(compared.mean, Critical::student_t, 0);
  std::vector<double> thesis_single, student_single;
  for (const SimulatedRun* run : compared.runs) {
    const std::vector<double>& values = run->channels[compared.channel].values;
    thesis_single.push_back(score(values, Critical::thesis_196, 0).percent);
    student_single.push_back(score(values, Critical::student_t, 0).percent);
  }
  // 2. What can be said of such a score before any model is run
  const std::vector<const Channel*> replicates = compared.rule.replicates_of(compared.condition);
  const auto count = static_cast<int>(replicates.size());
  const auto seeds = static_cast<int>(confirmed.runs.runs.size() / problem.scenes.size());
  const double leave_one_out = leave_one_out_percent(replicates, shape, Critical::student_t);
  const double ceiling = ceiling_percent(count, seeds, Critical::student_t);
  results.json["agreement"] = {
      {"quantities", compared_quantities(target.spreads, shape)},
      {"percent", thesis.percent},
      {"percent_student_t", student.percent},
      {"ceiling_percent", ceiling_percent(count, seeds, Critical::thesis_196)},
      {"ceiling_percent_student_t", ceiling},
      {"leave_one_out_percent", leave_one_out_percent(replicates, shape, Critical::thesis_196)},
      {"leave_one_out_percent_student_t", leave_one_out},
      {"replicates", count},
      {"seeds", seeds},
      {"single_run_median_percent", median(std::move(thesis_single))},
      {"single_run_median_percent_student_t", median(std::move(student_single))},
      {"without_first_frame",
       {{"percent", score(compared.mean, Critical::thesis_196, 1).percent},
        {"percent_student_t", score(compared.mean, Critical::student_t, 1).percent}}},
      {"per_particle", per_particle_json(thesis, student)}};
  results.json["rms_position_m"] = rms_position(compared.mean, target.mean, shape);
  add_agreement_table(thesis, student, results);
  add_ranks(compared, thesis, student, results);
  add_bands(compared, results);
  add_residuals(compared, problem, results);
  results.lines.push_back(
      compared.mean.empty()
          ? "No agreement: most simulations failed, so that they have no mean"
          : score_line(student.percent, thesis.percent, ceiling, leave_one_out, count));
  // A model that agrees less with the replicates than they do with each other is not the answer
  if (student.percent < leave_one_out) {
    results.warnings.push_back(fmt::format(
        "The parameters found agree in {:.0f} % only, less than a repeat of the experiment would "
        "({:.0f} %): the search ended in a wrong valley (raise --budget or narrow the bounds), or "
        "the model lacks something.",
        student.percent,
        leave_one_out));
  }
}

void tell_agreement(std::string_view observable,
                    const Problem& problem,
                    const Evaluation& evaluation,
                    Results& results) {
  if (problem.observables->of_agreement()->name() != observable) return;
  const auto& rule = static_cast<const RepeatedRule&>(*problem.calibrated->rule_of(observable));
  const RepeatedRule::Target& target = rule.target(0);
  const std::vector<double> mean = rule.simulated_mean(*rule.digest(evaluation.runs), 0);
  const auto score = [&](Critical critical) {
    return agreement(target.spreads, rule.shape(), mean, critical);
  };
  const Agreement thesis = score(Critical::thesis_196), student = score(Critical::student_t);
  results.json["agreement_percent"] = thesis.percent;
  results.json["agreement_percent_student_t"] = student.percent;
  // By what the score is judged
  const std::vector<const Channel*> replicates = rule.replicates_of(0);
  const auto count = static_cast<int>(replicates.size());
  const auto seeds = static_cast<int>(evaluation.runs.size() / problem.calibrated_scenes.size());
  results.json["agreement"] = {
      {"percent_student_t", student.percent},
      {"ceiling_percent_student_t", ceiling_percent(count, seeds, Critical::student_t)},
      {"leave_one_out_percent_student_t",
       leave_one_out_percent(replicates, rule.shape(), Critical::student_t)},
      {"replicates", count},
      {"seeds", seeds},
      {"per_particle", per_particle_json(thesis, student)}};
  results.json["rms_position_m"] = rms_position(mean, target.mean, rule.shape());
}

// Mean tracks of all replicates at the moments of the comparison, and where grains lie before the
// event.
void tell_tracks(const MeasuredExperiment& measured, Results& results) {
  const auto place = measured.observables.find("tracks");
  std::vector<const Channel*> channels;
  std::vector<const datasets::Trajectories*> tracks;
  for (std::size_t r = 0; r < measured.channels.size(); ++r) {
    if (!measured.channels[r][*place].is_known()) return;
    channels.push_back(&measured.channels[r][*place]);
    tracks.push_back(&*measured.recordings[r].tracks);
  }
  const auto particles = static_cast<std::size_t>(tracks.front()->particles);
  const ChannelShape shape = shape_of_tracks(particles);
  const std::vector<Spread> spreads = spreads_of(channels, shape);
  const std::vector<double> moments =
      measured.observables.all()[*place]->axis(measured.situations.front());
  Json names = Json::array(), starts = Json::array(), mean_tracks = Json::array();
  for (const datasets::Replicate& replicate : measured.experiment.replicates)
    names.push_back(replicate.name);
  const StartPoses start = measure_starts(tracks);
  for (const datasets::Pose& pose : start.mean)
    starts.push_back({{"x_m", pose.x}, {"z_m", pose.z}, {"angle_rad", pose.angle}});
  for (std::size_t i = 0; i < spreads.size(); i += 3) {
    mean_tracks.push_back({{"time_s", moments[i / shape.series]},
                           {"particle", i % shape.series / 3 + 1},
                           {"x_m", spreads[i].mean},
                           {"z_m", spreads[i + 1].mean},
                           {"angle_rad", spreads[i + 2].mean},
                           {"standard_deviation_x_m", spreads[i].standard_deviation},
                           {"standard_deviation_z_m", spreads[i + 1].standard_deviation},
                           {"standard_deviation_angle_rad", spreads[i + 2].standard_deviation},
                           {"replicates", spreads[i].count}});
  }
  const datasets::Pose& spread = start.standard_deviation;
  results.json["replicates"] = names;
  results.json["particles"] = particles;
  results.json["frames"] = moments;
  results.json["starts"] = starts;
  results.json["start_standard_deviation"] = {
      {"x_m", spread.x}, {"z_m", spread.z}, {"angle_rad", spread.angle}};
  results.json["mean_tracks"] = mean_tracks;
}

}  // namespace graintruth::calibrate
