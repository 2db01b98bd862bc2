// How well the filmed two-ball particles are tracked, against their truth: recall, identity,
// position and angle error, calibration of the stated uncertainty, time zero, speed; of every film,
// every body and every colour. Prints tables and writes the films' to OUT.csv, the bodies' to
// OUT_bodies.csv.
//   bench_tracking_micro [OUT.csv] [EXPERIMENT.toml] [part of a film's name]
// Without an experiment file: the five bundled films, and where the shared data lie beside the
// repository the interlaced one and those of pale balls on pale ground. Pixels are those of the
// film.
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <map>
#include <numbers>

#include "bench/tracking/films.h"
#include "bench/tracking/pair_truth.h"
#include "datasets/store/table.h"
#include "tracking/balls/ball_tracker.h"
#include "tracking/track_film.h"

using namespace graintruth;

namespace {

constexpr double degree = std::numbers::pi / 180.0;

std::string percent(double share) { return fmt::format("{:.1f}", 100.0 * share); }

// What is said of a body, a colour or all: errors of the midpoint, z-scores of the midpoint and of
// the centre of mass.
std::string row_of(const bench::PairErrors& e, double px) {
  return fmt::format(
      "{:>6} {:>7} {:6.3f} {:6.3f} {:7.2f} {:7.3f}   {:4.2f} {:4.2f} {:4.2f}   "
      "{:4.2f} {:4.2f}   {:>5} {:>5} {:>5}",
      percent(e.frames > 0.0 ? e.seen / e.frames : 0.0),
      e.strangers,
      px * e.root(e.x2),
      px * e.root(e.z2),
      px * e.worst,
      e.root(e.angle2) / degree,
      e.root(e.mid_x2),
      e.root(e.mid_z2),
      e.root(e.over_angle2),
      e.root(e.over_x2),
      e.root(e.over_z2),
      percent(e.share(e.within_x)),
      percent(e.share(e.within_z)),
      percent(e.share(e.within_angle)));
}

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path out = argc > 1 ? argv[1] : "tracking_micro.csv";
  std::vector<bench::Filmed> films =
      bench::films_of("micro", argc > 2 ? argv[2] : "", argc > 3 ? argv[3] : "");
  if (argc <= 2) {
    for (bench::Filmed& film : bench::pale_films()) films.push_back(std::move(film));
  }
  datasets::Table table({"replicate",
                         "frames",
                         "completeness",
                         "strangers",
                         "rmse_x_mm",
                         "rmse_z_mm",
                         "rmse_x_px",
                         "rmse_z_px",
                         "worst_mm",
                         "rmse_angle_deg",
                         "z_sd_x",
                         "z_sd_z",
                         "z_sd_angle",
                         "z_sd_x_centre_of_mass",
                         "z_sd_z_centre_of_mass",
                         "event_error_ms",
                         "event_sigma_ms",
                         "calibration_rms_mm",
                         "scale_px_per_mm",
                         "radius_mm",
                         "separation_mm",
                         "frames_per_second",
                         "grade"});
  datasets::Table body_table({"replicate",
                              "particle",
                              "colour",
                              "seen",
                              "strangers",
                              "rmse_x_px",
                              "rmse_z_px",
                              "worst_px",
                              "rmse_angle_deg",
                              "z_sd_x",
                              "z_sd_z",
                              "z_sd_angle",
                              "z_sd_x_centre_of_mass",
                              "z_sd_z_centre_of_mass",
                              "within_two_sigma_x",
                              "within_two_sigma_z",
                              "within_two_sigma_angle"});
  const auto text = [](double value) { return datasets::number_text(value); };
  const std::string header =
      fmt::format("{:>6} {:>7} {:>6} {:>6} {:>7} {:>7}   {:>14}   {:>9}   {:>17}",
                  "seen %",
                  "strange",
                  "x px",
                  "z px",
                  "worst",
                  "deg",
                  "sd of z x z a",
                  "mass x z",
                  "|z| < 2 % x z a");
  fmt::print("{:22} {} {:>9} {:>6}\n", "film, body", header, "event ms", "fps");
  std::map<std::string, bench::PairErrors> colours;
  bench::PairErrors all;
  double any_px = 1.0;
  for (const auto& [experiment, replicate, film, spec] : films) {
    const std::clock_t started = std::clock();
    tracking::BallTracker tracker(spec, film);
    const auto [tracks, summary] = tracking::track_film(tracker, spec, film);
    // Processor time: what one core can do, whoever else is using it
    const double frames_per_second = static_cast<double>(tracks.frames()) * CLOCKS_PER_SEC /
                                     static_cast<double>(std::clock() - started);
    const std::filesystem::path folder = replicate.video.parent_path();
    const std::vector<bench::PairBody> bodies = bench::compare_pairs(
        tracks, folder / "truth", replicate.video.stem().string().substr(0, 4));
    const double event_error_ms = 1.0e3 * (summary.event_time_s - bench::micro_event_s);
    const double px = 1.0e3 * summary.scale_px_per_mm;
    any_px = px;
    bench::PairErrors total;
    for (const bench::PairBody& body : bodies) total += body.errors;
    all += total;
    fmt::print("{:22} {} {:9.2f} {:6.0f}\n",
               replicate.name,
               row_of(total, px),
               event_error_ms,
               frames_per_second);
    for (std::size_t p = 0; p < bodies.size(); ++p) {
      const bench::PairErrors& e = bodies[p].errors;
      colours[bodies[p].colour] += e;
      fmt::print("{:22} {}\n", fmt::format("  {:2} {}", p + 1, bodies[p].colour), row_of(e, px));
      body_table.add({replicate.name,
                      std::to_string(p + 1),
                      bodies[p].colour,
                      text(e.seen / e.frames),
                      text(e.strangers),
                      text(px * e.root(e.x2)),
                      text(px * e.root(e.z2)),
                      text(px * e.worst),
                      text(e.root(e.angle2) / degree),
                      text(e.root(e.mid_x2)),
                      text(e.root(e.mid_z2)),
                      text(e.root(e.over_angle2)),
                      text(e.root(e.over_x2)),
                      text(e.root(e.over_z2)),
                      text(e.share(e.within_x)),
                      text(e.share(e.within_z)),
                      text(e.share(e.within_angle))});
    }
    fmt::print("  grade {}\n", tracking::to_string(summary.grade));
    for (const std::string& warning : summary.warnings) fmt::print("  {}\n", warning);
    table.add({replicate.name,
               std::to_string(summary.frames_read),
               text(summary.completeness),
               text(total.strangers),
               text(1.0e3 * total.root(total.x2)),
               text(1.0e3 * total.root(total.z2)),
               text(px * total.root(total.x2)),
               text(px * total.root(total.z2)),
               text(1.0e3 * total.worst),
               text(total.root(total.angle2) / degree),
               text(total.root(total.mid_x2)),
               text(total.root(total.mid_z2)),
               text(total.root(total.over_angle2)),
               text(total.root(total.over_x2)),
               text(total.root(total.over_z2)),
               text(event_error_ms),
               text(1.0e3 * summary.event_uncertainty_s),
               text(summary.calibration_rms_mm),
               text(summary.scale_px_per_mm),
               text(1.0e3 * tracker.learned().radius_mean),
               text(1.0e3 * tracker.learned().separation_mean),
               text(frames_per_second),
               tracking::to_string(summary.grade)});
  }
  fmt::print("{:22} {}\n", "colour", header);
  for (const auto& [colour, errors] : colours)
    fmt::print("{:22} {}\n", "  " + colour, row_of(errors, any_px));
  fmt::print("{:22} {}\n", "all", row_of(all, any_px));
  datasets::write_csv(out, table);
  std::filesystem::path bodies_file = out;
  bodies_file.replace_filename(out.stem().string() + "_bodies.csv");
  datasets::write_csv(bodies_file, body_table);
  fmt::print("written to {} and {}\n", out.string(), bodies_file.string());
  return 0;
}
