// Columns of grains that collapse between panes that do not rub, against what is published of dry
// columns in wide channels. With a = height / width of the column against its wall:
//   run-out / width       1.2 a (a < 1.8), 1.9 a^(2/3) (a > 2.8)   Lube et al. 2005
//                         a (a < 3)                                Lajeunesse et al. 2005
//   final height / width  0.65 a^(2/5) of high columns              Lube et al. 2005
//                         a^(1/3) of high columns                  Lajeunesse et al. 2005
//                         a of low ones                            both
// Lube, Huppert, Sparks and Freundt, Phys. Rev. E 72, 041301; Lajeunesse, Monnier and Homsy, Phys.
// Fluids 17, 103302.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "calibrate/observables/bed_profile.h"
#include "calibrate/problem.h"
#include "tests/support/temporary_folder.h"

namespace graintruth::calibrate {
namespace {

constexpr double grain = 4.0;             // mm
constexpr double mass_of_grain = 0.0831;  // g
constexpr double depth = 3.0 * grain;     // mm, between the panes

struct Column {
  double width = 0.0;   // mm
  double aspect = 0.0;  // asked for; the settled bed says how high it really stood
};

struct Collapsed {
  double aspect = 0.0, run_out = 0.0, height = 0.0;  // over the width
};

std::string experiment_of(const Column& column) {
  constexpr double poured = 0.6;  // share of the room that grains take
  const double volume = column.width * column.width * column.aspect * depth;  // mm3
  const double mass = volume * poured / (4.0 / 3.0 * 3.14159265358979 * 8.0) * mass_of_grain;  // g
  return fmt::format(R"(title = "A column that collapses"
[particle]
mass_g = {}
radius_mm = {}
[material]
elastic_modulus_gpa = 63
poisson_ratio = 0.25
friction_particle_particle = 0.5
friction_particle_wall = 0.5
friction_particle_pane = 0
restitution = 0.6
rolling_friction_particle_particle = 0.1
rolling_friction_particle_wall = 0.1
[rig]
kind = "column_collapse"
tank_length_mm = {}
tank_depth_mm = {}
column_width_mm = {}
gate_speed_mm_per_s = 3000
filled_mass_g = {}
[measure]
observables = ["run_out", "final_height"]
[[replicate]]
outline = "one.csv"
[[replicate]]
outline = "two.csv"
)",
                     mass_of_grain,
                     0.5 * grain,
                     column.width * (1.0 + 4.0 * std::max(1.0, column.aspect)),
                     depth,
                     column.width,
                     mass);
}

Collapsed collapse(const Column& column) {
  const tests::TemporaryFolder folder;
  for (const char* name : {"one.csv", "two.csv"}) folder.write(name, "time_s,column_m,height_m\n");
  const datasets::Experiment experiment =
      datasets::load_experiment(folder.write("experiment.toml", experiment_of(column)));
  const std::vector<datasets::Recording> recordings(experiment.replicates.size());
  const Problem problem = plan_problem(experiment, recordings);
  const EngineRun run =
      problem.engine->run(problem.spec_of(0, datasets::bench_parameters(experiment), 0.4, 1), {});
  EXPECT_EQ(run.status, RunStatus::completed) << run.message;
  const Situation situation{.particle = experiment.particle,
                            .rig = experiment.replicates.front().rig,
                            .measurement = experiment.measurement};
  const BedProfile before = profile_at(run.recording.outlines.front(), 0, situation);
  const BedProfile after = *profile_at_rest(run.recording, situation);
  // The column's level: the mean of its columns, half a grain below the tops that a camera sees
  double level = 0.0;
  int columns = 0;
  for (std::size_t i = 0; i < before.x.size(); ++i) {
    if (before.x[i] < 0.0 || before.x[i] > 1e-3 * column.width) continue;
    level += before.z[i];
    ++columns;
  }
  const double width = 1e-3 * column.width;
  const Collapsed made{level / columns / width,
                       foot_of(after, Side::right, situation) / width - 1.0,
                       after.z[*apex_of(after)] / width};
  fmt::print("{:.1f} grains wide, {} grains: a {:.2f}, run-out {:.2f}, height {:.2f}, {:.1f} s\n",
             column.width / grain,
             experiment.particle.count,
             made.aspect,
             made.run_out,
             made.height,
             run.seconds);
  std::fflush(stdout);
  return made;
}

double lube_run_out(double aspect) {
  return aspect < 1.8 ? 1.2 * aspect : 1.9 * std::cbrt(aspect * aspect);
}

// Both groups scatter by some 10 % about their own laws, and low columns of one run out by a fifth
// less than those of the other.
TEST(ColumnCollapse, RunsOutAndStandsAsDryColumnsDo) {
  for (const Column& column : {Column{60.0, 0.6}, Column{48.0, 1.0}, Column{24.0, 3.6}}) {
    const Collapsed made = collapse(column);
    EXPECT_NEAR(made.run_out / lube_run_out(made.aspect), 1.0, 0.2) << made.aspect;
    if (made.aspect < 1.0) {
      // What stands at the wall stays, but for a grain or two
      EXPECT_LT(made.height, made.aspect);
      EXPECT_GT(made.height, made.aspect - 2.0 * grain / column.width);
    } else {
      EXPECT_GT(made.height, 0.65 * std::pow(made.aspect, 0.4)) << made.aspect;
      EXPECT_LT(made.height, std::cbrt(made.aspect)) << made.aspect;
    }
  }
}

}  // namespace
}  // namespace graintruth::calibrate
