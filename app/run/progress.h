// One live line on a terminal, plain lines elsewhere: stage, done of total, best so far, time to
// go.
#pragma once

#include <chrono>
#include <mutex>
#include <string>
#include <string_view>

namespace graintruth::app {

class ProgressLine {
 public:
  explicit ProgressLine(bool quiet);
  ~ProgressLine();

  // `share` in 0..1 is how much of the job is done. Any thread may call.
  void show(std::string_view job, double share, std::string_view detail);
  // A line that stays.
  void say(std::string_view line);

 private:
  using Clock = std::chrono::steady_clock;
  void erase();

  std::mutex mutex_;
  bool quiet_;
  bool terminal_;
  bool drawn_ = false;
  std::string job_;
  Clock::time_point job_start_;
  double share_at_start_ = 0.0;  // a job may be shown again, or go on with what it had
  Clock::time_point last_shown_;
};

}  // namespace graintruth::app
