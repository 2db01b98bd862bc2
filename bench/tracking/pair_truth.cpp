#include "bench/tracking/pair_truth.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets/store/table.h"

namespace graintruth::bench {

namespace {

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

}  // namespace

PairErrors& PairErrors::operator+=(const PairErrors& other) {
  x2 += other.x2;
  z2 += other.z2;
  angle2 += other.angle2;
  mid_x2 += other.mid_x2;
  mid_z2 += other.mid_z2;
  over_x2 += other.over_x2;
  over_z2 += other.over_z2;
  over_angle2 += other.over_angle2;
  within_x += other.within_x;
  within_z += other.within_z;
  within_angle += other.within_angle;
  worst = std::max(worst, other.worst);
  frames += other.frames;
  seen += other.seen;
  strangers += other.strangers;
  return *this;
}

double PairErrors::root(double sum) const { return seen > 0.0 ? std::sqrt(sum / seen) : 0.0; }

std::vector<PairBody> compare_pairs(const datasets::Trajectories& tracks,
                                    const std::filesystem::path& truth_folder,
                                    const std::string& name) {
  const datasets::Table placement = datasets::read_csv(truth_folder / (name + "_placement.csv"));
  const datasets::Table truth_table = datasets::read_csv(truth_folder / (name + "_tracks.csv"));
  const auto particles = static_cast<std::size_t>(tracks.particles);
  // Pictures and truth run at the same rate
  std::vector<datasets::Pose> truth(tracks.poses.size());
  for (std::size_t row = 0; row < truth_table.rows(); ++row) {
    const auto frame = static_cast<std::size_t>(truth_table.integer(row, "frame"));
    const auto particle = static_cast<std::size_t>(truth_table.integer(row, "particle")) - 1;
    if (frame >= tracks.frames()) continue;
    truth[tracks.index(frame, particle)] = {truth_table.number(row, "x_m"),
                                            truth_table.number(row, "z_m"),
                                            truth_table.number(row, "angle_rad")};
  }
  std::vector<PairBody> bodies;
  for (std::size_t p = 0; p < particles; ++p) {
    const double offset = midpoint_offset(placement.number(p, "radius_1_m"),
                                          placement.number(p, "radius_2_m"),
                                          placement.number(p, "centre_distance_m"));
    PairErrors best;
    double least = 1.0e9;
    for (const double end : {-1.0, 1.0}) {
      PairErrors sums;
      for (std::size_t k = 0; k < tracks.frames(); ++k) {
        const std::size_t i = tracks.index(k, p);
        const datasets::Pose &seen = tracks.poses[i], &sigma = tracks.sigmas[i], &t = truth[i];
        sums.frames += 1.0;
        if (!std::isfinite(seen.x)) continue;
        sums.seen += 1.0;
        const double x = seen.x - t.x - end * offset * std::cos(t.angle);
        const double z = seen.z - t.z - end * offset * std::sin(t.angle);
        const double angle = std::remainder(seen.angle - t.angle, std::numbers::pi);
        sums.x2 += x * x;
        sums.z2 += z * z;
        sums.angle2 += angle * angle;
        sums.mid_x2 += std::pow(x / sigma.x, 2);
        sums.mid_z2 += std::pow(z / sigma.z, 2);
        const double over_x = (seen.x - t.x) / sigma.x, over_z = (seen.z - t.z) / sigma.z,
                     over_angle = angle / sigma.angle;
        sums.over_x2 += over_x * over_x;
        sums.over_z2 += over_z * over_z;
        sums.over_angle2 += over_angle * over_angle;
        sums.within_x += std::abs(over_x) < 2.0;
        sums.within_z += std::abs(over_z) < 2.0;
        sums.within_angle += std::abs(over_angle) < 2.0;
        sums.worst = std::max(sums.worst, std::hypot(x, z));
        const double own = std::hypot(seen.x - t.x, seen.z - t.z);
        for (std::size_t q = 0; q < particles; ++q) {
          const datasets::Pose& other = truth[tracks.index(k, q)];
          if (q == p || std::hypot(seen.x - other.x, seen.z - other.z) >= own) continue;
          sums.strangers += 1.0;
          break;
        }
      }
      if (sums.x2 + sums.z2 < least) {
        least = sums.x2 + sums.z2;
        best = sums;
      }
    }
    bodies.push_back({placement.text(p, "colour"), best});
  }
  return bodies;
}

}  // namespace graintruth::bench
