// Films of a heap and of a drum that lie beside the repository, from experiment files of their own.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <toml++/toml.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "datasets/store/table.h"
#include "tests/support/temporary_folder.h"
#include "tests/tracking/drawn_film.h"

namespace graintruth::tracking {
namespace {

const std::filesystem::path lab_films =
    std::filesystem::path(GRAINTRUTH_SOURCE_DIR).parent_path() / "shared/lab-videos";

constexpr const char* beads = R"(
title = "Glass beads"
[particle]
count = 1500
mass_g = 0.083106
radius_mm = 2
[material]
elastic_modulus_gpa = 63
poisson_ratio = 0.25
friction_particle_particle = 0.46
friction_particle_wall = 0.35
restitution = 0.79
rolling_friction_particle_particle = 0.19
rolling_friction_particle_wall = 0.19
[tune]
friction_particle_particle = {lower = 0.1, upper = 0.8}
)";

// An experiment file with this rig and the discs that the folder's geometry tells, of two films.
datasets::Experiment experiment_of(const tests::TemporaryFolder& place,
                                   const std::filesystem::path& folder,
                                   const std::string& rig,
                                   const std::string& replicates) {
  const toml::table geometry = toml::parse_file((folder / "geometry.toml").string());
  std::string discs;
  double diameter = 0.0;
  for (const auto& one : *geometry["fiducial"].as_array()) {
    const toml::table& disc = *one.as_table();
    discs += fmt::format("[{}, {}], ",
                         1e3 * disc["x_m"].value<double>().value(),
                         1e3 * disc["z_m"].value<double>().value());
    diameter = 1e3 * disc["diameter_m"].value<double>().value();
  }
  return datasets::load_experiment(place.write(
      "experiment.toml",
      fmt::format("{}\n{}\n[camera]\nframe_rate_hz = 50\nfiducial_diameter_mm = {}\nfiducials_mm = "
                  "[{}]\n{}",
                  beads,
                  rig,
                  diameter,
                  discs,
                  replicates)));
}

TEST(OutlineFilm, OfAHeapIsReadFromItsExperimentFile) {
  const std::filesystem::path folder = lab_films / "heap";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
  const tests::TemporaryFolder place;
  const datasets::Experiment experiment = experiment_of(
      place,
      folder,
      "[rig]\nkind = \"lifted_cylinder\"\ntube_inner_diameter_mm = 50\ntube_wall_mm = "
      "1.5\ntube_height_mm = 80\nlift_speed_mm_per_s = 16\n",
      fmt::format("[[replicate]]\nvideo = \"{0}/heap_rep1.mp4\"\n[[replicate]]\nvideo = "
                  "\"{0}/heap_rep2.mp4\"\n",
                  folder.string()));
  const datasets::Replicate& replicate = experiment.replicates.front();
  const datasets::TrackingSpec spec = datasets::make_tracking_spec(experiment, replicate);
  const datasets::Film film = datasets::film_of(experiment, replicate);
  const auto tracker = make_tracker(spec, film);
  const TrackingSummary summary = track_film(*tracker, spec, film).summary;
  const datasets::Outline& outline = tracker->outlines().front();
  EXPECT_EQ(summary.grade, Grade::ok) << testing::PrintToString(summary.failures);
  EXPECT_NEAR(summary.event_time_s, 0.2, 0.02);
  nlohmann::ordered_json figures;
  tracker->describe(figures);
  EXPECT_NEAR(figures["outline"]["lift_speed_mm_per_s"].get<double>(), 16.0, 0.02 * 16.0);
  // The heap at rest; the file is a parallel projection, up to 0.14 diameters from what is seen
  const datasets::Table truth = datasets::read_csv(folder / "truth/heap_rep1_profile.csv");
  constexpr double grain = 0.004;
  double square = 0.0;
  int count = 0, missed = 0;
  for (std::size_t k = 0; k < outline.column.size(); ++k) {
    double sum = 0.0;
    int parts = 0;
    for (std::size_t row = 0; row < truth.rows(); ++row) {
      if (std::abs(truth.number(row, "x_m") - outline.column[k]) > 0.25 * grain) continue;
      if (truth.number(row, "z_m") <= 0.0) parts -= 100;
      sum += truth.number(row, "z_m");
      ++parts;
    }
    if (parts <= 0) continue;
    const double height = outline.height[outline.index(outline.time.size() - 1, k)];
    if (!std::isfinite(height)) {
      ++missed;
      continue;
    }
    square += std::pow((height - sum / parts) / grain, 2);
    ++count;
  }
  EXPECT_GT(count, 40);
  EXPECT_LT(missed, 0.05 * count) << "lone grains at the foot may be lost, no more";
  EXPECT_LT(std::sqrt(square / count), 0.25);
}

TEST(OutlineFilm, OfADrumTellsHowFastItTurns) {
  const std::filesystem::path folder = lab_films / "drum";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
  const tests::TemporaryFolder place;
  const datasets::Experiment experiment = experiment_of(
      place,
      folder,
      "[rig]\nkind = \"rotating_drum\"\ndrum_diameter_mm = 110\ndrum_depth_mm = 20\n",
      fmt::format("[[replicate]]\nvideo = \"{0}/drum08_rep1.mp4\"\nturning_rpm = "
                  "8\n[[replicate]]\nvideo = \"{0}/drum20_rep1.mp4\"\nturning_rpm = 30\n",
                  folder.string()));
  for (const auto& [number, rate] : {std::pair(0, -8.0), {1, -20.0}}) {
    const datasets::Replicate& replicate = experiment.replicates[static_cast<std::size_t>(number)];
    const datasets::TrackingSpec spec = datasets::make_tracking_spec(experiment, replicate);
    const datasets::Film film = datasets::film_of(experiment, replicate);
    const auto tracker = make_tracker(spec, film);
    const TrackingSummary summary = track_film(*tracker, spec, film).summary;
    nlohmann::ordered_json figures;
    tracker->describe(figures);
    EXPECT_NEAR(figures["outline"]["turning_rpm"].get<double>(), rate, 0.01 * std::abs(rate));
    // The second one is stated wrongly
    EXPECT_EQ(summary.grade, number == 0 ? Grade::ok : Grade::fail);
  }
}

}  // namespace
}  // namespace graintruth::tracking
