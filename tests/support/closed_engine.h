// A simulator whose every answer is known: tests write it as a function.
#pragma once

#include <functional>

#include "calibrate/engines/engine.h"

namespace graintruth::tests {

class ClosedEngine final : public calibrate::Engine {
 public:
  using Simulate = std::function<calibrate::EngineRun(const calibrate::SimulationSpec& spec)>;
  explicit ClosedEngine(Simulate simulate, std::vector<std::string> curves = {})
      : simulate_(std::move(simulate)), curves_(std::move(curves)) {}

  std::string_view name() const override { return "closed"; }
  std::string version() const override { return "1"; }
  std::vector<std::string> curves(const calibrate::SimulationSpec&) const override {
    return curves_;
  }
  double largest_time_step_fraction(const calibrate::SimulationSpec&) const override {
    return 0.05;
  }
  calibrate::EngineRun run(const calibrate::SimulationSpec& spec,
                           const calibrate::EngineOptions&) const override {
    return simulate_(spec);
  }

 private:
  Simulate simulate_;
  std::vector<std::string> curves_;
};

}  // namespace graintruth::tests
