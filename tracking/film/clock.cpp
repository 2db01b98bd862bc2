#include "tracking/film/clock.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "tracking/film/video.h"
#include "tracking/median.h"

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

// What a particle's step into a frame should have been by those before and after, and was.
struct Share {
  std::size_t particle = 0;
  double expected = 0.0;  // m
  double share = 0.0;     // of it, along its direction
};

std::vector<Share> shares_into(const Steps& steps, std::size_t frame, int particles, double least) {
  std::vector<Share> shares;
  for (std::size_t particle = 0; particle < static_cast<std::size_t>(particles); ++particle) {
    const auto step = steps.into(frame, particle);
    const auto before = steps.usual(frame - 1, frame - 2, particle);
    const auto after = steps.usual(frame + 1, frame + 2, particle);
    if (!step || !before || !after || before->dot(*after) <= 0.0) continue;
    if (std::min(before->norm(), after->norm()) < least) continue;
    const Eigen::Vector2d expected = 0.5 * (*before + *after);
    // What moves to and fro, or in fits and starts, foretells nothing: both neighbours must be of
    // one motion, and one step beyond them too
    const auto goes_on = [&](const std::optional<Eigen::Vector2d>& other) {
      return other && (*other - expected).norm() < 0.5 * expected.norm();
    };
    if ((*after - *before).norm() > expected.norm()) continue;
    if (!goes_on(steps.into(frame - 2, particle)) && !goes_on(steps.into(frame + 2, particle)))
      continue;
    shares.push_back({particle, expected.norm(), step->dot(expected) / expected.squaredNorm()});
  }
  return shares;
}

// By how much steps differ from what is expected, m, one standard deviation, of each particle; of
// those that are rarely seen moving that of all.
std::vector<double> noise_of(const std::vector<std::vector<Share>>& frames, int particles) {
  constexpr std::size_t enough = 8;               // steps
  constexpr double deviation_of_median = 1.4826;  // of a normal distribution
  std::vector<std::vector<double>> misses(static_cast<std::size_t>(particles));
  std::vector<double> all;
  for (const auto& shares : frames) {
    for (const Share& one : shares) {
      const double miss = std::abs(one.share - 1.0) * one.expected;
      misses[one.particle].push_back(miss);
      all.push_back(miss);
    }
  }
  const double usual = deviation_of_median * median(all);
  std::vector<double> noise;
  for (auto& list : misses)
    noise.push_back(list.size() < enough ? usual : deviation_of_median * median(std::move(list)));
  return noise;
}

// Whether these particles moved `times` as far as they should have: three in four do so within
// their noise, and stand out of it.
bool moved(const std::vector<Share>& shares, const std::vector<double>& noise, double times) {
  constexpr double within = 0.25;  // of a step, where noise is less
  constexpr double sigmas = 3.0;
  std::size_t agreeing = 0;
  for (const Share& one : shares) {
    const double own = sigmas * noise[one.particle] / one.expected;
    const bool fits = std::abs(one.share - times) < std::max(within, std::min(own, 0.5));
    const bool stands_out = std::abs(one.share - 1.0) > own;
    agreeing += fits && stands_out;
  }
  return 4 * agreeing >= 3 * shares.size();
}

// The change into a picture over that into its neighbours: the least and the most of theirs.
struct Content {
  double over_least = 1.0, over_most = 1.0;
};
std::optional<Content> content_at(const std::vector<double>& changes, std::size_t frame) {
  constexpr std::size_t reach = 2;
  if (frame < reach + 1 || frame + reach >= changes.size()) return std::nullopt;
  double least = changes[frame - 1], most = least;
  for (std::size_t other = frame - reach; other <= frame + reach; ++other) {
    if (other == frame) continue;
    least = std::min(least, changes[other]);
    most = std::max(most, changes[other]);
  }
  if (!(least > 0.0)) return std::nullopt;
  return Content{changes[frame] / least, changes[frame] / most};
}

}  // namespace

ClockFaults find_clock_faults(const datasets::Trajectories& tracks,
                              double pixel,
                              const PictureClock& clock) {
  constexpr double least_step = 0.5;  // px
  constexpr std::size_t fewest = 3;   // particles that move
  const Steps steps(tracks);
  std::vector<std::vector<Share>> shares(tracks.frames());
  for (std::size_t frame = 3; frame + 2 < tracks.frames(); ++frame)
    shares[frame] = shares_into(steps, frame, tracks.particles, least_step * pixel);
  const std::vector<double> noise = noise_of(shares, tracks.particles);
  const bool has_own_stamps =
      std::any_of(clock.moments.begin(), clock.moments.end(), [](double moment) {
        return moment != std::floor(moment);
      });
  ClockFaults faults;
  for (std::size_t frame = 3; frame + 2 < tracks.frames(); ++frame) {
    if (shares[frame].size() < fewest) continue;
    // Of two fields the first shows what is new in their frame
    const auto woven = static_cast<std::size_t>(clock.pictures_a_frame);
    const auto content = content_at(clock.changes, frame / woven);
    if (!content || frame % woven != 0) continue;
    const auto number = static_cast<int>(frame);
    // Shows less than a third of what is usual: nothing new but compression
    constexpr double nothing_new = 0.3;
    if (content->over_least < nothing_new && moved(shares[frame], noise, 0.0)) {
      faults.repeated.push_back(number);
      continue;
    }
    // A stamp of its own tells when each picture was taken, and a step of several intervals that
    // pictures are lacking: no time is lost
    if (has_own_stamps || clock.moments[frame] - clock.moments[frame - 1] != 1.0) continue;
    // A repeated picture that took another's place is followed by a double step: no time is lost
    if (!faults.repeated.empty() && faults.repeated.back() == number - 1) continue;
    // Shows clearly more than any of its neighbours; twice as much where patterns are coarse
    constexpr double clearly_more = 1.25;
    if (content->over_most < clearly_more) continue;
    std::vector<double> times;
    for (const Share& one : shares[frame]) times.push_back(one.share);
    const double whole = std::round(median(std::move(times)));
    if (whole >= 2.0 && moved(shares[frame], noise, whole)) faults.jumps.push_back(number);
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
