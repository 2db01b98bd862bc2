#include "app/films.h"

#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>

#include "app/first_frame.h"
#include "app/given_data.h"
#include "app/interrupt.h"
#include "calibrate/ensemble.h"
#include "calibrate/problem.h"
#include "datasets/input_error.h"
#include "datasets/store/fingerprint.h"
#include "datasets/table.h"
#include "tracking/body.h"
#include "tracking/recording.h"
#include "tracking/track_bed.h"

namespace graintruth::app {

namespace {

using Json = nlohmann::ordered_json;

// Changes whenever the tracker gives other numbers for the same film.
constexpr const char* tracker_version = "6";

// Of the film and of everything in the experiment that the tracker looks at.
std::string hash_of(const datasets::Experiment& experiment, const std::string& film_hash) {
  std::string text = std::string(tracker_version) + ";" + film_hash + ";";
  const auto append = [&text](double value) { text += datasets::number_text(value) + ";"; };
  append(experiment.particle.count);
  for (const auto& sphere : experiment.particle.spheres) {
    append(sphere.offset);
    append(sphere.radius);
  }
  append(experiment.camera.frame_rate);
  append(experiment.camera.pixel_aspect);
  append(experiment.camera.noted_event_time.value_or(-1.0));
  for (const auto& fiducial : experiment.camera.fiducials) {
    for (const double value : {fiducial.x, fiducial.z, fiducial.diameter}) append(value);
  }
  for (const auto& start : experiment.starts) {
    for (const double value : {start.x, start.z, start.angle}) append(value);
  }
  for (const auto& wall : experiment.rig.walls) {
    for (const double value : {wall.from_x, wall.from_z, wall.to_x, wall.to_z}) append(value);
  }
  if (const auto& piston = experiment.rig.moving_face) {
    for (const double value : {piston->face_z, piston->left_x, piston->right_x, piston->velocity_z})
      append(value);
  }
  if (const auto& plate = experiment.particle.plate) {
    for (const double value : {plate->semi_major, plate->semi_minor, plate->thickness})
      append(value);
  }
  if (const auto& bed = experiment.rig.bed)
    for (const double value : {bed->left_x, bed->right_x, bed->height}) append(value);
  if (const auto& opening = experiment.rig.opening)
    for (const double value : {opening->left_x, opening->right_x, opening->z}) append(value);
  append(experiment.rig.gravity);
  return datasets::content_hash(text);
}

Json summary_json(const tracking::TrackingSummary& summary, const datasets::Replicate& replicate) {
  return {{"name", replicate.name},
          {"film", replicate.video.filename().string()},
          {"grade", tracking::to_string(summary.grade)},
          {"warnings", summary.warnings},
          {"width_px", summary.width},
          {"height_px", summary.height},
          {"frames", summary.frames_read},
          {"frames_declared", summary.frames_declared},
          {"frame_rate_hz", summary.frame_rate_hz},
          {"repeated_frames", summary.repeated_frames},
          {"scale_px_per_mm", summary.scale_px_per_mm},
          {"distortion_k1", summary.distortion_k1},
          {"distortion_k2", summary.distortion_k2},
          {"fiducials_given", summary.fiducials_given},
          {"fiducials_found", summary.fiducials_found},
          {"fiducials_used", summary.fiducials_used},
          {"calibration_rms_mm", summary.calibration_rms_mm},
          {"calibration_max_mm", summary.calibration_max_mm},
          {"calibration_leave_one_out_mm", summary.calibration_leave_one_out_rms_mm},
          {"calibration_leave_one_out_max_mm", summary.calibration_leave_one_out_max_mm},
          {"camera_shift_px", summary.camera_shift_px},
          {"particles", summary.particles},
          {"detections", summary.detections},
          {"completeness", summary.completeness},
          {"gaps", summary.gaps},
          {"suspected_swaps", summary.suspected_swaps},
          {"angle_jumps", summary.angle_jumps},
          {"pixel_error_px", summary.pixel_error_px},
          {"position_sigma_mm", summary.position_sigma_mm},
          {"angle_sigma_deg", summary.angle_sigma_deg},
          {"radius_learned_mm", summary.radius_learned_mm},
          {"radius_nominal_mm", summary.radius_nominal_mm},
          {"radius_spread_mm", summary.radius_spread_mm},
          {"separation_learned_mm", summary.separation_learned_mm},
          {"separation_nominal_mm", summary.separation_nominal_mm},
          {"separation_spread_mm", summary.separation_spread_mm},
          {"event_time_s", summary.event_time_s},
          {"event_time_sigma_s", summary.event_uncertainty_s},
          {"event_source", summary.event_source},
          {"noted_event_time_s", summary.noted_event_time_s},
          {"frames_per_second", summary.frames_per_second}};
}

Json bed_json(const tracking::BedSummary& bed) {
  return {{"particles_stated", bed.stated},
          {"particles_in_first_frame", bed.found_first},
          {"discharged", bed.discharged},
          {"remaining", bed.remaining},
          {"unaccounted", bed.unaccounted},
          {"filled_afterwards", bed.filled},
          {"lost_and_sought", bed.losses},
          {"size_ratio", bed.size_ratio},
          {"semi_major_learned_mm", bed.semi_major_learned_mm},
          {"semi_minor_learned_mm", bed.semi_minor_learned_mm},
          {"gravity_measured_m_per_s2", bed.gravity_measured},
          {"scan", bed.scan},
          {"sharpness", bed.sharpness},
          {"doubtful_frames", bed.doubtful_frames}};
}

// frame, time_s, x_m, z_m: the bed stands still (datasets/stagnant.h) from the floor up to z at x;
// nothing over the orifice.
void write_stagnant(const std::filesystem::path& file, const tracking::TrackedBed& bed) {
  datasets::Table table({"frame", "time_s", "x_m", "z_m"});
  for (std::size_t frame = 0; frame < bed.stagnant.height.size(); ++frame) {
    for (std::size_t i = 0; i < bed.stagnant.x.size(); ++i) {
      if (!std::isfinite(bed.stagnant.height[frame][i])) continue;
      table.add({std::to_string(frame),
                 datasets::number_text(bed.trajectories.time[frame]),
                 datasets::number_text(bed.stagnant.x[i]),
                 datasets::number_text(bed.stagnant.height[frame][i])});
    }
  }
  datasets::write_csv(file, table);
}

// What an earlier run left for this film; null where there is nothing or it is of another film or
// rig.
Json earlier_summary(const datasets::RunFolder& folder,
                     const std::string& name,
                     const std::string& hash) {
  if (!std::filesystem::exists(folder.tracking_of(name)) ||
      !std::filesystem::exists(folder.tracks(name)))
    return nullptr;
  Json summary = Json::parse(datasets::read_whole(folder.tracking_of(name)), nullptr, false);
  if (summary.is_discarded() || summary.value("hash", "") != hash) return nullptr;
  return summary;
}

Json track_film(const datasets::Experiment& experiment,
                const datasets::Replicate& replicate,
                const datasets::RunFolder& folder,
                const std::string& hash,
                const std::function<void(int, int)>& progress,
                const std::function<bool()>& stop) {
  tracking::TrackingOptions options;
  options.overlay_file = folder.overlay(replicate.name);
  options.annotated_first = folder.annotated_frame(replicate.name, "first");
  options.annotated_middle = folder.annotated_frame(replicate.name, "middle");
  options.annotated_last = folder.annotated_frame(replicate.name, "last");
  options.progress = progress;
  options.stop = stop;
  const datasets::Experiment recorded =
      tracking::as_recorded(datasets::as_filmed(experiment, replicate), replicate);
  Json summary;
  if (recorded.particle.plate) {
    const tracking::TrackedBed bed = tracking::track_bed(recorded, replicate, options);
    datasets::write_tracks(folder.tracks(replicate.name), bed.trajectories);
    if (!bed.stagnant.x.empty()) write_stagnant(folder.stagnant(replicate.name), bed);
    summary = summary_json(bed.summary, replicate);
    for (const char* of_balls : {"radius_learned_mm",
                                 "radius_nominal_mm",
                                 "radius_spread_mm",
                                 "separation_learned_mm",
                                 "separation_nominal_mm",
                                 "separation_spread_mm"})
      summary.erase(of_balls);
    summary["bed"] = bed_json(bed.bed);
  } else {
    const tracking::TrackedFilm film = tracking::track_video(recorded, replicate, options);
    datasets::write_tracks(folder.tracks(replicate.name), film.trajectories);
    summary = summary_json(film.summary, replicate);
    if (!tracking::nominal_shape(recorded).shows_angle()) {
      for (const char* of_pairs : {"angle_jumps",
                                   "angle_sigma_deg",
                                   "separation_learned_mm",
                                   "separation_nominal_mm",
                                   "separation_spread_mm"})
        summary.erase(of_pairs);
    }
  }
  for (const char* moment : {"first", "middle", "last"}) {
    const std::filesystem::path frame = folder.annotated_frame(replicate.name, moment);
    if (std::filesystem::exists(frame)) {
      summary["annotated_frames"].push_back(
          std::filesystem::relative(frame, folder.root).generic_string());
    }
  }
  // The summary is written last: its hash says that everything else of this film is there.
  summary["hash"] = hash;
  datasets::write_whole(folder.tracking_of(replicate.name), summary.dump(2) + "\n");
  return summary;
}

// What can be seen to be unusable before the work begins: tracks and curves that do not fit, and
// films of which no frame can be read. The tracks are empty where there is a film.
TrackedFilms look_at_inputs(const datasets::Experiment& experiment) {
  TrackedFilms films;
  films.is_smeared.assign(experiment.replicates.size(), 0);
  bool filmed = false;
  for (const datasets::Replicate& replicate : experiment.replicates) {
    films.recordings.push_back(read_given_data(experiment, replicate));
    if (replicate.video.empty()) continue;
    filmed = true;
    require_first_frame(experiment, replicate);
  }
  if (!filmed && !experiment.measurement.observables.empty())
    calibrate::make_problem(experiment, films.recordings);
  return films;
}

}  // namespace

TrackedFilms track_films(const datasets::Experiment& experiment,
                         const datasets::RunFolder& folder,
                         int jobs,
                         ProgressLine& progress) {
  const std::size_t count = experiment.replicates.size();
  TrackedFilms films = look_at_inputs(experiment);
  std::vector<Json> summaries(count);
  std::vector<std::string> hashes(count);
  std::vector<double> shares(count, 0.0);
  std::atomic<bool> failed = false;
  std::mutex mutex;
  const auto show = [&](std::size_t i, double share) {
    const std::lock_guard lock(mutex);
    shares[i] = share;
    double sum = 0.0;
    for (const double each : shares) sum += each;
    progress.show("tracking", sum / static_cast<double>(count), fmt::format("{} films", count));
  };

  // One film that cannot be used ends the work on the others.
  const auto stop = [&] { return failed || is_interrupted(); };
  const auto track = [&](std::size_t i, const datasets::Replicate& replicate) {
    const std::string corrections =
        replicate.corrections.empty() ? "" : datasets::file_hash(replicate.corrections);
    const std::string hash =
        hash_of(datasets::as_filmed(experiment, replicate), hashes[i] + corrections);
    summaries[i] = earlier_summary(folder, replicate.name, hash);
    if (!summaries[i].is_null()) return;
    const auto on_frame = [&](int frame, int total) {
      show(i, total > 0 ? static_cast<double>(frame) / total : 0.0);
    };
    try {
      summaries[i] = track_film(experiment, replicate, folder, hash, on_frame, stop);
    } catch (const tracking::Stopped&) {
      if (is_interrupted()) throw calibrate::Interrupted();
    } catch (...) {
      failed = true;
      throw;
    }
  };
  calibrate::parallel_for(static_cast<int>(count), jobs, [&](int index) {
    const auto i = static_cast<std::size_t>(index);
    const datasets::Replicate& replicate = experiment.replicates[i];
    const bool is_film = !replicate.video.empty();
    hashes[i] = datasets::file_hash(replicate.file());
    if (is_film) track(i, replicate);
    show(i, 1.0);
  });

  Json all = {{"replicates", Json::array()}};
  for (std::size_t i = 0; i < count; ++i) {
    const datasets::Replicate& replicate = experiment.replicates[i];
    const bool is_film = !replicate.video.empty();
    films.input_hashes[replicate.file().filename().string()] = hashes[i];
    if (!is_film) {
      if (!films.recordings[i].tracks) continue;
      const std::filesystem::path copy = folder.tracks(replicate.name);
      std::error_code error;
      if (!std::filesystem::equivalent(copy, replicate.tracks, error))
        datasets::write_tracks(copy, *films.recordings[i].tracks);
      continue;
    }
    // Always read back from the file, so that a resumed run works with the same bits as the first.
    films.recordings[i].tracks = datasets::read_tracks(folder.tracks(replicate.name));
    if (summaries[i].contains("bed")) {
      // Only its bed at rest can be followed, and it would look as if all else had left
      const Json& bed = summaries[i]["bed"];
      films.is_smeared[i] = bed["discharged"].get<int>() + bed["remaining"].get<int>() == 0;
    }
    for (const auto& warning : summaries[i]["warnings"]) {
      films.warnings.push_back(fmt::format("{}: {}", replicate.name, warning.get<std::string>()));
    }
    all["replicates"].push_back(std::move(summaries[i]));
  }
  datasets::write_whole(folder.tracking(), all.dump(2) + "\n");
  return films;
}

}  // namespace graintruth::app
