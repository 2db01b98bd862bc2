// graintruth simulate: a scene from its first particle to its last frame, and what it leaves.
#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "app/run/data_folder.h"
#include "app/run/held_folder.h"
#include "app/run/interrupt.h"
#include "app/run/progress.h"
#include "app/run/run_record.h"
#include "app/scenes/scene_files.h"
#include "app/scenes/scene_picture.h"
#include "app/scenes/scene_povray.h"
#include "app/verbs/commands.h"
#include "datasets/store/fingerprint.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"

namespace graintruth::app {

namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::filesystem::path folder_for(const SimulateCommand& command, const std::string& name) {
  return command.common.out.empty() ? std::filesystem::path("out") / name : command.common.out;
}

// The file of a deck that says what it leaves out: the one named, the one beside it, or else the
// bundled one of its name.
datasets::SceneFile load_deck(const SimulateCommand& command) {
  std::error_code error;
  if (!command.sidecar.empty()) {
    if (!std::filesystem::is_regular_file(command.sidecar, error)) {
      throw datasets::InputError(
          fmt::format("{}: no such file; --sidecar names the TOML file that "
                      "says what the deck leaves out.",
                      command.sidecar.string()));
    }
    return datasets::load_scene(command.scene, command.sidecar);
  }
  const std::filesystem::path beside = datasets::sidecar_beside(command.scene);
  if (std::filesystem::exists(beside, error)) return datasets::load_scene(command.scene, beside);
  const auto bundled = bundled_sidecar(command.scene);
  if (!bundled) return datasets::load_scene(command.scene, beside);
  datasets::SceneFile file = datasets::load_scene(command.scene, *bundled);
  file.warnings.push_back(
      fmt::format("What the deck leaves out is taken from the bundled scenes/decks/{}.",
                  bundled->filename().string()));
  return file;
}

datasets::SceneFile load(const SimulateCommand& command) {
  if (datasets::is_deck(command.scene)) return load_deck(command);
  if (!command.sidecar.empty()) {
    throw datasets::InputError(fmt::format(
        "--sidecar says what a deck (.txt) leaves out, but {} is a scene file; leave it away.",
        command.scene.string()));
  }
  return datasets::load_scene(command.scene);
}

Json run_record(const SimulateCommand& command,
                const datasets::SceneFile& file,
                const std::string& started_at,
                double simulating,
                double writing) {
  Json hashes = Json::object();
  hashes[file.file.filename().string()] = datasets::file_hash(file.file);
  for (const auto& input : file.inputs) {
    hashes[input.filename().string()] = datasets::file_hash(input);
  }
  return {{"version", GRAINTRUTH_VERSION},
          {"verb", "simulate"},
          {"command", command.common.command_line},
          {"started_at", started_at},
          {"seed", command.common.seed},
          {"jobs", threads_of(command.common)},
          {"options",
           {{"render", command.render},
            {"povray", command.povray},
            {"paraview", command.paraview},
            {"ovito", command.ovito},
            {"time_limit_s", command.time_limit}}},
          {"configuration", scene_configuration(file)},
          {"input_hashes", hashes},
          {"stages",
           Json::array({{{"name", "simulating"}, {"seconds", simulating}},
                        {{"name", "writing"}, {"seconds", writing}}})}};
}

void print_summary(const Json& result, const std::filesystem::path& folder) {
  fmt::print("{}\n", result["title"].get<std::string>());
  for (const Json& phase : result["phases"]) {
    fmt::print("{:12} {:9.4f} to {:9.4f} s, {} steps of {:.3g} s{}\n",
               phase["name"].get<std::string>(),
               phase["start_s"].get<double>(),
               phase["end_s"].get<double>(),
               phase["steps"].get<std::int64_t>(),
               phase["time_step_s"].get<double>(),
               phase["came_to_rest"].get<bool>() ? ", came to rest" : "");
  }
  fmt::print(
      "{} particles, {} frames\n", result["particles"].get<int>(), result["frames"].get<int>());
  if (result.contains("discharged")) {
    fmt::print("{} particles ({:.4g} g) left through the exit\n",
               result["discharged"]["particles"].get<int>(),
               1e3 * result["discharged"]["mass_kg"].get<double>());
  }
  for (const Json& warning : result["warnings"]) {
    fmt::print("Note: {}\n", warning.get<std::string>());
  }
  fmt::print("Results: {}\n", folder.string());
}

// Exit status and, on stderr, the sentence for a run that did not reach its end.
int conclude(const calibrate::SceneRun& run, const std::filesystem::path& folder) {
  if (is_interrupted()) {
    fmt::print(stderr,
               "graintruth: interrupted; what was simulated until then is in {}.\n",
               folder.string());
    return 130;
  }
  if (run.status == sim::RunStatus::unstable) {
    fmt::print(stderr,
               "graintruth: the simulation cannot be trusted any more: {}; what came before is in "
               "{}.\n",
               run.message,
               folder.string());
    return 3;
  }
  return 0;
}

struct Done {
  calibrate::SceneRun run;
  Json result;
  double simulating = 0.0;  // s
};

// All that shows progress.
Done simulate_and_write(const SimulateCommand& command,
                        const datasets::SceneFile& file,
                        const datasets::RunFolder& folder,
                        Clock::time_point start) {
  ProgressLine progress(command.common.quiet);
  calibrate::SceneRunOptions options;
  options.seed = command.common.seed;
  options.threads = threads_of(command.common);
  options.stop = [&] {
    return is_interrupted() ||
           (command.time_limit > 0.0 && seconds_since(start) > command.time_limit);
  };
  options.progress = [&](const std::string& job, double share, const std::string& detail) {
    progress.show(job, share, detail);
  };
  Done done;
  done.run = calibrate::run_scene(file, options);
  done.simulating = seconds_since(start);
  done.result = scene_result(file, done.run);
  write_scene_tables(folder, file, done.run);
  if (command.povray) write_povray(folder, file, done.run);
  if (command.paraview) write_paraview(folder, done.run);
  if (command.ovito) write_ovito(folder, done.run);
  if (command.render) {
    render_scene(
        folder.root, file, done.run, [&](double share) { progress.show("drawing", share, ""); });
  }
  return done;
}

}  // namespace

int run_simulate(const SimulateCommand& command) {
  const Clock::time_point start = Clock::now();
  const std::string started_at = utc_now();
  // 1. The scene and its folder
  const datasets::SceneFile file = load(command);
  const std::filesystem::path root = folder_for(command, file.name);
  const HeldFolder held(root, "simulate", command.common.quiet);
  const datasets::RunFolder& folder = held.folder();
  catch_interrupts();

  // 2. The simulation and its files
  const Done done = simulate_and_write(command, file, folder, start);
  Json result = done.result;
  const double total = seconds_since(start);
  result["wall_time_s"] = total;
  datasets::write_whole(folder.result(), result.dump(2) + "\n");
  const Json record =
      run_record(command, file, started_at, done.simulating, total - done.simulating);
  datasets::write_whole(folder.run(), record.dump(2) + "\n");

  // 3. What to tell
  if (command.common.json) {
    fmt::print("{}\n", result.dump(2));
  } else {
    print_summary(result, folder.root);
  }
  return conclude(done.run, folder.root);
}

}  // namespace graintruth::app
