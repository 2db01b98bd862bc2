#include "app/run/films.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <nlohmann/json.hpp>

#include "app/run/first_frame.h"
#include "app/run/given_data.h"
#include "app/run/interrupt.h"
#include "app/run/numbering.h"
#include "app/run/same_recording.h"
#include "calibrate/ensemble.h"
#include "calibrate/knowledge/outline_doubts.h"
#include "calibrate/problem.h"
#include "datasets/experiment/tracking_spec.h"
#include "datasets/store/fingerprint.h"
#include "datasets/store/table.h"
#include "tracking/film/recording.h"
#include "tracking/registry.h"
#include "tracking/track_film.h"

namespace graintruth::app {

namespace {

using Json = nlohmann::ordered_json;

Json summary_json(const tracking::TrackingSummary& summary, const datasets::Film& film) {
  Json json = {{"name", film.name},
               {"film", film.video.filename().string()},
               {"grade", tracking::to_string(summary.grade)},
               {"warnings", summary.warnings},
               {"failures", summary.failures},
               {"findings", summary.findings},
               {"width_px", summary.width},
               {"height_px", summary.height},
               {"frames", summary.frames_read},
               {"frames_declared", summary.frames_declared},
               {"frame_rate_hz", summary.frame_rate_hz},
               {"repeated_frames", summary.repeated_frames},
               {"scale_px_per_mm", summary.scale_px_per_mm},
               {"distortion_k1", summary.distortion_k1},
               {"distortion_k2", summary.distortion_k2},
               {"scale_from", fmt::format("{} {}", summary.references_found, summary.references)},
               {summary.references + "_given", summary.references_given},
               {summary.references + "_found", summary.references_found},
               {summary.references + "_used", summary.references_used},
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
               {"pixel_error_px", summary.pixel_error_px},
               {"position_sigma_mm", summary.position_sigma_mm}};
  if (summary.shows_angle) {
    json["angle_jumps"] = summary.angle_jumps;
    json["angle_sigma_deg"] = summary.angle_sigma_deg;
  }
  json["event_time_s"] = summary.event_time_s;
  json["event_time_sigma_s"] = summary.event_uncertainty_s;
  json["event_source"] = summary.event_source;
  json["noted_event_time_s"] = summary.noted_event_time_s;
  json["frames_per_second"] = summary.frames_per_second;
  return json;
}

// What proves that files of a film are those that its tracking left; only in tracks/<film>.json.
constexpr const char* file_hashes = "files";
constexpr const char* own_checksum = "checksum";

// What an earlier run left for this film.
struct EarlierTracks {
  Json summary;             // null where it cannot be used
  std::string complaint;    // why; empty where there is nothing
  bool is_damaged = false;  // files were changed, not what is asked for
};

// Says what is wrong with the files; empty where nothing is.
std::string changed_file(const datasets::RunFolder& folder, const Json& summary) {
  const auto files = summary.find(file_hashes);
  if (files == summary.end() || !files->is_object()) return "it was tracked by an earlier version";
  Json bare = summary;
  bare.erase(own_checksum);
  if (summary.value(own_checksum, "") != datasets::content_hash(bare.dump()))
    return "its record was changed after it was written";
  for (const auto& [name, hash] : files->items()) {
    const std::filesystem::path file = folder.tracks("").parent_path() / name;
    if (!std::filesystem::exists(file)) return fmt::format("tracks/{} is gone", name);
    if (hash != datasets::file_hash(file)) {
      return fmt::format(
          "tracks/{} was changed after it was written. Changes by hand belong in a file of "
          "corrections",
          name);
    }
  }
  return {};
}

EarlierTracks earlier_tracks(const datasets::RunFolder& folder,
                             const std::string& name,
                             const std::string& hash) {
  const std::filesystem::path file = folder.tracking_of(name);
  if (!std::filesystem::exists(file)) return {};
  Json summary = Json::parse(datasets::read_whole(file), nullptr, false);
  if (!summary.is_object()) return {nullptr, "its record is cut off or holds something else", true};
  if (!summary.contains("hash") || summary["hash"] != hash)
    return {nullptr, "the film, its corrections or what is said of it have changed", false};
  if (std::string complaint = changed_file(folder, summary); !complaint.empty())
    return {nullptr, std::move(complaint), true};
  summary.erase(file_hashes);
  summary.erase(own_checksum);
  return {std::move(summary), {}, false};
}

// tracks/<film>.outline.csv; what an outline's eye is called in tracking.json
constexpr const char* outline_name = "outline";

// What tracking a film left: always read back, so that a resumed run works with the same bits as
// the first.
void read_back(const datasets::RunFolder& folder,
               const datasets::TrackingSpec& spec,
               const std::string& film,
               const Json& summary,
               datasets::Recording& recording) {
  if (!spec.rig.outline) {
    recording.tracks = datasets::read_tracks(folder.tracks(film));
    return;
  }
  recording.outlines = datasets::read_outlines(folder.film_table(film, outline_name));
  const Json& eye = summary["outline"]["eye_m"];
  for (datasets::Outline& outline : recording.outlines)
    outline.eye = {eye["x"].get<double>(), eye["z"].get<double>(), eye["distance"].get<double>()};
}

Json track_film(const datasets::TrackingSpec& spec,
                const datasets::Film& film,
                const datasets::RunFolder& folder,
                const std::string& hash,
                const std::function<void(int, int)>& progress,
                const std::function<bool()>& stop) {
  tracking::TrackingOptions options;
  options.overlay_file = folder.overlay(film.name);
  options.annotated_first = folder.annotated_frame(film.name, "first");
  options.annotated_middle = folder.annotated_frame(film.name, "middle");
  options.annotated_last = folder.annotated_frame(film.name, "last");
  options.progress = progress;
  options.stop = stop;
  const datasets::TrackingSpec recorded = tracking::as_recorded(spec, film.video);
  const auto tracker = tracking::make_tracker(recorded, film);
  const tracking::TrackedFilm tracked = tracking::track_film(*tracker, recorded, film, options);
  std::vector<std::filesystem::path> files;
  if (const auto outlines = tracker->outlines(); !outlines.empty()) {
    files.push_back(folder.film_table(film.name, outline_name));
    datasets::write_outlines(files.back(), outlines);
  } else {
    files.push_back(folder.tracks(film.name));
    datasets::write_tracks(files.back(), tracked.trajectories);
  }
  for (const auto& [name, table] : tracker->tables()) {
    files.push_back(folder.film_table(film.name, name));
    datasets::write_csv(files.back(), table);
  }
  Json summary = summary_json(tracked.summary, film);
  tracker->describe(summary);
  for (const char* moment : {"first", "middle", "last"}) {
    const std::filesystem::path frame = folder.annotated_frame(film.name, moment);
    if (std::filesystem::exists(frame)) {
      summary["annotated_frames"].push_back(
          std::filesystem::relative(frame, folder.root).generic_string());
    }
  }
  // The summary is written last: its hash says that everything else of this film is there, and the
  // hashes of the files that they are as they were.
  summary["hash"] = hash;
  Json record = summary;
  for (const std::filesystem::path& file : files)
    record[file_hashes][file.filename().string()] = datasets::file_hash(file);
  record[own_checksum] = datasets::content_hash(record.dump());
  datasets::write_whole(folder.tracking_of(film.name), record.dump(2) + "\n");
  // With the digits that a later run reads back
  return Json::parse(summary.dump());
}

std::vector<datasets::Recording> recordings_of(const std::vector<GivenData>& given) {
  std::vector<datasets::Recording> recordings;
  for (const GivenData& one : given) recordings.push_back(one.recording);
  return recordings;
}

// What can be seen to be unusable before the work begins: tracks and curves that do not fit, films
// that nobody can follow or of which no frame can be read. The tracks are empty where there is a
// film.
std::vector<GivenData> look_at_inputs(const datasets::Experiment& experiment,
                                      std::vector<std::optional<datasets::TrackingSpec>>& specs) {
  std::vector<GivenData> given;
  bool filmed = false;
  for (const datasets::Replicate& replicate : experiment.replicates) {
    given.push_back(read_given_data(experiment, replicate));
    specs.emplace_back();
    if (replicate.video.empty()) continue;
    filmed = true;
    const datasets::Film film = datasets::film_of(experiment, replicate);
    specs.back() = datasets::make_tracking_spec(experiment, replicate);
    tracking::make_tracker(*specs.back(), film);
    require_first_frame(*specs.back(), film);
  }
  number_alike(experiment, given);
  const std::vector<datasets::Recording> recordings = recordings_of(given);
  require_different(experiment, recordings);
  if (!filmed && !experiment.measurement.observables.empty())
    calibrate::check_recordings(experiment, recordings);
  return given;
}

// Films whose particles give those of other replicates their numbers.
std::vector<char> which_give_numbers(const datasets::Experiment& experiment) {
  std::vector<char> gives(experiment.replicates.size(), 0);
  if (!experiment.starts.empty() || !are_numbered_alike(experiment)) return gives;
  for (std::size_t i = 0; i < gives.size(); ++i) {
    const std::size_t like = numbered_like(experiment, i);
    if (like != i) gives[like] = 1;
  }
  return gives;
}

// What trackers learn of the grains, by its key in tracking.json.
void add_seen(const std::vector<Json>& summaries, std::vector<calibrate::RepeatedQuantity>& seen) {
  constexpr double millimetre = 1e-3;
  for (const auto& [key, name] :
       {std::pair("radius_learned_mm", "radius of the balls"),
        std::pair("separation_learned_mm", "distance of the two balls")}) {
    calibrate::RepeatedQuantity quantity{.name = name, .unit = "m"};
    bool is_known = false;
    for (const Json& summary : summaries) {
      std::vector<double>& values = quantity.values.emplace_back();
      if (!summary.is_object() || !summary.contains(key) || !summary[key].is_number()) continue;
      values.push_back(millimetre * summary[key].get<double>());
      is_known = true;
    }
    if (is_known) seen.push_back(std::move(quantity));
  }
}

// The first of a film that was not read well enough stands in the first line.
void add_warnings_of_film(const std::string& name,
                          const Json& summary,
                          std::vector<datasets::Warning>& warnings) {
  bool is_first = summary.value("grade", "") == tracking::to_string(tracking::Grade::fail);
  for (const auto& sentence : summary["warnings"]) {
    std::string text = fmt::format("{}: {}", name, sentence.get<std::string>());
    if (is_first) {
      warnings.push_back(
          datasets::first_line(std::move(text),
                               fmt::format("the film {} could not be read well", name),
                               fmt::format("Look at tracks/{}.overlay.mp4", name)));
    } else {
      warnings.emplace_back(std::move(text));
    }
    is_first = false;
  }
}

// Of every file that the replicate names.
void add_hashes(const datasets::Replicate& replicate,
                const std::optional<datasets::TrackingSpec>& spec,
                std::map<std::string, std::string>& hashes) {
  if (spec) hashes[replicate.video.filename().string()] = spec->film_hash;
  for (const std::filesystem::path& file : {replicate.tracks,
                                            replicate.outline,
                                            replicate.discharge,
                                            replicate.curves,
                                            replicate.corrections}) {
    if (!file.empty()) hashes[file.filename().string()] = datasets::file_hash(file);
  }
}

}  // namespace

TrackedFilms track_films(const datasets::Experiment& experiment,
                         const datasets::RunFolder& folder,
                         int jobs,
                         ProgressLine& progress) {
  const std::size_t count = experiment.replicates.size();
  std::vector<std::optional<datasets::TrackingSpec>> specs;  // of the films
  std::vector<GivenData> given = look_at_inputs(experiment, specs);
  std::vector<Json> summaries(count);
  std::vector<std::string> remade(count);  // why files of an earlier run were not used
  std::vector<double> shares(count, 0.0);
  std::atomic<bool> failed = false;
  std::mutex mutex;
  const auto filmed =
      std::count_if(specs.begin(), specs.end(), [](const auto& spec) { return spec.has_value(); });
  const auto show = [&](std::size_t i, double share) {
    const std::lock_guard lock(mutex);
    shares[i] = share;
    double sum = 0.0;
    for (const double each : shares) sum += each;
    if (filmed > 0)
      progress.show("tracking", sum / static_cast<double>(count), fmt::format("{} films", filmed));
  };

  // One film that cannot be used ends the work on the others.
  const auto stop = [&] { return failed || is_interrupted(); };
  const auto track = [&](std::size_t i) {
    const datasets::TrackingSpec& spec = *specs[i];
    const datasets::Film film = datasets::film_of(experiment, experiment.replicates[i]);
    const std::string hash = datasets::fingerprint(spec);
    EarlierTracks earlier = earlier_tracks(folder, film.name, hash);
    summaries[i] = std::move(earlier.summary);
    if (!summaries[i].is_null()) return;
    if (!earlier.complaint.empty()) {
      const std::string sentence =
          fmt::format("{} is tracked again: {}.", film.name, earlier.complaint);
      progress.say("Note: " + sentence);
      if (earlier.is_damaged) remade[i] = sentence;
    }
    const auto on_frame = [&](int frame, int total) {
      show(i, total > 0 ? static_cast<double>(frame) / total : 0.0);
    };
    try {
      summaries[i] = track_film(spec, film, folder, hash, on_frame, stop);
    } catch (const tracking::Stopped&) {
      if (is_interrupted()) throw calibrate::Interrupted();
    } catch (...) {
      failed = true;
      throw;
    }
  };
  const std::vector<char> gives_numbers = which_give_numbers(experiment);
  const auto track_those = [&](bool that_give_numbers) {
    calibrate::parallel_for(static_cast<int>(count), jobs, [&](int index) {
      const auto i = static_cast<std::size_t>(index);
      if (static_cast<bool>(gives_numbers[i]) != that_give_numbers) return;
      if (specs[i]) {
        track(i);
        if (summaries[i].is_null()) return;  // another film cannot be used
        read_back(
            folder, *specs[i], experiment.replicates[i].name, summaries[i], given[i].recording);
      }
      show(i, 1.0);
    });
  };
  // The first film of each kind gives the places, the others find their particles in them
  track_those(true);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t like = numbered_like(experiment, i);
    if (like == i || !gives_numbers[like] || !specs[i]) continue;
    if (auto places = places_in(experiment, given[like].recording))
      specs[i]->starts = *std::move(places);
  }
  number_alike(experiment, given);
  track_those(false);

