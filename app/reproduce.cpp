// graintruth reproduce: the thesis's statistics, printed beside recomputed.
#include <fmt/format.h>

#include <cmath>

#include "app/commands.h"
#include "app/data_folder.h"
#include "calibrate/agreement.h"
#include "datasets/input_error.h"
#include "datasets/table.h"

namespace graintruth::app {

namespace {

// Table 4.2 (section 4.2.3): the agreement of each particle from its frames at rank 0 to 3.
bool reproduce_table_4_2() {
  const datasets::Table table =
      datasets::read_csv(data_folder() / "thesis" / "table_4_2_agreement.csv");
  int points = 0;
  int printed_points = 0;
  int frames = 0;
  int misprints = 0;
  fmt::print(
      "table-4.2: degree of agreement between simulation and experiment (thesis section 4.2.3)\n");
  fmt::print("{:>8} {:>6} {:>6} {:>6} {:>6} {:>16} {:>18}  {}\n",
             "particle",
             "rank 0",
             "rank 1",
             "rank 2",
             "rank 3",
             "points (printed)",
             "percent (printed)",
             "verdict");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    std::array<int, 4> ranks = {};
    for (int rank = 0; rank < 4; ++rank) {
      ranks[static_cast<std::size_t>(rank)] =
          table.integer(row, fmt::format("frames_rank{}", rank));
      frames += ranks[static_cast<std::size_t>(rank)];
    }
    const calibrate::ParticleAgreement scored =
        calibrate::score_ranks(table.integer(row, "particle_no"), ranks);
    const int printed = table.integer(row, "weighted_points_printed");
    const double printed_percent = table.number(row, "agreement_printed_percent");
    const bool agrees =
        printed == scored.points && std::abs(printed_percent - scored.percent) < 0.05 + 1e-9;
    misprints += agrees ? 0 : 1;
    points += scored.points;
    printed_points += printed;
    fmt::print(
        "{:>8} {:>6} {:>6} {:>6} {:>6} {:>7} {:>8} {:>9.2f} {:>8.1f}  {}\n",
        scored.particle,
        ranks[0],
        ranks[1],
        ranks[2],
        ranks[3],
        scored.points,
        fmt::format("({})", printed),
        scored.percent,
        printed_percent,
        agrees ? "reproduced" : "misprint in the thesis: its own ranks give the recomputed value");
  }
  const int tests = 3 * frames;
  fmt::print(
      "all      {}/{} = {:.2f} %; the thesis prints 82.13 %, which is {}/{}: its misprint in "
      "particle 9's row\n",
      points,
      tests,
      100.0 * points / tests,
      printed_points,
      tests);
  fmt::print(
      "ceiling  {:.1f} % for a model equal to the true mean, {:.1f} % for a sixth replicate (n = "
      "5, 1.96); "
      "{:.1f} and {:.1f} % with Student's t\n",
      calibrate::ceiling_percent(5, 0, calibrate::Critical::thesis_196),
      calibrate::ceiling_percent(5, 1, calibrate::Critical::thesis_196),
      calibrate::ceiling_percent(5, 0, calibrate::Critical::student_t),
      calibrate::ceiling_percent(5, 1, calibrate::Critical::student_t));
  return points == 615 && tests == 750 && printed_points == 616 && misprints == 1;
}

struct Target {
  const char* name;
  const char* what;
  bool (*reproduce)();
};

constexpr std::array targets = {
    Target{"table-4.2",
           "agreement of the micro-scale experiment, 82.00 % (printed 82.13 %)",
           reproduce_table_4_2}};

const Target& target_named(const std::string& name) {
  for (const Target& target : targets) {
    if (name == target.name) return target;
  }
  throw datasets::InputError(
      fmt::format("There is no target '{}'; 'graintruth reproduce --list' names them.", name));
}

}  // namespace

int run_reproduce(const ReproduceCommand& command) {
  if (command.list) {
    for (const Target& target : targets) fmt::print("{:12} {}\n", target.name, target.what);
    return 0;
  }
  std::vector<const Target*> chosen;
  for (const std::string& name : command.targets) chosen.push_back(&target_named(name));
  if (chosen.empty()) {
    for (const Target& target : targets) chosen.push_back(&target);
  }
  bool all = true;
  for (const Target* target : chosen) all = target->reproduce() && all;
  return all ? 0 : 1;
}

}  // namespace graintruth::app
