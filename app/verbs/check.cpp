// graintruth check: what a calibration of this experiment will do, what stands in its way, and how
// long it may take. Tracks nothing and calibrates nothing.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>

#include "app/run/first_frame.h"
#include "app/run/given_data.h"
#include "app/run/made_folders.h"
#include "app/run/numbering.h"
#include "app/run/same_recording.h"
#include "app/verbs/commands.h"
#include "calibrate/calibration.h"
#include "calibrate/engines/scene_build.h"
#include "calibrate/knowledge/foreign_replicates.h"
#include "calibrate/knowledge/outline_doubts.h"
#include "calibrate/parameters.h"
#include "datasets/experiment/joint_experiment.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"
#include "tracking/film/recording.h"
#include "tracking/registry.h"
#include "tracking/track_film.h"

namespace graintruth::app {

namespace {

using datasets::BeginsFrom;
using datasets::Experiment;

// Sentences, gathered: what makes the calibration impossible, and what makes it doubtful.
struct Findings {
  std::vector<std::string> missing;
  std::vector<std::string> doubtful;

  // What is thrown as unusable input is missing, in the words of whoever refuses it.
  template <typename Work>
  void try_to(const Work& work) {
    try {
      work();
    } catch (const datasets::InputError& error) {
      missing.emplace_back(error.what());
    }
  }
  // Before everything else that is doubtful.
  void doubt_first(const std::vector<datasets::Warning>& warnings) {
    std::vector<std::string> sentences;
    for (const datasets::Warning& warning : warnings) sentences.push_back(warning.text);
    doubtful.insert(doubtful.begin(), sentences.begin(), sentences.end());
  }
};

constexpr std::chrono::seconds trial_time_limit(30);  // for the one simulation that is timed
constexpr int usual_replicates = 5;  // the thesis's number; t falls slowly from there on

// How far, rms, the marks of the scale may lie off their places, m. A hundredth of a grain's width:
// that is little beside how grains differ. But never less than ten times what well placed marks
// leave, which are found to a twentieth of a pixel.
double largest_residual(const datasets::Particle& particle, double pixels_per_metre) {
  constexpr double share = 0.01, found_to = 0.05;
  return std::max(share * 2.0 * particle.half_width, 10.0 * found_to / pixels_per_metre);
}

// At stated moments, instead of until the flow ends.
bool is_measured_at_moments(const Experiment& experiment) {
  return experiment.rig.begins_from != BeginsFrom::each_replicate && !experiment.rig.seen_outline;
}

void print_what(const Experiment& experiment) {
  const datasets::Particle& particle = experiment.particle;
  fmt::print("{}\n", experiment.title);
  fmt::print("particles   {} of {} sphere(s), {:.4g} mm long, {:.4g} g each\n",
             particle.count,
             calibrate::spheres_of(particle.model).size(),
             1e3 * particle.length,
             1e3 * particle.mass);
  const double gap = experiment.rig.front_back_gap;
  fmt::print("rig         {}, {} walls{}\n",
             experiment.rig.kind,
             experiment.replicates.front().rig.scene.walls.size(),
             gap > 0.0 ? fmt::format(", panes {:.4g} mm apart", 1e3 * gap) : std::string());
  std::vector<std::string> observables;
  for (const auto& observable : experiment.measurement.observables)
    observables.push_back(observable.name);
  fmt::print("compared    {}, of {} replicates{}\n",
             fmt::join(observables, ", "),
             experiment.replicates.size(),
             is_measured_at_moments(experiment)
                 ? fmt::format(" at {} moments, 0 to {:.4g} s from the start event",
                               experiment.measurement.frames,
                               experiment.measurement.last_time())
             : experiment.rig.seen_outline ? std::string()
                                           : std::string(" until the flow ends"));
  const bool is_alone = experiment.part_of.empty();
  if (is_alone && experiment.tuned.size() > 1 && !experiment.rig.complement.empty()) {
    fmt::print("beside it   {} tells apart parameters that this experiment may leave together\n",
               experiment.rig.complement);
  }
  const calibrate::ParameterSet bench = datasets::bench_parameters(experiment);
  std::size_t longest = 0;
  for (const auto& [name, value] : bench) longest = std::max(longest, name.size());
  for (const auto& [name, value] : bench) {
    const auto tuned = std::find_if(
        experiment.tuned.begin(), experiment.tuned.end(), [&, &key = name](const auto& each) {
          return each.name == key;
        });
    const std::string what =
        tuned == experiment.tuned.end()
            ? std::string("held at its bench value")
            : fmt::format("tuned from {:.4g} to {:.4g}, bench value", tuned->lower, tuned->upper);
    const std::string prior = tuned != experiment.tuned.end() && tuned->prior
                                  ? fmt::format(", prior {:.4g} +- {:.2g}",
                                                tuned->prior->value,
                                                tuned->prior->standard_uncertainty)
                                  : std::string();
    fmt::print("{:<{}} {} {:.4g}{}\n", name, longest, what, value, prior);
  }
  fmt::print(
      "The simulator has no cohesion, no liquid between grains, no air drag, no breakage, no wear "
      "and no heat\n");
}

// What the search will have to work with.
void check_search(const Experiment& experiment, Findings& findings) {
  const auto doubt = [&](std::string sentence) {
    findings.doubtful.push_back(std::move(sentence));
  };
  const auto count = static_cast<int>(experiment.replicates.size());
  // Replicates with settings of their own are not repeats of each other
  if (count < usual_replicates && experiment.replicates.front().rig.settings.empty()) {
    doubt(fmt::format(
        "{} replicates make wide intervals; {} or more are usual.", count, usual_replicates));
  }
  if (experiment.tuned.empty()) doubt("Nothing is to be tuned; 'graintruth validate' is enough.");
  const calibrate::ParameterSet bench = datasets::bench_parameters(experiment);
  for (const datasets::TunedParameter& tuned : experiment.tuned) {
    const double value = bench.of(tuned.name);
    if (value < tuned.lower || value > tuned.upper) {
      doubt(fmt::format("The bench value {:.4g} of {} lies outside the bounds of its search.",
                        value,
                        tuned.name));
    }
    if (tuned.prior && (tuned.prior->value < tuned.lower || tuned.prior->value > tuned.upper)) {
      doubt(fmt::format("The prior's mean {:.4g} of {} lies outside the bounds of its search.",
                        tuned.prior->value,
                        tuned.name));
    }
  }
}

void check_particle(const Experiment& experiment, Findings& findings) {
  const auto doubt = [&](std::string sentence) {
    findings.doubtful.push_back(std::move(sentence));
  };
  const datasets::Particle& particle = experiment.particle;
  const double gap = experiment.rig.front_back_gap;
  if (gap > 0.0 && gap < particle.thickness)
    doubt("The panes are closer together than a particle is thick.");
  if (gap > 1.5 * particle.thickness)
    doubt("The panes leave room for particles to pass behind each other; one layer is simulated.");
  findings.doubtful.insert(
      findings.doubtful.end(), experiment.notes.begin(), experiment.notes.end());
}

// Throws what `track` says of a film whose particles it cannot find in the first frame. Who must
// see the whole film first is not asked.
void find_first_particles(const datasets::TrackingSpec& spec, const datasets::Film& film) {
  const auto tracker = tracking::make_tracker(spec, film);
  if (tracker->looks_ahead()) return;
  try {
    tracking::track_film(*tracker, spec, film, {.stop = [] { return true; }});
  } catch (const tracking::Stopped&) {
    // after the first frame
  }
}

// How long the film lasts, s, where it can be read.
std::optional<double> check_film(const Experiment& experiment,
                                 const datasets::Replicate& replicate,
                                 const std::filesystem::path& picture,
                                 Findings& findings) {
  FirstFrame frame;
  datasets::TrackingSpec spec;
  try {
    spec =
        tracking::as_recorded(datasets::make_tracking_spec(experiment, replicate), replicate.video);
    frame = look_at_first_frame(spec, datasets::film_of(experiment, replicate), picture);
  } catch (const datasets::InputError& error) {
    findings.missing.emplace_back(error.what());
    return std::nullopt;
  }
  const std::string& film = replicate.video.string();
  const double length = frame.length;
  fmt::print("{:<11} {} x {} px, {} frames = {:.2f} s, {} of {} {} found",
             replicate.name,
             frame.width,
             frame.height,
             frame.frames,
             length,
             frame.found,
             frame.given,
             frame.scale_from);
  if (frame.residual) {
    fmt::print(", {:.3f} mm rms, {:.3f} px/mm", 1e3 * *frame.residual, 1e-3 * *frame.scale);
  }
  fmt::print("\n            {}\n", picture.string());

  if (!frame.residual) {
    findings.missing.push_back(frame.complaint);
  } else if (*frame.residual > largest_residual(experiment.particle, *frame.scale)) {
    findings.doubtful.push_back(
        fmt::format("{}: the {} lie {:.2f} mm (rms) off their places; measure them again.",
                    film,
                    frame.scale_from,
                    1e3 * *frame.residual));
  }
  if (frame.residual) {
    findings.try_to([&] { find_first_particles(spec, datasets::film_of(experiment, replicate)); });
  }
  const double last = experiment.measurement.last_time();
  if (is_measured_at_moments(experiment) && length < last) {
    findings.missing.push_back(fmt::format(
        "{}: the film lasts {:.2f} s, but the comparison needs {:.2f} s after the start event; "
        "lower measure.frames or film for longer.",
        film,
        length,
        last));
  }
  for (const std::string& sentence : frame.warnings)
    findings.doubtful.push_back(fmt::format("{}: {}", film, sentence));
  return length;
}

// What is known of a film before it is tracked: how long it lasts, and where the particles start if
// the experiment file says so.
datasets::Recording before_tracking(const Experiment& experiment, double film_length) {
  datasets::Recording recording;
  if (experiment.rig.begins_from == BeginsFrom::each_replicate) {
    recording.discharge = datasets::DischargeCurve{.time = {0.0, film_length}, .mass = {0.0, 0.0}};
    return recording;
  }
  datasets::Trajectories tracks =
      datasets::make_trajectories(1, static_cast<int>(experiment.starts.size()), false);
  for (std::size_t n = 0; n < experiment.starts.size(); ++n) {
    const datasets::StartPlace& start = experiment.starts[n];
    tracks.poses[n] = {start.x, start.z, start.angle};
  }
  recording.tracks = std::move(tracks);
  return recording;
}

// What one replicate brings beside its film, printed.
void print_given(const datasets::Replicate& replicate, const datasets::Recording& recording) {
  if (const auto& tracks = recording.tracks) {
    fmt::print("{:<11} {} particles, {} frames from {:.4g} to {:.4g} s\n",
               replicate.name,
               tracks->particles,
               tracks->frames(),
               tracks->time.front(),
               tracks->time.back());
  }
  for (const datasets::Outline& outline : recording.outlines) {
    if (outline.time.empty() || outline.column.empty()) continue;
    fmt::print(
        "{:<11} an outline{} in {} columns from {:.4g} to {:.4g} mm, {} moment{} to {:.4g} s\n",
        replicate.name,
        outline.surface.empty() ? "" : fmt::format(" '{}'", outline.surface),
        outline.column.size(),
        1e3 * outline.column.front(),
        1e3 * outline.column.back(),
        outline.time.size(),
        outline.time.size() == 1 ? "" : "s",
        outline.time.back());
  }
  if (const auto& discharge = recording.discharge) {
    fmt::print("{:<11} {:.4g} g leave between {:.4g} and {:.4g} s\n",
               replicate.name,
               1e3 * (discharge->mass.back() - discharge->mass.front()),
               discharge->time.front(),
               discharge->time.back());
  }
  for (const auto& [name, curve] : recording.curves)
    fmt::print("{:<11} {} values of {}\n", replicate.name, curve.value.size(), name);
}

// What all replicates bring, as far as it is known before films are tracked; empty where some of it
// cannot be used. Pictures of films go below `out`.
std::vector<datasets::Recording> look_at_recordings(const Experiment& experiment,
                                                    const std::filesystem::path& out,
                                                    Findings& findings) {
  // 1. Tables, each as `track` and `calibrate` read it
  std::vector<GivenData> given;
  for (const datasets::Replicate& replicate : experiment.replicates)
    findings.try_to([&] { given.push_back(read_given_data(experiment, replicate)); });
  const bool are_read = given.size() == experiment.replicates.size();
  std::vector<datasets::Recording> recordings;
  if (are_read) {
    number_alike(experiment, given);
    for (GivenData& one : given) {
      recordings.push_back(std::move(one.recording));
      const std::vector<std::string>& notes = recordings.back().notes;
      findings.doubtful.insert(findings.doubtful.end(), notes.begin(), notes.end());
    }
    findings.try_to([&] { require_different(experiment, recordings); });
    findings.doubt_first(compare_starts(experiment, recordings));
    findings.doubt_first(calibrate::doubts_about_outlines(experiment, recordings));
  }
  // 2. Films
  bool can_be_used = are_read;
  for (std::size_t i = 0; i < experiment.replicates.size(); ++i) {
    const datasets::Replicate& replicate = experiment.replicates[i];
    if (are_read) print_given(replicate, recordings[i]);
    if (replicate.video.empty()) continue;
    const auto length =
        check_film(experiment, replicate, out / "check" / (replicate.name + ".png"), findings);
    can_be_used = can_be_used && length;
    if (!length || !are_read) continue;
    datasets::Recording film = before_tracking(experiment, *length);
    film.curves = std::move(recordings[i].curves);
    recordings[i] = std::move(film);
  }
  if (!can_be_used) recordings.clear();
  return recordings;
}

std::string duration_text(double seconds) {
  if (seconds < 90.0) return fmt::format("{:.0f} s", std::max(1.0, seconds));
  if (seconds < 5400.0) return fmt::format("{:.0f} min", seconds / 60.0);
  return fmt::format("{:.1f} h", seconds / 3600.0);
}

// Grains of a trial simulation that lie below every wall in the end, where nothing lets them leave
// and none of the recordings shows them there: the walls do not hold them.
void check_walls(const calibrate::Problem& problem,
                 std::span<const datasets::Recording> recordings,
                 const datasets::SceneData& scene,
                 const datasets::Trajectories& simulated,
                 Findings& findings) {
  if (scene.exit_height || scene.leaves_below || scene.walls.empty()) return;
  double bottom = std::numeric_limits<double>::infinity();
  for (const datasets::SceneWall& wall : scene.walls) {
    if (wall.kind == datasets::SceneWall::Kind::plane || !wall.motion.angular_velocity.isZero())
      return;
    // As low as it may have moved
    const double moved = std::max(0.0, -wall.motion.velocity.z()) * simulated.time.back();
    for (const Eigen::Vector3d& point : wall.points)
      bottom = std::min(bottom, point.z() - wall.radius - moved);
  }
  bottom -= problem.experiment.particle.length;
  const auto below = [&](const datasets::Trajectories& tracks) {
    std::vector<std::size_t> numbers;
    for (std::size_t n = 0; n < static_cast<std::size_t>(tracks.particles); ++n) {
      if (tracks.poses[tracks.index(tracks.frames() - 1, n)].z < bottom) numbers.push_back(n + 1);
    }
    return numbers;
  };
  const std::vector<std::size_t> fallen = below(simulated);
  if (fallen.empty()) return;
  for (const datasets::Recording& recording : recordings)
    if (recording.tracks && !below(*recording.tracks).empty()) return;
  findings.doubtful.push_back(fmt::format(
      "In a trial simulation {} of {} particles fall out of the rig within {:.3g} s, particle {} "
      "first by number: they end below every wall. Close the gap in [rig]; a scene in which grains "
      "are meant to leave needs exit_height.",
      fallen.size(),
      simulated.particles,
      simulated.time.back(),
      fallen.front()));
}

// Times one simulation in the middle of the bounds, and multiplies.
void estimate(const CheckCommand& command,
              const calibrate::Problem& problem,
              std::span<const datasets::Recording> recordings,
              Findings& findings) {
  const Experiment& experiment = problem.experiment;
  const std::array experiments = {calibrate::CalibratedExperiment{experiment.name, &problem}};
  calibrate::CalibrationOptions options = calibrate::default_options(experiments);
  if (command.budget > 0) options.budget = command.budget;
  if (experiment.tuned.empty()) options.budget = 0;
  const double cost = calibrate::expected_cost(experiments, options);
  fmt::print(
      "to come     {} evaluations. Together with all other steps they take as long as {:.0f} "
      "simulations",
      options.budget,
      cost);
  const calibrate::ParameterSpace space(experiment.tuned, datasets::bench_parameters(experiment));
  const std::size_t scene = problem.calibrated_scenes[problem.calibrated_scenes.size() / 2];
  const auto spec_at = [&](double share) {
    calibrate::SimulationSpec spec =
        problem.spec_of(scene,
                        space.from_unit(std::vector<double>(space.dimension(), 0.5)),
                        share * options.largest_time_step_fraction,
                        command.common.seed);
    if (!problem.engine->is_another_program()) spec.record.tracks = true;  // where grains end
    return spec;
  };
  // Nothing where it takes too long
  const auto try_out = [&](const calibrate::SimulationSpec& spec) {
    const auto deadline = std::chrono::steady_clock::now() + trial_time_limit;
    std::optional<calibrate::EngineRun> run;
    try {
      run =
          problem.engine->run(spec,
                              {.stop = [&] { return std::chrono::steady_clock::now() > deadline; },
                               .folder = std::filesystem::absolute(experiment.file).parent_path()});
    } catch (const calibrate::Interrupted&) {
    }
    return run;
  };
  const calibrate::SimulationSpec spec = spec_at(1.0);
  const std::optional<calibrate::EngineRun> trial = try_out(spec);
  const int jobs = threads_of(command.common);
  if (!trial) {
    const auto least = static_cast<double>(trial_time_limit.count());
    fmt::print(". One takes more than {:.0f} s here, so all take more than {} on {} core(s)\n",
               least,
               duration_text(cost * least / jobs),
               jobs);
    return;
  }
  if (trial->status != calibrate::RunStatus::completed) {
    fmt::print("\n");
    // Without a first step nothing could start, whatever the parameters
    const bool has_started = trial->time_step > 0.0;
    (has_started ? findings.doubtful : findings.missing)
        .push_back(fmt::format("{}: A trial simulation did not complete ({}); look at walls and "
                               "starting places.",
                               experiment.file.string(),
                               trial->message));
    if (!has_started) return;
    // Grains that fall out get too fast for a large step
    if (const auto finer = try_out(spec_at(0.25)); finer && finer->recording.tracks)
      check_walls(problem, recordings, spec.scene, *finer->recording.tracks, findings);
    return;
  }
  const bool is_filmed =
      std::any_of(experiment.replicates.begin(),
                  experiment.replicates.end(),
                  [](const datasets::Replicate& replicate) { return !replicate.video.empty(); });
  fmt::print(
      ". One took {:.2g} s here at the largest time step, so all take about {} on {} core(s). A "
      "smaller time step can make this four times longer{}\n",
      trial->seconds,
      duration_text(cost * trial->seconds / jobs),
      jobs,
      is_filmed ? ". Tracking is not included" : "");
  if (trial->recording.tracks)
    check_walls(problem, recordings, spec.scene, *trial->recording.tracks, findings);
}

const calibrate::Engine& engine_of(const Experiment& experiment) {
  return calibrate::engine_named(experiment.simulator.engine);
}

// Whether what is simulated is known before films are tracked.
bool is_start_known(const Experiment& experiment) {
  return experiment.rig.begins_from != BeginsFrom::mean_of_replicates ||
         !experiment.starts.empty() ||
         std::all_of(experiment.replicates.begin(),
                     experiment.replicates.end(),
                     [](const auto& replicate) { return replicate.video.empty(); });
}

// Prints what is found of one experiment; pictures go below `out`.
Findings look_at(const CheckCommand& command,
                 Experiment experiment,
                 const std::filesystem::path& out) {
  // 1. What the file says
  Findings findings;
  calibrate::complete_particle(experiment);
  print_what(experiment);
  findings.try_to([&] { calibrate::require_comparable(experiment, engine_of(experiment)); });
  findings.try_to(
      [&] { calibrate::require_repeats(experiment, calibrate::conditions_of(experiment)); });
  findings.try_to([&] {
    const MadeFolders made(out);
    datasets::open_run_folder(out);
  });
  check_search(experiment, findings);
  check_particle(experiment, findings);

  // 2. Films and tracks
  const std::vector<datasets::Recording> recordings = look_at_recordings(experiment, out, findings);
  const bool is_all_given = std::all_of(experiment.replicates.begin(),
                                        experiment.replicates.end(),
                                        [](const auto& each) { return each.video.empty(); });

  // 3. What it will cost
  if (findings.missing.empty() && !is_start_known(experiment)) {
    fmt::print(
        "to come     The time of the calibration is not known until the films are tracked, because "
        "no [[start]] is given\n");
  } else if (findings.missing.empty()) {
    findings.try_to([&] {
      const calibrate::Problem problem =
          is_all_given ? calibrate::make_problem(experiment, recordings, engine_of(experiment))
                       : calibrate::plan_problem(experiment, recordings, engine_of(experiment));
      if (is_all_given) findings.doubt_first(calibrate::foreign_replicates(problem, recordings));
      for (const datasets::Warning& warning : problem.warnings)
        findings.doubtful.push_back(warning.text);
      const std::vector<std::string> of_scene =
          calibrate::build_scene(problem.scenes.front().spec.scene, experiment.file.string())
              .warnings;
      findings.doubtful.insert(findings.doubtful.end(), of_scene.begin(), of_scene.end());
      estimate(command, problem, recordings, findings);
    });
  }

  // 4. Verdict
  for (const std::string& sentence : findings.doubtful) fmt::print("doubtful: {}\n", sentence);
  for (const std::string& sentence : findings.missing) fmt::print("missing: {}\n", sentence);
  return findings;
}

std::filesystem::path folder_for(const CheckCommand& command, const Experiment& experiment) {
  return command.common.out.empty() ? std::filesystem::path("out") / experiment.name
                                    : command.common.out;
}

// All experiments of a joint calibration, one after the other.
std::size_t look_at_all(const CheckCommand& command) {
  const datasets::JointExperiment joint = datasets::load_joint_experiment(command.experiment);
  fmt::print("{}: {} experiments, calibrated together\n", joint.common.title, joint.parts.size());
  std::size_t missing = 0;
  for (const datasets::JointPart& part : joint.parts) {
    const std::string& name = part.experiment.name;
    fmt::print("\n{} (weight {:.4g}): ", name, part.weight);
    missing +=
        look_at(command, part.experiment, folder_for(command, joint.common) / name).missing.size();
  }
  fmt::print("\nThe whole takes about the sum of the times above.\n");
  return missing;
}

}  // namespace

int run_check(const CheckCommand& command) {
  std::size_t missing = 0;
  if (datasets::is_joint(command.experiment)) {
    missing = look_at_all(command);
  } else {
    const Experiment experiment = datasets::load_experiment(command.experiment);
    missing = look_at(command, experiment, folder_for(command, experiment)).missing.size();
  }
  if (missing == 0) {
    fmt::print("Ready: graintruth calibrate {}{}{}\n",
               command.experiment.string(),
               command.common.out.empty() ? "" : " --out " + command.common.out.string(),
               command.budget > 0 ? fmt::format(" --budget {}", command.budget) : "");
    return 0;
  }
  throw datasets::InputError(fmt::format("{}: not ready, {} thing(s) are missing; see the list.",
                                         command.experiment.string(),
                                         missing));
}

}  // namespace graintruth::app
