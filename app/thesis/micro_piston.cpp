// Section 4.2 simulated again: ten two-ball particles follow a piston, at four frictions and two
// time steps. There is no film of the thesis to compare with, so simulations with one friction
// stand in for its experiment, and those with each friction are held against them as the thesis
// does.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>

#include "app/run/data_folder.h"
#include "app/run/interrupt.h"
#include "app/scenes/scene_files.h"
#include "app/thesis/targets.h"
#include "calibrate/compare/agreement.h"
#include "calibrate/engines/scene_run.h"
#include "calibrate/observables/track_results.h"
#include "calibrate/problem.h"
#include "datasets/rigs/followed_grains.h"
#include "datasets/store/fingerprint.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"

namespace graintruth::app {

namespace {

using calibrate::Channel;
using calibrate::ChannelShape;
using calibrate::Critical;
using datasets::Trajectories;
using Json = Studies::Json;

const std::string setup = "micro_experiment_setup";
const std::string properties = "table_4_1_micro_properties";
const std::string printed_distances = "micro_rms_vs_mu";

std::filesystem::path scene_of_rig() { return data_folder() / "scenes" / "micro_thesis.toml"; }

// The bed at rest on the piston: the arrangement that every run starts from.
calibrate::SceneRun settled_bed(std::uint64_t seed) {
  datasets::SceneFile file = datasets::load_scene(scene_of_rig());
  file.phases.back().duration = file.phases.back().output_interval;
  calibrate::SceneRun run = calibrate::run_scene(file, {.seed = seed, .stop = is_interrupted});
  if (is_interrupted()) throw calibrate::Interrupted();
  if (run.status != sim::RunStatus::completed || !run.reached_event)
    throw datasets::InputError(
        fmt::format("{}: the particles do not settle: {}.", scene_of_rig().string(), run.message));
  return run;
}

// The rig of the scene as an experiment, so that a run starts from placed particles as those of a
// calibration do.
datasets::Experiment experiment_in(const ThesisData& thesis, const calibrate::SceneRun& bed) {
  datasets::Experiment experiment;
  experiment.measurement = {.frame_interval = thesis.si(setup, "frame_interval"),
                            .frames = static_cast<int>(thesis.number(setup, "frames_used"))};
  experiment.measurement.observables = {{.name = "tracks"}};
  experiment.material = {.elastic_modulus = thesis.si(properties, "elastic_modulus"),
                         .poisson_ratio = thesis.number(properties, "poisson_ratio")};
  const sim::Clump& clump = bed.scene.types[bed.scene.bodies.front().type];
  datasets::SceneParticle model = datasets::load_scene(scene_of_rig()).particles.front();
  model.mass = clump.mass;
  experiment.particle = datasets::particle_of(model, static_cast<int>(bed.scene.bodies.size()));
  datasets::Rig& rig = experiment.rig;
  rig.scene.is_planar = true;
  for (const datasets::SceneWall& wall : datasets::load_scene(scene_of_rig()).walls) {
    const auto &from = wall.points[0], &to = wall.points[1];
    if (wall.motion.velocity.isZero(0.0)) {
      rig.walls.push_back({wall.name, from.x(), from.z(), to.x(), to.z()});
    } else {
      rig.moving_face = {from.z(), from.x(), to.x(), wall.motion.velocity.z()};
    }
  }
  datasets::follow_grains({.particle = &experiment.particle}, rig);
  experiment.replicates = {{.name = "arrangement", .rig = rig}};
  return experiment;
}

// What is simulated: the arrangement, placed again for every run.
calibrate::Problem problem_of(const ThesisData& thesis, const calibrate::SceneRun& bed) {
  const Trajectories tracks = planar_tracks(bed);
  std::size_t frame = 0;
  while (frame + 1 < tracks.frames() && tracks.time[frame + 1] <= 0.0) ++frame;
  Trajectories arrangement = datasets::make_trajectories(1, tracks.particles, false);
  for (std::size_t i = 0; i < arrangement.poses.size(); ++i)
    arrangement.poses[i] = tracks.poses[tracks.index(frame, i)];
  const std::vector<datasets::Recording> recordings = {{.tracks = arrangement}};
  calibrate::Problem problem = calibrate::plan_problem(experiment_in(thesis, bed), recordings);
  const double placing = thesis.setting("micro", "placing");
  problem.scenes.front().spec.start.standard_deviation = {
      placing, placing, thesis.setting("micro", "placing_angle")};
  return problem;
}

Json json_of(const Trajectories& tracks) {
  Json poses = Json::array();
  for (const datasets::Pose& pose : tracks.poses)
    for (const double number : {pose.x, pose.z, pose.angle}) poses.push_back(number);
  return poses;
}

// The runs of one friction at one time step: some stand in for the experiment, as many are its
// simulations.
struct Runs {
  std::vector<Channel> replicates, simulations;
};

struct Study {
  std::vector<double> frictions;
  std::vector<std::string> labels;      // the frictions as printed
  ChannelShape shape;                   // of the tracks of a run
  std::vector<std::vector<Runs>> runs;  // [time step][friction]
};

Study run_all(const ThesisData& thesis, Studies& studies) {
  Study study;
  const datasets::Table& table = thesis.table(printed_distances);
  study.frictions = table.numbers("friction_mu");
  for (std::size_t row = 0; row < table.rows(); ++row)
    study.labels.push_back(table.text(row, "friction_mu"));

  // 1. One arrangement of the bed, as Fig 4.2 shows one
  const calibrate::Problem problem = problem_of(thesis, settled_bed(studies.seed()));
  study.shape =
      calibrate::shape_of_tracks(static_cast<std::size_t>(problem.experiment.particle.count));

  // 2. Placed again for every run
  const auto replicates = static_cast<std::size_t>(thesis.number(setup, "replicates"));
  const auto seeds =
      calibrate::make_seeds(studies.seed(), "micro", static_cast<int>(2 * replicates));
  const std::string inputs = fmt::format("{} {} {} replicates, {} frames",
                                         thesis.settings_text("micro"),
                                         datasets::file_hash(scene_of_rig()),
                                         replicates,
                                         problem.experiment.measurement.frames);
  const double restitution = thesis.number(properties, "coefficient_of_restitution");
  for (const double fraction : thesis.settings("micro", "step_fraction")) {
    study.runs.emplace_back();
    for (std::size_t f = 0; f < study.frictions.size(); ++f) {
      const double friction = study.frictions[f];
      const std::string name =
          fmt::format("study-micro-friction-{}-step-{}", study.labels[f], fraction);
      const Json stored = studies.result(name, inputs, [&] {
        std::vector<Json> found(seeds.size());
        studies.in_parallel(static_cast<int>(seeds.size()), [&](int i) {
          const auto which = static_cast<std::size_t>(i);
          const calibrate::EngineRun run =
              calibrate::run_with_retry(*problem.engine,
                                        problem.spec_of(0,
                                                        {{"friction_particle_particle", friction},
                                                         {"friction_particle_wall", friction},
                                                         {"restitution", restitution}},
                                                        fraction / std::numbers::pi,
                                                        seeds[which]),
                                        {.stop = is_interrupted});
          if (run.status == calibrate::RunStatus::completed)
            found[which] = json_of(*run.recording.tracks);
        });
        return Json(found);
      });
      Runs& runs = study.runs.back().emplace_back();
      for (std::size_t i = 0; i < seeds.size(); ++i) {
        if (stored[i].is_null()) continue;
        (i < replicates ? runs.replicates : runs.simulations)
            .push_back({.values = stored[i].get<std::vector<double>>()});
      }
    }
  }
  return study;
}

// RMS distances, m, of one replicate from every simulation: their mean, for each replicate.
std::vector<double> distances(const Runs& experiment,
                              const Runs& model,
                              const ChannelShape& shape) {
  std::vector<double> values;
  for (const Channel& replicate : experiment.replicates) {
    double sum = 0.0;
    for (const Channel& simulation : model.simulations)
      sum += calibrate::rms_position(replicate.values, simulation.values, shape);
    values.push_back(sum / static_cast<double>(model.simulations.size()));
  }
  return values;
}

// Agreement, %, of every simulation with the interval of the replicates.
std::vector<double> agreements(const Runs& experiment,
                               const Runs& model,
                               const ChannelShape& shape,
                               Critical critical) {
  const auto spreads = calibrate::spreads_of(calibrate::pointers_to(experiment.replicates), shape);
  std::vector<double> values;
  for (const Channel& simulation : model.simulations) {
    values.push_back(
        calibrate::percent_of_tests_passed(spreads, shape, simulation.values, critical));
  }
  return values;
}

std::vector<double> in_millimetres(std::vector<double> values) {
  for (double& value : values) value /= unit_in_si("mm");
  return values;
}

// Whether `far` exceeds `near`, replicate by replicate, by more than chance: paired t-test at 95 %.
bool is_farther(const std::vector<double>& far, const std::vector<double>& near) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < far.size(); ++i) differences.push_back(far[i] - near[i]);
  const Simulated difference = over_seeds(differences);
  if (difference.seeds < 2) return false;
  const boost::math::students_t_distribution<double> student(difference.seeds - 1);
  return difference.mean >
         boost::math::quantile(student, 0.975) * difference.spread / std::sqrt(difference.seeds);
}

