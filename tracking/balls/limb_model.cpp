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

LimbModel::LimbModel(double radius_px, double brightness_blur_px, double colour_blur_px)
    : blur_px_{brightness_blur_px, colour_blur_px} {
  bases_.resize(2 * (RayProfile::samples - least_usable + 1) * positions);
  for (int part = 0; part < 2; ++part) {
    const double blur = blur_px_[static_cast<std::size_t>(part)];
    for (int position = 0; position < positions; ++position) {
      const double edge = static_cast<double>(position) / positions_per_px - most_px;
      Eigen::Matrix<double, 3, RayProfile::samples> all;
      for (int i = 0; i < RayProfile::samples; ++i) {
        const double t = (i - RayProfile::inside) * RayProfile::step - edge;
        all.col(i) << 1.0, blurred_step(t, blur), blurred_limb(t, blur, radius_px);
      }
      for (int usable = least_usable; usable <= RayProfile::samples; ++usable) {
        // Gram-Schmidt over the usable samples
        Eigen::Matrix<double, 3, RayProfile::samples> rows = all;
        rows.rightCols(RayProfile::samples - usable).setZero();
        for (int r = 0; r < 3; ++r) {
          for (int pass = 0; pass < 2; ++pass)
            for (int q = 0; q < r; ++q) rows.row(r) -= rows.row(r).dot(rows.row(q)) * rows.row(q);
          rows.row(r).normalize();
        }
        bases_[index_of(part, usable, position)] = rows.cast<float>();
      }
    }
  }
}

std::size_t LimbModel::index_of(int part, int usable, int position) {
  constexpr int lengths = RayProfile::samples - least_usable + 1;
  return static_cast<std::size_t>((part * lengths + usable - least_usable) * positions + position);
}

LimbModel::Scan LimbModel::scan(const RayProfile& profile, double start, double reach) const {
  const auto position_of = [](double px) {
    return std::clamp(
        static_cast<int>(std::lround((px + most_px) * positions_per_px)), 0, positions - 1);
  };
  Scan result{.first = position_of(start - reach), .last = position_of(start + reach)};
  Eigen::Matrix<float, RayProfile::samples, 3> colours;
  const Eigen::Vector3f origin = profile.colours[RayProfile::inside];
  for (int i = 0; i < RayProfile::samples; ++i) {
    if (i < profile.usable)
      colours.row(i) = (profile.colours[static_cast<std::size_t>(i)] - origin).transpose();
    else
      colours.row(i).setZero();
  }
  const float brightness = colours.col(0).squaredNorm();
  const float colour = colours.rightCols<2>().squaredNorm();
  for (int p = result.first; p <= result.last; ++p) {
    const auto k = static_cast<std::size_t>(p);
    result.misfit[0][k] =
        brightness -
        bases_[index_of(0, profile.usable, p)].lazyProduct(colours.col(0)).squaredNorm();
    result.misfit[1][k] =
        colour -
        bases_[index_of(1, profile.usable, p)].lazyProduct(colours.rightCols<2>()).squaredNorm();
  }
  return result;
}

LimbEdge LimbModel::locate(const RayProfile& profile,
                           double start,
                           double reach,
                           double noise) const {
  LimbEdge edge;
  if (profile.usable < least_usable) return edge;
  const auto [first, last, misfit] = scan(profile, start, reach);
  // Each part in units of its own noise: what its best edge leaves, or the camera's. White noise
  // smoothed by a Gaussian of width s has 1/(2 sqrt(pi) s) independent values a pixel; samples are
  // closer than that.
  std::array<double, 2> scale;
  for (std::size_t part = 0; part < 2; ++part) {
    const double least =
        *std::min_element(misfit[part].begin() + first, misfit[part].begin() + last + 1);
    const double freedom = (part + 1.0) * (profile.usable - 4);
    const double independent =
        std::min(1.0, RayProfile::step / (2.0 * std::sqrt(std::numbers::pi) * smoothing_px[part]));
    scale[part] = independent / std::max(least / freedom, 0.25 * noise * noise);
  }
  const auto total = [&, &misfit = misfit](int p) {
    const auto k = static_cast<std::size_t>(p);
    return scale[0] * misfit[0][k] + scale[1] * misfit[1][k];
  };
  int best = first;
  for (int p = first; p <= last; ++p)
    if (total(p) < total(best)) best = p;
  if (best == first || best == last) return edge;
  // chi^2 = least + (t - edge)^2 / variance
  const double before = total(best - 1), here = total(best), after = total(best + 1);
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
  const auto [first, last, misfit] = scan(profile, start, reach);
  std::array<double, 2> least;
  for (std::size_t part = 0; part < 2; ++part)
    least[part] = *std::min_element(misfit[part].begin() + first, misfit[part].begin() + last + 1);
  return least;
}

LimbModel learn_limb_model(double radius_px,
                           const std::vector<RayProfile>& profiles,
                           const std::vector<double>& starts) {
  constexpr double least_blur = 0.8, most_blur = 2.4, stride = 0.1;  // px
  constexpr double reach = 1.25;                                     // px
  std::array<double, 2> best_blur = {1.1, 1.6}, best = {1.0e300, 1.0e300};
  for (double blur = least_blur; blur < most_blur; blur += stride) {
    const LimbModel model(radius_px, blur, blur);
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
  return {radius_px, best_blur[0], best_blur[1]};
}

}  // namespace graintruth::tracking
