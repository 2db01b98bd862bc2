// A box that is drawn down into another: films that the test draws of its own simulations, tracked
// and validated by the built program.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "calibrate/problem.h"
#include "tests/app/laboratory.h"
#include "tests/support/read_rows.h"
#include "tests/support/run_program.h"
#include "tests/tracking/drawn_shapes.h"
#include "tracking/film/synthetic_video.h"

namespace graintruth::tests {
namespace {

using Json = nlohmann::json;

constexpr double grain = 0.004;      // m
constexpr double pixels = 3000.0;    // a metre
constexpr double frame_rate = 50.0;  // Hz, of films and of what simulations keep
constexpr int still_frames = 12;     // before the slide moves
constexpr double gate_speed = 0.2;   // m/s
constexpr double half_slot = 0.011, gate_length = 0.036;  // m
constexpr double shelf = 0.004, gate = 0.003, fall = 0.035, depth = 0.0055;
constexpr double half_upper = 0.028, half_lower = 0.045;

// Places of the plane of the scale: (0, 0) is the middle of the slot.
Eigen::Vector2d pixel_of(double x, double z) { return {180.0 + pixels * x, 130.0 - pixels * z}; }

constexpr const char* text = R"(title = "Drawn"
[particle]
mass_g = 0.0831
radius_mm = 2
[material]
elastic_modulus_gpa = 63
poisson_ratio = 0.25
friction_particle_particle = 0.46
friction_particle_wall = 0.35
restitution = 0.4
rolling_friction_particle_particle = 0.1
rolling_friction_particle_wall = 0.1
[rig]
kind = "draw_down"
upper_width_mm = 56
upper_height_mm = 40
slot_width_mm = 22
shelf_thickness_mm = 4
gate_length_mm = 36
gate_thickness_mm = 3
gate_speed_mm_per_s = 200
fall_height_mm = 35
lower_width_mm = 90
box_depth_mm = 5.5
filled_mass_g = 6.5
[measure]
observables = ["free_surface_upper", "free_surface_lower", "bed_area_lower"]
[tune]
friction_particle_particle = {lower = 0.1, upper = 0.8}
)";

// Four corners that lie in the plane of the grains' middles, where a laboratory puts its scale.
std::string camera_text() {
  std::string camera = "[camera]\nframe_rate_hz = 50\nclick_error_px = 0.1\n";
  for (const auto& [x, z] :
       {std::pair(-0.05, -0.03), {0.05, -0.03}, {0.05, 0.03}, {-0.05, 0.03}, {0.0, 0.0}}) {
    const Eigen::Vector2d at = pixel_of(x, z);
    camera += fmt::format(
        "[[camera.point]]\npx = [{}, {}]\nmm = [{}, {}]\n", at.x(), at.y(), 1e3 * x, 1e3 * z);
  }
  return camera;
}

class DrawDownRun : public testing::Test {
 protected:
  // What the engine makes of the rig at the bench values, every grain at every picture.
  calibrate::EngineRun simulated(std::uint64_t seed) {
    for (const char* name : {"one.csv", "two.csv"})
      folder_.write(name, "surface,time_s,column_m,height_m\n");
    const datasets::Experiment experiment = datasets::load_experiment(folder_.write(
        "tables.toml",
        std::string(text) +
            "[[replicate]]\noutline = \"one.csv\"\n[[replicate]]\noutline = \"two.csv\"\n"));
    const std::vector<datasets::Recording> nothing(experiment.replicates.size());
    const calibrate::Problem problem = calibrate::plan_problem(experiment, nothing);
    calibrate::SimulationSpec spec =
        problem.spec_of(0, datasets::bench_parameters(experiment), 0.5, seed);
    spec.record.tracks = true;
    return problem.engine->run(spec, {});
  }

  void draw(const std::string& name, const datasets::Trajectories& grains) {
    std::vector<cv::Mat> pictures;
    std::size_t frames = grains.frames();
    const auto is_there = [&](std::size_t frame) {
      return std::isfinite(grains.poses[grains.index(frame, 0)].z);
    };
    while (!is_there(frames - 1)) --frames;
    for (int number = 0; number < still_frames + static_cast<int>(frames) + 5; ++number) {
      const auto frame = static_cast<std::size_t>(
          std::clamp(number - still_frames, 0, static_cast<int>(frames) - 1));
      const double moved = gate_speed * std::max(0, number - still_frames) / frame_rate;
      tracking::Canvas canvas(360, 250, {185, 190, 190});
      const auto box = [&](double x0, double z0, double x1, double z1, const cv::Scalar& colour) {
        canvas.fill({pixel_of(x0, z0), pixel_of(x1, z0), pixel_of(x1, z1), pixel_of(x0, z1)},
                    colour);
      };
      for (std::size_t i = 0; i < static_cast<std::size_t>(grains.particles); ++i) {
        const datasets::Pose& pose = grains.poses[grains.index(frame, i)];
        canvas.ellipse(pixel_of(pose.x, pose.z),
                       0.5 * grain * pixels,
                       0.5 * grain * pixels,
                       0.0,
                       {40, 50, 110});
      }
      const cv::Scalar wall(90, 95, 90);
      box(-0.06, -fall - 0.01, 0.06, -fall, wall);
      for (const double side : {-1.0, 1.0}) {
        box(side * half_slot, -shelf, side * half_lower, 0.0, wall);
        box(side * half_upper, 0.0, side * (half_upper + 0.002), 0.04, wall);
        box(side * half_lower, -fall, side * (half_lower + 0.002), -shelf, wall);
      }
      box(-half_slot + moved,
          -shelf - gate,
          gate_length - half_slot + moved,
          -shelf,
          {230, 235, 235});
      pictures.push_back(canvas.picture(2.0, static_cast<unsigned>(number)));
    }
    tracking::write_film(folder_ / (name + ".avi"), pictures, frame_rate);
  }

