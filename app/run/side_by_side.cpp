#include "app/run/side_by_side.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/run/interrupt.h"
#include "datasets/store/input_error.h"
#include "tracking/film/recording.h"
#include "tracking/film/side_by_side.h"

namespace graintruth::app {

namespace {

constexpr std::size_t stills = 21;
constexpr double film_interval = 0.04;  // s, between poses of the simulation

std::uint64_t seed_of(const Session& session) {
  return calibrate::make_seeds(session.seed(), "side by side", 1).front();
}

// `simulate` is only called where there is a film.
void draw(Session& session,
          std::size_t replicate_number,
          const std::function<calibrate::EngineRun()>& simulate) {
  const datasets::Experiment& experiment = session.experiment();
  const datasets::Replicate& replicate = experiment.replicates[replicate_number];
  if (replicate.video.empty()) return;
  session.progress().show("drawing", 0.0, "film and simulation side by side");
  try {
    const calibrate::EngineRun run = simulate();
    if (run.status != calibrate::RunStatus::completed) return;
    const datasets::RunFolder& folder = session.folder();
    tracking::SideBySideFiles files{.film = folder.side_by_side()};
    for (std::size_t i = 0; i < stills; ++i) files.stills.push_back(folder.side_by_side_still(i));
    datasets::make_folder(files.stills.front().parent_path());
    const auto times = tracking::draw_side_by_side(
        {.film = datasets::film_of(experiment, replicate),
         .recorded = tracking::as_recorded(datasets::make_tracking_spec(experiment, replicate),
                                           replicate.video),
         .event_time = session.films().event_times[replicate_number],
         .filmed = session.films().recordings[replicate_number],
         .simulated = run.recording},
        files,
        is_interrupted);
    if (times.empty()) return;
    nlohmann::ordered_json list = {
        {"replicate", replicate.name},
        {"film", folder.side_by_side().filename().string()},
        {"shows", run.recording.outlines.empty() ? "particles" : "outline"},
        {"stills", nlohmann::json::array()}};
    for (std::size_t i = 0; i < times.size(); ++i) {
      const auto file = std::filesystem::relative(files.stills[i], folder.root);
      list["stills"].push_back({{"time_s", times[i]}, {"file", file.generic_string()}});
    }
    datasets::write_whole(folder.side_by_side_list(), list.dump(2) + "\n");
  } catch (const calibrate::Interrupted&) {
    // All results are there already
  } catch (const datasets::InputError& error) {
    session.progress().say(
        fmt::format("Note: film and simulation cannot be shown side by side: {}", error.what()));
  }
}

}  // namespace

void draw_side_by_side(Session& session,
                       const calibrate::Problem& problem,
                       const calibrate::EvaluationPoint& point) {
  // 1. The middle condition of those calibrated on, and its film nearest to the mean of all
  std::vector<const calibrate::Condition*> conditions;
  for (const calibrate::Condition& condition : problem.conditions) {
    if (!condition.held_out) conditions.push_back(&condition);
  }
  const calibrate::Condition& condition = *conditions[conditions.size() / 2];
  const auto chosen = calibrate::typical_replicate(problem, condition, [&](std::size_t replicate) {
    return !problem.experiment.replicates[replicate].video.empty();
  });
  if (!chosen) return;
  const std::string& name = problem.experiment.replicates[*chosen].name;
  const auto& replicates = session.experiment().replicates;
  const auto replicate = std::find_if(
      replicates.begin(), replicates.end(), [&](const auto& one) { return one.name == name; });
  // 2. A simulation of what is compared, seen as often as a film shows it
  const auto scene =
      std::find_if(condition.scenes.begin(), condition.scenes.end(), [&](std::size_t one) {
        return problem.scenes[one].replicate == *chosen || !problem.scenes[one].is_of_one_replicate;
      });
  draw(session, static_cast<std::size_t>(replicate - replicates.begin()), [&] {
    calibrate::SimulationSpec spec =
        problem.spec_of(*scene, point.parameters, point.time_step_fraction, seed_of(session));
    if (spec.record.outlines.empty()) spec.record = {.tracks = true, .curves = {}};
    datasets::ScenePhase& last = spec.scene.phases.back();
    if (last.output_interval > film_interval) {
      last.duration = std::floor(last.duration / film_interval + 1e-9) * film_interval;
      last.output_interval = film_interval;
    }
    return problem.engine->run(spec, session.engine_options());
  });
}

}  // namespace graintruth::app
