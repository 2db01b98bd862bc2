#include "app/verbs/commands.h"

#include <algorithm>
#include <thread>

namespace graintruth::app {

int threads_of(const CommonOptions& options) {
  if (options.jobs > 0) return options.jobs;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace graintruth::app
