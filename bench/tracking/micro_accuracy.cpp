// How well the five bundled films are tracked, against their truth: recall, identity, position and
// angle error, calibration of the stated uncertainty, time zero, speed. Prints a table and writes
// it as CSV.
//   bench_tracking_micro [OUT.csv] [EXPERIMENT.toml] [part of a film's name]
// Without an experiment file: the five films, and the interlaced one where the shared data lie
// beside the repository. Pixels are those of the film.
//
// The tracked point is the midpoint of the two ball centres; the truth file gives the centre of
// mass. The midpoint is rebuilt from placement.csv: radii r1, r2 and centre distance d give the
// offset between the two along the axis (the solid of two overlapping balls). Which ball lies at
// which end is not in the files; the end that fits is taken.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>

#include "bench/tracking/films.h"
#include "datasets/store/table.h"
#include "tracking/balls/ball_tracker.h"
#include "tracking/track_film.h"

using namespace graintruth;

namespace {

constexpr double degree = std::numbers::pi / 180.0;

// From the centre of mass to the midpoint of the centres, along the axis from ball 1 to ball 2, m.
// Each ball is cut by the plane of the circle in which they meet; volume and first moment of a
// ball's part x in [low, high] are
//   V = pi int (r^2 - x^2) dx,   M = pi int x (r^2 - x^2) dx,   x from the ball's own centre.
double midpoint_offset(double r1, double r2, double d) {
  const double seam = (d * d + r1 * r1 - r2 * r2) / (2.0 * d);  // from the centre of ball 1
  const auto volume = [](double r, double low, double high) {
    const auto primitive = [&](double x) { return r * r * x - x * x * x / 3.0; };
    return primitive(high) - primitive(low);
  };
  const auto moment = [](double r, double low, double high) {
    const auto primitive = [&](double x) { return r * r * x * x / 2.0 - x * x * x * x / 4.0; };
    return primitive(high) - primitive(low);
  };
  const double v1 = volume(r1, -r1, seam), v2 = volume(r2, seam - d, r2);
  const double centre = (moment(r1, -r1, seam) + moment(r2, seam - d, r2) + v2 * d) / (v1 + v2);
  return 0.5 * d - centre;
}

struct Sums {
  double x2 = 0.0, z2 = 0.0, angle2 = 0.0;  // squared errors
  double zx2 = 0.0, zz2 = 0.0, za2 = 0.0;   // squared errors over sigma
  double mass_x2 = 0.0, mass_z2 = 0.0;      // over sigma, against the centre of mass
  double worst = 0.0;
  double count = 0.0;
};

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path out = argc > 1 ? argv[1] : "tracking_micro.csv";
  const std::vector<bench::Filmed> films =
      bench::films_of("micro", argc > 2 ? argv[2] : "", argc > 3 ? argv[3] : "");
  datasets::Table table({"replicate",
                         "frames",
                         "completeness",
                         "identity_switches",
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
  fmt::print("{:22} {:>7} {:>8} {:>8} {:>8} {:>11} {:>8} {:>8} {:>20} {:>13} {:>9} {:>6}\n",
             "replicate",
             "seen %",
             "switches",
             "x mm",
             "z mm",
             "x z px",
             "worst",
             "deg",
             "z-score sd x z angle",
             "(mass centre)",
             "event ms",
             "fps");
  for (const auto& [experiment, replicate, film, spec] : films) {
    const std::clock_t started = std::clock();
    tracking::BallTracker tracker(spec, film);
    const auto [tracks, summary] = tracking::track_film(tracker, spec, film);
    // Processor time: what one core can do, whoever else is using it
    const double frames_per_second = static_cast<double>(tracks.frames()) * CLOCKS_PER_SEC /
                                     static_cast<double>(std::clock() - started);
    const std::filesystem::path folder = replicate.video.parent_path() / "truth";
    const std::string run = replicate.name.substr(0, std::string("rep1").size());
    const datasets::Table placement = datasets::read_csv(folder / (run + "_placement.csv"));
    const datasets::Table truth_table = datasets::read_csv(folder / (run + "_tracks.csv"));
    const auto particles = static_cast<std::size_t>(tracks.particles);
    // Pictures and truth run at the same rate
    std::vector<datasets::Pose> truth(tracks.poses.size());
    double event_truth = 0.0;
    for (std::size_t row = 0; row < truth_table.rows(); ++row) {
      const auto frame = static_cast<std::size_t>(truth_table.integer(row, "frame"));
      const auto particle = static_cast<std::size_t>(truth_table.integer(row, "particle")) - 1;
      if (frame >= tracks.frames()) continue;
      truth[tracks.index(frame, particle)] = {truth_table.number(row, "x_m"),
                                              truth_table.number(row, "z_m"),
                                              truth_table.number(row, "angle_rad")};
    }
    event_truth = 0.2;  // s of film, README of the data set: frame 10 of 50 a second
    // Identity: which true particle is nearest; a change along a track is a switch
    int switches = 0;
    for (std::size_t p = 0; p < particles; ++p) {
      std::size_t before = p;  // numbers are starting places in both
      for (std::size_t k = 0; k < tracks.frames(); ++k) {
        const datasets::Pose& seen = tracks.poses[tracks.index(k, p)];
        if (!std::isfinite(seen.x)) continue;
        std::size_t nearest = 0;
        double least = 1.0e9;
        for (std::size_t q = 0; q < particles; ++q) {
          const datasets::Pose& t = truth[tracks.index(k, q)];
          const double distance = std::hypot(seen.x - t.x, seen.z - t.z);
          if (distance < least) {
            least = distance;
            nearest = q;
          }
        }
        switches += nearest != before;
        before = nearest;
      }
    }
    Sums total;
    for (std::size_t p = 0; p < particles; ++p) {
      const double offset = midpoint_offset(placement.number(p, "radius_1_m"),
                                            placement.number(p, "radius_2_m"),
                                            placement.number(p, "centre_distance_m"));
      Sums best;
      double least = 1.0e9;
      for (const double end : {-1.0, 1.0}) {
        Sums sums;
        for (std::size_t k = 0; k < tracks.frames(); ++k) {
          const std::size_t i = tracks.index(k, p);
          const datasets::Pose &seen = tracks.poses[i], &sigma = tracks.sigmas[i], &t = truth[i];
          if (!std::isfinite(seen.x)) continue;
          const double x = seen.x - t.x - end * offset * std::cos(t.angle);
          const double z = seen.z - t.z - end * offset * std::sin(t.angle);
          const double angle = std::remainder(seen.angle - t.angle, std::numbers::pi);
          sums.x2 += x * x;
          sums.z2 += z * z;
          sums.angle2 += angle * angle;
          sums.zx2 += std::pow(x / sigma.x, 2);
          sums.zz2 += std::pow(z / sigma.z, 2);
          sums.za2 += std::pow(angle / sigma.angle, 2);
          sums.mass_x2 += std::pow((seen.x - t.x) / sigma.x, 2);
          sums.mass_z2 += std::pow((seen.z - t.z) / sigma.z, 2);
          sums.worst = std::max(sums.worst, std::hypot(x, z));
          sums.count += 1.0;
        }
        if (sums.x2 + sums.z2 < least) {
          least = sums.x2 + sums.z2;
          best = sums;
        }
      }
      total.x2 += best.x2;
      total.z2 += best.z2;
      total.angle2 += best.angle2;
      total.zx2 += best.zx2;
      total.zz2 += best.zz2;
      total.za2 += best.za2;
      total.mass_x2 += best.mass_x2;
      total.mass_z2 += best.mass_z2;
      total.worst = std::max(total.worst, best.worst);
      total.count += best.count;
    }
    const auto root_mean = [&](double sum) { return std::sqrt(sum / total.count); };
    const double event_error_ms = 1.0e3 * (summary.event_time_s - event_truth);
    const double px = 1.0e3 * summary.scale_px_per_mm;
    fmt::print(
        "{:22} {:7.2f} {:8} {:8.3f} {:8.3f} {:>11} {:8.2f} {:8.3f} {:>20} {:>13} {:9.2f} {:6.0f}\n",
        replicate.name,
        100.0 * summary.completeness,
        switches,
        1.0e3 * root_mean(total.x2),
        1.0e3 * root_mean(total.z2),
        fmt::format("{:.3f} {:.3f}", px * root_mean(total.x2), px * root_mean(total.z2)),
        1.0e3 * total.worst,
        root_mean(total.angle2) / degree,
        fmt::format("{:.2f} {:.2f} {:.2f}",
                    root_mean(total.zx2),
                    root_mean(total.zz2),
                    root_mean(total.za2)),
        fmt::format("{:.2f} {:.2f}", root_mean(total.mass_x2), root_mean(total.mass_z2)),
        event_error_ms,
        frames_per_second);
    for (const std::string& warning : summary.warnings) fmt::print("  {}\n", warning);
    const auto text = [](double value) { return datasets::number_text(value); };
    table.add({replicate.name,
               std::to_string(summary.frames_read),
               text(summary.completeness),
               std::to_string(switches),
               text(1.0e3 * root_mean(total.x2)),
               text(1.0e3 * root_mean(total.z2)),
               text(px * root_mean(total.x2)),
               text(px * root_mean(total.z2)),
               text(1.0e3 * total.worst),
               text(root_mean(total.angle2) / degree),
               text(root_mean(total.zx2)),
               text(root_mean(total.zz2)),
               text(root_mean(total.za2)),
               text(root_mean(total.mass_x2)),
               text(root_mean(total.mass_z2)),
               text(event_error_ms),
               text(1.0e3 * summary.event_uncertainty_s),
               text(summary.calibration_rms_mm),
               text(summary.scale_px_per_mm),
               text(1.0e3 * tracker.learned().radius_mean),
               text(1.0e3 * tracker.learned().separation_mean),
               text(frames_per_second),
               tracking::to_string(summary.grade)});
  }
  datasets::write_csv(out, table);
  fmt::print("written to {}\n", out.string());
  return 0;
}
