#include "tracking/film/clock.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "tracking/film/video.h"

namespace graintruth::tracking {

namespace {

class Steps {
 public:
  explicit Steps(const datasets::Trajectories& tracks) : tracks_(tracks) {}

  // How a particle moved from the frame before, m; nothing where it was not seen.
  std::optional<Eigen::Vector2d> into(std::size_t frame, std::size_t particle) const {
    const datasets::Pose& before = tracks_.poses[tracks_.index(frame - 1, particle)];
    const datasets::Pose& now = tracks_.poses[tracks_.index(frame, particle)];
    if (!std::isfinite(before.x) || !std::isfinite(now.x)) return std::nullopt;
    return Eigen::Vector2d(now.x - before.x, now.z - before.z);
  }

  // The step into `nearer`, or into `farther` where hardly anything moved in that one: it may be a
  // fault, too.
  std::optional<Eigen::Vector2d> usual(std::size_t nearer,
                                       std::size_t farther,
                                       std::size_t particle) const {
    const auto one = into(nearer, particle), other = into(farther, particle);
    if (!one || !other) return std::nullopt;
    return one->norm() > 0.25 * other->norm() ? one : other;
  }

 private:
  const datasets::Trajectories& tracks_;
};

}  // namespace

ClockFaults find_clock_faults(const datasets::Trajectories& tracks, double pixel) {
  constexpr double least_step = 0.5;  // px
  constexpr std::size_t fewest = 3;   // particles that move
  const Steps steps(tracks);
  ClockFaults faults;
  std::vector<double> shares;  // of the step that is expected
  for (std::size_t frame = 3; frame + 2 < tracks.frames(); ++frame) {
    shares.clear();
    for (std::size_t particle = 0; particle < static_cast<std::size_t>(tracks.particles);
         ++particle) {
      const auto step = steps.into(frame, particle);
      const auto before = steps.usual(frame - 1, frame - 2, particle);
      const auto after = steps.usual(frame + 1, frame + 2, particle);
      if (!step || !before || !after || before->dot(*after) <= 0.0) continue;
      if (std::min(before->norm(), after->norm()) < least_step * pixel) continue;
      const Eigen::Vector2d expected = 0.5 * (*before + *after);
      shares.push_back(step->dot(expected) / expected.squaredNorm());
    }
    if (shares.size() < fewest) continue;
    std::sort(shares.begin(), shares.end());
    const double lower = shares[shares.size() / 4];
    const double upper = shares[shares.size() - 1 - shares.size() / 4];
    const auto number = static_cast<int>(frame);
    if (upper < 0.25 && lower > -0.25) faults.repeated.push_back(number);
    // A repeated picture that took another's place is followed by a double step: no time is lost.
    else if (lower > 1.6 && (faults.repeated.empty() || faults.repeated.back() != number - 1))
      faults.jumps.push_back(number);
  }
  return faults;
}

std::vector<std::string> describe(const ClockFaults& faults, const std::vector<int>& known) {
  std::vector<int> repeated;
  for (const int frame : faults.repeated)
    if (std::find(known.begin(), known.end(), frame) == known.end()) repeated.push_back(frame);
  std::vector<std::string> sentences;
  if (!repeated.empty()) {
    sentences.push_back("Nothing moves into frames " + listed(repeated) +
                        " although everything does before and after: pictures are repeated, and "
                        "the clock of this recording may slip there.");
  }
  if (!faults.jumps.empty()) {
    sentences.push_back("Everything moves at least twice as far into frames " +
                        listed(faults.jumps) +
                        " as before: pictures are missing, and later times are too early.");
  }
  return sentences;
}

}  // namespace graintruth::tracking