// In how many of all comparisons of one replicate with one simulation at each friction, as the
// thesis made one, the friction of the replicate is the nearest.
double share_found(const Study& study, std::size_t of) {
  const std::vector<Runs>& runs = study.runs.front();
  int found = 0, all = 0;
  for (const Channel& replicate : runs[of].replicates) {
    for (std::size_t seed = 0; seed < runs[of].simulations.size(); ++seed) {
      std::vector<double> away;
      for (const Runs& model : runs) {
        if (seed < model.simulations.size())
          away.push_back(calibrate::rms_position(
              replicate.values, model.simulations[seed].values, study.shape));
      }
      if (away.size() < runs.size()) continue;
      ++all;
      found += std::min_element(away.begin(), away.end()) - away.begin() ==
               static_cast<std::ptrdiff_t>(of);
    }
  }
  return all == 0 ? no_number : 100.0 * found / all;
}

// The labels, from the least to the largest value.
std::string ranking(const std::vector<std::string>& labels, const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return values[a] < values[b]; });
  std::vector<std::string> ranked;
  for (const std::size_t i : order) ranked.push_back(labels[i]);
  return fmt::format("{}", fmt::join(ranked, " < "));
}

// Section 4.2.2: RMS distances tell the frictions apart, and the nearest has that of the
// experiment.
void examine_distances(Examination& exam, const ThesisData& thesis, const Study& study) {
  const std::vector<Runs>& runs = study.runs.front();
  Curve curve{.id = "micro-distances",
              .caption =
                  "RMS distance of simulations from a simulated experiment, against the "
                  "friction of the simulation. Mean and standard deviation over replicates.",
              .x_title = "Friction of the simulation",
              .y_title = "RMS distance (mm)"};
  for (std::size_t of = 0; of < runs.size(); ++of) {
    const std::string experiment = fmt::format("experiment at {}", study.labels[of]);
    const std::vector<double> own = in_millimetres(distances(runs[of], runs[of], study.shape));
    Series series{.name = experiment, .x = study.frictions, .is_ours = true};
    std::vector<double> means;
    for (std::size_t other = 0; other < runs.size(); ++other) {
      const std::vector<double> away =
          in_millimetres(distances(runs[of], runs[other], study.shape));
      const Simulated distance = over_seeds(away);
      means.push_back(distance.mean);
      series.y.push_back(distance.mean);
      series.spread.push_back(distance.spread);
      if (other == of) continue;
      exam.claim(fmt::format("{}, simulation at {}: farther than one at {}",
                             experiment,
                             study.labels[other],
                             study.labels[of]),
                 {"farther", "mm", "sec 4.2.2"},
                 distance,
                 no_number,
                 is_farther(away, own),
                 fmt::format("RMS; at {} {:.1f} mm", study.labels[of], over_seeds(own).mean));
    }
    curve.series.push_back(series);
    const double share = share_found(study, of);
    exam.claim(fmt::format("{}: the nearest of four single runs has its friction", experiment),
               {"always", "percent", "sec 4.2.2"},
               {.mean = share, .seeds = static_cast<int>(runs[of].replicates.size())},
               no_number,
               share == 100.0,
               "share of all comparisons of one replicate with one run at each friction");
    if (study.frictions[of] == thesis.number(setup, "friction_best")) {
      const std::string printed =
          ranking(study.labels, thesis.table(printed_distances).numbers("rms_printed_mm"));
      const std::string ours = ranking(study.labels, means);
      exam.claim(fmt::format("{}: order of the four distances", experiment),
                 {printed, "-", "sec 4.2.2"},
                 {},
                 no_number,
                 ours == printed,
                 "ours: " + ours);
    }
  }
  exam.add_curve(curve);
}

