#include "tracking/track_bed.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "datasets/input_error.h"
#include "tracking/bed_tracks.h"
#include "tracking/clock.h"
#include "tracking/corrections.h"
#include "tracking/median.h"
#include "tracking/overlay.h"
#include "tracking/stagnant.h"
#include "tracking/video.h"

namespace graintruth::tracking {

using datasets::InputError;

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double degree = std::numbers::pi / 180.0;

void check(const datasets::Experiment& experiment) {
  const auto refuse = [&](const std::string& complaint) {
    throw InputError(fmt::format("{}: {}", experiment.file.string(), complaint));
  };
  if (!experiment.particle.plate)
    refuse("particle.plate is missing; a bed is tracked by the outline of its plates");
  if (!experiment.rig.bed) refuse("rig.kind must be 'flat_bin_orifice' to track a bed of plates");
  if (!experiment.rig.opening) refuse("rig.orifice_width_mm is missing");
}

// The camera, first and last picture of the film, and what the reader has to say of all of them.
struct Scouted {
  FilmCamera camera;
  cv::Mat first, last;
  int first_parity = -1;
  int frames = 0;
  double sharpness = 1.0;
  std::vector<std::string> warnings;
};

Scouted scout(VideoReader& video,
              const datasets::Experiment& experiment,
              const std::string& where) {
  Scouted scouted;
  SharpnessWatcher sharpness;
  cv::Mat frame;
  while (video.read(frame)) {
    if (scouted.frames++ == 0) {
      scouted.first = frame.clone();
      scouted.first_parity = video.parity();
      scouted.camera = calibrate_on(experiment, scouted.first, where);
      video.hold_steady(scouted.camera.sightings);
    }
    sharpness.add(frame);
    scouted.last = frame;
  }
  scouted.sharpness = sharpness.sharpness();
  scouted.last = scouted.last.clone();
  scouted.warnings = video.warnings();
  return scouted;
}

class BedTracker {
 public:
  BedTracker(const datasets::Experiment& experiment, const datasets::Replicate& replicate)
      : experiment_(experiment), replicate_(replicate) {
    summary_.replicate = replicate.name;
  }

  TrackedBed run(const TrackingOptions& options);

 private:
  void follow_plates(const TrackingOptions& options, TrackedBed& result);
  void map_stagnant_bed(const TrackingOptions& options, TrackedBed& result);
  void draw(const TrackingOptions& options, const TrackedBed& result);
  void look_at_film();
  void look_at_bed();
  void judge_size();
  double find_event(const BedTracks& tracks, int frames);
  datasets::Trajectories trajectories_of(const BedTracks& tracks, int frames, double zero);
  void count_plates(const BedTracks& tracks);
  void measure_gravity(const BedTracks& tracks);
  void judge();
  void warn(std::string sentence) { summary_.warn(std::move(sentence)); }
  void fail(std::string sentence) { summary_.fail(std::move(sentence)); }
  std::string where() const { return replicate_.video.string(); }

