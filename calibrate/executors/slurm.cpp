// On a cluster with Slurm: job arrays, whose tasks leave a file for every simulation. The file is
// the truth; the queue only says whether to wait for it. The driver alone writes the journal, finds
// its arrays again by their names, and may be killed at any time.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <thread>

#include "calibrate/executors/canary.h"
#include "calibrate/executors/executor.h"
#include "calibrate/executors/slurm_queue.h"
#include "calibrate/executors/task_folder.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"

namespace graintruth::calibrate {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr int most_tries = 3;
constexpr std::size_t largest_array = 1000;  // Slurm's own limit is 1001 where nobody changed it
constexpr std::size_t first_tasks = 16;      // as long as nobody knows how long a simulation takes
constexpr double straggling = 4.0;           // times the median of those that have ended

// Of the grace period: how often the folder and the queue are looked at, and at most.
constexpr double look_share = 0.02, longest_look = 1.0;    // s
constexpr double queue_share = 0.1, longest_queue = 10.0;  // s

std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

// What one machine learns of the cluster while it drives it.
struct Experience {
  double seconds = 0.0;  // of all simulations that came back
  std::size_t simulations = 0;
  std::set<std::string> refused_nodes;
};

struct Wanted {
  std::vector<std::size_t> places;  // among the tasks that were asked for
  bool is_done = false;
  int tries = 0;
  std::string trouble;  // of the last try
};

struct ArrayTask {
  Clock::time_point last_sign;  // in the queue, or since we know of it
  std::optional<QueuedTask> queued;
  bool is_lost = false;
  bool has_duplicate = false;
  bool is_cancelled = false;
  double seconds = 0.0;                         // that it took; 0 where it has not ended
  std::optional<Clock::time_point> idle_since;  // with nothing of it left to do, as far as we know
};

struct Array {
  std::string name;
  TaskManifest manifest;
  bool is_submitted = false;
  std::vector<ArrayTask> tasks;
};

// One call of Executor::run.
class Batch {
 public:
  Batch(const ExecutorSetup& setup,
        SlurmQueue& queue,
        Experience& experience,
        const std::string& canary_bits,
        std::span<const SimulationTask> tasks,
        const EngineOptions& options,
        const Executor::Done& done)
      : setup_(setup),
        folder_{setup.folder},
        queue_(queue),
        experience_(experience),
        canary_bits_(canary_bits),
        tasks_(tasks),
        options_(options),
        done_(done),
        grace_(setup.execution.grace_seconds) {
    for (std::size_t place = 0; place < tasks.size(); ++place) {
      const std::string key = fingerprint_of(tasks[place].spec);
      if (wanted_[key].places.empty()) order_.push_back(key);
      wanted_[key].places.push_back(place);
    }
  }

  void run() {
    make_task_folder(folder_);
    refuse_conflicts();
    adopt();
    const Seconds look(std::min(longest_look, look_share * grace_));
    const Seconds between(std::min(longest_queue, queue_share * grace_));
    for (Clock::time_point next = Clock::now();;) {
      collect();
      if (left() == 0) break;
      if (options_.stop && options_.stop()) {
        say("Slurm: the tasks stay in the queue; the same command takes up what they do");
        throw Interrupted();
      }
      if (Clock::now() >= next) {
        look_at_queue();
        look_at_refusals();
        give_up_what_is_lost();
        duplicate_stragglers();
        submit();
        next = Clock::now() + std::chrono::duration_cast<Clock::duration>(between);
      }
      refuse_what_nobody_can_run();
      std::this_thread::sleep_for(look);
    }
    tidy();
    refuse_conflicts();
  }

 private:
  void say(const std::string& sentence) const {
    if (setup_.say) setup_.say(sentence);
  }

  std::size_t left() const {
    return static_cast<std::size_t>(std::count_if(
        wanted_.begin(), wanted_.end(), [](const auto& one) { return !one.second.is_done; }));
  }

  bool is_left(const std::string& key) const {
    const auto found = wanted_.find(key);
    return found != wanted_.end() && !found->second.is_done;
  }

  bool has_left(const std::vector<std::string>& keys) const {
    return std::any_of(keys.begin(), keys.end(), [&](const auto& key) { return is_left(key); });
  }

  // --- What an earlier driver left

