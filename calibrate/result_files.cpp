#include "calibrate/result_files.h"

#include <algorithm>
#include <cmath>

#include "calibrate/result_json.h"
#include "datasets/table.h"

namespace graintruth::calibrate {

namespace {

using datasets::number_text;
using datasets::Table;

Json agreement_json(const Problem& problem, const Score& score, const ScoreContext& context) {
  Json per_particle = Json::array();
  for (std::size_t i = 0; i < score.thesis.per_particle.size(); ++i) {
    const ParticleAgreement& row = score.thesis.per_particle[i];
    per_particle.push_back({{"particle", row.particle},
                            {"rank0", row.frames_of_rank[0]},
                            {"rank1", row.frames_of_rank[1]},
                            {"rank2", row.frames_of_rank[2]},
                            {"rank3", row.frames_of_rank[3]},
                            {"points", row.points},
                            {"possible", row.possible},
                            {"percent", row.percent},
                            {"percent_student_t", score.student.per_particle[i].percent}});
  }
  Json compared = Json::array();
  for (const Quantity quantity : compared_quantities(problem.comparison->target().replicates))
    compared.push_back(name_of(quantity));
  return {{"quantities", compared},
          {"percent", score.thesis.percent},
          {"percent_student_t", score.student.percent},
          {"ceiling_percent", context.thesis_ceiling},
          {"ceiling_percent_student_t", context.student_ceiling},
          {"leave_one_out_percent", context.thesis_leave_one_out},
          {"leave_one_out_percent_student_t", context.student_leave_one_out},
          {"replicates", problem.comparison->replicates().size()},
          {"seeds", score.evaluation.runs.size()},
          {"single_run_median_percent", score.thesis_single_run_median},
          {"single_run_median_percent_student_t", score.student_single_run_median},
          {"without_first_frame",
           {{"percent", score.thesis_without_first_frame},
            {"percent_student_t", score.student_without_first_frame}}},
          {"per_particle", per_particle}};
}

void write_measured(const datasets::RunFolder& folder, const Problem& problem) {
  Json names = Json::array();
  for (const datasets::Replicate& replicate : problem.experiment.replicates)
    names.push_back(replicate.name);
  Json starts = Json::array();
  for (const datasets::Pose& pose : problem.starts.mean) {
    starts.push_back({{"x_m", pose.x}, {"z_m", pose.z}, {"angle_rad", pose.angle}});
  }
  const Band& band = problem.comparison->target().replicates;
  Json tracks = Json::array();
  for (std::size_t frame = 0; frame < band.frames(); ++frame) {
    for (std::size_t particle = 0; particle < static_cast<std::size_t>(band.particles);
         ++particle) {
      const auto& spreads = band.spreads[band.index(frame, particle)];
      tracks.push_back({{"time_s", band.time[frame]},
                        {"particle", particle + 1},
                        {"x_m", spreads[0].mean},
                        {"z_m", spreads[1].mean},
                        {"angle_rad", spreads[2].mean},
                        {"standard_deviation_x_m", spreads[0].standard_deviation},
                        {"standard_deviation_z_m", spreads[1].standard_deviation},
                        {"standard_deviation_angle_rad", spreads[2].standard_deviation},
                        {"replicates", spreads[0].count}});
    }
  }
  const datasets::Pose& spread = problem.starts.standard_deviation;
  write_json(folder.measured(),
             {{"replicates", names},
              {"particles", band.particles},
              {"frames", band.time},
              {"starts", starts},
              {"start_standard_deviation",
               {{"x_m", spread.x}, {"z_m", spread.z}, {"angle_rad", spread.angle}}},
              {"mean_tracks", tracks}});
}

void write_agreement(const datasets::RunFolder& folder, const Score& score) {
  Table table({"particle",
               "rank0",
               "rank1",
               "rank2",
               "rank3",
               "points",
               "possible",
               "percent",
               "percent_student_t"});
  for (std::size_t i = 0; i < score.thesis.per_particle.size(); ++i) {
    const ParticleAgreement& row = score.thesis.per_particle[i];
    std::vector<std::string> cells = {std::to_string(row.particle)};
    for (const int frames : row.frames_of_rank) cells.push_back(std::to_string(frames));
    cells.push_back(std::to_string(row.points));
    cells.push_back(std::to_string(row.possible));
    cells.push_back(number_text(row.percent));
    cells.push_back(number_text(score.student.per_particle[i].percent));
    table.add(std::move(cells));
  }
  datasets::write_csv(folder.table("agreement"), table);
}

void write_ranks(const datasets::RunFolder& folder, const Band& band, const Score& score) {
  Table table({"frame", "time_s", "particle", "rank", "rank_student_t"});
  for (std::size_t frame = 0; frame < band.frames(); ++frame) {
    for (std::size_t particle = 0; particle < static_cast<std::size_t>(band.particles);
         ++particle) {
      const std::size_t i = band.index(frame, particle);
      if (score.thesis.ranks[i] < 0) continue;
      table.add({std::to_string(frame),
                 number_text(band.time[frame]),
                 std::to_string(particle + 1),
                 std::to_string(score.thesis.ranks[i]),
                 std::to_string(score.student.ranks[i])});
    }
  }
  datasets::write_csv(folder.table("ranks"), table);
}

// Replicates' mean and 95 % intervals beside the simulated mean and the standard deviation of its
// single runs.
void write_bands(const datasets::RunFolder& folder, const Band& band, const Score& score) {
  const Band simulated = measure(completed_tracks(score.evaluation.runs));
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
  for (std::size_t frame = 0; frame < band.frames(); ++frame) {
    for (std::size_t particle = 0; particle < static_cast<std::size_t>(band.particles);
         ++particle) {
      const std::size_t i = band.index(frame, particle);
      for (std::size_t q = 0; q < quantities.size(); ++q) {
        const Spread& measured = band.spreads[i][q];
        const double error = measured.standard_deviation / std::sqrt(std::max(1, measured.count));
        const double z = critical_value(Critical::thesis_196, measured.count) * error;
        const double t = measured.count < 2
                             ? std::nan("")
                             : critical_value(Critical::student_t, measured.count) * error;
        Spread model{.mean = std::nan(""), .standard_deviation = std::nan("")};
        if (!simulated.spreads.empty()) model = simulated.spreads[i][q];
        // Drawn on the branch of the measured angle.
        const double mean = measured.mean + difference(quantities[q], model.mean, measured.mean);
        table.add({std::to_string(frame),
                   number_text(band.time[frame]),
                   std::to_string(particle + 1),
                   name_of(quantities[q]),
                   number_text(measured.mean),
                   number_text(measured.mean - z),
                   number_text(measured.mean + z),
                   number_text(measured.mean - t),
                   number_text(measured.mean + t),
                   number_text(mean),
                   number_text(mean - model.standard_deviation),
                   number_text(mean + model.standard_deviation)});
      }
    }
  }
  datasets::write_csv(folder.table("bands"), table);
}

void write_friction_rows(const datasets::RunFolder& folder, const CalibrationResult& result) {
  Table table({"friction", "rms_position_m", "spread_m", "agreement_percent"});
  for (const FrictionRow& row : result.friction_rows) {
    table.add({number_text(row.friction),
               number_text(row.rms_position),
               number_text(row.single_run_spread),
               number_text(row.agreement_percent)});
  }
  datasets::write_csv(folder.table("rms_friction"), table);
}

void write_influence(const datasets::RunFolder& folder, const CalibrationResult& result) {
  Table table({"left_out",
               "friction_particle_particle",
               "friction_particle_wall",
               "restitution",
               "objective"});
  for (const InfluenceRow& row : result.influence) {
    table.add({row.left_out,
               number_text(row.best.friction_particle_particle),
               number_text(row.best.friction_particle_wall),
               number_text(row.best.restitution),
               number_text(row.objective)});
  }
  datasets::write_csv(folder.table("influence"), table);
}

void write_comparison(const datasets::RunFolder& folder,
                      const Problem& problem,
                      const Score& score) {
  write_measured(folder, problem);
  write_agreement(folder, score);
  write_ranks(folder, problem.comparison->target().replicates, score);
  write_bands(folder, problem.comparison->target().replicates, score);
}

}  // namespace

EvaluationAgreement agreement_of(const Problem& problem) {
  return [&problem](const Evaluation& evaluation) {
    const datasets::Trajectories mean = mean_of_runs(evaluation.runs);
    if (mean.poses.empty()) return 0.0;
    return agreement(problem.comparison->target().replicates, mean, Critical::student_t).percent;
  };
}

void write_calibration(const datasets::RunFolder& folder,
                       const Problem& problem,
                       const CalibrationOptions& options,
                       const CalibrationResult& result,
                       double wall_time) {
  write_comparison(folder, problem, result.score);
  write_evaluations(folder.table("evaluations"), result.evaluations, agreement_of(problem));
  write_friction_rows(folder, result);
  write_profiles(folder, result);
  write_influence(folder, result);

  Json json = head_json(problem.experiment, "calibration");
  add_search(result, options, json);
  json["objective"]["best"] = result.score.evaluation.objective;
  json["time_step"]["at_half"] = {{"objective_change", result.half_step.objective_change},
                                  {"noise", result.half_step.noise},
                                  {"agreement_change_points", result.half_step.agreement_change}};
  json["agreement"] = agreement_json(problem, result.score, result.context);
  json["rms_position_m"] = result.score.rms_position;
  json["wall_time_s"] = wall_time;
  write_json(folder.result(), json);
}

void write_validation(const datasets::RunFolder& folder,
                      const Problem& problem,
                      const ValidationResult& result,
                      double wall_time) {
  write_comparison(folder, problem, result.score);
  Json json = head_json(problem.experiment, "validation");
  add_given_parameters(problem.experiment, result.parameters, json);
  json["time_step"] = {{"fraction", result.time_step_fraction},
                       {"seconds", result.score.evaluation.runs.front().time_step},
                       {"discretisation_error", nullptr}};
  json["agreement"] = agreement_json(problem, result.score, result.context);
  json["rms_position_m"] = result.score.rms_position;
  json["objective"] = {{"best", result.score.evaluation.objective},
                       {"noise", problem.comparison->noise(result.score.evaluation.runs)}};
  json["evaluations"] = 1;
  json["simulations"] = result.score.evaluation.runs.size();
  json["failed"] = result.score.evaluation.failed;
  json["wall_time_s"] = wall_time;
  json["warnings"] = result.warnings;
  write_json(folder.result(), json);
}

}  // namespace graintruth::calibrate