  const datasets::Experiment& experiment_;
  const datasets::Replicate& replicate_;
  Scouted scouted_;
  std::optional<BedScene> scene_;
  std::optional<FirstBed> first_;
  TrackingSummary summary_;
  BedSummary bed_;
};

void BedTracker::look_at_film() {
  VideoReader video(replicate_.video, experiment_.camera.frame_rate);
  scouted_ = scout(video, experiment_, where());
  summary_.width = video.width();
  summary_.height = video.height();
  summary_.frames_declared = video.declared_frames();
  summary_.frames_read = summary_.frames_used = scouted_.frames;
  summary_.frame_rate_hz = experiment_.camera.frame_rate;
  summary_.frame_rate_declared_hz = video.declared_frame_rate();
  summary_.repeated_frames = video.repeated_frames();
  for (std::string& sentence : scouted_.warnings) warn(std::move(sentence));
  describe_steadiness(*video.steady(), summary_);
  bed_.scan = video.scan() == Scan::progressive       ? "progressive"
              : video.scan() == Scan::even_rows_first ? "even rows first"
                                                      : "odd rows first";
  bed_.sharpness = scouted_.sharpness;
  constexpr int fewest = 4;
  if (scouted_.frames < fewest) {
    throw InputError(
        fmt::format("{}: the film has only {} frames; it must show the bed at rest "
                    "and its discharge",
                    where(),
                    scouted_.frames));
  }
}

void BedTracker::look_at_bed() {
  scene_ =
      prepare_bed(experiment_, std::move(scouted_.camera), scouted_.first, scouted_.last, where());
  describe_camera(scene_->film, experiment_, scene_->pixel(), summary_);
  summary_.scale_px_per_mm = 1.0e-3 / scene_->pixel();
  constexpr double least_changed = 0.01;  // of the bin: two or three plates of two hundred
  if (scene_->changed < least_changed) {
    throw InputError(fmt::format(
        "{}: nothing leaves the bin between the first and the last frame ({:.1f} % of it looks "
        "different); the film must show plates running out, and the rig's measures must fit it",
        where(),
        100.0 * scene_->changed));
  }
  first_ = find_bed(*scene_, scouted_.first, scouted_.first_parity);
  bed_.stated = experiment_.particle.count;
  bed_.found_first = static_cast<int>(first_->plates.size());
  if (first_->plates.empty()) {
    throw InputError(fmt::format(
        "{}: no plate of {:.1f} mm x {:.1f} mm (half axes) was found in the first frame; check "
        "the film, the particle's size and the fiducials",
        where(),
        1.0e3 * scene_->shape.semi_major,
        1.0e3 * scene_->shape.semi_minor));
  }
  if (bed_.found_first != bed_.stated) {
    fail(fmt::format(
        "Frame 0 shows {} particles but the experiment says {}.", bed_.found_first, bed_.stated));
  }
  judge_size();
}

// Contacts tell the size best: neighbours at rest touch. Where too few do, outlines tell it to some
// per cent, because rims are rounded and shaded.
void BedTracker::judge_size() {
  // A bed whose neighbours are all further apart than their outlines say rests on no contacts.
  constexpr double agreement = 0.05;
  const bool has_contacts = std::abs(first_->contact_scale / first_->edge_radius - 1.0) < agreement;
  bed_.size_ratio = has_contacts ? first_->contact_scale : first_->edge_radius;
  bed_.semi_major_learned_mm = 1.0e3 * bed_.size_ratio * scene_->shape.semi_major;
  bed_.semi_minor_learned_mm = 1.0e3 * bed_.size_ratio * scene_->shape.semi_minor;
  const double tolerance = has_contacts ? 0.02 : 0.035;
  if (std::abs(bed_.size_ratio - 1.0) < tolerance) return;
  warn(
      fmt::format("The plates look {:.2f} mm x {:.2f} mm (half axes; told by {}) but the "
                  "experiment says {:.2f} mm x {:.2f} mm ({:+.1f} %): check the particle's size "
                  "and the fiducials' positions.",
                  bed_.semi_major_learned_mm,
                  bed_.semi_minor_learned_mm,
                  has_contacts ? "their contacts" : "their outlines",
                  1.0e3 * scene_->shape.semi_major,
                  1.0e3 * scene_->shape.semi_minor,
                  100.0 * (bed_.size_ratio - 1.0)));
}

// Time zero in seconds of film: the plates that lie over the orifice fall freely once it opens, so
// the square root of their mean drop is a straight line,  sqrt(drop) = sqrt(c / 2) (t - t0).
double BedTracker::find_event(const BedTracks& tracks, int frames) {
  const double interval = 1.0 / experiment_.camera.frame_rate;
  const auto& noted = experiment_.camera.noted_event_time;
  summary_.noted_event_time_s = noted.value_or(nan);
  const double half = 0.35 * experiment_.rig.opening->width();
  const double pixel = scene_->pixel();
  const double row_height = 2.0 * scene_->shape.semi_major;
  std::vector<const PlateTrack*> over;
  for (const PlateTrack& track : tracks.tracks()) {
    if (track.sightings.empty() || !track.sightings[0]) continue;
    const datasets::Pose& rest = track.sightings[0]->pose;
    if (std::abs(rest.x) < half && rest.z < row_height) over.push_back(&track);
  }
  const auto drop_at = [&](int frame) {
    std::vector<double> drops;
    const auto k = static_cast<std::size_t>(frame);
    for (const PlateTrack* track : over)
      if (track->sightings.size() > k && track->sightings[k])
        drops.push_back(track->sightings[0]->pose.z - track->sightings[k]->pose.z);
    return drops.size() * 2 > over.size() ? median(drops) : nan;
  };
  std::optional<double> time;
  double uncertainty = interval;
  std::vector<double> times, roots;
  const double least = 0.4 * pixel, most = 0.5 * scene_->shape.semi_major;
  for (int frame = 1; frame < frames && !over.empty(); ++frame) {
    const double drop = drop_at(frame);
    if (!(drop > least)) {
      if (!times.empty() && !(drop > least)) break;
      continue;
    }
    if (drop > most && times.size() >= 2) break;
    times.push_back(frame * interval);
    roots.push_back(std::sqrt(drop));
    if (drop > most) break;
  }
  if (times.size() >= 2) {
    double mean_t = 0.0, mean_r = 0.0, tt = 0.0, tr = 0.0;
    const auto n = static_cast<double>(times.size());
    for (std::size_t i = 0; i < times.size(); ++i) {
      mean_t += times[i] / n;
      mean_r += roots[i] / n;
    }
    for (std::size_t i = 0; i < times.size(); ++i) {
      tt += (times[i] - mean_t) * (times[i] - mean_t);
      tr += (times[i] - mean_t) * (roots[i] - mean_r);
    }
    const double slope = tr / tt;
    if (slope > 0.0) {
      time = mean_t - mean_r / slope;
      double square = 0.0;
      for (std::size_t i = 0; i < times.size(); ++i)
        square += std::pow(roots[i] - slope * (times[i] - *time), 2);
      const double scatter = std::sqrt(square / std::max(1.0, n - 2.0)) / slope;
      // The lid takes a moment to leave, and plates rub: a fifth of a frame at least
      uncertainty =
          std::max(0.2 * interval, scatter * std::sqrt(1.0 / n + std::pow(mean_t - *time, 2) / tt));
    }
  }
  if (time && *time > 0.5 * interval) {
    summary_.event_source = "plates over the orifice";
    if (noted && std::abs(*time - *noted) > 3.0 * uncertainty + 0.5 * interval) {
      warn(
          fmt::format("The orifice opens at {:.3f} s of film (+- {:.3f} s, {}), but {:.3f} s was "
                      "noted.",
                      *time,
                      uncertainty,
                      summary_.event_source,
                      *noted));
    }
  } else {
    const char* what = time ? "The film starts after the orifice has opened"
                            : "No plate over the orifice is seen to start falling";
    // Where the bed moves from the first frame on, a noted time cannot be right either.
    const bool use_noted = noted && !time;
    time = use_noted ? *noted : 0.0;
    uncertainty = interval;
    summary_.event_source = use_noted ? "noted by the laboratory" : "first frame of the film";
    fail(fmt::format(
        "{}: times count from {:.3f} s of film ({}).", what, *time, summary_.event_source));
  }
  summary_.event_time_s = *time;
  summary_.event_uncertainty_s = uncertainty;
  return *time;
}

datasets::Trajectories BedTracker::trajectories_of(const BedTracks& tracks,
                                                   int frames,
                                                   double zero) {
  const auto count = static_cast<int>(tracks.tracks().size());
  datasets::Trajectories out =
      datasets::make_trajectories(static_cast<std::size_t>(frames), count, true);
  for (int k = 0; k < frames; ++k)
    out.time[static_cast<std::size_t>(k)] = k / experiment_.camera.frame_rate - zero;
  const std::array<Eigen::Vector3d, 3> inflation = {tracks.variance_inflation(Pace::rest),
                                                    tracks.variance_inflation(Pace::slow),
                                                    tracks.variance_inflation(Pace::fast)};
  std::vector<double> position_sigmas, angle_sigmas, residuals;
  double score_sum = 0.0, least = 1.0;
  long expected = 0;
  for (std::size_t p = 0; p < tracks.tracks().size(); ++p) {
    const PlateTrack& track = tracks.tracks()[p];
    const int present = track.left_at >= 0 ? track.left_at : frames;
    int detections = 0;
    for (int k = 0; k < present; ++k) {
      const auto frame = static_cast<std::size_t>(k);
      const bool seen = track.sightings.size() > frame && track.sightings[frame];
      if (!seen) {
        const bool gap_starts =
            k == 0 || (track.sightings.size() > frame - 1 && track.sightings[frame - 1]);
        summary_.gaps += gap_starts;
        continue;
      }
      ++detections;
      const PlateSighting& sighting = *track.sightings[frame];
      Eigen::Vector3d variance = sighting.covariance.diagonal().cwiseProduct(
          inflation[static_cast<std::size_t>(sighting.pace)]);
      variance.head<2>() +=
          scene_->film.calibration.point_covariance(sighting.pose.x, sighting.pose.z).diagonal();
      // The outline's height above the plane is known to the quarter of the thickness that
      // separates both ends of its range (uniform: over the square root of three).
      const Eigen::Vector3d camera = scene_->film.calibration.camera.position();
      const double slant = scene_->plate_height / std::numbers::sqrt3 / camera.z();
      variance[0] += std::pow(slant * (sighting.pose.x - camera.x()), 2);
      variance[1] += std::pow(slant * (sighting.pose.z - camera.y()), 2);
      const std::size_t i = out.index(frame, p);
      const bool turned = experiment_.particle.plate->shows_angle();
      out.poses[i] = {sighting.pose.x, sighting.pose.z, turned ? sighting.pose.angle : nan};
      out.sigmas[i] = {
          std::sqrt(variance[0]), std::sqrt(variance[1]), turned ? std::sqrt(variance[2]) : nan};
      out.scores[i] = std::clamp(static_cast<double>(sighting.score), 0.0, 1.0);
      score_sum += out.scores[i];
      bed_.filled += sighting.filled;
      position_sigmas.push_back(std::sqrt(0.5 * (variance[0] + variance[1])));
      angle_sigmas.push_back(out.sigmas[i].angle);
    }
    summary_.detections += detections;
    expected += present;
    if (present > 0) least = std::min(least, static_cast<double>(detections) / present);
  }
  summary_.particles = count;
  summary_.completeness = expected > 0 ? summary_.detections / static_cast<double>(expected) : 0.0;
  summary_.least_complete_particle = least;
  summary_.mean_score = summary_.detections > 0 ? score_sum / summary_.detections : 0.0;
  summary_.position_sigma_mm = 1.0e3 * median(position_sigmas, nan);
  summary_.pixel_error_px = summary_.position_sigma_mm * summary_.scale_px_per_mm;
  summary_.angle_sigma_deg = median(angle_sigmas, nan) / degree;
  return out;
}

// n_in + n_out = N0: whoever is neither seen in the bin at the end nor has crossed the floor's
// level is unaccounted for.
void BedTracker::count_plates(const BedTracks& tracks) {
  for (const PlateTrack& track : tracks.tracks()) {
    double lowest = 1.0e9;
    bool at_end = false;
    for (std::size_t k = 0; k < track.sightings.size(); ++k) {
      if (!track.sightings[k]) continue;
      lowest = std::min(lowest, track.sightings[k]->pose.z);
      at_end = static_cast<int>(k) + 1 == scouted_.frames;
    }
    if (lowest < 0.0)
      ++bed_.discharged;
    else if (at_end)
      ++bed_.remaining;
    else
      ++bed_.unaccounted;
  }
  bed_.losses = tracks.losses();
  bed_.doubtful_frames = tracks.doubtful_frames();
}

// Second differences of the heights of plates below the floor: the clock and the scale against g.
void BedTracker::measure_gravity(const BedTracks& tracks) {
  const double rate = experiment_.camera.frame_rate;
  std::vector<double> accelerations;
  for (const PlateTrack& track : tracks.tracks()) {
    for (std::size_t k = 2; k < track.sightings.size(); ++k) {
      const auto &a = track.sightings[k - 2], &b = track.sightings[k - 1], &c = track.sightings[k];
      if (!a || !b || !c || a->pose.z > -scene_->shape.semi_major) continue;
      accelerations.push_back(-(a->pose.z - 2.0 * b->pose.z + c->pose.z) * rate * rate);
    }
  }
  constexpr std::size_t enough = 20;
  bed_.gravity_measured = accelerations.size() < enough ? nan : median(accelerations);
  const double stated = experiment_.rig.gravity;
  if (std::isfinite(bed_.gravity_measured) &&
      std::abs(bed_.gravity_measured / stated - 1.0) > 0.15) {
    warn(
        fmt::format("Plates fall at {:.2f} m/s2 below the orifice but gravity is {:.2f} m/s2: "
                    "frame rate or scale is wrong.",
                    bed_.gravity_measured,
                    stated));
  }
}

void BedTracker::judge() {
  if (bed_.unaccounted > 0) {
    fail(fmt::format("{} particle(s) were lost inside the bin: {} left and {} remain of {}.",
                     bed_.unaccounted,
                     bed_.discharged,
                     bed_.remaining,
                     bed_.found_first));
  }
  if (!bed_.doubtful_frames.empty())
    warn(fmt::format("Not all particles were found in {} {}.",
                     bed_.doubtful_frames.size() == 1 ? "frame" : "frames",
                     listed(bed_.doubtful_frames)));
  constexpr double least_complete = 0.98;
  if (bed_.sharpness >= least_sharpness && summary_.completeness < least_complete) {
    fail(fmt::format("Only {:.1f} % of all poses were found.", 100.0 * summary_.completeness));
  }
}

void BedTracker::follow_plates(const TrackingOptions& options, TrackedBed& result) {
  VideoReader video(replicate_.video, experiment_.camera.frame_rate);
  video.hold_steady(scene_->film.sightings);
  std::optional<BedTracks> tracks;
  cv::Mat frame;
  while (video.read(frame)) {
    const int number = video.frames_read() - 1;
    if (number == 0)
      tracks.emplace(*scene_, *first_, frame);
    else
      tracks->follow(frame, number, video.parity());
    if (options.progress) options.progress(video.frames_read(), video.declared_frames());
    if (options.stop && options.stop()) throw Stopped{};
  }
  const double zero = find_event(*tracks, scouted_.frames);
  result.trajectories = trajectories_of(*tracks, scouted_.frames, zero);
  count_plates(*tracks);
  measure_gravity(*tracks);
  for (std::string& sentence :
       describe(find_clock_faults(result.trajectories, scene_->pixel()), summary_.repeated_frames))
    warn(std::move(sentence));
}

// A shutter that stays open too long smears whatever moves: what stands still is all that such a
// film can tell.
void BedTracker::map_stagnant_bed(const TrackingOptions& options, TrackedBed& result) {
  VideoReader video(replicate_.video, experiment_.camera.frame_rate);
  video.hold_steady(scene_->film.sightings);
  StagnantWatcher watcher(*scene_);
  OrificeWatcher orifice(*scene_, scouted_.first);
  int opened_at = -1;
  cv::Mat frame;
  while (video.read(frame)) {
    watcher.add(frame, video.parity());
    if (opened_at < 0 && orifice.is_open(frame)) opened_at = video.frames_read() - 1;
    if (options.progress) options.progress(video.frames_read(), video.declared_frames());
    if (options.stop && options.stop()) throw Stopped{};
  }
  const double orifice_width = experiment_.rig.opening->width();
  result.stagnant.frames_apart = watcher.pictures_apart();
  result.stagnant.maps = watcher.maps();
  for (const datasets::StagnantMap& map : result.stagnant.maps) {
    result.stagnant.x = map.x;
    result.stagnant.height.push_back(datasets::stagnant_heights(map, orifice_width));
  }
  const double interval = 1.0 / experiment_.camera.frame_rate;
  summary_.noted_event_time_s = experiment_.camera.noted_event_time.value_or(nan);
  summary_.event_source = "first change below the orifice";
  summary_.event_time_s = std::max(0, opened_at) * interval;
  summary_.event_uncertainty_s = interval;
  const auto frames = static_cast<std::size_t>(scouted_.frames);
  datasets::Trajectories& out = result.trajectories;
  out = datasets::make_trajectories(frames, bed_.found_first, true);
  std::vector<Eigen::Vector2d> centres;
  for (const PlateFit& plate : first_->plates) centres.emplace_back(plate.pose.x, plate.pose.z);
  const std::vector<std::size_t> until = watcher.stay_until(centres);
  for (std::size_t k = 0; k < frames; ++k) {
    out.time[k] = static_cast<double>(k) * interval - summary_.event_time_s;
    for (std::size_t p = 0; p < first_->plates.size(); ++p) {
      const PlateFit& plate = first_->plates[p];
      if (k >= until[p]) continue;
      const std::size_t i = out.index(k, p);
      const Eigen::Vector3d sigma = plate.covariance.diagonal().cwiseSqrt();
      const bool turned = experiment_.particle.plate->shows_angle();
      out.poses[i] = {plate.pose.x, plate.pose.z, turned ? plate.pose.angle : nan};
      out.sigmas[i] = {sigma[0], sigma[1], turned ? sigma[2] : nan};
      out.scores[i] = plate.score;
      ++summary_.detections;
    }
  }
  summary_.particles = bed_.found_first;
  summary_.completeness =
      summary_.detections / (static_cast<double>(frames) * std::max(1, bed_.found_first));
  warn(fmt::format(
      "Plates in motion are smeared (moving edges are {:.0f} % as sharp as resting ones): they "
      "were not tracked. The film gives the part of the bed that stands still; use a shorter "
      "exposure to track the flow.",
      100.0 * bed_.sharpness));
}

void BedTracker::draw(const TrackingOptions& options, const TrackedBed& result) {
  Findings findings{.camera = &scene_->film.calibration.camera,
                    .trajectories = &result.trajectories,
                    .fiducials = scene_->film.sightings,
                    .plate = scene_->shape};
  const int frames = scouted_.frames;
  const int event_frame = std::clamp(
      static_cast<int>(std::lround(summary_.event_time_s * summary_.frame_rate_hz)), 0, frames - 1);
  OverlayFiles files;
  files.film = options.overlay_file;
  files.frame_rate = experiment_.camera.frame_rate;
  files.stills = {{0, options.annotated_first},
                  {(event_frame + frames - 1) / 2, options.annotated_middle},
                  {frames - 1, options.annotated_last}};
  if (!draw_overlay(replicate_.video, findings, files, options.stop)) throw Stopped{};
}

TrackedBed BedTracker::run(const TrackingOptions& options) {
  const auto started = std::chrono::steady_clock::now();
  check(experiment_);
  TrackedBed result;
  // 1. The film from end to end: its clock, its sharpness, its first and its last picture
  look_at_film();
  // 2. Camera, contrast, and the bed at rest
  look_at_bed();
  // 3. Every plate from frame to frame; or, where they are smeared, where they stand still
  if (bed_.sharpness < least_sharpness)
    map_stagnant_bed(options, result);
  else
    follow_plates(options, result);
  // 4. Repairs by hand, and how good the result is
  if (!replicate_.corrections.empty()) {
    for (std::string& sentence :
         apply_corrections(replicate_.corrections, scene_->pixel(), result.trajectories))
      warn(std::move(sentence));
  }
  judge();
  summary_.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  summary_.frames_per_second = scouted_.frames / summary_.seconds;
  result.summary = summary_;
  result.bed = bed_;
  // 5. The findings drawn on the film, outside the clock
  draw(options, result);
  return result;
}

}  // namespace

TrackedBed track_bed(const datasets::Experiment& experiment,
                     const datasets::Replicate& replicate,
                     const TrackingOptions& options) {
  cv::setNumThreads(1);  // films are tracked side by side
  return BedTracker(experiment, replicate).run(options);
}

}  // namespace graintruth::tracking
