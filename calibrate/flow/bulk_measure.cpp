#include "calibrate/flow/bulk_measure.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <span>

#include "calibrate/observables/observable.h"
#include "datasets/statistics/linear_least_squares.h"

namespace graintruth::calibrate {

namespace {

using datasets::Pose;
using datasets::Trajectories;

bool seen(const Pose& pose) { return std::isfinite(pose.x) && std::isfinite(pose.z); }

// Twice the time of falling by a diameter: longer than that nothing but an arch holds them up.
double longest_gap(const BulkRig& rig) {
  return 2.0 * std::sqrt(2.0 * rig.particle_diameter / rig.gravity);
}

// Least-squares line of the count against time over exits [first, last].
datasets::StraightLine line_through(const std::vector<double>& times,
                                    const std::vector<double>& counts,
                                    std::size_t first,
                                    std::size_t last) {
  const std::size_t number = last - first + 1;
  return datasets::straight_line(std::span(times).subspan(first, number),
                                 std::span(counts).subspan(first, number));
}

// Standard error of the mean of values that follow one another, with Bartlett's weights.
double standard_error_of_mean(const std::vector<double>& values) {
  const auto count = static_cast<double>(values.size());
  double mean = 0.0;
  for (double value : values) mean += value / count;
  const auto covariance = [&](std::size_t lag) {
    double sum = 0.0;
    for (std::size_t i = lag; i < values.size(); ++i)
      sum += (values[i] - mean) * (values[i - lag] - mean);
    return sum / count;
  };
  const auto lags = static_cast<std::size_t>(std::cbrt(count));
  double variance = covariance(0);
  for (std::size_t lag = 1; lag <= lags; ++lag)
    variance +=
        2.0 * (1.0 - static_cast<double>(lag) / static_cast<double>(lags + 1)) * covariance(lag);
  return std::sqrt(std::max(0.0, variance) / count);
}

// When a particle left; none where it stayed.
std::optional<double> exit_time(const Trajectories& tracks,
                                std::size_t particle,
                                const BulkRig& rig) {
  std::optional<std::size_t> before;  // last frame in which it was seen in the bin
  for (std::size_t frame = 0; frame < tracks.frames(); ++frame) {
    const Pose& pose = tracks.poses[tracks.index(frame, particle)];
    if (!seen(pose)) continue;
    const double above_exit = pose.z - rig.exit_z;
    if (above_exit >= 0.0) {
      before = frame;
      continue;
    }
    if (!before) return tracks.time[frame];
    const double above = tracks.poses[tracks.index(*before, particle)].z - rig.exit_z;
    return tracks.time[*before] +
           (tracks.time[frame] - tracks.time[*before]) * above / (above - above_exit);
  }
  if (!before || *before + 1 >= tracks.frames()) return std::nullopt;
  const Pose& last = tracks.poses[tracks.index(*before, particle)];
  const bool over_orifice =
      std::abs(last.x) < 0.5 * rig.orifice && last.z - rig.exit_z < rig.particle_diameter;
  if (!over_orifice) return std::nullopt;
  return tracks.time[*before + 1];
}

std::size_t frame_at(const Trajectories& tracks, double time) {
  const auto later = std::lower_bound(tracks.time.begin(), tracks.time.end(), time);
  return std::min(tracks.frames() - 1, static_cast<std::size_t>(later - tracks.time.begin()));
}

double mean_height(const BedShape& bed) {
  double height = 0.0;
  for (const double strip : bed.surface) height += strip / static_cast<double>(bed.surface.size());
  return height;
}

// When the bed has sunk so far that less than a diameter of it lies above the band.
double profile_end(const Trajectories& tracks,
                   const BulkRig& rig,
                   double height,
                   const SteadyRate& steady) {
  double until = steady.from;
  for (std::size_t frame = frame_at(tracks, until); frame < tracks.frames(); ++frame) {
    const BedShape bed = measure_bed(tracks, frame, rig);
    const double lowest = *std::min_element(bed.surface.begin(), bed.surface.end());
    if (lowest < height + rig.particle_diameter || tracks.time[frame] > steady.to) break;
    until = tracks.time[frame];
  }
  return until;
}

}  // namespace

Discharge measure_discharge(const Trajectories& tracks, const BulkRig& rig) {
  Discharge discharge;
  if (tracks.frames() == 0) return discharge;
  discharge.from = tracks.time.front();
  discharge.to = tracks.time.back();
  for (std::size_t particle = 0; particle < static_cast<std::size_t>(tracks.particles);
       ++particle) {
    bool ever = false;
    for (std::size_t frame = 0; frame < tracks.frames() && !ever; ++frame)
      ever = seen(tracks.poses[tracks.index(frame, particle)]);
    if (!ever) continue;
    ++discharge.particles;
    if (const auto time = exit_time(tracks, particle, rig)) {
      discharge.times.push_back(*time);
      continue;
    }
    const Pose& last = tracks.poses[tracks.index(tracks.frames() - 1, particle)];
    discharge.over_orifice += seen(last) && std::abs(last.x) < 0.5 * rig.orifice ? 1 : 0;
  }
  std::sort(discharge.times.begin(), discharge.times.end());
  return discharge;
}

Discharge measure_discharge(const datasets::DischargeCurve& curve,
                            int particles,
                            const BulkRig& rig) {
  Discharge discharge{.particles = particles, .from = curve.time.front(), .to = curve.time.back()};
  std::size_t first = 0, last = 0;  // samples between which particles leave
  for (std::size_t sample = 1; sample < curve.time.size(); ++sample) {
    const double before = curve.mass[sample - 1], now = curve.mass[sample];
    for (auto next = static_cast<double>(discharge.times.size());
         next < particles && now >= (next + 0.5) * rig.particle_mass;
         next += 1.0) {
      const double share = ((next + 0.5) * rig.particle_mass - before) / (now - before);
      discharge.times.push_back(curve.time[sample - 1] +
                                share * (curve.time[sample] - curve.time[sample - 1]));
      if (first == 0) first = sample;
      last = sample;
    }
  }
  if (!discharge.times.empty()) {
    discharge.together = static_cast<int>(std::ceil(static_cast<double>(discharge.times.size()) /
                                                    static_cast<double>(last - first + 1)));
  }
  return discharge;
}

int discharged_by(const Discharge& discharge, double time) {
  return static_cast<int>(std::upper_bound(discharge.times.begin(), discharge.times.end(), time) -
                          discharge.times.begin());
}

Arching find_arching(const Discharge& discharge, const BulkRig& rig) {
  Arching arching;
  const double longest = longest_gap(rig);
  const std::vector<double>& times = discharge.times;
  for (std::size_t i = 1; i < times.size(); ++i)
    if (times[i] - times[i - 1] > longest) arching.pauses.push_back({times[i - 1], times[i]});
  const double last = times.empty() ? std::max(0.0, discharge.from) : times.back();
  arching.jammed = discharge.over_orifice >= 2 && discharge.to - last > 10.0 * longest;
  return arching;
}

std::optional<SteadyRate> steady_rate(const Discharge& discharge, const BulkRig& rig) {
  const auto together = static_cast<std::size_t>(discharge.together);
  std::vector<double> times;  // in which so many leave together
  std::vector<bool> paused;   // whether nobody left for too long before
  const double longest = longest_gap(rig);
  bool pause = false;
  for (std::size_t i = 0; i < discharge.times.size(); ++i) {
    pause |= i > 0 && discharge.times[i] - discharge.times[i - 1] > longest;
    if ((i + 1) % together != 0) continue;
    times.push_back(discharge.times[i]);
    paused.push_back(pause);
    pause = false;
  }
  const double all = discharge.particles / static_cast<double>(together);
  const auto begin = static_cast<std::size_t>(std::ceil(0.1 * all));
  const std::size_t end = std::min(times.size(), static_cast<std::size_t>(0.8 * all) + 1);
  const double tolerance = 0.02 * all;
  std::vector<double> counts(times.size());
  std::iota(counts.begin(), counts.end(), 0.0);
  std::size_t best_first = 0, best_last = 0;
  for (std::size_t first = begin; first < end; ++first) {
    for (std::size_t last = first + 1; last < end; ++last) {
      if (paused[last]) break;
      if (last - first <= best_last - best_first) continue;
      if (line_through(times, counts, first, last).largest_residual > tolerance) continue;
      best_first = first;
      best_last = last;
    }
  }
  const std::size_t gaps = best_last - best_first;
  if (static_cast<double>(gaps) < 0.1 * all || gaps < 4) return std::nullopt;
  SteadyRate steady;
  steady.from = times[best_first];
  steady.to = times[best_last];
  steady.particles = static_cast<int>(gaps * together);
  // Rate = 1 / mean gap; to first order its error is rate^2 times that of the mean gap.
  std::vector<double> between;
  for (std::size_t i = best_first + 1; i <= best_last; ++i)
    between.push_back(times[i] - times[i - 1]);
  const double frequency = line_through(times, counts, best_first, best_last).slope;
  const double mass = rig.particle_mass * discharge.together;
  steady.rate = mass * frequency;
  steady.standard_error = mass * frequency * frequency * standard_error_of_mean(between);
  return steady;
}

double rate_of(const Discharge& discharge, const BulkRig& rig) {
  if (const auto steady = steady_rate(discharge, rig)) return steady->rate;
  const double duration = discharge.to - std::max(0.0, discharge.from);
  if (!(duration > 0.0)) return 0.0;
  return static_cast<double>(discharge.times.size()) * rig.particle_mass / duration;
}

BedShape measure_bed(const Trajectories& tracks, std::size_t frame, const BulkRig& rig) {
  constexpr std::size_t strips = 10;
  BedShape bed;
  bed.surface.assign(strips, 0.0);
  const double strip_width = rig.width / static_cast<double>(strips);
  int count = 0;
  for (std::size_t particle = 0; particle < static_cast<std::size_t>(tracks.particles);
       ++particle) {
    const Pose& pose = tracks.poses[tracks.index(frame, particle)];
    if (!seen(pose) || pose.z < rig.exit_z) continue;
    ++count;
    const double strip = std::floor((pose.x + 0.5 * rig.width) / strip_width);
    const auto at = static_cast<std::size_t>(std::clamp(strip, 0.0, strips - 1.0));
    bed.surface[at] = std::max(bed.surface[at], pose.z + 0.5 * rig.particle_diameter);
  }
  for (double height : bed.surface) bed.area += height * strip_width;
  if (bed.area > 0.0) {
    bed.solid_fraction = count * rig.particle_area / bed.area;
    bed.areal_density = count * rig.particle_mass / bed.area;
  }
  return bed;
}

std::size_t profile_bins(const BulkRig& rig) {
  return static_cast<std::size_t>(std::max(1.0, std::floor(rig.width / rig.particle_diameter)));
}

VelocityProfile measure_profile(
    const Trajectories& tracks, const BulkRig& rig, double height, double from, double to) {
  VelocityProfile profile;
  profile.height = height;
  const std::size_t bins = profile_bins(rig);
  const double bin_width = rig.width / static_cast<double>(bins);
  struct Passage {
    double velocity = 0.0, x = 0.0;
    int frames = 0;
  };
  std::vector<std::map<std::size_t, Passage>> passages(bins);  // by particle
  long frames = 0, inside = 0;
  for (std::size_t frame = 1; frame < tracks.frames(); ++frame) {
    if (tracks.time[frame - 1] < from || tracks.time[frame] > to) continue;
    ++frames;
    const double interval = tracks.time[frame] - tracks.time[frame - 1];
    for (std::size_t particle = 0; particle < static_cast<std::size_t>(tracks.particles);
         ++particle) {
      const Pose& before = tracks.poses[tracks.index(frame - 1, particle)];
      const Pose& now = tracks.poses[tracks.index(frame, particle)];
      if (!seen(before) || !seen(now)) continue;
      const double z = 0.5 * (before.z + now.z), x = 0.5 * (before.x + now.x);
      if (std::abs(z - height) > 0.5 * rig.particle_diameter) continue;
      const double bin = std::floor((x + 0.5 * rig.width) / bin_width);
      if (bin < 0.0 || bin >= static_cast<double>(bins)) continue;
      ++inside;
      Passage& passage = passages[static_cast<std::size_t>(bin)][particle];
      passage.velocity += (before.z - now.z) / interval;
      passage.x += x;
      ++passage.frames;
    }
  }
  if (frames == 0) return profile;
  profile.areal_density = static_cast<double>(inside) / static_cast<double>(frames) *
                          rig.particle_mass / (rig.width * rig.particle_diameter);
  for (const auto& bin : passages) {
    double velocity = 0.0, x = 0.0, weighted = 0.0;
    long seen_frames = 0;
    for (const auto& [particle, passage] : bin) {
      velocity += passage.velocity / passage.frames / static_cast<double>(bin.size());
      x += passage.x / passage.frames / static_cast<double>(bin.size());
      weighted += passage.velocity;
      seen_frames += passage.frames;
    }
    if (bin.empty()) continue;
    // Every frame counts alike in the flux: that is what passes per second.
    profile.flux +=
        weighted * rig.particle_mass / (static_cast<double>(frames) * rig.particle_diameter);
    double square = 0.0;
    for (const auto& [particle, passage] : bin)
      square += std::pow(passage.velocity / passage.frames - velocity, 2);
    const auto count = static_cast<double>(bin.size());
    // The mean over time, which the flux and a picture of the flow ask for
    VelocitySample sample{x, weighted / static_cast<double>(seen_frames), 0.0};
    if (bin.size() > 2) sample.standard_uncertainty = std::sqrt(square / (count - 1.0) / count);
    profile.samples.push_back(sample);
  }
  return profile;
}

datasets::StagnantMap measure_stagnant(const Trajectories& tracks,
                                       const BulkRig& rig,
                                       double height,
                                       std::size_t from,
                                       std::size_t to) {
  datasets::StagnantMap map = datasets::make_stagnant_map(rig.width, height, rig.particle_diameter);
  const double limit = datasets::stagnant_speed(rig.particle_diameter, rig.gravity) *
                       (tracks.time[to] - tracks.time[from]);
  const double reach = 0.6 * rig.particle_diameter;
  for (std::size_t column = 0; column < map.x.size(); ++column) {
    for (std::size_t row = 0; row < map.z.size(); ++row) {
      double least = reach;
      for (std::size_t p = 0; p < static_cast<std::size_t>(tracks.particles); ++p) {
        const Pose &before = tracks.poses[tracks.index(from, p)],
                   &after = tracks.poses[tracks.index(to, p)];
        // Not seen compares false
        const double distance = std::hypot(before.x - map.x[column], before.z - map.z[row]);
        if (!(distance < least)) continue;
        least = distance;
        const bool is_still = std::hypot(after.x - before.x, after.z - before.z) < limit;
        map.at(column, row) = is_still ? datasets::Ground::still : datasets::Ground::moving;
      }
    }
  }
  return map;
}

namespace {

// At five moments of the steady stretch, each over the time in which a particle falls by its own
// diameter: what is still for so long has not moved by a tenth of that.
std::vector<double> mean_stagnant_heights(const Trajectories& tracks,
                                          const BulkRig& rig,
                                          const BedShape& at_rest,
                                          const SteadyRate& steady) {
  constexpr int moments = 5;
  const double height = *std::max_element(at_rest.surface.begin(), at_rest.surface.end());
  const double watched = std::sqrt(2.0 * rig.particle_diameter / rig.gravity);
  std::vector<double> mean;
  for (int i = 0; i < moments; ++i) {
    const double time = steady.from + (steady.to - steady.from) * (i + 0.5) / moments;
    const std::size_t from = frame_at(tracks, time - 0.5 * watched),
                      to = frame_at(tracks, time + 0.5 * watched);
    if (from >= to || !(height > 0.0)) return {};
    const std::vector<double> heights =
        datasets::stagnant_heights(measure_stagnant(tracks, rig, height, from, to), rig.orifice);
    mean.resize(heights.size(), 0.0);
    for (std::size_t column = 0; column < heights.size(); ++column)
      mean[column] += heights[column] / moments;
  }
  return mean;
}

}  // namespace

BulkMeasurement measure_bulk(const Trajectories& tracks,
                             const BulkRig& rig,
                             std::optional<double> profile_height) {
  BulkMeasurement measured;
  measured.discharge = measure_discharge(tracks, rig);
  measured.at_rest = measure_bed(tracks, frame_at(tracks, 0.0), rig);
  const double height = profile_height.value_or(0.5 * mean_height(measured.at_rest));
  measured.profile.height = height;
  const std::optional<SteadyRate> steady = steady_rate(measured.discharge, rig);
  if (!steady) return measured;
  constexpr int moments = 10;
  for (int i = 0; i < moments; ++i) {
    const double time = steady->from + (steady->to - steady->from) * (i + 0.5) / moments;
    measured.flowing_density +=
        measure_bed(tracks, frame_at(tracks, time), rig).areal_density / moments;
  }
  const double until = profile_end(tracks, rig, height, *steady);
  VelocityProfile profile = measure_profile(tracks, rig, height, steady->from, until);
  if (profile.samples.size() >= 4) measured.profile = std::move(profile);
  measured.stagnant_heights = mean_stagnant_heights(tracks, rig, measured.at_rest, *steady);
  return measured;
}

BulkMeasurement measure_bulk(const datasets::DischargeCurve& curve,
                             int particles,
                             const BulkRig& rig) {
  return {.discharge = measure_discharge(curve, particles, rig), .of_tracks = false};
}

BulkRig bulk_rig(const Situation& situation) {
  const datasets::Particle& particle = situation.particle;
  const datasets::Rig& rig = situation.rig;
  BulkRig bulk{.particle_area = particle.seen_area,
               .particle_diameter = particle.diameter,
               .particle_mass = particle.mass,
               .gravity = rig.gravity};
  if (rig.bed) bulk.width = rig.bed->right_x - rig.bed->left_x;
  if (rig.opening) {
    bulk.orifice = rig.opening->width();
    bulk.exit_z = rig.opening->z;
  } else {
    bulk.orifice = std::numeric_limits<double>::infinity();
    bulk.exit_z = rig.scene.exit_height.value_or(-std::numeric_limits<double>::infinity());
  }
  return bulk;
}

}  // namespace graintruth::calibrate
