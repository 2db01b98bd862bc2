// An engine for tests that is not ours: a block that slides down a slope of 35 degrees. Its one
// curve is how far it has slid, with a scatter of a hundredth from seed to seed.
//   s = 1/2 g (sin a - mu cos a) t^2
#pragma once

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <numbers>

#include "calibrate/engines/engine.h"

namespace graintruth::tests {

class SlidingBlock final : public calibrate::Engine {
 public:
  static constexpr double slope = 35.0 * std::numbers::pi / 180.0;  // rad
  static constexpr double scatter = 0.01;

  std::string_view name() const override { return "sliding_block"; }
  std::string version() const override { return "1"; }
  std::vector<std::string> curves(const calibrate::SimulationSpec&) const override {
    return {"slid_m"};
  }
  double largest_time_step_fraction(const calibrate::SimulationSpec&) const override { return 1.0; }

  static datasets::Curve slid(double friction, std::uint64_t seed) {
    boost::random::mt19937_64 generator(seed);
    boost::random::normal_distribution<double> normal(1.0, scatter);
    const double pull = 9.81 * std::max(0.0, std::sin(slope) - friction * std::cos(slope));
    const double faster = normal(generator);
    datasets::Curve curve;
    for (int i = 0; i <= 100; ++i) {
      curve.time.push_back(0.01 * i);
      curve.value.push_back(0.5 * pull * faster * curve.time.back() * curve.time.back());
    }
    return curve;
  }

  calibrate::EngineRun run(const calibrate::SimulationSpec& spec,
                           const calibrate::EngineOptions&) const override {
    calibrate::EngineRun run{.time_step = 0.01 * spec.time_step_fraction};
    run.recording.curves["slid_m"] = slid(spec.parameters.of("friction_particle_wall"), spec.seed);
    return run;
  }
};

inline const calibrate::Engine& sliding_block() {
  static const SlidingBlock engine;
  return engine;
}

}  // namespace graintruth::tests
