#include "calibrate/objective.h"

#include <algorithm>
#include <cmath>

#include "calibrate/agreement.h"

namespace graintruth::calibrate {

namespace {

constexpr std::size_t pooled_neighbours = 2;  // frames before and after whose variance is pooled

// Root mean square over replicates of the measurement's own standard deviation; 0 where none is
// known.
double measurement_error(std::span<const datasets::Trajectories> tracks,
                         std::size_t i,
                         Quantity quantity) {
  double squares = 0.0;
  int count = 0;
  for (const datasets::Trajectories& track : tracks) {
    if (track.sigmas.empty()) continue;
    const double sigma = value_of(track.sigmas[i], quantity);
    if (!std::isfinite(sigma)) continue;
    squares += sigma * sigma;
    ++count;
  }
  return count == 0 ? 0.0 : std::sqrt(squares / count);
}

// Mean variance over the frames around `frame`.
double pooled_variance(const Band& band,
                       std::size_t frame,
                       std::size_t particle,
                       std::size_t quantity) {
  const std::size_t first = frame < pooled_neighbours ? 0 : frame - pooled_neighbours;
  const std::size_t last = std::min(frame + pooled_neighbours, band.frames() - 1);
  double sum = 0.0;
  int count = 0;
  for (std::size_t f = first; f <= last; ++f) {
    const double sd = band.spreads[band.index(f, particle)][quantity].standard_deviation;
    if (!std::isfinite(sd)) continue;
    sum += sd * sd;
    ++count;
  }
  return count == 0 ? 0.0 : sum / count;
}

// Student's 95 % interval of the mean of `count` values, t s / sqrt(n).
double half_width_of_mean(double standard_deviation, int count) {
  return critical_value(Critical::student_t, count) * standard_deviation / std::sqrt(count);
}

double loss(datasets::ObjectiveForm form, double z) {
  if (form == datasets::ObjectiveForm::smooth) return pseudo_huber(z);
  return std::abs(z) > 1.0 ? 1.0 : 0.0;
}

}  // namespace

double mean_loss(datasets::ObjectiveForm form, std::span<const double> residuals) {
  double sum = 0.0;
  for (const double z : residuals) sum += loss(form, z);
  return residuals.empty() ? 0.0 : sum / static_cast<double>(residuals.size());
}

double pseudo_huber(double z) { return std::sqrt(1.0 + 0.25 * z * z) - 1.0; }

HalfWidths smooth_half_widths(const Band& replicates,
                              std::span<const datasets::Trajectories> tracks,
                              int left_out) {
  // The smallest error that is believed where a track file states none: far below any camera's.
  constexpr std::array<double, 3> least_error = {1.0e-5, 1.0e-5, 1.0e-4};  // m, m, rad
  HalfWidths widths;
  widths.half_width.resize(replicates.spreads.size());
  for (std::size_t frame = 0; frame < replicates.frames(); ++frame) {
    for (std::size_t particle = 0; particle < static_cast<std::size_t>(replicates.particles);
         ++particle) {
      const std::size_t i = replicates.index(frame, particle);
      for (std::size_t q = 0; q < quantities.size(); ++q) {
        const Spread& spread = replicates.spreads[i][q];
        if (spread.count < 2) continue;
        const double own = spread.standard_deviation * spread.standard_deviation;
        const double variance = 0.5 * (own + pooled_variance(replicates, frame, particle, q));
        const double floor = std::max(measurement_error(tracks, i, quantities[q]), least_error[q]);
        widths.half_width[i][q] =
            std::max(half_width_of_mean(std::sqrt(variance), spread.count + left_out), floor);
      }
    }
  }
  return widths;
}

HalfWidths agreement_half_widths(const Band& replicates, int left_out) {
  HalfWidths widths{.form = datasets::ObjectiveForm::requested};
  for (const auto& spreads : replicates.spreads) {
    auto& half_width = widths.half_width.emplace_back();
    for (std::size_t q = 0; q < quantities.size(); ++q) {
      if (spreads[q].count < 2) continue;
      half_width[q] =
          half_width_of_mean(spreads[q].standard_deviation, spreads[q].count + left_out);
    }
  }
  return widths;
}

std::vector<double> residuals(const datasets::Trajectories& replicate_mean,
                              const HalfWidths& widths,
                              const datasets::Trajectories& simulated_mean) {
  std::vector<double> all;
  all.reserve(replicate_mean.poses.size() * quantities.size());
  for (std::size_t i = 0; i < replicate_mean.poses.size(); ++i) {
    const std::size_t first = i % static_cast<std::size_t>(replicate_mean.particles);
    for (const Quantity quantity : quantities) {
      const double half_width = widths.half_width[i][static_cast<std::size_t>(quantity)];
      if (!(half_width > 0.0)) continue;
      const double measured = value_of(replicate_mean.poses[i], quantity);
      double simulated = value_of(simulated_mean.poses[i], quantity);
      if (!std::isfinite(simulated)) simulated = value_of(replicate_mean.poses[first], quantity);
      const double z = difference(quantity, simulated, measured) / half_width;
      if (std::isfinite(z)) all.push_back(z);
    }
  }
  return all;
}

double objective(const datasets::Trajectories& replicate_mean,
                 const HalfWidths& widths,
                 const datasets::Trajectories& simulated_mean) {
  return mean_loss(widths.form, residuals(replicate_mean, widths, simulated_mean));
}

double objective_of_rest(const datasets::Trajectories& replicate_mean, const HalfWidths& widths) {
  const datasets::Trajectories nothing =
      datasets::make_trajectories(replicate_mean.frames(), replicate_mean.particles, false);
  return objective(replicate_mean, widths, nothing);
}

}  // namespace graintruth::calibrate
