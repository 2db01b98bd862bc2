// How well the films of the macro experiment are tracked, against their truth: missed and false
// plates at rest and in flow, position and angle error, calibration of the stated uncertainty,
// identity, discharge count, time zero, speed. Prints a table and writes it as CSV.
//   bench_tracking_macro [OUT.csv] [EXPERIMENT.toml] [part of a film's name]
// Without an experiment file: the fifteen films, the interlaced one and the one with a slow
// shutter.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <numbers>

#include "bench/tracking/films.h"
#include "calibrate/flow/bulk_measure.h"
#include "calibrate/observables/observable.h"
#include "datasets/store/table.h"
#include "tracking/plates/bed_tracker.h"
#include "tracking/track_film.h"

using namespace graintruth;

namespace {

constexpr double degree = std::numbers::pi / 180.0;
constexpr double event_truth = 0.1;    // s of film, README of the data set
constexpr double truth_rate = 100.0;   // Hz, of the truth files
constexpr double same_plate = 2.5e-3;  // m; half a semi-minor axis: nearer than any neighbour
constexpr double at_rest = 0.02;       // m/s; slower is still

struct Truth {
  std::vector<std::vector<datasets::Pose>> poses;  // frame, particle; NaN once it has left
  std::vector<int> discharged;
};

Truth read_truth(const std::filesystem::path& folder, const std::string& run) {
  const datasets::Table tracks = datasets::read_csv(folder / (run + "_tracks.csv"));
  const datasets::Table counts = datasets::read_csv(folder / (run + "_discharge.csv"));
  Truth truth;
  int particles = 0;
  for (std::size_t row = 0; row < tracks.rows(); ++row)
    particles = std::max(particles, tracks.integer(row, "particle"));
  for (std::size_t row = 0; row < tracks.rows(); ++row) {
    const auto frame = static_cast<std::size_t>(tracks.integer(row, "frame"));
    if (truth.poses.size() <= frame)
      truth.poses.resize(frame + 1,
                         std::vector<datasets::Pose>(static_cast<std::size_t>(particles)));
    truth.poses[frame][static_cast<std::size_t>(tracks.integer(row, "particle") - 1)] = {
        tracks.number(row, "x_m"), tracks.number(row, "z_m"), tracks.number(row, "angle_rad")};
  }
  for (std::size_t row = 0; row < counts.rows(); ++row)
    truth.discharged.push_back(counts.integer(row, "discharged_count"));
  truth.poses.resize(truth.discharged.size(),
                     std::vector<datasets::Pose>(static_cast<std::size_t>(particles)));
  return truth;
}

struct Figures {
  long still = 0, still_missed = 0, still_false = 0, moving = 0, moving_missed = 0,
       moving_false = 0;
  double x2 = 0.0, z2 = 0.0, angle2 = 0.0;     // squared errors: m, rad
  double zx2 = 0.0, zz2 = 0.0, zangle2 = 0.0;  // over sigma
  double x = 0.0, z = 0.0;                     // sums of errors, m
  long matched = 0, links = 0, switches = 0;
  int worst_count = 0, final_count = 0;
};

Figures compare(const datasets::Trajectories& tracks,
                const Truth& truth,
                double truth_frames_a_frame,
                double bottom) {
  Figures f;
  const auto particles = static_cast<std::size_t>(tracks.particles);
  std::vector<int> identity(particles, -1);
  std::vector<char> out(particles, 0);
  for (std::size_t k = 0; k < tracks.frames(); ++k) {
    const auto t =
        static_cast<std::size_t>(std::lround(static_cast<double>(k) * truth_frames_a_frame));
    if (t >= truth.poses.size()) break;
    const std::vector<datasets::Pose>& now = truth.poses[t];
    std::vector<int> seen_by(now.size(), -1);
    int count = 0;
    for (std::size_t p = 0; p < particles; ++p) {
      const std::size_t i = tracks.index(k, p);
      const datasets::Pose& pose = tracks.poses[i];
      if (std::isfinite(pose.x)) out[p] = pose.z < 0.0;
      count += out[p];
      if (!std::isfinite(pose.x)) continue;
      int nearest = -1;
      double least = same_plate;
      for (std::size_t q = 0; q < now.size(); ++q) {
        const double distance = std::hypot(now[q].x - pose.x, now[q].z - pose.z);
        if (distance < least) {
          least = distance;
          nearest = static_cast<int>(q);
        }
      }
      if (nearest < 0 || seen_by[static_cast<std::size_t>(nearest)] >= 0) {
        const bool still = pose.z > 0.0 && k < 10;
        ++(still ? f.still_false : f.moving_false);
        continue;
      }
      seen_by[static_cast<std::size_t>(nearest)] = static_cast<int>(p);
      if (identity[p] >= 0) {
        ++f.links;
        f.switches += identity[p] != nearest;
      }
      identity[p] = nearest;
      const datasets::Pose& sigma = tracks.sigmas[i];
      const datasets::Pose& real = now[static_cast<std::size_t>(nearest)];
      const double x = pose.x - real.x, z = pose.z - real.z;
      const double angle = std::remainder(pose.angle - real.angle, std::numbers::pi);
      f.x += x;
      f.z += z;
      f.x2 += x * x;
      f.z2 += z * z;
      f.angle2 += angle * angle;
      f.zx2 += std::pow(x / sigma.x, 2);
      f.zz2 += std::pow(z / sigma.z, 2);
      f.zangle2 += std::pow(angle / sigma.angle, 2);
      ++f.matched;
    }
    for (std::size_t q = 0; q < now.size(); ++q) {
      // Wholly in the picture
      if (!std::isfinite(now[q].x) || now[q].z < bottom) continue;
      const std::size_t before = t > 0 ? t - 1 : t, after = std::min(t + 1, truth.poses.size() - 1);
      const datasets::Pose &a = truth.poses[before][q], &b = truth.poses[after][q];
      const double time = static_cast<double>(after - before) / truth_rate;
      const bool still = std::hypot(b.x - a.x, b.z - a.z) < at_rest * time;
      ++(still ? f.still : f.moving);
      if (seen_by[q] < 0) ++(still ? f.still_missed : f.moving_missed);
    }
    f.worst_count = std::max(f.worst_count, std::abs(count - truth.discharged[t]));
    f.final_count = count - truth.discharged[t];
  }
  return f;
}

// What stands still in a smeared film against the truth, both by the rule of
// datasets/imports/stagnant.h: the boundary's height in each frame and column beside the orifice,
// the median height of each column while the bed discharges, and the places themselves.
struct StagnantFigures {
  double median = 0.0, mean = 0.0;  // m, of the heights' errors
  double within = 0.0;              // share of them within a particle diameter
  double worst_typical = 0.0;       // m, of the medians over time
  double overlap = 0.0;             // of places, mean over the frames of the discharge
};

double median_of(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

StagnantFigures compare_stagnant(const tracking::StagnantBed& film,
                                 const Truth& truth,
                                 const calibrate::BulkRig& rig,
                                 double frame_rate) {
  // A frame of this shutter covers the time to the next one: it shows the middle of that
  const double truth_frames = truth_rate / frame_rate;
  datasets::Trajectories tracks = datasets::make_trajectories(
      truth.poses.size(), static_cast<int>(truth.poses.front().size()), false);
  for (std::size_t t = 0; t < truth.poses.size(); ++t) {
    tracks.time[t] = static_cast<double>(t) / truth_rate;
    for (std::size_t q = 0; q < truth.poses[t].size(); ++q)
      tracks.poses[tracks.index(t, q)] = truth.poses[t][q];
  }
  StagnantFigures figures;
  std::vector<double> errors;
  std::vector<std::vector<double>> filmed(film.x.size()), real(film.x.size());
  int discharging = 0;
  for (std::size_t k = 0; k < film.maps.size(); ++k) {
    const auto from = static_cast<std::size_t>((static_cast<double>(k) + 0.5) * truth_frames);
    const auto to = from + static_cast<std::size_t>(std::lround(film.frames_apart * truth_frames));
    if (to >= tracks.frames()) break;
    const double height = film.maps[k].z.back() + film.maps[k].z.front();
    const datasets::StagnantMap map = calibrate::measure_stagnant(tracks, rig, height, from, to);
    const std::vector<double> heights = datasets::stagnant_heights(map, rig.orifice);
    const bool flows = truth.discharged[to] > truth.discharged[from];
    if (flows) {
      figures.overlap += datasets::stagnant_overlap(map, film.maps[k]);
      ++discharging;
    }
    for (std::size_t i = 0; i < film.x.size(); ++i) {
      if (!std::isfinite(heights[i])) continue;
      errors.push_back(std::abs(film.height[k][i] - heights[i]));
      if (!flows) continue;
      filmed[i].push_back(film.height[k][i]);
      real[i].push_back(heights[i]);
    }
  }
  for (const double error : errors) {
    figures.mean += error / static_cast<double>(errors.size());
    figures.within += (error < rig.particle_diameter) / static_cast<double>(errors.size());
  }
  figures.median = median_of(errors);
  for (std::size_t i = 0; i < film.x.size(); ++i)
    figures.worst_typical =
        std::max(figures.worst_typical, std::abs(median_of(filmed[i]) - median_of(real[i])));
  figures.overlap /= std::max(1, discharging);
  return figures;
}

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path out = argc > 1 ? argv[1] : "tracking_macro.csv";
  const std::vector<bench::Filmed> films =
      bench::films_of("macro", argc > 2 ? argv[2] : "", argc > 3 ? argv[3] : "");
  datasets::Table table({"replicate",
                         "still_missed_percent",
                         "still_false_percent",
                         "moving_missed_percent",
                         "moving_false_percent",
                         "rmse_x_px",
                         "rmse_z_px",
                         "bias_x_px",
                         "bias_z_px",
                         "rmse_angle_deg",
                         "z_sd_x",
                         "z_sd_z",
                         "z_sd_angle",
                         "links",
                         "switches",
                         "worst_count_error",
                         "final_count_error",
                         "event_error_ms",
                         "event_sigma_ms",
                         "gravity_m_per_s2",
                         "size_ratio",
                         "cpu_frames_per_second",
                         "grade"});
  fmt::print("{:36} {:>11} {:>11} {:>11} {:>13} {:>5} {:>14} {:>12} {:>7} {:>8} {:>6} {:>5}\n",
             "replicate",
             "still m f %",
             "flow m f %",
             "rmse px",
             "bias px",
             "deg",
             "z-score sd",
             "links switch",
             "count",
             "event ms",
             "g",
             "fps");
  for (const auto& [experiment, replicate, film, spec] : films) {
    const std::clock_t start = std::clock();
    tracking::BedTracker tracker(spec, film);
    const auto [tracks, summary] = tracking::track_film(tracker, spec, film);
    const auto& stagnant = tracker.stagnant();
    const auto& bed = tracker.bed();
    const double cpu = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    const std::string run = replicate.name.substr(0, std::string("orifice050_rep1").size());
    const Truth truth = read_truth(replicate.video.parent_path() / "truth", run);
    if (!stagnant.x.empty()) {
      const calibrate::BulkRig rig =
          calibrate::bulk_rig({.particle = experiment.particle, .rig = replicate.rig});
      const StagnantFigures f = compare_stagnant(stagnant, truth, rig, spec.camera.frame_rate);
      fmt::print(
          "{:36} smeared: stagnant boundary off the truth by {:.1f} mm (median), {:.1f} mm (mean), "
          "{:.1f} % within a diameter; its median over the discharge by {:.1f} mm at most; places "
          "overlap by {:.2f}; {:.0f} frames/s\n",
          replicate.name,
          1.0e3 * f.median,
          1.0e3 * f.mean,
          100.0 * f.within,
          1.0e3 * f.worst_typical,
          f.overlap,
          summary.frames_read / cpu);
      for (const std::string& warning : summary.warnings) fmt::print("  {}\n", warning);
      continue;
    }
    // 40 mm below the floor the picture ends; a plate's own half axis stays inside
    constexpr double bottom = -0.029;  // m
    const Figures f = compare(tracks, truth, truth_rate / spec.camera.frame_rate, bottom);
    const double n = static_cast<double>(std::max(1L, f.matched));
    const double px = 1.0e3 * summary.scale_px_per_mm;
    const auto rms = [&](double square) { return std::sqrt(square / n); };
    const auto percent = [](long part, long whole) {
      return 100.0 * static_cast<double>(part) / static_cast<double>(std::max(1L, whole));
    };
    const double event_error = 1.0e3 * (summary.event_time_s - event_truth);
    const double fps = summary.frames_read / cpu;
    fmt::print(
        "{:36} {:5.2f} {:5.2f} {:5.2f} {:5.2f} {:5.3f} {:5.3f} {:+.3f} {:+.3f} {:5.2f} {:4.2f} "
        "{:4.2f} {:4.2f} {:7} {:4} {:3} {:+3} {:8.2f} {:6.2f} {:5.1f} {} {:.4f}\n",
        replicate.name,
        percent(f.still_missed, f.still),
        percent(f.still_false, f.still),
        percent(f.moving_missed, f.moving),
        percent(f.moving_false, f.moving),
        px * rms(f.x2),
        px * rms(f.z2),
        px * f.x / n,
        px * f.z / n,
        rms(f.angle2) / degree,
        rms(f.zx2),
        rms(f.zz2),
        rms(f.zangle2),
        f.links,
        f.switches,
        f.worst_count,
        f.final_count,
        event_error,
        bed.gravity_measured,
        fps,
        tracking::to_string(summary.grade),
        bed.size_ratio);
    for (const std::string& warning : summary.warnings) fmt::print("  {}\n", warning);
    const auto text = [](double value) { return datasets::number_text(value); };
    table.add({replicate.name,
               text(percent(f.still_missed, f.still)),
               text(percent(f.still_false, f.still)),
               text(percent(f.moving_missed, f.moving)),
               text(percent(f.moving_false, f.moving)),
               text(px * rms(f.x2)),
               text(px * rms(f.z2)),
               text(px * f.x / n),
               text(px * f.z / n),
               text(rms(f.angle2) / degree),
               text(rms(f.zx2)),
               text(rms(f.zz2)),
               text(rms(f.zangle2)),
               std::to_string(f.links),
               std::to_string(f.switches),
               std::to_string(f.worst_count),
               std::to_string(f.final_count),
               text(event_error),
               text(1.0e3 * summary.event_uncertainty_s),
               text(bed.gravity_measured),
               text(bed.size_ratio),
               text(fps),
               tracking::to_string(summary.grade)});
  }
  datasets::write_csv(out, table);
  fmt::print("written to {}\n", out.string());
  return 0;
}
