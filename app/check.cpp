// graintruth check: what a calibration of this experiment will do, what stands in its way, and how
// long it may take. Tracks nothing and calibrates nothing.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "app/commands.h"
#include "app/first_frame.h"
#include "app/given_data.h"
#include "calibrate/bin_calibration.h"
#include "calibrate/calibration.h"
#include "calibrate/dem_simulator.h"
#include "datasets/input_error.h"
#include "datasets/joint_experiment.h"
#include "datasets/run_folder.h"
#include "tracking/recording.h"

namespace graintruth::app {

namespace {

using datasets::Experiment;

// Sentences, gathered: what makes the calibration impossible, and what makes it doubtful.
struct Findings {
  std::vector<std::string> missing;
  std::vector<std::string> doubtful;
};

constexpr double trial_time_limit = 30.0;  // s for the one simulation that is timed
constexpr int usual_replicates = 5;        // the thesis's number; t falls slowly from there on
// Of a bin: nine films of 200 plates took half an hour on two cores, 3 s a simulation. Beside the
// evaluations of the search there are the time step, the choice and the confirmation.
constexpr double bin_seconds_per_plate = 3.0 / 200.0;
constexpr double bin_overhead = 2.0;
constexpr double blurred_residual = 0.5e-3;  // m; ten times what well placed dots leave

double last_time(const Experiment& experiment) {
  return experiment.measurement.frame_interval * (experiment.measurement.frames - 1);
}

void print_what(const Experiment& experiment) {
  const datasets::Particle& particle = experiment.particle;
  fmt::print("{}\n", experiment.title);
  const std::string shape = particle.plate ? fmt::format("plate {:.4g} mm x {:.4g} mm (half axes)",
                                                         1e3 * particle.plate->semi_major,
                                                         1e3 * particle.plate->semi_minor)
                                           : fmt::format("{} ball(s)", particle.spheres.size());
  fmt::print("particles   {} of {}, {:.4g} g each\n", particle.count, shape, 1e3 * particle.mass);
  fmt::print("rig         {} walls{}, panes {:.4g} mm apart\n",
             experiment.rig.walls.size(),
             experiment.rig.piston
                 ? fmt::format(", a piston at {:.4g} mm/s", 1e3 * experiment.rig.piston->velocity_z)
                 : std::string(),
             1e3 * experiment.rig.front_back_gap);
  if (experiment.rig.bin) {
    fmt::print("compared    {} films: flow rates, what stays behind, velocity profiles\n",
               experiment.replicates.size());
  } else {
    fmt::print("compared    {} replicates at {} moments, 0 to {:.4g} s from the start event\n",
               experiment.replicates.size(),
               experiment.measurement.frames,
               last_time(experiment));
  }
  const calibrate::ParameterSet bench = calibrate::bench_parameters(experiment);
  for (const std::string_view name : calibrate::parameter_names) {
    const auto tuned = std::find_if(experiment.tuned.begin(),
                                    experiment.tuned.end(),
                                    [&](const auto& each) { return each.name == name; });
    const std::string what =
        tuned == experiment.tuned.end()
            ? std::string("held at its bench value")
            : fmt::format("tuned from {:.4g} to {:.4g}, bench value", tuned->lower, tuned->upper);
    const std::string prior = tuned != experiment.tuned.end() && tuned->prior
                                  ? fmt::format(", prior {:.4g} +- {:.2g}",
                                                tuned->prior->value,
                                                tuned->prior->standard_uncertainty)
                                  : std::string();
    fmt::print("{:<28} {} {:.4g}{}\n", name, what, value_of(bench, name), prior);
  }
}

// What the search will have to work with.
void check_search(const Experiment& experiment, Findings& findings) {
  const auto doubt = [&](std::string sentence) { findings.doubtful.push_back(sentence); };
  const auto count = static_cast<int>(experiment.replicates.size());
  if (count < usual_replicates && !experiment.rig.bin) {  // a bin's films differ in their orifices
    doubt(fmt::format(
        "{} replicates make wide intervals; {} or more are usual.", count, usual_replicates));
  }
  if (experiment.tuned.empty()) doubt("Nothing is to be tuned; 'graintruth validate' is enough.");
  const calibrate::ParameterSet bench = calibrate::bench_parameters(experiment);
  for (const datasets::TunedParameter& tuned : experiment.tuned) {
    const double value = value_of(bench, tuned.name);
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
  const auto doubt = [&](std::string sentence) { findings.doubtful.push_back(sentence); };
  double radius = 0.0;  // half of its thickness between the panes
  double volume = 0.0;  // at most: balls of a particle may overlap
  for (const datasets::AxialSphere& sphere : experiment.particle.spheres) {
    radius = std::max(radius, sphere.radius);
    volume += 4.0 / 3.0 * std::numbers::pi * std::pow(sphere.radius, 3);
  }
  if (const auto& plate = experiment.particle.plate) {
    radius = 0.5 * plate->thickness;
    volume = std::numbers::pi * plate->semi_major * plate->semi_minor * plate->thickness;
  }
  if (experiment.rig.front_back_gap < 2.0 * radius)
    doubt("The panes are closer together than a particle is thick.");
  if (experiment.rig.front_back_gap > 3.0 * radius)
    doubt("The panes leave room for particles to pass behind each other; one layer is simulated.");
  const double density = experiment.particle.mass / volume;
  if (density < 100.0 || density > 20000.0) {
    doubt(fmt::format("The mass makes a density of at least {:.3g} kg/m3: look at mass and radii.",
                      density));
  }
}

void check_film(const Experiment& experiment,
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
    return;
  }
  const std::string& film = replicate.video.string();
  const double length = frame.declared_frames / spec.camera.frame_rate;
  fmt::print("{:<11} {} x {} px, {} frames = {:.2f} s, {} of {} {} found",
             replicate.name,
             frame.width,
             frame.height,
             frame.declared_frames,
             length,
             frame.found,
             frame.given,
             frame.scale_from);
  if (frame.residual) {
    fmt::print(", {:.3f} mm rms, {:.3f} px/mm", 1e3 * *frame.residual, 1e-3 * *frame.scale);
  }
  fmt::print("\n            {}\n", picture.string());

  if (!frame.residual) {
    findings.missing.push_back(frame.complaint + "; the picture shows what was seen.");
  } else if (*frame.residual > blurred_residual) {
    findings.doubtful.push_back(
        fmt::format("{}: the {} lie {:.2f} mm (rms) off their places; measure them again.",
                    film,
                    frame.scale_from,
                    1e3 * *frame.residual));
  }
  // A bin is measured until it has run out, however long that takes.
  if (!experiment.rig.bin && frame.declared_frames > 0 && length < last_time(experiment)) {
    findings.missing.push_back(fmt::format(
        "{}: the film lasts {:.2f} s, but the comparison needs {:.2f} s after the start event; "
        "lower measure.frames or film for longer.",
        film,
        length,
        last_time(experiment)));
  }
  const double declared = frame.declared_frame_rate;
  if (declared > 0.0 && std::abs(declared / spec.camera.frame_rate - 1.0) > 0.01) {
    findings.doubtful.push_back(
        fmt::format("{}: the film's header says {:.4g} frames/s, the experiment file {:.4g}; the "
                    "experiment file is believed.",
                    film,
                    declared,
                    spec.camera.frame_rate));
  }
}

// Where the particles start: as the file says, else as the tracks show.
std::optional<calibrate::StartPoses> starts_of(const Experiment& experiment,
                                               const std::vector<datasets::Trajectories>& tracks) {
  if (tracks.size() == experiment.replicates.size()) return calibrate::measure_starts(tracks);
  if (experiment.starts.empty()) return std::nullopt;
  calibrate::StartPoses starts{.standard_deviation = {0.0, 0.0, 0.0}};
  for (const datasets::StartPlace& start : experiment.starts)
    starts.mean.push_back({start.x, start.z, start.angle});
  return starts;
}

// Simulations that a calibration asks for at most, in its numbered steps, and what they cost in
// units of one simulation at the largest time step.
struct Work {
  int simulations = 0;
  double cost = 0.0;
};

Work work_of(const Experiment& experiment, int budget) {
  const calibrate::CalibrationOptions options;
  const int places = 2 * options.gate_seeds;
  const int time_step = 3 * places;                     // at 1, 1/2 and 1/4 of the time step
  const int half_step = options.confirmation_seeds;     // of the winner; twice the cost
  const int friction = 4 * options.confirmation_seeds;  // the thesis's frictions
  const bool searches = !experiment.tuned.empty();
  const int rest =
      (searches ? budget * options.search_seeds + calibrate::choice_simulations(options) : 0) +
      options.confirmation_seeds + friction;
  return {time_step + rest + half_step, places * (1.0 + 2.0 + 4.0) + rest + 2.0 * half_step};
}

std::string duration_text(double seconds) {
  if (seconds < 90.0) return fmt::format("{:.0f} s", std::max(1.0, seconds));
  if (seconds < 5400.0) return fmt::format("{:.0f} min", seconds / 60.0);
  return fmt::format("{:.1f} h", seconds / 3600.0);
}

// Times one simulation in the middle of the bounds, and multiplies.
void estimate(const CheckCommand& command,
              const Experiment& experiment,
              const std::optional<calibrate::StartPoses>& starts,
              Findings& findings) {
  const int budget = command.budget > 0 ? command.budget : calibrate::CalibrationOptions{}.budget;
  const Work work = work_of(experiment, budget);
  fmt::print(
      "to come     about {} simulations for a budget of {} evaluations", work.simulations, budget);
  if (!starts) {
    fmt::print("; their time is not known before the films are tracked (no [[start]] is given)\n");
    return;
  }
  const calibrate::ParameterSpace space(experiment.tuned, calibrate::bench_parameters(experiment));
  const calibrate::SimulatedRun run =
      calibrate::make_dem_simulator(experiment, *starts, {.time_limit = trial_time_limit})(
          {space.from_unit(std::vector<double>(space.dimension(), 0.5)),
           calibrate::largest_time_step_fraction(experiment),
           command.common.seed});
  if (run.status != calibrate::RunStatus::completed) {
    fmt::print("\n");
    findings.doubtful.push_back(
        fmt::format("A trial simulation did not complete ({}); look at walls and starting places.",
                    run.message));
    return;
  }
  const int jobs = threads_of(command.common);
  fmt::print(
      "; one took {:.2g} s here at the largest time step, so about {} on {} core(s), up to four "
      "times that if a smaller step turns out to be needed, besides tracking\n",
      run.seconds,
      duration_text(work.cost * run.seconds / jobs),
      jobs);
}

// Prints what is found of one experiment; pictures go below `out`.
Findings look_at(const CheckCommand& command,
                 const Experiment& experiment,
                 const std::filesystem::path& out) {
  // 1. What the file says
  Findings findings;
  print_what(experiment);
  check_search(experiment, findings);
  check_particle(experiment, findings);

  // 2. Films and tracks
  std::vector<datasets::Trajectories> tracks;
  std::vector<calibrate::BinRecord> records;
  for (const datasets::Replicate& replicate : experiment.replicates) {
    if (!replicate.video.empty()) {
      check_film(experiment, replicate, out / "check" / (replicate.name + ".png"), findings);
      continue;
    }
    try {
      if (!replicate.discharge.empty()) {
        const datasets::DischargeCurve curve = read_given_curve(experiment, replicate);
        fmt::print("{:<11} {:.4g} g leave between {:.4g} and {:.4g} s\n",
                   replicate.name,
                   1e3 * (curve.mass.back() - curve.mass.front()),
                   curve.time.front(),
                   curve.time.back());
        records.push_back({{}, curve});
        continue;
      }
      tracks.push_back(read_given_tracks(experiment, replicate));
      records.push_back({tracks.back(), std::nullopt});
      fmt::print("{:<11} {} particles, {} frames from {:.4g} to {:.4g} s\n",
                 replicate.name,
                 tracks.back().particles,
                 tracks.back().frames(),
                 tracks.back().time.front(),
                 tracks.back().time.back());
    } catch (const datasets::InputError& error) {
      findings.missing.emplace_back(error.what());
    }
  }
  if (findings.missing.empty() && records.size() == experiment.replicates.size()) {
    try {
      if (experiment.rig.bin) {
        const auto problem = calibrate::make_bin_problem(experiment, records);
        findings.doubtful.insert(
            findings.doubtful.end(), problem.warnings.begin(), problem.warnings.end());
      } else {
        calibrate::make_problem(experiment, tracks);
      }
    } catch (const datasets::InputError& error) {
      findings.missing.emplace_back(error.what());
    }
  }

  // 3. What it will cost
  if (findings.missing.empty() && experiment.rig.bin) {
    const int budget = command.budget > 0 ? command.budget : calibrate::bin_options().budget;
    const int jobs = threads_of(command.common);
    const double seconds = bin_seconds_per_plate * experiment.particle.count;
    fmt::print(
        "to come     a simulation of every film for each of {} evaluations; {} particles take some "
        "{:.2g} s a film, so these {} film(s) about {} on {} core(s), besides tracking\n",
        budget,
        experiment.particle.count,
        seconds,
        experiment.replicates.size(),
        duration_text(bin_overhead * budget * seconds * experiment.replicates.size() / jobs),
        jobs);
  } else if (findings.missing.empty()) {
    estimate(command, experiment, starts_of(experiment, tracks), findings);
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
  fmt::print(
      "\nEvery evaluation simulates all of them: what is to come is the sum of the above, with the "
      "number of evaluations of the bin, if there is one.\n");
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