  TrackedFilms films;
  films.recordings = recordings_of(given);
  films.is_smeared.assign(count, 0);
  films.event_times.assign(count, 0.0);
  films.doubts = compare_starts(experiment, films.recordings);
  for (datasets::Warning& doubt : calibrate::doubts_about_outlines(experiment, films.recordings))
    films.doubts.push_back(std::move(doubt));
  add_seen(summaries, films.seen);
  for (const std::string& note : experiment.notes) films.warnings.emplace_back(note);
  for (const datasets::Recording& recording : films.recordings)
    films.warnings.insert(films.warnings.end(), recording.notes.begin(), recording.notes.end());
  Json all = {{"replicates", Json::array()}, {"notes", experiment.notes}};
  for (std::size_t i = 0; i < count; ++i) {
    const datasets::Replicate& replicate = experiment.replicates[i];
    add_hashes(replicate, specs[i], films.input_hashes);
    for (const std::string& note : films.recordings[i].notes) all["notes"].push_back(note);
    if (!specs[i]) {
      if (!films.recordings[i].tracks) continue;
      const std::filesystem::path copy = folder.tracks(replicate.name);
      std::error_code error;
      if (!std::filesystem::equivalent(copy, replicate.tracks, error))
        datasets::write_tracks(copy, *films.recordings[i].tracks);
      continue;
    }
    films.event_times[i] = summaries[i].value("event_time_s", 0.0);
    if (summaries[i].contains("bed")) {
      // Only its bed at rest can be followed, and it would look as if all else had left
      const Json& bed = summaries[i]["bed"];
      const bool nobody = bed["discharged"].get<int>() + bed["remaining"].get<int>() == 0;
      films.is_smeared[i] = nobody ? 1 : 0;
    }
    if (!remade[i].empty()) films.warnings.push_back(remade[i]);
    if (const Json& reasons = summaries[i]["failures"]; !reasons.empty() && !films.is_smeared[i]) {
      std::string reason = reasons.front().get<std::string>();
      while (reason.ends_with('.')) reason.pop_back();
      films.failures.push_back(fmt::format("{} ({})", replicate.name, reason));
    }
    add_warnings_of_film(replicate.name, summaries[i], films.warnings);
    all["replicates"].push_back(std::move(summaries[i]));
  }
  datasets::write_whole(folder.tracking(), all.dump(2) + "\n");
  return films;
}

}  // namespace graintruth::app
