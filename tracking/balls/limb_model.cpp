#include "tracking/balls/limb_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace graintruth::tracking {

namespace {

// What EdgeImage smooths brightness and colour by; films store colour at half the resolution.
constexpr std::array<double, 2> smoothing_px = {0.8, 1.6};

double normal_density(double x) {
  return std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi);
}

// Phi(-t / blur): 1 inside, 0 outside
double blurred_step(double t, double blur) {
  return 0.5 * std::erfc(t / (blur * std::numbers::sqrt2));
}

// H(t) = int_0^2R sqrt(s (1 - s / 2R)) phi((t + s) / blur) ds / blur; with s = w^2 the integrand is
// smooth: 2 w^2 sqrt(1 - w^2 / 2R) phi.
double blurred_limb(double t, double blur, double radius) {
  constexpr int intervals = 200;
  const double most = std::sqrt(std::min(std::max(0.0, -t) + 6.0 * blur, 2.0 * radius));
  double sum = 0.0;
  for (int i = 0; i < intervals; ++i) {
    const double w = most * (i + 0.5) / intervals;
    const double depth = w * w;
    sum +=
        2.0 * depth * std::sqrt(1.0 - depth / (2.0 * radius)) * normal_density((t + depth) / blur);
  }
  return sum * most / intervals / blur;
}

}  // namespace

LimbModel::LimbModel(double radius_px,
                     double brightness_blur_px,
                     double colour_blur_px,
                     double black)
    : blur_px_{brightness_blur_px, colour_blur_px}, black_(static_cast<float>(black)) {
  bases_.resize(2 * (RayProfile::samples - least_usable + 1) * positions);
  for (int part = 0; part < 2; ++part) {
    const double blur = blur_px_[static_cast<std::size_t>(part)];
    for (int position = 0; position < positions; ++position) {
      const double edge = static_cast<double>(position) / positions_per_px - most_px;
      Eigen::Matrix<double, 3, RayProfile::samples> all;
      for (int i = 0; i < RayProfile::samples; ++i) {
        const double t = (i - RayProfile::inside) * RayProfile::step - edge;
        const double covered = blurred_step(t, blur);
        all.col(i) << 1.0 - covered, covered, blurred_limb(t, blur, radius_px);
      }
      for (int usable = least_usable; usable <= RayProfile::samples; ++usable) {
        Eigen::Matrix<double, 3, RayProfile::samples> rows = all;
        rows.rightCols(RayProfile::samples - usable).setZero();
        // What lies behind is free: the ball is seen in what that does not explain
        rows.row(0).normalize();
        for (int pass = 0; pass < 2; ++pass)
          for (int r = 1; r < 3; ++r) rows.row(r) -= rows.row(r).dot(rows.row(0)) * rows.row(0);
        Basis& basis = bases_[index_of(part, usable, position)];
        basis.rows = rows.cast<float>();
        basis.products = rows.bottomRows<2>() * rows.bottomRows<2>().transpose();
      }
    }
  }
}

std::size_t LimbModel::index_of(int part, int usable, int position) {
  constexpr int lengths = RayProfile::samples - least_usable + 1;
  return static_cast<std::size_t>((part * lengths + usable - least_usable) * positions + position);
}

LimbModel::Range LimbModel::range(double start, double reach) {
  const auto position_of = [](double px) {
    return std::clamp(
        static_cast<int>(std::lround((px + most_px) * positions_per_px)), 0, positions - 1);
  };
  return {position_of(start - reach), position_of(start + reach)};
}

LimbModel::Samples LimbModel::samples_of(const RayProfile& profile) const {
  Samples samples;
  samples.usable = profile.usable;
  samples.colours.setZero();
  for (int i = 0; i < profile.usable; ++i) {
    samples.colours.row(i) = profile.colours[static_cast<std::size_t>(i)].transpose();
    samples.colours(i, 0) -= black_;
  }
  // Its own paint: as deep inside as the ray reaches, out to where blur mixes it with the ground
  constexpr int deep = RayProfile::inside / 2 + 1;
  samples.paint = samples.colours.topRows<deep>().colwise().mean().transpose().cast<double>();
  return samples;
}