  void adopt() {
    for (const std::string& name : files_of(folder_.root)) {
      if (!name.starts_with("graintruth-")) continue;
      std::optional<TaskManifest> manifest;
      try {
        manifest = read_manifest(folder_.manifest(name));
      } catch (const datasets::InputError&) {  // it was killed before it could write it
      }
      const bool is_wanted = manifest && manifest->program_version == setup_.program_version &&
                             manifest->canary_bits == canary_bits_ &&
                             std::any_of(manifest->tasks.begin(),
                                         manifest->tasks.end(),
                                         [&](const auto& keys) { return has_left(keys); });
      if (!is_wanted) {
        queue_.cancel_array(name);
        remove_array(name, manifest);
        continue;
      }
      for (const auto& keys : manifest->tasks) {
        for (const std::string& key : keys) {
          if (is_left(key)) wanted_[key].tries = 1;
        }
      }
      say(fmt::format("Slurm: takes up array {}, which an earlier run began", name));
      add_array(*std::move(manifest), true);
    }
  }

  Array& add_array(TaskManifest manifest, bool is_submitted) {
    Array array{.name = name_of(manifest), .manifest = std::move(manifest)};
    array.is_submitted = is_submitted;
    array.tasks.resize(array.manifest.tasks.size());
    for (ArrayTask& task : array.tasks) task.last_sign = Clock::now();
    return arrays_.emplace_back(std::move(array));
  }

  void remove_array(const std::string& name, const std::optional<TaskManifest>& manifest) const {
    std::error_code ignored;
    if (manifest) {
      for (const auto& keys : manifest->tasks) {
        for (const std::string& key : keys) {
          if (is_left(key)) continue;
          fs::remove(folder_.done(key), ignored);
          fs::remove(folder_.spec(key), ignored);
        }
      }
    }
    fs::remove_all(folder_.array(name), ignored);
  }

  // --- Results

  void collect() {
    for (const std::string& key : files_of(folder_.root / "done")) {
      if (!is_left(key)) continue;
      Wanted& wanted = wanted_[key];
      std::string complaint;
      std::optional<TaskResult> result = read_result(folder_.done(key), key, complaint);
      if (!result) {
        say(fmt::format(
            "Slurm: the result {} is thrown away: {}", folder_.done(key).string(), complaint));
        std::error_code ignored;
        fs::rename(folder_.done(key), folder_.root / "damaged" / key, ignored);
        if (ignored) fs::remove(folder_.done(key), ignored);
        wanted.trouble = "its result was damaged: " + complaint;
        lost_keys_.insert(key);  // its task is over and done with
        continue;
      }
      experience_.seconds += result->run.seconds;
      ++experience_.simulations;
      note_time(key, result->task_seconds);
      for (const std::size_t place : wanted.places) done_(place, result->run);
      wanted.is_done = true;
    }
  }

  void note_time(const std::string& key, double seconds) {
    for (Array& array : arrays_) {
      for (std::size_t i = 0; i < array.tasks.size(); ++i) {
        const auto& keys = array.manifest.tasks[i];
        if (std::find(keys.begin(), keys.end(), key) != keys.end())
          array.tasks[i].seconds = std::max(array.tasks[i].seconds, seconds);
      }
    }
  }

  // --- The queue

  void look_at_queue() {
    std::vector<std::string> names;
    for (const Array& array : arrays_) names.push_back(array.name);
    if (names.empty()) {
      queue_answers_ = true;
      return;
    }
    const auto queued = queue_.look(names);
    queue_answers_ = queued.has_value();
    const auto now = Clock::now();
    for (Array& array : arrays_) {
      for (ArrayTask& task : array.tasks) {
        if (!queued) task.last_sign = now;  // nobody knows; no time runs against it
        task.queued.reset();
      }
    }
    if (!queued) return;
    for (const QueuedTask& one : *queued) {
      for (Array& array : arrays_) {
        if (array.name != one.array || static_cast<std::size_t>(one.index) >= array.tasks.size())
          continue;
        ArrayTask& task = array.tasks[static_cast<std::size_t>(one.index)];
        array.is_submitted = true;
        // Of two of the same array, the one that gets somewhere
        if (!task.queued || task.queued->is_stuck) task.queued = one;
        if (!task.queued->is_stuck) task.last_sign = now;
      }
    }
  }

