// graintruth report: the page of a run, made anew from its folder.
#include "reports/report.h"

#include <fmt/format.h>

#include "app/run/pdf.h"
#include "app/verbs/commands.h"

namespace graintruth::app {

int run_report(const ReportCommand& command) {
  const datasets::RunFolder folder{command.run_folder};
  reports::write_report(folder);
  fmt::print("{}\n", folder.report().string());
  if (command.pdf) {
    print_pdf(folder.report(), folder.report_pdf());
    fmt::print("{}\n", folder.report_pdf().string());
  }
  return 0;
}

}  // namespace graintruth::app