LimbModel::Misfit LimbModel::misfit(const Samples& samples,
                                    int position,
                                    const std::array<double, 2>& weights) const {
  Misfit result;
  std::array<Eigen::Matrix<double, 2, 1>, 3> seen;
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  std::array<double, 3> square;
  for (int c = 0; c < 3; ++c) {
    const int part = c == 0 ? 0 : 1;
    const Basis& basis = bases_[index_of(part, samples.usable, position)];
    const Eigen::Vector3f products = basis.rows.lazyProduct(samples.colours.col(c));
    const auto channel = static_cast<std::size_t>(c);
    square[channel] = samples.square[channel] - static_cast<double>(products[0]) * products[0];
    seen[channel] = products.tail<2>().cast<double>();
    const double weight = weights[static_cast<std::size_t>(part)], paint = samples.paint[c];
    normal += weight * paint * paint * basis.products;
    right += weight * paint * seen[channel];
  }
  normal.diagonal().array() += 1.0e-9 * (1.0 + normal.trace());
  const Eigen::Vector2d shade = normal.inverse() * right;
  for (int c = 0; c < 3; ++c) {
    const int part = c == 0 ? 0 : 1;
    const Basis& basis = bases_[index_of(part, samples.usable, position)];
    const auto channel = static_cast<std::size_t>(c);
    const Eigen::Vector2d own = samples.paint[c] * shade;
    result.parts[static_cast<std::size_t>(part)] +=
        square[channel] - 2.0 * own.dot(seen[channel]) + own.dot(basis.products * own);
  }
  result.total = weights[0] * result.parts[0] + weights[1] * result.parts[1];
  return result;
}

LimbEdge LimbModel::locate(const RayProfile& profile,
                           double start,
                           double reach,
                           double noise) const {
  LimbEdge edge;
  if (profile.usable < least_usable) return edge;
  const Range tried = range(start, reach);
  Samples samples = samples_of(profile);
  for (int c = 0; c < 3; ++c)
    samples.square[static_cast<std::size_t>(c)] = samples.colours.col(c).squaredNorm();
  std::array<double, positions> total;
  const auto best_with = [&](const std::array<double, 2>& weights, Misfit& least) {
    int best = tried.first;
    for (int p = tried.first; p <= tried.last; ++p) {
      const Misfit here = misfit(samples, p, weights);
      total[static_cast<std::size_t>(p)] = here.total;
      if (p > tried.first && here.total >= least.total) continue;
      least = here;
      best = p;
    }
    return best;
  };
  // Each part in units of its own noise: what the best edge leaves, or the camera's. White noise
  // smoothed by a Gaussian of width s has 1/(2 sqrt(pi) s) independent values a pixel; samples are
  // closer than that.
  Misfit least;
  best_with({1.0, 1.0}, least);
  std::array<double, 2> weights;
  for (std::size_t part = 0; part < 2; ++part) {
    const double freedom = (part + 1.0) * (profile.usable - 4);
    const double independent =
        std::min(1.0, RayProfile::step / (2.0 * std::sqrt(std::numbers::pi) * smoothing_px[part]));
    weights[part] = independent / std::max(least.parts[part] / freedom, 0.25 * noise * noise);
  }
  const int best = best_with(weights, least);
  if (best == tried.first || best == tried.last) return edge;
  // chi^2 = least + (t - edge)^2 / variance
  const auto at = [&](int p) { return total[static_cast<std::size_t>(p)]; };
  const double before = at(best - 1), here = at(best), after = at(best + 1);
  const double curvature = before - 2.0 * here + after;
  if (!(curvature > 0.0)) return edge;
  edge.found = true;
  edge.position = (best + 0.5 * (before - after) / curvature) / positions_per_px - most_px;
  edge.variance = 2.0 / (curvature * positions_per_px * positions_per_px);
  return edge;
}

