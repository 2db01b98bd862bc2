#include "calibrate/bin_problem.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "calibrate/prior.h"
#include "datasets/input_error.h"
#include "datasets/run_folder.h"
#include "datasets/store/fingerprint.h"
#include "datasets/table.h"

namespace graintruth::calibrate {

namespace {

constexpr const char* numbers_version = "3";  // see problem.cpp
// Where tracks state no error: far below any camera's, and enough for seeds to tell runs apart.
constexpr datasets::Pose least_error{1.0e-5, 1.0e-5, 1.0e-4};
constexpr double curve_frame_interval = 0.01;  // s; as finely as a film shows when particles leave
constexpr double arching_diameters = 6.0;      // orifices narrower than this arch

void append(std::string& text, double value) { text += datasets::number_text(value) + ";"; }

std::string hash_of(const BinStart& start) {
  std::string text = numbers_version;
  const datasets::Experiment& experiment = start.experiment;
  for (const datasets::AxialSphere& sphere : experiment.particle.spheres) {
    append(text, sphere.offset);
    append(text, sphere.radius);
  }
  const datasets::EllipticalPlate& plate = *experiment.particle.plate;
  for (const double value : {plate.semi_major,
                             plate.semi_minor,
                             plate.thickness,
                             experiment.particle.mass,
                             experiment.material.elastic_modulus,
                             experiment.material.poisson_ratio,
                             experiment.rig.gravity,
                             experiment.rig.bin->width,
                             experiment.rig.bin->height,
                             experiment.rig.bin->orifice_width,
                             start.standard_deviation.x,
                             start.standard_deviation.z,
                             start.standard_deviation.angle,
                             start.duration,
                             start.frame_interval,
                             start.profile_height.value_or(-1.0),
                             start.impact_speed})
    append(text, value);
  if (start.bed.empty()) {
    append(text, experiment.particle.count);
    append(text, start.prepared_bed);
  }
  for (const datasets::Pose& pose : start.bed) {
    append(text, pose.x);
    append(text, pose.z);
    append(text, pose.angle);
  }
  return datasets::content_hash(text);
}

// Median over particles and frames of what the tracker says of its own error.
datasets::Pose typical_error(const datasets::Trajectories& track) {
  datasets::Pose typical = least_error;
  for (double datasets::Pose::*member :
       {&datasets::Pose::x, &datasets::Pose::z, &datasets::Pose::angle}) {
    std::vector<double> values;
    for (const datasets::Pose& sigma : track.sigmas) {
      if (std::isfinite(sigma.*member)) values.push_back(sigma.*member);
    }
    if (values.empty()) continue;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    typical.*member = *middle;
  }
  return typical;
}

BinStart start_of(const datasets::Experiment& experiment,
                  const datasets::Replicate& replicate,
                  const BinRecord& record,
                  const BinMeasurement& measured) {
  BinStart start{.experiment = datasets::as_filmed(experiment, replicate),
                 .rig = bulk_rig(experiment, replicate)};
  if (record.curve) {
    start.duration = record.curve->time.back();
    start.frame_interval = curve_frame_interval;
    return start;
  }
  const datasets::Trajectories& track = record.tracks;
  start.bed = measure_starts({&track, 1}).mean;
  int unseen = 0, turned = 0;
  for (const datasets::Pose& pose : start.bed) {
    unseen += std::isfinite(pose.x) && std::isfinite(pose.z) ? 0 : 1;
    turned += std::isfinite(pose.angle) ? 1 : 0;
  }
  if (turned > 0) unseen = std::max(unseen, static_cast<int>(start.bed.size()) - turned);
  if (static_cast<int>(start.bed.size()) != experiment.particle.count || unseen > 0) {
    throw datasets::InputError(fmt::format(
        "{}: {} particles are seen at rest before the orifice opens, but particle.count is {}; "
        "correct particle.count, or the tracks with a file of corrections.",
        replicate.name,
        static_cast<int>(start.bed.size()) - unseen,
        experiment.particle.count));
  }
  start.standard_deviation = typical_error(track);
  if (turned == 0) {
    // Discs lie the same whichever way they are turned.
    if (experiment.particle.plate && !experiment.particle.plate->shows_angle())
      for (datasets::Pose& pose : start.bed) pose.angle = 0.0;
    else
      start.bed.clear();
  }
  start.duration = track.time.back();
  start.frame_interval =
      (track.time.back() - track.time.front()) / static_cast<double>(track.frames() - 1);
  start.profile_height = measured.profile.height;
  return start;
}

void choose_held_out(std::vector<BinStart>& starts) {
  const auto& replicates = starts.front().experiment.replicates;
  const bool stated = std::any_of(replicates.begin(), replicates.end(), [](const auto& replicate) {
    return replicate.held_out.has_value();
  });
  std::set<double> wide;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    if (stated) starts[i].held_out = replicates[i].held_out.value_or(false);
    const BulkRig& rig = starts[i].rig;
    if (rig.orifice >= arching_diameters * rig.particle_diameter) wide.insert(rig.orifice);
  }
  if (!stated && wide.size() >= 2) {
    for (BinStart& start : starts) start.held_out = !wide.contains(start.rig.orifice);
  }
  // What was fitted and what is predicted is never averaged.
  std::map<double, bool> of_orifice;
  for (const BinStart& start : starts) {
    const auto [at, is_new] = of_orifice.try_emplace(start.rig.orifice, start.held_out);
    if (is_new || at->second == start.held_out) continue;
    throw datasets::InputError(fmt::format(
        "{}: some films of the orifice of {:.4g} mm are held out and some are not; hold out all "
        "films of an orifice, or none.",
        start.experiment.file.string(),
        1e3 * start.rig.orifice));
  }
}

}  // namespace

