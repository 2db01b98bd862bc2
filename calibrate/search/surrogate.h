// A Gaussian process through the evaluations (Kriging, by OpenTURNS), and designs that fill a
// space. The surrogate smooths the objective's seed noise, finds its minimum and carries the
// bootstrap; it never supplies a reported score.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace graintruth::calibrate {

using UnitPoint = std::vector<double>;  // a place in the unit cube

// Largest difference of any coordinate.
double chebyshev_distance(const UnitPoint& a, const UnitPoint& b);

// The first `count` points of a Sobol sequence, shifted as a whole by an offset drawn from the seed
// (Cranley and Patterson 1976), so that designs differ between seeds and stay evenly spread.
std::vector<UnitPoint> low_discrepancy_points(int count, std::size_t dimension, std::uint64_t seed);

// Kriging with constant trend and Matern 5/2 covariance, one length a dimension, fitted by maximum
// likelihood.
class Surrogate {
 public:
  // `noise` is the standard deviation of each value that comes from its seeds.
  Surrogate(std::vector<UnitPoint> points,
            std::span<const double> values,
            std::span<const double> noise);
  ~Surrogate();
  Surrogate(Surrogate&&) noexcept;

  struct Prediction {
    double mean = 0.0;
    double standard_deviation = 0.0;  // of the smooth part: large where no point is near
  };
  std::vector<Prediction> predict(std::span<const UnitPoint> places) const;

  // The same process, of ln(J + known) where its own values are of ln J: for a part of J that is
  // known everywhere. With m and s the process's own,
  //   mean = ln(exp(m) + known),   standard deviation = s exp(m) / (exp(m) + known)  to first
  //   order.
  Surrogate plus(std::function<double(const UnitPoint&)> known) const;

  // Standard deviation of an independent error of each value beyond its noise: how rough the
  // values are from one place to the next.
  double roughness() const;

  // Root mean square error of leave-one-out predictions, and the standard deviation of the values:
  // how much of the variation the surrogate explains.
  double leave_one_out_error() const;
  double value_spread() const;

 private:
  struct Fit;
  std::vector<Prediction> predict_own(std::span<const UnitPoint> places) const;
  explicit Surrogate(std::unique_ptr<Fit> fit);
  std::unique_ptr<Fit> fit_;
};

}  // namespace graintruth::calibrate
