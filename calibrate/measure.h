// What is measured of trajectories, on film and in simulation alike: values at the frames of the
// comparison, their mean and spread over repeats. Thesis section 4.2.3; circular statistics for
// angles after Fisher (1993).
#pragma once

#include <array>
#include <span>
#include <vector>

#include "datasets/experiment.h"
#include "datasets/trajectories.h"

namespace graintruth::calibrate {

// The three parameters that the thesis compares per particle and frame.
enum class Quantity { x, z, angle };
inline constexpr std::array<Quantity, 3> quantities = {Quantity::x, Quantity::z, Quantity::angle};

const char* name_of(Quantity quantity);  // as in files: x, z, angle
double value_of(const datasets::Pose& pose, Quantity quantity);

// a - b. Angles of bodies with equal ends repeat every pi: their difference is wrapped to [-pi/2,
// pi/2).
double difference(Quantity quantity, double a, double b);

// One quantity of one particle at one frame, over repeats.
struct Spread {
  double mean = 0.0;
  double standard_deviation = 0.0;  // divisor n - 1; about the circular mean for angles
  int count = 0;                    // repeats in which the particle was seen
};

// Spreads of all particles at all frames.
struct Band {
  std::vector<double> time;  // s
  int particles = 0;
  std::vector<std::array<Spread, 3>> spreads;  // frame-major; [quantity]

  std::size_t frames() const { return time.size(); }
  std::size_t index(std::size_t frame, std::size_t particle) const {
    return frame * static_cast<std::size_t>(particles) + particle;
  }
};

// Times of the comparison, s: 0, interval, 2 interval, ...
std::vector<double> measurement_times(double interval, int frames);

// What is compared of these tracks: themselves, or the height of the heap as the z of a single body
// whose x and angle are not seen. The heap is as high as its highest particle's centre.
datasets::Trajectories compared_part(datasets::Trajectories tracks, datasets::Compared compared);

// Mean and spread over repeats that share their times.
Band measure(std::span<const datasets::Trajectories> repeats);

// The mean track over repeats: what a Band holds as means, as trajectories.
datasets::Trajectories mean_track(const Band& band);

// Mean tracks of the same repeats under many weightings, as a jackknife needs them: what does not
// depend on the weights (sines and cosines) is computed once.
class WeightedMeans {
 public:
  // The repeats must outlive it.
  explicit WeightedMeans(std::span<const datasets::Trajectories> repeats);
  // `weights` counts how often each repeat enters; each once gives mean_track(measure(repeats)).
  datasets::Trajectories mean(std::span<const int> weights) const;

 private:
  struct Direction {
    double sine, cosine;  // of twice the angle
  };
  std::span<const datasets::Trajectories> repeats_;
  std::vector<std::vector<Direction>> directions_;  // of every pose of every repeat
};

// Root of the mean over particles and frames of the squared distance of positions, m. Unseen ones
// are left out.
double rms_position(const datasets::Trajectories& a, const datasets::Trajectories& b);

}  // namespace graintruth::calibrate
