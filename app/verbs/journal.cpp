// graintruth journal: look after the record of simulations of a run.
#include "calibrate/journal.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "app/verbs/commands.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"
#include "datasets/store/table.h"

namespace graintruth::app {

namespace {

using calibrate::Journal;
using calibrate::JournalRow;

// A journal that is there; opening one that is not would make it.
Journal open_journal(const std::filesystem::path& run_folder) {
  const std::filesystem::path file = datasets::RunFolder{run_folder}.journal();
  if (!std::filesystem::is_regular_file(file)) {
    throw datasets::InputError(
        fmt::format("{}: there is no such journal; give the folder of a calibration or validation.",
                    file.string()));
  }
  return Journal(file);
}

// Simulations by problem, stage and status, with the processor time spent on them.
void list(Journal& journal) {
  struct Sum {
    int count = 0;
    double seconds = 0.0;
  };
  std::map<std::tuple<std::string, std::string, std::string>, Sum> sums;
  for (const JournalRow& row : journal.rows()) {
    Sum& sum = sums[{row.problem, row.stage, std::string(name_of(row.run.status))}];
    ++sum.count;
    sum.seconds += row.run.seconds;
  }
  fmt::print("{:<32}  {:<14}  {:<10} {:>11} {:>9}\n",
             "problem",
             "stage",
             "status",
             "simulations",
             "seconds");
  Sum all;
  for (const auto& [key, sum] : sums) {
    const auto& [problem, stage, status] = key;
    fmt::print(
        "{:<32}  {:<14}  {:<10} {:>11} {:>9.1f}\n", problem, stage, status, sum.count, sum.seconds);
    all.count += sum.count;
    all.seconds += sum.seconds;
  }
  fmt::print("{:<32}  {:<14}  {:<10} {:>11} {:>9.1f}\n", "all", "", "", all.count, all.seconds);
}

void show(const std::filesystem::path& run_folder, Journal& journal, std::int64_t id) {
  const std::vector<JournalRow> rows = journal.rows();
  const auto at =
      std::find_if(rows.begin(), rows.end(), [&](const JournalRow& row) { return row.id == id; });
  if (at == rows.end()) {
    throw datasets::InputError(fmt::format(
        "{}: there is no simulation {}; the journal holds {}.",
        datasets::RunFolder{run_folder}.journal().string(),
        id,
        rows.empty()
            ? std::string("none")
            : fmt::format("{} from {} to {}", rows.size(), rows.front().id, rows.back().id)));
  }
  const auto line = [](std::string_view name, const std::string& value) {
    fmt::print("{:<28} {}\n", name, value);
  };
  line("id", std::to_string(at->id));
  line("fingerprint", at->fingerprint);
  line("problem", at->problem);
  line("stage", at->stage);
  for (const auto& [name, value] : at->parameters) line(name, datasets::number_text(value));
  line("time_step_fraction", datasets::number_text(at->time_step_fraction));
  line("time_step_s", datasets::number_text(at->run.time_step));
  line("seed", std::to_string(at->seed));
  line("status", std::string(name_of(at->run.status)));
  if (!at->run.message.empty()) line("message", at->run.message);
  line("objective", datasets::number_text(at->objective));
  line("agreement_percent", datasets::number_text(at->agreement_percent));
  line("seconds", datasets::number_text(at->run.seconds));
}

void export_rows(const JournalCommand& command, Journal& journal) {
  if (command.out == "-") {
    fmt::print("{}", datasets::to_csv(calibrate::journal_table(journal)));
    return;
  }
  const std::filesystem::path file =
      command.out.empty() ? datasets::RunFolder{command.run_folder}.journal_csv() : command.out;
  calibrate::write_journal_csv(file, journal);
  fmt::print("{}\n", file.string());
}

void drop(const JournalCommand& command, Journal& journal) {
  std::vector<std::int64_t> ids;
  const std::vector<JournalRow> rows = journal.rows();
  for (const JournalRow& row : rows) {
    const bool chosen =
        (command.failed && row.run.status != calibrate::RunStatus::completed) ||
        (!command.problem.empty() && row.problem == command.problem) ||
        std::find(command.ids.begin(), command.ids.end(), row.id) != command.ids.end();
    if (chosen) ids.push_back(row.id);
  }
  journal.drop(ids);
  calibrate::write_journal_csv(datasets::RunFolder{command.run_folder}.journal_csv(), journal);
  fmt::print("{} simulations dropped, {} left\n", ids.size(), rows.size() - ids.size());
}

void merge(const JournalCommand& command, Journal& journal) {
  Journal other = open_journal(command.other);
  int added = 0;
  int known = 0;
  for (const JournalRow& row : other.rows()) {
    if (journal.find(row.fingerprint)) {
      ++known;
    } else {
      journal.add(row);
      ++added;
    }
  }
  calibrate::write_journal_csv(datasets::RunFolder{command.run_folder}.journal_csv(), journal);
  fmt::print("{} simulations added, {} were there already\n", added, known);
}

}  // namespace

int run_journal(const JournalCommand& command) {
  Journal journal = open_journal(command.run_folder);
  switch (command.action) {
    case JournalAction::list:
      list(journal);
      break;
    case JournalAction::show:
      show(command.run_folder, journal, command.ids.front());
      break;
    case JournalAction::export_rows:
      export_rows(command, journal);
      break;
    case JournalAction::drop:
      drop(command, journal);
      break;
    case JournalAction::merge:
      merge(command, journal);
      break;
  }
  return 0;
}

}  // namespace graintruth::app
