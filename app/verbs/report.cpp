// graintruth report: the page of a run, made anew from its folder.
#include "reports/report.h"

#include <fmt/format.h>

#include <optional>

#include "app/run/held_folder.h"
#include "app/run/pdf.h"
#include "app/verbs/commands.h"

namespace graintruth::app {

int run_report(const ReportCommand& command) {
  const datasets::RunFolder folder{command.run_folder};
  std::optional<Hold> hold;  // what is no folder is refused below
  if (std::filesystem::is_directory(folder.root)) hold.emplace(folder.root, "report", false);
  reports::write_report(folder);
  fmt::print("{}\n", folder.report().string());
  if (command.pdf) {
    print_pdf(folder.report(), folder.report_pdf());
    fmt::print("{}\n", folder.report_pdf().string());
  }
  return 0;
}

}  // namespace graintruth::app