// Section 4.2.3, applied to the same runs.
void examine_agreement(Examination& exam, const Study& study) {
  const std::vector<Runs>& runs = study.runs.front();
  Curve curve{.id = "micro-agreement",
              .caption =
                  "Agreement (1.96) of single simulations with a simulated experiment of "
                  "five replicates, against the friction of the simulation. Mean and "
                  "standard deviation over the simulations.",
              .x_title = "Friction of the simulation",
              .y_title = "Agreement (%)"};
  for (std::size_t of = 0; of < runs.size(); ++of) {
    const std::string experiment = fmt::format("experiment at {}", study.labels[of]);
    Series series{.name = experiment, .x = study.frictions, .is_ours = true};
    for (const Runs& model : runs) {
      const Simulated percent =
          over_seeds(agreements(runs[of], model, study.shape, Critical::thesis_196));
      series.y.push_back(percent.mean);
      series.spread.push_back(percent.spread);
    }
    const int replicates = static_cast<int>(runs[of].replicates.size());
    const Simulated own =
        over_seeds(agreements(runs[of], runs[of], study.shape, Critical::thesis_196));
    exam.claim(fmt::format("{}: agreement is best at its friction", experiment),
               {"best", "percent", "sec 4.2.3"},
               own,
               no_number,
               std::max_element(series.y.begin(), series.y.end()) - series.y.begin() ==
                   static_cast<std::ptrdiff_t>(of),
               fmt::format("simulations at {} score {:.1f} %; a run of a perfect model {:.1f} % on "
                           "average",
                           fmt::join(study.labels, ", "),
                           fmt::join(series.y, ", "),
                           calibrate::ceiling_percent(replicates, 1, Critical::thesis_196)));
    curve.series.push_back(series);
  }
  exam.add_curve(curve);
}

