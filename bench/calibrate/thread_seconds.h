// Processor time of one thread, for studies that run several at once.
#pragma once

#include <ctime>

namespace graintruth::bench {

// s, of the calling thread.
inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1.0e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace graintruth::bench
