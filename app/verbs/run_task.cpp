// graintruth run-task: one task of a batch system, on the node that runs it.
#include "calibrate/executors/run_task.h"

#include <fmt/format.h>

#include "app/run/interrupt.h"
#include "app/verbs/commands.h"

namespace graintruth::app {

int run_run_task(const RunTaskCommand& command) {
  catch_interrupts();
  const std::vector<std::string> complaints =
      calibrate::run_task(command.folder,
                          command.index,
                          {.program_version = GRAINTRUTH_VERSION, .stop = is_interrupted});
  for (const std::string& complaint : complaints) fmt::print(stderr, "{}.\n", complaint);
  return complaints.empty() ? 0 : 1;
}

}  // namespace graintruth::app