void require_plates(const datasets::Experiment& experiment) {
  if (!experiment.particle.plate) {
    throw datasets::InputError(
        fmt::format("{}: particle.plate is missing; what runs out of a bin is measured as plates.",
                    experiment.file.string()));
  }
}

BinMeasurement measure_bin(const BinRecord& record,
                           const datasets::Experiment& experiment,
                           const datasets::Replicate& replicate) {
  const BulkRig rig = bulk_rig(experiment, replicate);
  return record.curve ? measure_bin(*record.curve, experiment.particle.count, rig)
                      : measure_bin(record.tracks, rig);
}

BinProblem make_bin_problem(const datasets::Experiment& experiment,
                            std::span<const BinRecord> records) {
  require_plates(experiment);
  BinProblem problem{.experiment = experiment};
  std::vector<FilmedBin> films;
  std::vector<std::string> weighed, unturned;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const datasets::Replicate& replicate = experiment.replicates[i];
    FilmedBin film{.name = replicate.name, .rig = bulk_rig(experiment, replicate)};
    const datasets::Trajectories& tracks = records[i].tracks;
    if (!records[i].curve && (tracks.frames() < 2 || tracks.time.back() <= 0.0)) {
      throw datasets::InputError(
          fmt::format("{}: nothing is seen after the orifice opens; film until the flow ends.",
                      replicate.name));
    }
    film.measured = measure_bin(records[i], experiment, replicate);
    problem.starts.push_back(start_of(experiment, replicate, records[i], film.measured));
    if (problem.starts.back().bed.empty()) {
      (records[i].curve ? weighed : unturned).push_back(replicate.name);
      problem.starts.back().prepared_bed = static_cast<int>(weighed.size() + unturned.size());
    }
    films.push_back(std::move(film));
  }
  if (!weighed.empty()) {
    problem.warnings.push_back(fmt::format(
        "{}: a discharge curve tells neither the bed nor velocities nor whether an arch holds the "
        "rest; simulations start from prepared beds, and only rates and what stays are compared.",
        fmt::join(weighed, ", ")));
  }
  if (!unturned.empty()) {
    problem.warnings.push_back(fmt::format(
        "{}: the tracks tell no angles; simulations start from prepared beds instead of this one.",
        fmt::join(unturned, ", ")));
  }
  choose_held_out(problem.starts);
  double widest = 0.0;
  for (const BinStart& start : problem.starts) widest = std::max(widest, start.rig.orifice);
  for (BinStart& start : problem.starts) {
    start.impact_speed = std::sqrt(2.0 * start.rig.gravity * widest);
    start.hash = hash_of(start);
  }
  for (std::size_t i = 0; i < films.size(); ++i)
    problem.parts.emplace_back("film " + films[i].name, problem.starts[i].hash);
  if (const std::string priors = text_of_priors(experiment); !priors.empty()) {
    problem.parts.emplace_back("priors", datasets::content_hash(priors));
    for (BinStart& start : problem.starts) start.hash = datasets::content_hash(start.hash + priors);
  }
  std::vector<FilmedBin> calibrated;
  for (std::size_t i = 0; i < films.size(); ++i) {
    if (problem.starts[i].held_out) continue;
    calibrated.push_back(films[i]);
    problem.calibrated_films.push_back(i);
  }
  problem.all = std::make_shared<BinComparison>(std::move(films));
  problem.calibrated = std::make_shared<BinComparison>(std::move(calibrated));
  if (problem.calibrated->scatter().freedom == 0) {
    throw datasets::InputError(fmt::format(
        "{}: no orifice that is calibrated on has two films; the scatter between films of the same "
        "orifice is the only measure of how exactly its rate is known.",
        experiment.file.string()));
  }
  if (experiment.objective == datasets::ObjectiveForm::requested) {
    std::shared_ptr<const Comparison> by_laws =
        problem.calibrated->with_form(datasets::ObjectiveForm::requested);
    if (!by_laws) {
      throw datasets::InputError(fmt::format(
          "{}: tune.objective = \"requested\" compares Beverloo's C and k, which take tracks of "
          "particles that flow steadily through two orifices that are calibrated on; use "
          "\"smooth\".",
          experiment.file.string()));
    }
    problem.calibrated = std::static_pointer_cast<const BinComparison>(by_laws);
  }
  return problem;
}

}  // namespace graintruth::calibrate
