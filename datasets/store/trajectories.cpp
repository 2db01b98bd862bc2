#include "datasets/store/trajectories.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets/store/run_folder.h"
#include "datasets/store/table.h"

namespace graintruth::datasets {

namespace {

bool is_seen(const Pose& pose) { return std::isfinite(pose.x) && std::isfinite(pose.z); }

// a + share (b - a); share may lie a little outside 0..1.
Pose between(const Pose& a, const Pose& b, double share) {
  return {
      a.x + share * (b.x - a.x), a.z + share * (b.z - a.z), a.angle + share * (b.angle - a.angle)};
}

}  // namespace

Trajectories make_trajectories(std::size_t frames, int particles, bool with_uncertainty) {
  Trajectories made;
  made.time.resize(frames);
  made.particles = particles;
  made.poses.resize(frames * static_cast<std::size_t>(particles));
  if (with_uncertainty) {
    made.sigmas.resize(made.poses.size());
    made.scores.resize(made.poses.size(), 0.0);
  }
  return made;
}

Trajectories sample(const Trajectories& trajectories, const std::vector<double>& times) {
  const bool uncertain = !trajectories.sigmas.empty();
  Trajectories sampled = make_trajectories(times.size(), trajectories.particles, uncertain);
  sampled.time = times;
  const std::vector<double>& recorded = trajectories.time;
  if (recorded.size() < 2) return sampled;

  for (std::size_t frame = 0; frame < times.size(); ++frame) {
    // 1. The two recorded frames around the wanted time
    const auto after = std::upper_bound(recorded.begin() + 1, recorded.end() - 1, times[frame]);
    const auto right = static_cast<std::size_t>(after - recorded.begin());
    const std::size_t left = right - 1;
    const double share = (times[frame] - recorded[left]) / (recorded[right] - recorded[left]);
    if (share < -0.5 || share > 1.5) continue;
    // 2. Every particle that both of them saw
    for (std::size_t particle = 0; particle < static_cast<std::size_t>(sampled.particles);
         ++particle) {
      const std::size_t a = trajectories.index(left, particle);
      const std::size_t b = trajectories.index(right, particle);
      if (!is_seen(trajectories.poses[a]) || !is_seen(trajectories.poses[b])) continue;
      const std::size_t to = sampled.index(frame, particle);
      sampled.poses[to] = between(trajectories.poses[a], trajectories.poses[b], share);
      if (uncertain) {
        const std::size_t nearest = share < 0.5 ? a : b;
        sampled.sigmas[to] = trajectories.sigmas[nearest];
        sampled.scores[to] = trajectories.scores[nearest];
      }
    }
  }
  return sampled;
}

void unwrap_angles(Trajectories& tracks) {
  constexpr double pi = std::numbers::pi;
  for (std::size_t particle = 0; particle < static_cast<std::size_t>(tracks.particles);
       ++particle) {
    double last = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t frame = 0; frame < tracks.frames(); ++frame) {
      double& angle = tracks.poses[tracks.index(frame, particle)].angle;
      if (!std::isfinite(angle)) continue;
      // Angles that are continuous already keep their bits.
      const double turns = std::isfinite(last) ? std::floor((last - angle) / pi + 0.5) : 0.0;
      if (turns != 0.0) angle += turns * pi;
      last = angle;
    }
  }
}

void write_tracks(const std::filesystem::path& file, const Trajectories& trajectories) {
  Table table({"frame",
               "time_s",
               "particle",
               "x_m",
               "z_m",
               "angle_rad",
               "sigma_x_m",
               "sigma_z_m",
               "sigma_angle_rad",
               "score"});
  for (std::size_t frame = 0; frame < trajectories.frames(); ++frame) {
    for (std::size_t particle = 0; particle < static_cast<std::size_t>(trajectories.particles);
         ++particle) {
      const std::size_t i = trajectories.index(frame, particle);
      const Pose& pose = trajectories.poses[i];
      if (!is_seen(pose)) continue;
      const Pose sigma = trajectories.sigmas.empty() ? Pose{} : trajectories.sigmas[i];
      table.add({std::to_string(frame),
                 number_text(trajectories.time[frame]),
                 std::to_string(particle + 1),
                 number_text(pose.x),
                 number_text(pose.z),
                 number_text(pose.angle),
                 number_text(sigma.x),
                 number_text(sigma.z),
                 number_text(sigma.angle),
                 trajectories.scores.empty() ? "" : number_text(trajectories.scores[i])});
    }
  }
  write_csv(file, table);
}

}  // namespace graintruth::datasets
