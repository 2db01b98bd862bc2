// Section 3.10 run again: what a step costs, beside the thesis's computer of 1999. Information; no
// claim is made of it.
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/thesis/button.h"
#include "app/thesis/lone_row.h"
#include "app/thesis/targets.h"
#include "sim/laws/restitution.h"

namespace graintruth::app {

namespace {

using sim::Vec3;

// Uniform over all orientations (Shoemake 1992).
sim::Quat random_orientation(const double* share) {
  const double a = std::sqrt(1.0 - share[0]), b = std::sqrt(share[0]);
  const double turn = 2.0 * std::numbers::pi;
  return sim::Quat(b * std::cos(turn * share[2]),
                   a * std::sin(turn * share[1]),
                   a * std::cos(turn * share[1]),
                   b * std::sin(turn * share[2]));
}

// Rows of spheres of 1 cm and aspect ratio 2 (single spheres for count 1) on a lattice in an open
// box.
sim::Scene loose_bed(const ThesisData& thesis, int particles, int spheres, std::uint64_t seed) {
  const double radius = thesis.setting("weight", "element_radius");
  const double box = thesis.setting("run_time", "box");
  sim::Scene scene;
  const int grain = scene.add_material(button_material(thesis));
  const int rigid = scene.add_material(sim::rigid_material());
  const sim::Surfaces surfaces{.friction = 0.2, .restitution = 0.3};
  scene.surfaces.set(grain, grain, surfaces);
  scene.surfaces.set(grain, rigid, surfaces);
  const double spacing = spheres > 1 ? 2.0 * radius / (spheres - 1) : 0.0;
  const int type = scene.add_type(sim::make_clump(
      sim::chain_of_spheres(spheres, radius, spacing), {.density = button_density(thesis)}, grain));
  const double pitch = 2.05 * scene.types[type].bounding_radius;
  const int across = static_cast<int>(std::floor(box / pitch));
  const std::vector<double> shares = shares_of_seed(seed, "run_time", 3 * particles);
  for (int i = 0; i < particles; ++i) {
    const int row = i / across % across, layer = i / (across * across);
    const Vec3 site(i % across + 0.5, row + 0.5, layer + 0.5);
    scene.add_body(
        type, pitch * site, random_orientation(&shares[3 * static_cast<std::size_t>(i)]));
  }
  scene.add_wall(sim::plane_wall(Vec3::Zero(), Vec3::UnitZ(), {}, rigid));
  for (const Vec3& inwards : {Vec3(1, 0, 0), Vec3(0, 1, 0)}) {
    scene.add_wall(sim::plane_wall(Vec3::Zero(), inwards, {}, rigid));
    scene.add_wall(sim::plane_wall(box * inwards, -inwards, {}, rigid));
  }
  return scene;
}

// Seconds a step of a settled bed.
double step_time(const ThesisData& thesis, int particles, int spheres, std::uint64_t seed) {
  sim::Simulation simulation(loose_bed(thesis, particles, spheres, seed),
                             {.time_step = {.fraction = 0.5, .impact_speed = 2.0}});
  const double settled = thesis.setting("run_time", "settling");
  simulation.run_until(settled);
  const double step = thesis.number("ch3_misc", "run_time_study_time_step");
  const int steps = thesis.count("run_time", "steps");
  simulation.set_time_step(exactly(step));
  const auto start = std::chrono::steady_clock::now();
  const sim::RunSummary summary = simulation.run_until(settled + steps * step);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() /
         static_cast<double>(summary.steps);
}

struct Bed {
  int particles = 0, spheres = 0;  // spheres of a particle
};

// One after the other: two at a time would slow each other.
std::vector<double> step_times(const ThesisData& thesis,
                               Studies& studies,
                               const std::string& name,
                               const std::vector<Bed>& beds) {
  const std::string inputs = thesis.settings_text("run_time") + fmt::format("beds={}", beds.size());
  return studies
      .result(name,
              inputs,
              [&] {
                std::vector<double> times;
                for (const Bed& bed : beds) {
                  studies.in_parallel(1, [&](int) {
                    times.push_back(step_time(thesis, bed.particles, bed.spheres, studies.seed()));
                  });
                }
                return Studies::Json(times);
              })
      .get<std::vector<double>>();
}

void add_time(Examination& exam, const std::string& where, const Printed& printed, double seconds) {
  Row& row = exam.take(where, printed, "simulated again: this machine, one core; information");
  row.simulated = seconds;
  row.seeds = 1;
}

}  // namespace

void simulate_run_time_of_clumps(Examination& exam, const ThesisData& thesis, Studies& studies) {
  const std::string name = "table_3_5_run_time_multisphere";
  const datasets::Table& table = thesis.table(name);
  std::vector<Bed> beds;
  for (std::size_t row = 0; row < table.rows(); ++row)
    beds.push_back({table.integer(row, "particles"), table.integer(row, "spheres_per_particle")});
  const std::vector<double> times = step_times(thesis, studies, exam.target(), beds);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    add_time(
        exam,
        fmt::format("{} spheres a particle: our time of a particle and step", beds[row].spheres),
        thesis.cell(name, row, "run_time_per_particle_per_step_printed_s", "s"),
        times[row] / beds[row].particles);
  }
}

void simulate_run_time_of_spheres(Examination& exam, const ThesisData& thesis, Studies& studies) {
  const std::string name = "table_3_6_run_time_spheres";
  const datasets::Table& table = thesis.table(name);
  std::vector<Bed> beds;
  for (std::size_t row = 0; row < table.rows(); ++row)
    beds.push_back({table.integer(row, "total_spheres"), 1});
  const std::vector<double> times = step_times(thesis, studies, exam.target(), beds);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    add_time(exam,
             fmt::format("{} spheres: our time of a sphere and step", beds[row].particles),
             thesis.cell(name, row, "run_time_per_sphere_per_step_s", "s"),
             times[row] / beds[row].particles);
  }
}

}  // namespace graintruth::app
