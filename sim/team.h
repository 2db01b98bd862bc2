// A team of threads that runs short tasks again and again, several thousand times a second.
#pragma once

#include <atomic>
#include <functional>
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
  // are done. Tasks must not throw, and must not care who does them.
  void run(int count, const std::function<void(int worker, int i)>& task);

 private:
  void wait_for_work(int worker);
  void work(int worker);

  std::vector<std::thread> threads_;
  const std::function<void(int, int)>* task_ = nullptr;
  int count_ = 0;
  std::atomic<int> next_{0};
  std::atomic<int> busy_{0};
  std::atomic<unsigned> round_{0};
  std::atomic<bool> ends_{false};
};

}  // namespace graintruth::sim
