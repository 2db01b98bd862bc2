#include "app/run/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>

namespace graintruth::app {

namespace {

// Often enough to look alive, seldom enough to cost nothing and to keep logs short.
constexpr auto terminal_interval = std::chrono::milliseconds(100);
constexpr auto log_interval = std::chrono::seconds(15);

std::string duration_text(double seconds) {
  if (seconds < 60.0) return fmt::format("{:.0f} s", seconds);
  return fmt::format("{:.0f} min {:02.0f} s", std::floor(seconds / 60.0), std::fmod(seconds, 60.0));
}

}  // namespace

ProgressLine::ProgressLine(bool quiet) : quiet_(quiet), terminal_(::isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() { erase(); }

void ProgressLine::erase() {
  if (drawn_) std::fputs("\r\033[K", stderr);
  drawn_ = false;
}

void ProgressLine::show(std::string_view job, double share, std::string_view detail) {
  const std::lock_guard lock(mutex_);
  if (quiet_) return;
  const auto now = Clock::now();
  const bool new_job = job != job_;
  if (new_job) {
    job_ = job;
    job_start_ = now;
    share_at_start_ = share;
  }
  const auto interval =
      terminal_ ? Clock::duration(terminal_interval) : Clock::duration(log_interval);
  if (!new_job && now - last_shown_ < interval) return;
  last_shown_ = now;
  const double elapsed = std::chrono::duration<double>(now - job_start_).count();
  const std::string to_go =
      share - share_at_start_ > 0.02 && elapsed > 1.0
          ? fmt::format(", {} to go",
                        duration_text(elapsed * (1.0 - share) / (share - share_at_start_)))
          : "";
  const std::string line = fmt::format(
      "{}: {:.0f} %{}{}{}", job, 100.0 * share, detail.empty() ? "" : ", ", detail, to_go);
  erase();
  std::fputs(line.c_str(), stderr);
  if (!terminal_) std::fputc('\n', stderr);
  drawn_ = terminal_;
  std::fflush(stderr);
}

void ProgressLine::say(std::string_view line) {
  const std::lock_guard lock(mutex_);
  if (quiet_) return;
  erase();
  fmt::print(stderr, "{}\n", line);
}

}  // namespace graintruth::app
