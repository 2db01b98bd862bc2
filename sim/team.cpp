#include "sim/team.h"

namespace graintruth::sim {
namespace {

// A task comes within microseconds while a simulation runs, so a worker looks for it a while before
// it lets others have the processor.
constexpr int kLooksBeforeYield = 2000;

template <class Condition>
void wait_until(const Condition& holds) {
  for (int looks = 0; !holds(); ++looks) {
    if (looks >= kLooksBeforeYield) std::this_thread::yield();
  }
}

}  // namespace

Team::Team(int workers) {
  for (int worker = 1; worker < workers; ++worker) {
    threads_.emplace_back([this, worker] { wait_for_work(worker); });
  }
}

Team::~Team() {
  ends_ = true;
  round_.fetch_add(1);
  round_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void Team::run(int count, const std::function<void(int, int)>& task) {
  task_ = &task;
  count_ = count;
  next_.store(0, std::memory_order_relaxed);
  busy_.store(static_cast<int>(threads_.size()), std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  if (!threads_.empty()) round_.notify_all();
  work(0);
  wait_until([this] { return busy_.load(std::memory_order_acquire) == 0; });
}

void Team::work(int worker) {
  for (int i = next_.fetch_add(1); i < count_; i = next_.fetch_add(1)) (*task_)(worker, i);
}

// Between runs nobody steps: after a while the thread sleeps.
void Team::wait_for_work(int worker) {
  constexpr int kYieldsBeforeSleep = 2000;
  for (unsigned seen = 0;;) {
    for (int yields = 0; round_.load(std::memory_order_acquire) == seen; ++yields) {
      if (yields > kLooksBeforeYield) std::this_thread::yield();
      if (yields > kLooksBeforeYield + kYieldsBeforeSleep) round_.wait(seen);
    }
    ++seen;
    if (ends_) return;
    work(worker);
    busy_.fetch_sub(1, std::memory_order_release);
  }
}

}  // namespace graintruth::sim
