// The bundled calibration against its truth: runs the program as a user does, then compares what it
// found with datasets/micro/truth/truth.toml, which the program itself never reads.
//   bench_calibration_micro [FIGURES.json] [RUN_DIR]
#include <toml++/toml.h>

#include "bench/calibrate/truth_check.h"

using namespace graintruth::bench;

namespace {

const fs::path micro = fs::path(GRAINTRUTH_SOURCE_DIR) / "datasets" / "micro";

}  // namespace

int main(int argc, char** argv) {
  const fs::path figures = argc > 1 ? argv[1] : "calibration_micro.json";
  const fs::path folder = argc > 2 ? argv[2] : "out/bench/micro";
  const fs::path truth_folder = folder.string() + "-at-truth";

  // 1. The calibration, and the score at the true parameters with the same seeds, films and time
  // step
  run(fmt::format(
      "calibrate '{}' --out '{}' --quiet", (micro / "experiment.toml").string(), folder.string()));
  const Json result = read_json(folder / "result.json");
  const toml::table truth = toml::parse_file((micro / "truth" / "truth.toml").string());
  const double true_pp = truth["parameters"]["mu_particle_particle"].value<double>().value();
  const double true_pw = truth["parameters"]["mu_particle_wall"].value<double>().value();
  const double true_e = truth["parameters"]["restitution"].value<double>().value();
  Json at_truth;
  at_truth["parameters"]["friction_particle_particle"]["value"] = true_pp;
  at_truth["parameters"]["friction_particle_wall"]["value"] = true_pw;
  at_truth["parameters"]["restitution"]["value"] = true_e;
  at_truth["time_step"]["fraction"] = result["time_step"]["fraction"];
  fs::create_directories(truth_folder);
  fs::copy(folder / "tracks",
           truth_folder / "tracks",
           fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  std::ofstream(truth_folder / "truth.json") << at_truth.dump(2);
  run(fmt::format("validate '{}' --parameters '{}' --out '{}' --quiet",
                  (micro / "experiment.toml").string(),
                  (truth_folder / "truth.json").string(),
                  truth_folder.string()));
  const Json truth_result = read_json(truth_folder / "result.json");

  // 2. What must hold
  const Json& pp = result["parameters"]["friction_particle_particle"];
  const Json& pw = result["parameters"]["friction_particle_wall"];
  const double width = number(pp, "upper") - number(pp, "lower");
  const Json& agreement = result["agreement"];
  const double score = agreement["percent_student_t"];
  const double leave_one_out = agreement["leave_one_out_percent_student_t"];
  const double score_at_truth = truth_result["agreement"]["percent_student_t"];
  const double thesis_score = agreement["percent"];
  const double thesis_leave_one_out = agreement["leave_one_out_percent"];
  const double thesis_at_truth = truth_result["agreement"]["percent"];
  const std::vector<Check> checks = {
      {"friction particle-particle",
       pp["value"],
       fmt::format("within 0.04 of {}", true_pp),
       std::abs(pp["value"].get<double>() - true_pp) <= 0.04},
      {"its interval",
       width,
       fmt::format("[{:.3f}, {:.3f}] holds {}, no wider than 0.14",
                   number(pp, "lower"),
                   number(pp, "upper"),
                   true_pp),
       holds_inside(pp, true_pp) && width <= 0.14},
      {"friction particle-wall",
       pw["value"],
       fmt::format("[{:.3f}, {:.3f}] holds {}", number(pw, "lower"), number(pw, "upper"), true_pw),
       holds_inside(pw, true_pw)},
      {"restitution",
       result["parameters"]["restitution"]["value"],
       "status " + result["parameters"]["restitution"]["status"].get<std::string>() +
           " is not_identified",
       result["parameters"]["restitution"]["status"] == "not_identified"},
      {"agreement, Student",
       score,
       fmt::format("at least the replicates' {:.1f}", leave_one_out),
       score >= leave_one_out},
      {"agreement, Student",
       score,
       fmt::format("{:+.1f} points against {:.1f} at the truth; not below -5",
                   score - score_at_truth,
                   score_at_truth),
       score - score_at_truth >= -5.0},
      {"agreement, thesis form",
       thesis_score,
       fmt::format("at least the replicates' {:.1f}", thesis_leave_one_out),
       thesis_score >= thesis_leave_one_out},
      {"agreement, thesis form",
       thesis_score,
       fmt::format("{:+.1f} points against {:.1f} at the truth; not below -5",
                   thesis_score - thesis_at_truth,
                   thesis_at_truth),
       thesis_score - thesis_at_truth >= -5.0},
      {"wall time, s",
       result["wall_time_s"],
       "at most 300",
       result["wall_time_s"].get<double>() <= 300.0},
  };

  return report(checks, figures);
}
