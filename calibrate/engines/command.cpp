#include "calibrate/engines/command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>

#include "calibrate/engines/recording_archive.h"
#include "calibrate/engines/scratch_folder.h"
#include "datasets/store/external_program.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"

namespace graintruth::calibrate {

namespace {

namespace fs = std::filesystem;
using datasets::Json;

constexpr int says_unstable = 75;

// The last line that a program wrote, for a sentence.
std::string last_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  return text.substr(text.find_last_of('\n') + 1);
}

// What is wrong with a curve; nothing where it is sound.
std::string complaint_on(const std::string& name, const datasets::Curve& curve) {
  if (curve.value.empty()) return fmt::format("the curve '{}' has no values", name);
  if (!curve.time.empty() && curve.time.size() != curve.value.size()) {
    return fmt::format(
        "the curve '{}' has {} times and {} values", name, curve.time.size(), curve.value.size());
  }
  for (std::size_t i = 1; i < curve.time.size(); ++i) {
    if (!(curve.time[i] > curve.time[i - 1]))
      return fmt::format("the times of the curve '{}' do not rise", name);
  }
  for (const double value : curve.value) {
    if (!std::isfinite(value)) return fmt::format("the curve '{}' holds what is no number", name);
  }
  return "";
}

std::string complaint_on(const SimulationSpec& spec, const datasets::Recording& recording) {
  for (const std::string& name : spec.record.curves) {
    const auto found = recording.curves.find(name);
    if (found == recording.curves.end()) return fmt::format("the curve '{}' is missing", name);
    if (std::string wrong = complaint_on(name, found->second); !wrong.empty()) return wrong;
  }
  if (spec.record.tracks && !recording.tracks) return "'tracks' is missing";
  if (const auto& tracks = recording.tracks) {
    if (tracks->particles < 1 || tracks->time.empty() ||
        tracks->poses.size() != tracks->time.size() * static_cast<std::size_t>(tracks->particles)) {
      return fmt::format("'tracks' holds {} poses for {} times of {} particles",
                         tracks->poses.size(),
                         tracks->time.size(),
                         tracks->particles);
    }
  }
  if (const auto& discharge = recording.discharge) {
    if (discharge->time.empty() || discharge->time.size() != discharge->mass.size())
      return "'discharge' needs as many masses as times";
  }
  return "";
}

// Fills a run from what the command wrote, or says why that cannot be.
std::string read_recording(const SimulationSpec& spec, const fs::path& file, EngineRun& run) {
  std::error_code absent;
  if (!fs::exists(file, absent)) return "wrote no recording.json";
  const Json json = Json::parse(datasets::read_whole(file), nullptr, false);
  if (!json.is_object()) return "wrote a recording.json that is not valid JSON";
  try {
    if (json.contains("time_step_s"))
      datasets::JsonReader::read(json["time_step_s"], run.time_step, false);
    if (!json.contains("recording")) return "wrote a recording.json without 'recording'";
    datasets::JsonReader::read(json["recording"], run.recording, true);
  } catch (const std::invalid_argument& error) {
    return fmt::format("wrote a recording.json that cannot be used: {}", error.what());
  }
  if (std::string wrong = complaint_on(spec, run.recording); !wrong.empty())
    return fmt::format("wrote a recording.json that cannot be used: {}", wrong);
  return "";
}

class Command final : public Engine {
 public:
  std::string_view name() const override { return "command"; }
  std::string version() const override { return "1"; }
  bool is_another_program() const override { return true; }

  std::vector<std::string> curves(const SimulationSpec& spec) const override {
    return spec.foreign ? spec.foreign->curves : std::vector<std::string>{};
  }
  double largest_time_step_fraction(const SimulationSpec&) const override { return 1.0; }

  EngineRun run(const SimulationSpec& spec, const EngineOptions& options) const override {
    const auto start = std::chrono::steady_clock::now();
    EngineRun run;
    const auto end_badly = [&](RunStatus status, const std::string& message) {
      run.status = status;
      run.message = message;
      run.recording = {};
    };
    // 1. The spec, in a folder of this run
    const ScratchFolder scratch(options.scratch);
    datasets::write_whole(scratch.path() / "spec.json", to_text(spec));
    datasets::ExternalCall call{.words = {}, .folder = scratch.path()};
    if (spec.foreign) {
      for (const std::string& word : spec.foreign->command)
        call.words.push_back(datasets::command_word(word, options.folder));
    }
    if (call.words.empty()) {
      throw datasets::InputError(
          "the engine 'command' needs the program to run: [simulation] command = [...].");
    }
    const std::string name = fmt::format("{}", fmt::join(call.words, " "));
    call.words.insert(call.words.end(), {"spec.json", "recording.json"});
    call.time_limit = options.time_limit;
    call.stop = options.stop;
    // 2. The program
    const datasets::ExternalEnd end = datasets::run_external(call);
    using How = datasets::ExternalEnd::How;
    if (end.how == How::stopped) throw Interrupted();
    if (end.how == How::not_started) {
      throw datasets::InputError(fmt::format(
          "the command '{}' {}; see [simulation] of the experiment file.", name, end.words()));
    }
    if (end.how == How::too_late) {
      end_badly(
          RunStatus::timed_out,
          fmt::format("the command '{}' did not end within {:.4g} s", name, options.time_limit));
    } else if (!end.succeeded()) {
      const std::string words = last_line(end.err.empty() ? end.out : end.err);
      end_badly(
          RunStatus::unstable,
          end.how == How::by_itself && end.status == says_unstable
              ? fmt::format("the command '{}' says that it is unstable{}",
                            name,
                            words.empty() ? "" : ": " + words)
              : fmt::format(
                    "the command '{}' {}{}", name, end.words(), words.empty() ? "" : ": " + words));
    } else {
      // 3. The recording
      const std::string wrong = read_recording(spec, scratch.path() / "recording.json", run);
      if (!wrong.empty())
        end_badly(RunStatus::unstable, fmt::format("the command '{}' {}", name, wrong));
    }
    run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return run;
  }
};

}  // namespace

const Engine& command_engine() {
  static const Command engine;
  return engine;
}

}  // namespace graintruth::calibrate
