// How well the films of the macro experiment are tracked, against their truth: missed and false
// plates at rest and in flow, position and angle error, calibration of the stated uncertainty,
// identity, discharge count, time zero, speed. Prints a table and writes it as CSV.
//   bench_tracking_macro [OUT.csv] [EXPERIMENT.toml] [part of a film's name]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <numbers>

#include "datasets/table.h"
#include "tracking/recording.h"
#include "tracking/track_bed.h"

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

// The stagnant boundary of a smeared film against the truth: in each frame and column the top of
// the lowest plates in a row that all rest; median error, m. A frame covers the time to the next
// one.
double stagnant_error(const tracking::TrackedBed& tracked, const Truth& truth, double frame_rate) {
  constexpr double plate = 5.3e-3;  // m
  const double slow =
      frame_rate / (1.0e3 * tracked.summary.scale_px_per_mm);  // m/s, a pixel a frame
  std::vector<double> errors;
  for (std::size_t k = 0; k < tracked.stagnant.height.size(); ++k) {
    const auto t =
        static_cast<std::size_t>(std::lround(static_cast<double>(k) * truth_rate / frame_rate));
    const std::size_t after = t + static_cast<std::size_t>(truth_rate / frame_rate);
    if (after >= truth.poses.size()) break;
    for (std::size_t i = 0; i < tracked.stagnant.x.size(); ++i) {
      if (!std::isfinite(tracked.stagnant.height[k][i])) continue;
      // The lowest plate of the column that moves, or is missing, ends what stands still
      std::vector<std::pair<double, bool>> column;  // top, at rest
      for (std::size_t q = 0; q < truth.poses[t].size(); ++q) {
        const datasets::Pose &a = truth.poses[t][q], &b = truth.poses[after][q];
        if (!std::isfinite(a.x) || std::abs(a.x - tracked.stagnant.x[i]) > plate) continue;
        const double speed =
            std::isfinite(b.x) ? std::hypot(b.x - a.x, b.z - a.z) * frame_rate : 1.0;
        column.emplace_back(a.z + plate, speed < slow);
      }
      std::sort(column.begin(), column.end());
      double top = 0.0;
      for (const auto& [height, rests] : column) {
        if (!rests || height > top + 4.0 * plate) break;
        top = height;
      }
      errors.push_back(std::abs(tracked.stagnant.height[k][i] - top));
    }
  }
  if (errors.empty()) return 0.0;
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path file =
      argc > 2 ? argv[2]
               : std::filesystem::path(GRAINTRUTH_SOURCE_DIR) / "datasets/macro/experiment.toml";
  const std::filesystem::path out = argc > 1 ? argv[1] : "tracking_macro.csv";
  const std::string only = argc > 3 ? argv[3] : "";
  datasets::Experiment experiment;
  try {
    experiment = datasets::load_experiment(file);
  } catch (const std::exception& error) {
    fmt::print("skipped: {}\n", error.what());
    return 0;
  }
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
  for (const datasets::Replicate& replicate : experiment.replicates) {
    if (replicate.name.find(only) == std::string::npos) continue;
    const datasets::Experiment filmed =
        tracking::as_recorded(datasets::as_filmed(experiment, replicate), replicate);
    const std::clock_t start = std::clock();
    const tracking::TrackedBed tracked = tracking::track_bed(filmed, replicate);
    const auto& [tracks, stagnant, summary, bed] = tracked;
    const double cpu = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    const std::string run = replicate.name.substr(0, std::string("orifice050_rep1").size());
    const Truth truth = read_truth(replicate.video.parent_path() / "truth", run);
    if (!stagnant.x.empty()) {
      fmt::print(
          "{:36} smeared: stagnant boundary {:.1f} mm (median) off the truth, {:.0f} frames/s\n",
          replicate.name,
          1.0e3 * stagnant_error(tracked, truth, filmed.camera.frame_rate),
          summary.frames_read / cpu);
      for (const std::string& warning : summary.warnings) fmt::print("  {}\n", warning);
      continue;
    }
    // 40 mm below the floor the picture ends; a plate's own half axis stays inside
    constexpr double bottom = -0.029;  // m
    const Figures f = compare(tracks, truth, truth_rate / filmed.camera.frame_rate, bottom);
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
