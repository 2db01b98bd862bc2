// graintruth reproduce: the thesis, number by number: printed, recomputed from its printed data,
// simulated again, and a verdict.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "app/run/data_folder.h"
#include "app/run/held_folder.h"
#include "app/run/interrupt.h"
#include "app/run/run_record.h"
#include "app/thesis/results.h"
#include "app/thesis/targets.h"
#include "app/verbs/commands.h"
#include "datasets/store/fingerprint.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"
#include "reports/report.h"

namespace graintruth::app {

namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

struct Group {
  const char* name;
  const char* what;
};
constexpr Group printed_group{"printed", "all tables, from their printed data alone"};
constexpr Group quick_group{"all-quick", "the same, and what is simulated in minutes (default)"};
constexpr Group whole_group{"all", "everything"};

struct Choice {
  std::vector<const Target*> targets;  // in the thesis's order
  bool simulates = true;
};

void list_targets() {
  for (const Target& target : all_targets()) fmt::print("{:13} {}\n", target.name, target.what);
  for (const Group& group : {printed_group, quick_group, whole_group})
    fmt::print("{:13} {}\n", group.name, group.what);
}

Choice chosen_targets(const std::vector<std::string>& names) {
  const auto targets = all_targets();
  for (const std::string& name : names) {
    const bool is_known =
        name == printed_group.name || name == quick_group.name || name == whole_group.name ||
        std::any_of(
            targets.begin(), targets.end(), [&](const Target& t) { return t.name == name; });
    if (!is_known) {
      throw datasets::InputError(
          fmt::format("There is no target '{}'; 'graintruth reproduce --list' names them.", name));
    }
  }
  const auto asked = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  Choice choice;
  const bool whole = asked(whole_group.name);
  const bool quick = names.empty() || asked(quick_group.name);
  const bool printed = asked(printed_group.name);
  choice.simulates = !(printed && names.size() == 1);
  for (const Target& target : targets) {
    if (whole || (quick && target.is_quick) || (printed && target.from_printed != nullptr) ||
        asked(target.name))
      choice.targets.push_back(&target);
  }
  return choice;
}

TargetResult examine(const Target& target,
                     const ThesisData& thesis,
                     Studies& studies,
                     bool simulates) {
  Examination exam(target.name, target.what, thesis);
  try {
    if (target.from_printed != nullptr) target.from_printed(exam, thesis);
    if (simulates && target.simulated != nullptr) target.simulated(exam, thesis, studies);
  } catch (const std::invalid_argument& error) {
    // What the simulator says of a scene made from changed data
    throw datasets::InputError(
        fmt::format("{}: cannot be made from datasets/thesis: {}", target.name, error.what()));
  }
  return exam.finish();
}

Json run_record(const ReproduceCommand& command,
                const std::filesystem::path& data,
                const std::string& started_at,
                double seconds) {
  Json hashes = Json::object();
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(data)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) hashes[file.filename().string()] = datasets::file_hash(file);
  return {{"version", GRAINTRUTH_VERSION},
          {"verb", "reproduce"},
          {"command", command.common.command_line},
          {"started_at", started_at},
          {"seed", command.common.seed},
          {"targets", command.targets},
          {"input_hashes", hashes},
          {"stages", Json::array({{{"name", "reproducing"}, {"seconds", seconds}}})}};
}

}  // namespace

int run_reproduce(const ReproduceCommand& command) {
  if (command.list) {
    list_targets();
    return 0;
  }
  // 1. What is asked, and where it goes
  const Choice choice = chosen_targets(command.targets);
  const Clock::time_point start = Clock::now();
  const std::string started_at = utc_now();
  const std::filesystem::path data = data_folder() / "thesis";
  const ThesisData thesis(data);
  const std::vector<Erratum> errata = thesis.errata();
  const std::filesystem::path root =
      command.common.out.empty() ? std::filesystem::path("out") / "reproduce" : command.common.out;
  const HeldFolder held(root, "reproduce", command.common.quiet);
  const datasets::RunFolder& folder = held.folder();
  catch_interrupts();

  // 2. Target by target
  const int jobs = threads_of(command.common);
  ProgressLine progress(command.common.quiet);
  Studies studies(folder.root, command.common.seed, jobs, progress);
  std::vector<TargetResult> results;
  for (const Target* target : choice.targets) {
    progress.show("reproduce",
                  static_cast<double>(results.size()) / static_cast<double>(choice.targets.size()),
                  target->name);
    results.push_back(examine(*target, thesis, studies, choice.simulates));
  }

  // 3. What it leaves
  for (const TargetResult& result : results) write_target_table(folder, result);
  const Json result = reproduction_result(results, errata);
  datasets::write_whole(folder.result(), result.dump(2) + "\n");
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  datasets::write_whole(folder.run(),
                        run_record(command, data, started_at, seconds).dump(2) + "\n");
  reports::write_report(folder);

  // 4. What to tell
  if (command.common.json) {
    fmt::print("{}\n", result.dump(2));
  } else {
    for (const TargetResult& one : results) fmt::print("{}", target_text(one));
    fmt::print("{}\n", folder.report().string());
  }
  return std::any_of(results.begin(), results.end(), has_failed) ? 1 : 0;
}

}  // namespace graintruth::app
