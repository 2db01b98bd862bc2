// An executor for tests that is not ours: one task after the other, the last one first.
#pragma once

#include <cassert>
#include <memory>

#include "calibrate/executors/executor.h"

namespace graintruth::tests {

class Backwards final : public calibrate::Executor {
 public:
  void run(std::span<const calibrate::SimulationTask> tasks,
           const calibrate::EngineOptions& options,
           const Done& done) override {
    for (std::size_t i = tasks.size(); i-- > 0;)
      done(i, calibrate::run_with_retry(*tasks[i].engine, tasks[i].spec, options));
  }
};

inline constexpr calibrate::ExecutorKind backwards{
    .name = "backwards",
    .make = [](const calibrate::ExecutorSetup&) -> std::unique_ptr<calibrate::Executor> {
      return std::make_unique<Backwards>();
    }};

}  // namespace graintruth::tests
