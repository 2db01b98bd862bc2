// graintruth journal: look after the record of simulations of a run.
#include "calibrate/journal.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <tuple>

#include "app/run/held_folder.h"
#include "app/verbs/commands.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"
#include "datasets/store/table.h"

namespace graintruth::app {

namespace {

using calibrate::Journal;
using calibrate::JournalRow;

// The file of a journal that is there; opening one that is not would make it.
std::filesystem::path journal_of(const std::filesystem::path& run_folder) {
  std::filesystem::path file = datasets::RunFolder{run_folder}.journal();
  if (!std::filesystem::is_regular_file(file)) {
    throw datasets::InputError(
        fmt::format("{}: there is no such journal; give the folder of a calibration or validation.",
                    file.string()));
  }
  return file;
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

std::vector<std::int64_t> chosen_rows(const JournalCommand& command, Journal& journal) {
  if (command.damaged) return journal.damaged();
  if (command.failed) return journal.failed();
  if (!command.problem.empty()) return journal.of_problem(command.problem);
  std::vector<std::int64_t> chosen;
  for (const std::int64_t id : journal.all()) {
    if (std::find(command.ids.begin(), command.ids.end(), id) != command.ids.end())
      chosen.push_back(id);
  }
  return chosen;
}

// Rows that are damaged can be dropped as all others.
void drop(const JournalCommand& command, Journal& journal) {
  const std::vector<std::int64_t> chosen = chosen_rows(command, journal);
  journal.drop(chosen);
  fmt::print("{} simulations dropped, {} left\n", chosen.size(), journal.all().size());
  if (const std::size_t damaged = journal.damaged().size(); damaged > 0) {
    fmt::print(
        "{} damaged rows are left, so that journal.csv is not renewed; drop them with "
        "--damaged\n",
        damaged);
    return;
  }
  calibrate::write_journal_csv(datasets::RunFolder{command.run_folder}.journal_csv(), journal);
}

// Nothing is added where anything is refused.
void merge(const JournalCommand& command, Journal& journal) {
  Journal other(journal_of(command.other), Journal::Use::reading);
  journal.require_sound();
  other.require_sound();
  std::vector<JournalRow> added;
  int known = 0;
  for (JournalRow& row : other.rows()) {
    const auto here = journal.row_of(row.fingerprint);
    const auto timed_out = calibrate::RunStatus::timed_out;
    if (!here || (here->run.status == timed_out && row.run.status != timed_out)) {
      added.push_back(std::move(row));
      continue;
    }
    ++known;
    if (row.run.status == timed_out || is_same_result(*here, row)) continue;
    throw datasets::InputError(fmt::format(
        "{}: row {} and row {} of {} are of the same simulation and have different results; find "
        "out which machine errs, and drop its row with 'graintruth journal drop RUN_DIR --id ID'.",
        datasets::RunFolder{command.other}.journal().string(),
        row.id,
        here->id,
        datasets::RunFolder{command.run_folder}.journal().string()));
  }
  journal.belong_to(other.parts());
  for (const JournalRow& row : added) journal.add(row);
  calibrate::write_journal_csv(datasets::RunFolder{command.run_folder}.journal_csv(), journal);
  fmt::print("{} simulations added, {} were there already\n", added.size(), known);
}

}  // namespace

int run_journal(const JournalCommand& command) {
  const std::filesystem::path file = journal_of(command.run_folder);
  // Whoever writes into the folder has it for himself
  std::optional<Hold> hold;
  const bool changes =
      command.action == JournalAction::drop || command.action == JournalAction::merge;
  if (changes || (command.action == JournalAction::export_rows && command.out.empty()))
    hold.emplace(command.run_folder, "journal", false);
  Journal journal(file, changes ? Journal::Use::writing : Journal::Use::reading);
  for (const std::string& sentence : journal.notices()) fmt::print(stderr, "Note: {}\n", sentence);
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