// Fig 4.5: a tenth of the step changes the tracks less than placing the particles anew does.
void examine_time_steps(Examination& exam, const ThesisData& thesis, const Study& study) {
  if (study.runs.size() < 2) return;
  for (std::size_t f = 0; f < study.frictions.size(); ++f) {
    const Runs &coarse = study.runs[0][f], &fine = study.runs[1][f];
    std::vector<double> changes;
    for (std::size_t i = 0; i < std::min(coarse.replicates.size(), fine.replicates.size()); ++i)
      changes.push_back(calibrate::rms_position(
          coarse.replicates[i].values, fine.replicates[i].values, study.shape));
    const Simulated change = over_seeds(in_millimetres(changes));
    const Simulated placing = over_seeds(in_millimetres(distances(coarse, coarse, study.shape)));
    const bool is_of_thesis = study.frictions[f] == thesis.number(setup, "friction_best");
    exam.claim(fmt::format("friction {}: RMS change by a tenth of the time step", study.labels[f]),
               {"not significant", "mm", is_of_thesis ? "fig 4.5" : "ours"},
               change,
               no_number,
               change.mean <= placing.mean,
               fmt::format("the same start; placing anew changes {:.1f} mm", placing.mean));
  }
}

}  // namespace

void simulate_micro(Examination& exam, const ThesisData& thesis, Studies& studies) {
  const Study study = run_all(thesis, studies);
  examine_distances(exam, thesis, study);
  examine_agreement(exam, study);
  examine_time_steps(exam, thesis, study);
  exam.add_note(
      "Reading A of the deck's CON. Wall friction is that between particles, as in deck (f). The "
      "arrangement is ours, settled without friction from a lattice; the thesis's cannot be had "
      "from its text, nor can its experiment, so runs at each friction stand in for it.");
}

}  // namespace graintruth::app
