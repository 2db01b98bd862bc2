// Every executor, one line each; each is defined in a file of this folder.
#pragma once

#include "calibrate/executors/executor.h"

namespace graintruth::calibrate {

extern const ExecutorKind threads_executor;

}  // namespace graintruth::calibrate