  void look_at_refusals() {
    for (const std::string& file : files_of(folder_.root / "refused")) {
      const auto first = file.find('.'), second = file.find('.', first + 1);
      if (second == std::string::npos) continue;
      const std::string array_name = file.substr(0, first), node = file.substr(second + 1);
      const std::string index = file.substr(first + 1, second - first - 1);
      if (experience_.refused_nodes.insert(node).second) {
        say(
            fmt::format("Slurm: node {} is left out: it gives other bits for the known simulation "
                        "than this machine",
                        node));
      }
      for (Array& array : arrays_) {
        if (array.name != array_name) continue;
        for (std::size_t i = 0; i < array.tasks.size(); ++i) {
          if (std::to_string(i) == index)
            mark_lost(array, i, fmt::format("node {} gives other bits than this machine", node));
        }
      }
      std::error_code ignored;
      fs::remove(folder_.root / "refused" / file, ignored);
    }
  }

  void mark_lost(Array& array, std::size_t index, const std::string& trouble) {
    ArrayTask& task = array.tasks[index];
    if (task.is_lost) return;
    task.is_lost = true;
    for (const std::string& key : array.manifest.tasks[index]) {
      if (is_left(key))
        wanted_[key].trouble = fmt::format(
            "{} (log {})", trouble, folder_.log(array.name, static_cast<int>(index)).string());
    }
  }

  void give_up_what_is_lost() {
    if (!queue_answers_) return;
    const auto now = Clock::now();
    for (Array& array : arrays_) {
      if (!array.is_submitted) continue;
      for (std::size_t i = 0; i < array.tasks.size(); ++i) {
        ArrayTask& task = array.tasks[i];
        const bool is_wanted = has_left(array.manifest.tasks[i]);
        // 1. What still runs for nobody
        if (!is_wanted && task.queued && !task.is_cancelled &&
            Seconds(now - task.last_sign).count() < grace_ && task.queued->runs) {
          if (!task.idle_since) task.idle_since = now;
          if (Seconds(now - *task.idle_since).count() > grace_) {
            queue_.cancel_task(task.queued->id);
            task.is_cancelled = true;
          }
        }
        // 2. What nobody will run
        if (!is_wanted || task.is_lost || Seconds(now - task.last_sign).count() <= grace_) continue;
        if (task.queued) {
          say(fmt::format("Slurm: task {} will not start ({}); it is submitted again",
                          task.queued->id,
                          task.queued->reason));
          queue_.cancel_task(task.queued->id);
          mark_lost(array, i, fmt::format("it did not start: {}", task.queued->reason));
        } else {
          say(fmt::format(
              "Slurm: task {} of {} has left the queue without a result", i, array.name));
          mark_lost(array, i, "it left the queue without a result");
        }
      }
    }
  }

  void duplicate_stragglers() {
    std::vector<std::vector<std::string>> again;
    for (Array& array : arrays_) {
      // 1. The median of those that have ended, once they are half
      std::vector<double> seconds;
      for (std::size_t i = 0; i < array.tasks.size(); ++i) {
        if (!has_left(array.manifest.tasks[i])) seconds.push_back(array.tasks[i].seconds);
      }
      if (seconds.empty() || 2 * seconds.size() < array.tasks.size()) continue;
      const auto middle = seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2);
      std::nth_element(seconds.begin(), middle, seconds.end());
      // 2. A second chance for who is far behind
      for (std::size_t i = 0; i < array.tasks.size(); ++i) {
        ArrayTask& task = array.tasks[i];
        if (task.is_lost || task.has_duplicate || !task.queued || !task.queued->runs ||
            task.queued->elapsed <= std::max(straggling * *middle, grace_))
          continue;
        std::vector<std::string> keys;
        for (const std::string& key : array.manifest.tasks[i]) {
          if (is_left(key)) keys.push_back(key);
        }
        if (keys.empty()) continue;
        task.has_duplicate = true;
        say(fmt::format(
            "Slurm: task {} has run for {:.0f} s, where half of all took at most {:.0f} "
            "s; another does the same beside it",
            task.queued->id,
            task.queued->elapsed,
            *middle));
        again.push_back(std::move(keys));
      }
    }
    if (!again.empty()) add_new(std::move(again));
  }

