#include "app/side_by_side.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/interrupt.h"
#include "calibrate/bin_simulator.h"
#include "calibrate/dem_simulator.h"
#include "calibrate/score.h"
#include "datasets/input_error.h"
#include "tracking/recording.h"
#include "tracking/side_by_side.h"

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
          const std::function<calibrate::SimulatedRun()>& simulate) {
  const datasets::Experiment& experiment = session.experiment();
  const datasets::Replicate& replicate = experiment.replicates[replicate_number];
  if (replicate.video.empty()) return;
  session.progress().show("drawing", 0.0, "film and simulation side by side");
  try {
    const calibrate::SimulatedRun run = simulate();
    if (run.status != calibrate::RunStatus::completed) return;
    const datasets::RunFolder& folder = session.folder();
    tracking::SideBySideFiles files{.film = folder.side_by_side()};
    for (std::size_t i = 0; i < stills; ++i) files.stills.push_back(folder.side_by_side_still(i));
    datasets::make_folder(files.stills.front().parent_path());
    const auto times = tracking::draw_side_by_side(
        {.film = datasets::film_of(experiment, replicate),
         .recorded = tracking::as_recorded(datasets::make_tracking_spec(experiment, replicate),
                                           replicate.video),
         .filmed = session.films().tracks[replicate_number],
         .simulated = run.trajectories},
        files,
        is_interrupted);
    if (times.empty()) return;
    nlohmann::ordered_json list = {{"replicate", replicate.name},
                                   {"film", folder.side_by_side().filename().string()},
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
  // 1. The film nearest to the mean of all, where particles are told apart
  std::size_t nearest = 0;
  double distance = std::numeric_limits<double>::infinity();
  const auto& replicates = problem.comparison->replicates();
  for (std::size_t i = 0; i < replicates.size(); ++i) {
    const double own = calibrate::rms_position(replicates[i], problem.comparison->target().mean);
    if (!(own < distance) || problem.experiment.replicates[i].video.empty()) continue;
    distance = own;
    nearest = i;
  }

  // 2. A simulation of what is compared, seen more often
  draw(session, nearest, [&] {
    datasets::Experiment dense = session.experiment();
    const double last = dense.measurement.frame_interval * (dense.measurement.frames - 1);
    dense.measurement = {.compared = datasets::Compared::particles,
                         .frame_interval = film_interval,
                         .frames = static_cast<int>(std::floor(last / film_interval + 1e-9)) + 1};
    return calibrate::make_dem_simulator(dense, problem.starts, {.stop = is_interrupted})(
        {point.parameters, point.time_step_fraction, seed_of(session)});
  });
}

void draw_side_by_side(Session& session,
                       const calibrate::BinProblem& problem,
                       const calibrate::EvaluationPoint& point) {
  std::vector<std::size_t> films = problem.calibrated_films;
  const auto orifice_of = [&](std::size_t film) { return problem.starts[film].rig.orifice; };
  std::stable_sort(films.begin(), films.end(), [&](std::size_t a, std::size_t b) {
    return orifice_of(a) < orifice_of(b);
  });
  const double middle = orifice_of(films[films.size() / 2]);
  const auto film = std::find_if(
      films.begin(), films.end(), [&](std::size_t one) { return orifice_of(one) == middle; });
  const calibrate::BinStart& start = problem.starts[*film];
  const std::string& name = problem.all->films()[*film].name;
  const auto& replicates = session.experiment().replicates;
  const auto replicate = std::find_if(
      replicates.begin(), replicates.end(), [&](const auto& one) { return one.name == name; });
  draw(session, static_cast<std::size_t>(replicate - replicates.begin()), [&] {
    return calibrate::make_bin_simulator(start, {.stop = is_interrupted, .keep_tracks = true})(
        {point.parameters, point.time_step_fraction, seed_of(session)});
  });
}

}  // namespace graintruth::app
