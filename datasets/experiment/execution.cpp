#include "datasets/experiment/execution.h"

#include "datasets/store/toml_section.h"

namespace graintruth::datasets {

Execution read_execution(TomlSection& section, const std::filesystem::path& folder) {
  Execution execution;
  execution.executor = section.optional_text("executor").value_or(execution.executor);
  if (const auto given = section.optional_text("folder")) execution.folder = folder / *given;
  execution.partition = section.optional_text("partition").value_or("");
  execution.account = section.optional_text("account").value_or("");
  execution.time_limit =
      section.optional_quantity("time_limit", time_limit_units, positive).value_or(0.0);
  execution.cpus = section.optional_whole_number("cpus", 1, 1024).value_or(execution.cpus);
  execution.options = section.optional_texts("options").value_or(execution.options);
  execution.set_up = section.optional_texts("set_up").value_or(execution.set_up);
  execution.task_seconds =
      section.optional_quantity("task_seconds", plain, positive).value_or(execution.task_seconds);
  execution.grace_seconds =
      section.optional_quantity("grace_seconds", plain, positive).value_or(execution.grace_seconds);
  section.finish();
  return execution;
}

}  // namespace graintruth::datasets