  // --- Submitting

  bool is_under_way(const std::string& key) const {
    if (lost_keys_.contains(key)) return false;
    for (const Array& array : arrays_) {
      for (std::size_t i = 0; i < array.tasks.size(); ++i) {
        if (array.tasks[i].is_lost) continue;
        const auto& keys = array.manifest.tasks[i];
        if (std::find(keys.begin(), keys.end(), key) != keys.end()) return true;
      }
    }
    return false;
  }

  std::size_t simulations_of_a_task(std::size_t count) const {
    if (experience_.simulations == 0) return (count + first_tasks - 1) / first_tasks;
    const double each = experience_.seconds / static_cast<double>(experience_.simulations);
    const double in_time = setup_.execution.task_seconds * setup_.execution.cpus / each;
    return static_cast<std::size_t>(
        std::clamp(in_time, 1.0, std::max(1.0, static_cast<double>(count))));
  }

  void submit() {
    if (!queue_answers_) return;
    // 1. What nobody does, in tasks of about the time that is wished for
    if (Clock::now() >= next_try_) {
      std::vector<std::string> keys;
      for (const std::string& key : order_) {
        const Wanted& wanted = wanted_.at(key);
        if (!wanted.is_done && wanted.tries < most_tries && !is_under_way(key)) keys.push_back(key);
      }
      const std::size_t each = simulations_of_a_task(keys.size());
      std::vector<std::vector<std::string>> tasks;
      for (std::size_t i = 0; i < keys.size(); i += each) {
        tasks.emplace_back(
            keys.begin() + static_cast<std::ptrdiff_t>(i),
            keys.begin() + static_cast<std::ptrdiff_t>(std::min(i + each, keys.size())));
      }
      for (const std::string& key : keys) {
        ++wanted_[key].tries;
        lost_keys_.erase(key);
      }
      for (std::size_t i = 0; i < tasks.size(); i += largest_array) {
        add_new({tasks.begin() + static_cast<std::ptrdiff_t>(i),
                 tasks.begin() +
                     static_cast<std::ptrdiff_t>(std::min(i + largest_array, tasks.size()))});
      }
    }
    // 2. Arrays that Slurm does not have yet
    for (Array& array : arrays_) {
      if (array.is_submitted) continue;
      const std::vector<std::string> refused(experience_.refused_nodes.begin(),
                                             experience_.refused_nodes.end());
      array.is_submitted = queue_.submit(array.name,
                                         array.tasks.size(),
                                         folder_.array(array.name) / "job.sh",
                                         (folder_.root / "log" / "%x-%a.txt").string(),
                                         refused);
      for (ArrayTask& task : array.tasks) task.last_sign = Clock::now();
      if (!array.is_submitted) return;
    }
  }

  // Writes all that its tasks need. Where the disk refuses, the try is lost.
  void add_new(std::vector<std::vector<std::string>> tasks) {
    TaskManifest manifest{.program_version = setup_.program_version,
                          .step_limit = options_.step_limit,
                          .threads = setup_.execution.cpus,
                          .time_limit = options_.time_limit,
                          .folder = options_.folder.string(),
                          .patience = grace_,
                          .canary = to_text(canary_spec()),
                          .canary_bits = canary_bits_,
                          .tasks = std::move(tasks)};
    // Another name than any array of the same simulations had
    do ++manifest.attempt;
    while (fs::exists(folder_.array(name_of(manifest))));
    const std::string name = name_of(manifest);
    try {
      for (const auto& keys : manifest.tasks) {
        for (const std::string& key : keys) {
          if (!fs::exists(folder_.spec(key)))
            datasets::write_whole(folder_.spec(key),
                                  to_text(tasks_[wanted_.at(key).places.front()].spec));
        }
      }
      datasets::make_folder(folder_.array(name));
      datasets::write_whole(folder_.array(name) / "job.sh", script_of(name));
      datasets::write_whole(folder_.manifest(name), to_text(manifest));
    } catch (const datasets::InputError& error) {
      say(fmt::format("Slurm: the task folder cannot be written ({}); waiting", error.what()));
      for (const auto& keys : manifest.tasks) {
        for (const std::string& key : keys) wanted_[key].trouble = error.what();
      }
      next_try_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(Seconds(grace_));
      std::error_code ignored;
      fs::remove_all(folder_.array(name), ignored);
      return;
    }
    add_array(std::move(manifest), false);
  }