std::array<double, 2> LimbModel::misfits(const RayProfile& profile,
                                         double start,
                                         double reach) const {
  const Range tried = range(start, reach);
  const Samples samples = samples_of(profile);
  std::array<double, 2> least = {1.0e300, 1.0e300};
  for (int p = tried.first; p <= tried.last; ++p) {
    std::array<double, 2> here = {};
    for (int c = 0; c < 3; ++c) {
      const std::size_t part = c == 0 ? 0 : 1;
      const Basis& basis = bases_[index_of(static_cast<int>(part), samples.usable, p)];
      const Eigen::Vector3d seen = basis.rows.lazyProduct(samples.colours.col(c)).cast<double>();
      here[part] += samples.colours.col(c).squaredNorm() - seen[0] * seen[0] -
                    seen.tail<2>().dot(basis.products.inverse() * seen.tail<2>());
    }
    for (std::size_t part = 0; part < 2; ++part) least[part] = std::min(least[part], here[part]);
  }
  return least;
}

double learn_black(const std::vector<RayProfile>& profiles,
                   const std::vector<std::size_t>& firsts) {
  // Squared distance of the colours from lines through `black`, each body its own
  const auto misfit = [&](double black) {
    double sum = 0.0;
    for (std::size_t body = 0; body + 1 < firsts.size(); ++body) {
      double light = 0.0;
      Eigen::Vector2d colour = Eigen::Vector2d::Zero(), both = Eigen::Vector2d::Zero();
      for (std::size_t i = firsts[body]; i < firsts[body + 1]; ++i) {
        for (int k = 0; k < RayProfile::inside / 2 + 1; ++k) {
          const Eigen::Vector3d seen =
              profiles[i].colours[static_cast<std::size_t>(k)].cast<double>();
          light += (seen[0] - black) * (seen[0] - black);
          both += (seen[0] - black) * seen.tail<2>();
          colour += seen.tail<2>().cwiseProduct(seen.tail<2>());
        }
      }
      if (light > 0.0) sum += (colour - both.cwiseProduct(both) / light).sum();
    }
    return sum;
  };
  constexpr double lowest = -255.0, highest = 510.0, stride = 5.0;
  double best = 0.0, least = misfit(0.0);
  const double usual = least;
  for (double black = lowest; black <= highest; black += stride) {
    const double here = misfit(black);
    if (here >= least) continue;
    least = here;
    best = black;
  }
  constexpr double clearly = 1.5;
  return usual > clearly * least ? best : 0.0;
}

LimbModel learn_limb_model(double radius_px,
                           const std::vector<RayProfile>& profiles,
                           const std::vector<double>& starts,
                           double black) {
  constexpr double least_blur = 0.8, most_blur = 2.4, stride = 0.1;  // px
  constexpr double reach = 1.25;                                     // px
  std::array<double, 2> best_blur = {1.1, 1.6}, best = {1.0e300, 1.0e300};
  for (double blur = least_blur; blur < most_blur; blur += stride) {
    const LimbModel model(radius_px, blur, blur, black);
    // Logarithms: no single ray across a shadow or a numeral decides.
    std::array<double, 2> sum = {};
    for (std::size_t i = 0; i < profiles.size(); ++i) {
      if (profiles[i].usable < RayProfile::samples) continue;
      const std::array<double, 2> misfit = model.misfits(profiles[i], starts[i], reach);
      for (std::size_t part = 0; part < 2; ++part)
        sum[part] += std::log(std::max(misfit[part], 0.0) + 1.0);
    }
    for (std::size_t part = 0; part < 2; ++part) {
      if (sum[part] >= best[part]) continue;
      best[part] = sum[part];
      best_blur[part] = blur;
    }
  }
  return {radius_px, best_blur[0], best_blur[1], black};
}

}  // namespace graintruth::tracking
