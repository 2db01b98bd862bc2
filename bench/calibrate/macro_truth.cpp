// The bin's calibration against its truth: runs the program as a user does on the films in
// ../shared, then compares what it found with their truth, which the program itself never reads.
//   bench_calibration_macro [FIGURES.json] [RUN_DIR]
#include <toml++/toml.h>

#include "bench/calibrate/truth_check.h"

using namespace graintruth::bench;

int main(int argc, char** argv) {
  const fs::path source = GRAINTRUTH_SOURCE_DIR;
  const fs::path figures = argc > 1 ? argv[1] : "calibration_macro.json";
  const fs::path folder = argc > 2 ? argv[2] : "out/bench/macro";
  const fs::path truth_file = source / "../shared/lab-videos/macro/truth/truth.toml";
  if (!fs::exists(truth_file)) {
    fmt::print("skipped: {} is not here\n", truth_file.string());
    return 0;
  }
  run(fmt::format("calibrate '{}' --out '{}' --quiet",
                  (source / "datasets/macro/experiment.toml").string(),
                  folder.string()));
  const Json result = read_json(folder / "result.json");
  const toml::table truth = toml::parse_file(truth_file.string());
  const std::pair<const char*, const char*> names[] = {
      {"friction_particle_particle", "mu_particle_particle"},
      {"friction_particle_wall", "mu_particle_wall"},
      {"restitution", "restitution"}};

  std::vector<Check> checks;
  for (const auto& [name, true_name] : names) {
    const Json& parameter = result["parameters"][name];
    const double expected = truth["parameters"][true_name].value<double>().value();
    const bool has_interval = parameter.contains("lower");
    checks.push_back(
        {name,
         parameter["value"],
         has_interval
             ? fmt::format("[{:.3f}, {:.3f}] holds {}",
                           number(parameter, "lower"),
                           number(parameter, "upper"),
                           expected)
             : fmt::format("{}; the truth is {}", parameter["status"].get<std::string>(), expected),
         !has_interval || holds_inside(parameter, expected)});
  }
  for (const Json& row : result["comparison"]) {
    const double reach = 2.0 * number(row, "validation_uncertainty_kg_per_s");
    checks.push_back({fmt::format("rate at {:.0f} mm, g/s{}",
                                  1e3 * number(row, "orifice_m"),
                                  row["held_out"] == true ? ", held out" : ""),
                      1e3 * number(row, "simulated_kg_per_s"),
                      fmt::format("within {:.2f} of the films' {:.2f}",
                                  1e3 * reach,
                                  1e3 * number(row, "filmed_kg_per_s")),
                      std::abs(number(row, "error_kg_per_s")) <= reach});
    const bool is_held_out = row["held_out"] == true;
    checks.push_back({"  its discharge curve",
                      number(row, "curve_inside"),
                      is_held_out ? "of the time inside the films' band; nothing is asked of it"
                                  : "of the time inside the films' band, at least 0.9",
                      is_held_out || number(row, "curve_inside") >= 0.9});
  }
  checks.push_back({"mean signed error",
                    result["mean_signed_error"],
                    "at most 0.1 either way",
                    std::abs(result["mean_signed_error"].get<double>()) <= 0.1});
  checks.push_back({"wall time with tracking, s",
                    result["wall_time_s"],
                    "at most 1800 without tracking",
                    result["wall_time_s"].get<double>() <= 1800.0});
  return report(checks, figures);
}