  std::string script_of(const std::string& name) const {
    std::string script = "#!/bin/bash\n";
    for (const std::string& line : setup_.execution.set_up) script += line + "\n";
    script += fmt::format("exec {} run-task {} \"$SLURM_ARRAY_TASK_ID\"\n",
                          quoted(setup_.program.string()),
                          quoted(folder_.array(name).string()));
    return script;
  }

  // --- Ends

  void refuse_what_nobody_can_run() {
    std::vector<std::string> lost;
    for (const auto& [key, wanted] : wanted_) {
      if (wanted.is_done) continue;
      if (wanted.tries < most_tries || is_under_way(key)) return;
      lost.push_back(fmt::format("{}: {}", key, wanted.trouble));
    }
    constexpr std::size_t named = 5;  // in the sentence
    const std::size_t count = lost.size();
    lost.resize(std::min(count, named));
    for (Array& array : arrays_) {
      queue_.cancel_array(array.name);
      remove_array(array.name, std::nullopt);
    }
    throw TasksFailed(fmt::format(
        "{} of {} simulations were lost {} times each: {}{}; what ended is in the journal, and the "
        "same command tries the rest again",
        count,
        wanted_.size(),
        most_tries,
        fmt::join(lost, "; "),
        count > named ? fmt::format("; and {} more", count - named) : std::string()));
  }

  void refuse_conflicts() const {
    const std::vector<std::string> files = files_of(folder_.root / "conflict");
    if (files.empty()) return;
    throw TasksFailed(fmt::format(
        "{} gave other bits than a task on another node for the same simulation, so the result "
        "would depend on the machine; compare {} with the journal, find out how the nodes differ, "
        "then remove the folder conflict/",
        files.front(),
        (folder_.root / "conflict" / files.front()).string()));
  }

  // Everything is in the journal: nothing stays in the queue or the folder.
  void tidy() {
    for (const Array& array : arrays_) {
      if (std::any_of(array.tasks.begin(), array.tasks.end(), [](const ArrayTask& task) {
            return task.has_duplicate || task.is_lost;
          }))
        queue_.cancel_array(array.name);
      remove_array(array.name, array.manifest);
    }
    if (!files_of(folder_.root / "conflict").empty()) return;
    std::error_code ignored;
    fs::remove_all(folder_.root, ignored);
  }

  const ExecutorSetup& setup_;
  TaskFolder folder_;
  SlurmQueue& queue_;
  Experience& experience_;
  const std::string& canary_bits_;
  std::span<const SimulationTask> tasks_;
  const EngineOptions& options_;
  const Executor::Done& done_;
  double grace_;                          // s
  std::map<std::string, Wanted> wanted_;  // by key
  std::vector<std::string> order_;        // keys, as they were asked for
  std::vector<Array> arrays_;
  std::set<std::string> lost_keys_;  // whose task may have gone on with others
  bool queue_answers_ = false;
  Clock::time_point next_try_ = Clock::now();
};

class Slurm final : public Executor {
 public:
  explicit Slurm(const ExecutorSetup& setup) : setup_(setup), queue_(setup.execution, setup.say) {
    queue_.require_commands();
    setup_.folder = fs::absolute(setup_.folder).lexically_normal();
  }

  void run(std::span<const SimulationTask> tasks,
           const EngineOptions& options,
           const Done& done) override {
    if (tasks.empty()) return;
    if (canary_bits_.empty()) {
      const SimulationSpec canary = canary_spec();
      canary_bits_ = bits_of(engine_named(canary.engine).run(canary, {}));
    }
    Batch(setup_, queue_, experience_, canary_bits_, tasks, options, done).run();
  }

 private:
  ExecutorSetup setup_;
  SlurmQueue queue_;
  Experience experience_;
  std::string canary_bits_;
};

}  // namespace

extern constinit const ExecutorKind slurm_executor{
    .name = "slurm", .make = [](const ExecutorSetup& setup) -> std::unique_ptr<Executor> {
      return std::make_unique<Slurm>(setup);
    }};

}  // namespace graintruth::calibrate
