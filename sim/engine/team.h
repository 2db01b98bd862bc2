// A team of threads that runs short tasks again and again, several thousand times a second.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace graintruth::sim {

class Team {
 public:
  // The caller is one of the workers: with one worker no thread is started.
  explicit Team(int workers);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  int workers() const { return static_cast<int>(threads_.size()) + 1; }

  // Does task(worker, i) for all i in [0, count), each once, by whoever is free; returns when all
  // are done. Waits for nobody who has not begun one: where others keep the processor busy, the
  // caller does alone what its team does not come to. Half the workers begin with the first task
  // and half with the last, so that from round to round a task mostly meets the same worker, and
  // its cache. Tasks must not throw, and must not care who does them; at most 2^20 - 1 at once.
  template <class Task>
  void run(int count, const Task& task) {
    run_any(count, {&task, [](const void* any, int worker, int i) {
                      (*static_cast<const Task*>(any))(worker, i);
                    }});
  }

 private:
  // A task of any type where it stands: a step allocates nothing.
  struct AnyTask {
    const void* task = nullptr;
    void (*call)(const void* task, int worker, int i) = nullptr;
  };
  void run_any(int count, const AnyTask& task);
  void wait_for_work(int worker);
  void work(int worker);

  std::vector<std::thread> threads_;
  AnyTask task_;
  // Round and the tasks left of it in one number, so that a task can only be taken of the round
  // that it belongs to, however late a worker looks.
  std::atomic<std::uint64_t> ticket_{0};
  std::atomic<int> done_{0};  // tasks of this round
  std::atomic<bool> ends_{false};
};

}  // namespace graintruth::sim
