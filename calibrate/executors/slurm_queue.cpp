#include "calibrate/executors/slurm_queue.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "datasets/store/external_program.h"
#include "datasets/store/input_error.h"

namespace graintruth::calibrate {

namespace {

constexpr double command_limit = 100.0;  // s; Slurm's own commands give up after 10 to 60

bool contains_any(const std::string& text, std::initializer_list<std::string_view> words) {
  return std::any_of(words.begin(), words.end(), [&](std::string_view word) {
    return text.find(word) != std::string::npos;
  });
}

std::string one_line(std::string text) {
  for (char& letter : text) letter = letter == '\n' ? ' ' : letter;
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

// What passes by itself: the controller is away or busy, or the user has too many jobs for now.
bool may_pass(const std::string& complaint) {
  return contains_any(complaint,
                      {"emporar",
                       "nable to contact",
                       "timed out",
                       "Connection refused",
                       "ransport",
                       "Zero Bytes",
                       "ommunication",
                       "SubmitLimit",
                       "SubmitJobs",
                       "job submit limit",
                       "did not end in time",
                       "MaxJobCount",
                       "try again"});
}

// Why a job that waits will not begin: somebody held it, or nothing fits it.
bool is_stuck(const std::string& state, const std::string& reason) {
  return state == "RH" || state == "SE" || state == "SO" ||
         contains_any(reason,
                      {"Held",
                       "held",
                       "JobHold",
                       "DRAINED",
                       "PartitionDown",
                       "PartitionInactive",
                       "PartitionNodeLimit",
                       "PartitionTimeLimit",
                       "BadConstraints",
                       "InvalidAccount",
                       "InvalidQOS",
                       "ReqNodeNotAvail",
                       "NodeDown"});
}

std::string minutes_and_seconds(double seconds) {
  const auto whole = static_cast<long>(std::ceil(seconds));
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

double seconds_of(const std::string& slurm_time) {
  double days = 0.0, seconds = 0.0;
  std::string rest = slurm_time;
  try {
    if (const auto dash = rest.find('-'); dash != std::string::npos) {
      days = std::stod(rest.substr(0, dash));
      rest = rest.substr(dash + 1);
    }
    std::istringstream parts(rest);
    for (std::string part; std::getline(parts, part, ':');)
      seconds = 60.0 * seconds + std::stod(part);
  } catch (const std::exception&) {
    return 0.0;  // INVALID, where clocks differ
  }
  return 86400.0 * days + seconds;
}

std::vector<QueuedTask> read_queue(const std::string& printed) {
  std::vector<QueuedTask> tasks;
  std::istringstream lines(printed);
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> cells;
    std::istringstream rest(line);
    for (std::string cell; std::getline(rest, cell, '|');) cells.push_back(cell);
    if (cells.size() < 6 || cells[2].empty() ||
        cells[2].find_first_not_of("0123456789") != std::string::npos)
      continue;
    const std::string& state = cells[3];
    QueuedTask task{
        .array = cells[0], .id = cells[1] + "_" + cells[2], .index = std::stoi(cells[2])};
    task.runs = state == "R" || state == "CG";
    task.reason = cells[4];
    task.is_stuck = !task.runs && is_stuck(state, task.reason);
    task.elapsed = task.runs ? seconds_of(cells[5]) : 0.0;
    tasks.push_back(std::move(task));
  }
  return tasks;
}

SlurmQueue::SlurmQueue(datasets::Execution execution, Say say)
    : execution_(std::move(execution)), say_(std::move(say)) {
  if (!say_) say_ = [](const std::string&) {};
}

void SlurmQueue::require_commands() const {
  for (const char* command : {"sbatch", "squeue", "scancel"}) {
    if (datasets::find_program(command)) continue;
    throw datasets::InputError(fmt::format(
        "the executor 'slurm' needs Slurm's command {}, which PATH does not find; run this on a "
        "machine that may submit jobs, or use --executor threads.",
        command));
  }
}

SlurmQueue::Answer SlurmQueue::ask(const std::vector<std::string>& words) {
  const datasets::ExternalEnd end =
      datasets::run_external({.words = words, .time_limit = command_limit});
  if (end.succeeded()) {
    if (silent_ == words.front()) {
      say_(fmt::format("Slurm: {} answers again", silent_));
      silent_.clear();
    }
    return {.came = true, .out = end.out};
  }
  return {.trouble = end.err.empty() ? end.words() : one_line(end.err)};
}

bool SlurmQueue::submit(const std::string& array,
                        std::size_t tasks,
                        const std::filesystem::path& script,
                        const std::string& log_pattern,
                        const std::vector<std::string>& excluded_nodes) {
  std::vector<std::string> words = {"sbatch",
                                    "--parsable",
                                    "--requeue",
                                    "--open-mode=append",
                                    "--job-name=" + array,
                                    fmt::format("--array=0-{}", tasks - 1),
                                    "--output=" + log_pattern,
                                    fmt::format("--cpus-per-task={}", execution_.cpus)};
  if (!execution_.partition.empty()) words.push_back("--partition=" + execution_.partition);
  if (!execution_.account.empty()) words.push_back("--account=" + execution_.account);
  if (execution_.time_limit > 0.0)
    words.push_back("--time=" + minutes_and_seconds(execution_.time_limit));
  if (!excluded_nodes.empty())
    words.push_back(fmt::format("--exclude={}", fmt::join(excluded_nodes, ",")));
  words.insert(words.end(), execution_.options.begin(), execution_.options.end());
  words.push_back(script.string());
  const Answer answer = ask(words);
  if (answer.came) {
    last_complaint_.clear();
    std::string id = one_line(answer.out);
    say_(fmt::format("Slurm: {} {} in job {}", tasks, tasks == 1 ? "task" : "tasks", id));
    return true;
  }
  // The same complaint again, with the controller there to answer, is its last word
  if (!may_pass(answer.trouble) && answer.trouble == last_complaint_) {
    throw datasets::InputError(
        fmt::format("Slurm does not take the job: '{}'{}; see [execution] of the experiment file.",
                    answer.trouble,
                    excluded_nodes.empty()
                        ? std::string()
                        : fmt::format(" (without {}, which give other bits than this machine)",
                                      fmt::join(excluded_nodes, ", "))));
  }
  if (silent_ != "sbatch") {
    silent_ = "sbatch";
    say_(fmt::format("Slurm: sbatch does not take the job now ({}); waiting", answer.trouble));
  }
  last_complaint_ = answer.trouble;
  return false;
}

std::optional<std::vector<QueuedTask>> SlurmQueue::look(const std::vector<std::string>& arrays) {
  const Answer answer = ask({"squeue",
                             "--noheader",
                             "--array",
                             fmt::format("--name={}", fmt::join(arrays, ",")),
                             "--format=%j|%F|%K|%t|%r|%M"});
  if (answer.came) return read_queue(answer.out);
  if (silent_ != "squeue") {
    silent_ = "squeue";
    say_(fmt::format("Slurm: squeue does not answer ({}); waiting", answer.trouble));
  }
  return std::nullopt;
}

void SlurmQueue::cancel_task(const std::string& id) { ask({"scancel", id}); }

void SlurmQueue::cancel_array(const std::string& array) { ask({"scancel", "--name=" + array}); }

}  // namespace graintruth::calibrate
