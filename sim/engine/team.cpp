#include "sim/engine/team.h"

#include <cassert>
#include <system_error>

namespace graintruth::sim {
namespace {

// A task comes within microseconds while a simulation runs, so a worker looks for it a while before
// it lets others have the processor.
constexpr int kLooksBeforeYield = 2000;

// A ticket holds, from its highest bit: round (24 bits), end of the tasks left (20), the first of
// them (20).
constexpr int kBits = 20;
constexpr std::uint64_t kLargest = (std::uint64_t{1} << kBits) - 1;

std::uint64_t first_of(std::uint64_t ticket) { return ticket & kLargest; }
std::uint64_t end_of(std::uint64_t ticket) { return (ticket >> kBits) & kLargest; }
std::uint64_t round_of(std::uint64_t ticket) { return ticket >> (2 * kBits); }

bool has_task(std::uint64_t ticket) { return first_of(ticket) < end_of(ticket); }

std::uint64_t tickets_of_next_round(std::uint64_t ticket, int count) {
  return (round_of(ticket) + 1) << (2 * kBits) | static_cast<std::uint64_t>(count) << kBits;
}

}  // namespace

Team::Team(int workers) {
  // Fewer do the same work where the system allows no more threads
  try {
    for (int worker = 1; worker < workers; ++worker)
      threads_.emplace_back([this, worker] { wait_for_work(worker); });
  } catch (const std::system_error&) {
  }
}

Team::~Team() {
  ends_ = true;
  ticket_.store(tickets_of_next_round(ticket_, 0));
  ticket_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void Team::run_any(int count, const AnyTask& task) {
  assert(count >= 0 && static_cast<std::uint64_t>(count) <= kLargest);
  task_ = task;
  done_.store(0, std::memory_order_relaxed);
  ticket_.store(tickets_of_next_round(ticket_.load(std::memory_order_relaxed), count),
                std::memory_order_release);
  if (!threads_.empty()) ticket_.notify_all();
  work(0);
  for (int looks = 0; done_.load(std::memory_order_acquire) < count; ++looks) {
    if (looks >= kLooksBeforeYield) std::this_thread::yield();
  }
}

void Team::work(int worker) {
  std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
  const bool from_the_end = worker % 2 == 1;
  while (has_task(ticket)) {
    const std::uint64_t left = from_the_end ? ticket - (std::uint64_t{1} << kBits) : ticket + 1;
    if (!ticket_.compare_exchange_weak(ticket, left, std::memory_order_acq_rel)) continue;
    // Taken: the round lasts until this task is done, and so does task_
    const std::uint64_t taken = from_the_end ? end_of(left) : first_of(ticket);
    task_.call(task_.task, worker, static_cast<int>(taken));
    done_.fetch_add(1, std::memory_order_release);
    ticket = ticket_.load(std::memory_order_acquire);
  }
}

// Between runs nobody steps: after a while the thread sleeps.
void Team::wait_for_work(int worker) {
  constexpr int kYieldsBeforeSleep = 2000;
  while (!ends_) {
    std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
    for (int looks = 0; !has_task(ticket) && !ends_; ++looks) {
      if (looks > kLooksBeforeYield) std::this_thread::yield();
      if (looks > kLooksBeforeYield + kYieldsBeforeSleep) ticket_.wait(ticket);
      ticket = ticket_.load(std::memory_order_acquire);
    }
    work(worker);
  }
}

}  // namespace graintruth::sim