  TemporaryFolder folder_;
};

TEST_F(DrawDownRun, IsTrackedAndValidatedFromItsFilms) {
  std::vector<calibrate::EngineRun> truths;
  for (const std::uint64_t seed : {1, 2}) {
    truths.push_back(simulated(seed));
    ASSERT_EQ(truths.back().status, calibrate::RunStatus::completed) << truths.back().message;
    draw(fmt::format("film{}", seed), *truths.back().recording.tracks);
  }
  const std::string file = folder_.write(
      "experiment.toml",
      text + camera_text() +
          "[[replicate]]\nvideo = \"film1.avi\"\n[[replicate]]\nvideo = \"film2.avi\"\n");
  // 1. The outlines of a simulation tell who stayed and who came down
  for (const calibrate::EngineRun& truth : truths) {
    const datasets::Outline& upper = *truth.recording.outline_of("upper");
    const datasets::Outline& lower = *truth.recording.outline_of("lower");
    const auto highest = [](const datasets::Outline& outline, std::size_t moment) {
      double most = -1.0;
      for (std::size_t k = 0; k < outline.column.size(); ++k)
        most = std::fmax(most, outline.height[outline.index(moment, k)]);
      return most;
    };
    EXPECT_GT(highest(upper, 0), 0.012);
    EXPECT_EQ(highest(lower, 0), -1.0) << "the lower box is empty at first";
    EXPECT_GT(highest(lower, lower.time.size() - 1), -fall + 0.9 * grain);
    EXPECT_LT(highest(lower, lower.time.size() - 1), -shelf - gate);
  }
  // 2. Both surfaces are found, and how fast the slide went
  const std::string out = folder_ / "out";
  const ProgramOutcome tracked = run_program({"track", file, "--out", out, "--quiet"});
  ASSERT_EQ(tracked.status, 0) << tracked.err;
  const Json films = Json::parse(content_of(folder_ / "out/tracking.json"))["replicates"];
  for (std::size_t film = 0; film < 2; ++film) {
    EXPECT_EQ(films[film]["grade"], "ok") << films[film].dump(1);
    EXPECT_NEAR(films[film]["outline"]["lift_speed_mm_per_s"].get<double>(), 200.0, 4.0);
    EXPECT_NEAR(films[film]["event_time_s"].get<double>(), still_frames / frame_rate, 0.01);
    const std::vector<datasets::Outline> found =
        datasets::read_outlines(folder_ / fmt::format("out/tracks/film{}.outline.csv", film + 1));
    ASSERT_EQ(found.size(), 2U);
    for (const datasets::Outline& outline : found) {
      const datasets::Outline& truth = *truths[film].recording.outline_of(outline.surface);
      double sum = 0.0, square = 0.0;
      int count = 0;
      for (std::size_t k = 0; k < outline.column.size(); ++k) {
        const auto place =
            std::lower_bound(truth.column.begin(), truth.column.end(), outline.column[k] - 1e-6);
        const auto own = static_cast<std::size_t>(place - truth.column.begin());
        const double error = (outline.height[outline.index(outline.time.size() - 1, k)] -
                              truth.height[truth.index(truth.time.size() - 1, own)]) /
                             grain;
        if (!std::isfinite(error)) continue;
        sum += error;
        square += error * error;
        ++count;
      }
      EXPECT_GT(count, 8) << outline.surface;
      EXPECT_LT(std::abs(sum / count), 0.1) << outline.surface;
      EXPECT_LT(std::sqrt(square / count), 0.25) << outline.surface;
    }
  }
  // 3. The parameters that made them agree with them
  const std::string parameters =
      folder_.write("parameters.toml", "friction_particle_particle = 0.46\n");
  const ProgramOutcome validated = run_program(
      {"validate", file, "--parameters", parameters, "--out", out, "--runs", "2", "--quiet"});
  ASSERT_EQ(validated.status, 0) << validated.err << validated.out;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/report.html"));
  const auto rows = read_rows(folder_ / "out/tables/outlines.csv");
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0].at("surface"), "upper");
  EXPECT_EQ(rows[1].at("surface"), "lower");
}

}  // namespace
}  // namespace graintruth::tests
