#include "calibrate/observables/moments.h"

namespace graintruth::calibrate {

std::vector<double> measurement_times(double interval, int frames) {
  std::vector<double> times(static_cast<std::size_t>(frames));
  for (std::size_t frame = 0; frame < times.size(); ++frame) {
    times[frame] = interval * static_cast<double>(frame);
  }
  return times;
}

datasets::Trajectories poses_at(const datasets::Trajectories& tracks,
                                const std::vector<double>& times) {
  return tracks.time == times ? tracks : datasets::sample(tracks, times);
}

bool spans(const std::vector<double>& time, double last) {
  if (time.empty()) return false;
  const double step =
      time.size() < 2 ? 0.0 : (time.back() - time.front()) / static_cast<double>(time.size() - 1);
  return time.front() <= 0.5 * step && time.back() >= last - 0.5 * step;
}

}  // namespace graintruth::calibrate
