// Who was where when: the one form in which tracked films and simulations meet, so that both are
// measured by the same functions.
#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <vector>

namespace graintruth::datasets {

// Where one particle is in the picture plane. Also used for standard deviations, component by
// component.
struct Pose {
  double x = std::numeric_limits<double>::quiet_NaN();  // m, to the right
  double z = std::numeric_limits<double>::quiet_NaN();  // m, upwards
  double angle =
      std::numeric_limits<double>::quiet_NaN();  // rad, long axis from +x, counter-clockwise
};

// Poses of the same particles at many times. A particle that was not seen has NaN in its pose.
// Angles are unwrapped along each track (continuous in time; first seen angle in [0, pi)); whoever
// compares angles of bodies with equal ends must do so modulo pi.
struct Trajectories {
  std::vector<double> time;  // s, one a frame, increasing; 0 is the start event
  int particles = 0;         // count; particle number p (from 1) is stored at index p - 1
  std::vector<Pose> poses;   // frame-major: frames x particles
  std::vector<Pose>
      sigmas;  // standard deviations, same shape; empty where none are known (a simulation)
  std::vector<double>
      scores;  // 0..1 quality of each detection, same shape; empty where none are known

  std::size_t frames() const { return time.size(); }
  std::size_t index(std::size_t frame, std::size_t particle) const {
    return frame * static_cast<std::size_t>(particles) + particle;
  }
};

// A trajectory set with room for `frames` times and `particles` particles, all unseen.
Trajectories make_trajectories(std::size_t frames, int particles, bool with_uncertainty);

// The poses at the given times, each by linear interpolation between the two frames around it;
// unseen where either of them is unseen, or where the time lies more than half a frame interval
// outside the recording (within half an interval the nearest frame is extended by its own
// velocity).
Trajectories sample(const Trajectories& trajectories, const std::vector<double>& times);

// tracks/<replicate>.csv:
// frame,time_s,particle,x_m,z_m,angle_rad,sigma_x_m,sigma_z_m,sigma_angle_rad,score, one row for
// each particle seen. Written whole, then renamed; numbers are the shortest that read back to the
// same bits.
void write_tracks(const std::filesystem::path& file, const Trajectories& trajectories);

// Makes each track's angle continuous: bodies with equal ends look the same after half a turn, and
// other programs write their angles within one.
void unwrap_angles(Trajectories& tracks);

}  // namespace graintruth::datasets
