// On threads of this machine.
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>

#include "calibrate/executors/executor.h"

namespace graintruth::calibrate {

void parallel_for(int count, int jobs, const std::function<void(int)>& task) {
  std::atomic<int> next = 0;
  std::exception_ptr failure;
  std::mutex mutex;
  const auto work = [&] {
    for (int i = next++; i < count; i = next++) {
      try {
        task(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
  };
  std::vector<std::jthread> threads;
  // Fewer do the same work where the system allows no more threads
  try {
    for (int thread = 1; thread < std::min(jobs, count); ++thread) threads.emplace_back(work);
  } catch (const std::system_error&) {
  }
  work();
  threads.clear();
  if (failure) std::rethrow_exception(failure);
}

namespace {

class Threads final : public Executor {
 public:
  explicit Threads(int jobs) : jobs_(jobs) {}

  void run(std::span<const SimulationTask> tasks,
           const EngineOptions& options,
           const Done& done) override {
    parallel_for(static_cast<int>(tasks.size()), jobs_, [&](int i) {
      const auto place = static_cast<std::size_t>(i);
      done(place, run_with_retry(*tasks[place].engine, tasks[place].spec, options));
    });
  }

 private:
  int jobs_;
};

}  // namespace

extern constinit const ExecutorKind threads_executor{
    .name = "threads", .make = [](const ExecutorSetup& setup) -> std::unique_ptr<Executor> {
      return std::make_unique<Threads>(setup.jobs);
    }};

}  // namespace graintruth::calibrate
