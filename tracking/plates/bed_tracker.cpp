#include "tracking/plates/bed_tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "datasets/store/input_error.h"
#include "tracking/film/clock.h"
#include "tracking/film/video.h"
#include "tracking/median.h"
#include "tracking/plates/plate_drawing.h"

namespace graintruth::tracking {

using datasets::InputError;

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double degree = std::numbers::pi / 180.0;

}  // namespace

BedTracker::BedTracker(const datasets::TrackingSpec& spec, const datasets::Film& film)
    : spec_(spec), film_(film), nominal_(plate_shape(spec.body)) {
  const auto refuse = [&](const std::string& complaint) {
    throw InputError(fmt::format("{}: {}", film.experiment.string(), complaint));
  };
  if (!(spec.rig.box->opening > 0.0)) refuse("rig.orifice_width_mm is missing");
  if (!spec.body.count) refuse("particle.count is missing; a bed is counted");
}

// The first and the last picture of the film, and how sharp it is.
void BedTracker::look_ahead(const Picture& picture, const FilmCamera& /*camera*/) {
  if (pictures_++ == 0) first_picture_ = {picture.frame.clone(), 0, picture.parity};
  sharpness_.add(picture.frame);
  picture.frame.copyTo(last_picture_.frame);
}

void BedTracker::find_first(const Picture& picture,
                            const FilmCamera& camera,
                            TrackingSummary& summary) {
  const std::string where = film_.video.string();
  bed_.sharpness = sharpness_.sharpness();
  bed_.scan = picture.parity < 0    ? "progressive"
              : picture.parity == 0 ? "even rows first"
                                    : "odd rows first";
  constexpr int fewest = 4;
  if (pictures_ < fewest) {
    throw InputError(
        fmt::format("{}: the film has only {} frames; it must show the bed at rest "
                    "and its discharge",
                    where,
                    pictures_));
  }
  // 1. The box, and how plates differ from the ground
  const cv::Mat& first = first_picture_.frame;
  scene_ = prepare_bed(spec_, camera, first, last_picture_.frame, where);
  summary.scale_px_per_mm = 1.0e-3 / scene_->pixel();
  constexpr double least_changed = 0.01;  // of the bin: two or three plates of two hundred
  if (scene_->changed < least_changed) {
    throw InputError(fmt::format(
        "{}: nothing leaves the bin between the first and the last frame ({:.1f} % of it looks "
        "different); the film must show plates running out, and the rig's measures must fit it",
        where,
        100.0 * scene_->changed));
  }
  // 2. The bed at rest
  first_ = find_bed(*scene_, first, first_picture_.parity);
  bed_.stated = *spec_.body.count;
  bed_.found_first = static_cast<int>(first_->plates.size());
  if (first_->plates.empty()) {
    throw InputError(
        fmt::format("{}: no plate of {:.1f} mm x {:.1f} mm (half axes) was found in the first "
                    "frame; check the film, the particle's size and the scale",
                    where,
                    1.0e3 * nominal_.semi_major,
                    1.0e3 * nominal_.semi_minor));
  }
  if (bed_.found_first != bed_.stated) {
    summary.fail(fmt::format(
        "Frame 0 shows {} particles but the experiment says {}.", bed_.found_first, bed_.stated));
  }
  judge_size(summary);
  // 3. Every plate from frame to frame; or, where they are smeared, where they stand still
  if (is_smeared()) {
    still_.emplace(*scene_);
    orifice_.emplace(*scene_, first);
    follow(picture);
  } else {
    tracks_.emplace(*scene_, *first_, picture.frame);
  }
}

void BedTracker::follow(const Picture& picture) {
  if (tracks_) {
    tracks_->follow(picture.frame, picture.number, picture.parity);
    return;
  }
  still_->add(picture.frame, picture.parity);
  if (opened_at_ < 0 && orifice_->is_open(picture.frame)) opened_at_ = picture.number;
}

datasets::Trajectories BedTracker::finish(TrackingSummary& summary) {
  summary.shows_angle = scene_->shape.shows_angle();
  datasets::Trajectories out;
  if (tracks_) {
    const double zero = find_event(summary.frames_read, summary);
    out = trajectories_of(zero, summary);
    count_plates(summary.frames_read);
    measure_gravity(summary);
    for (std::string& sentence : tracking::describe(
             find_clock_faults(out, scene_->pixel(), summary.clock), summary.repeated_frames))
      summary.warn(std::move(sentence));
  } else {
    out = resting_plates(summary);
  }
  judge(summary);
  time_ = out.time;
  return out;
}

// Contacts tell the size best: neighbours at rest touch. Where too few do, outlines tell it to some
// per cent, because rims are rounded and shaded.
void BedTracker::judge_size(TrackingSummary& summary) {
  // A bed whose neighbours are all further apart than their outlines say rests on no contacts.
  constexpr double agreement = 0.05;
  const bool has_contacts = std::abs(first_->contact_scale / first_->edge_radius - 1.0) < agreement;
  bed_.size_ratio = has_contacts ? first_->contact_scale : first_->edge_radius;
  bed_.semi_major_learned_mm = 1.0e3 * bed_.size_ratio * scene_->shape.semi_major;
  bed_.semi_minor_learned_mm = 1.0e3 * bed_.size_ratio * scene_->shape.semi_minor;
  const double tolerance = has_contacts ? 0.02 : 0.035;
  if (std::abs(bed_.size_ratio - 1.0) < tolerance) return;
  summary.warn(
      fmt::format("The plates look {:.2f} mm x {:.2f} mm (half axes; told by {}) but the "
                  "experiment says {:.2f} mm x {:.2f} mm ({:+.1f} %): check the particle's size "
                  "and the scale.",
                  bed_.semi_major_learned_mm,
                  bed_.semi_minor_learned_mm,
                  has_contacts ? "their contacts" : "their outlines",
                  1.0e3 * scene_->shape.semi_major,
                  1.0e3 * scene_->shape.semi_minor,
                  100.0 * (bed_.size_ratio - 1.0)));
}

// Time zero in seconds of film: the plates that lie over the orifice fall freely once it opens, so
// the square root of their mean drop is a straight line,  sqrt(drop) = sqrt(c / 2) (t - t0).
double BedTracker::find_event(int frames, TrackingSummary& summary) const {
  const double interval = 1.0 / spec_.camera.frame_rate;
  const auto& noted = spec_.camera.noted_event_time;
  const double half = 0.35 * scene_->box().opening;
  const double pixel = scene_->pixel();
  const double row_height = 2.0 * scene_->shape.semi_major;
  std::vector<const PlateTrack*> over;
  for (const PlateTrack& track : tracks_->tracks()) {
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
    times.push_back(summary.clock.moments[static_cast<std::size_t>(frame)] * interval);
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
    summary.event_source = "plates over the orifice";
    if (noted && std::abs(*time - *noted) > 3.0 * uncertainty + 0.5 * interval) {
      summary.warn(
          fmt::format("The orifice opens at {:.3f} s of film (+- {:.3f} s, {}), but {:.3f} s was "
                      "noted.",
                      *time,
                      uncertainty,
                      summary.event_source,
                      *noted));
    }
  } else {
    const char* what = time ? "The film starts after the orifice has opened"
                            : "No plate over the orifice is seen to start falling";
    // Where the bed moves from the first frame on, a noted time cannot be right either.
    const bool use_noted = noted && !time;
    time = use_noted ? *noted : 0.0;
    uncertainty = interval;
    summary.event_source = use_noted ? "noted by the laboratory" : "first frame of the film";
    summary.fail(fmt::format(
        "{}: times count from {:.3f} s of film ({}).", what, *time, summary.event_source));
  }
  summary.event_time_s = *time;
  summary.event_uncertainty_s = uncertainty;
  return *time;
}

datasets::Trajectories BedTracker::trajectories_of(double zero, TrackingSummary& summary) {
  const BedTracks& tracks = *tracks_;
  const int frames = summary.frames_read;
  const auto count = static_cast<int>(tracks.tracks().size());
  datasets::Trajectories out =
      datasets::make_trajectories(static_cast<std::size_t>(frames), count, true);
  for (std::size_t k = 0; k < out.frames(); ++k)
    out.time[k] = summary.clock.moments[k] / spec_.camera.frame_rate - zero;
  const std::array<Eigen::Vector3d, 3> inflation = {tracks.variance_inflation(Pace::rest),
                                                    tracks.variance_inflation(Pace::slow),
                                                    tracks.variance_inflation(Pace::fast)};
  std::vector<double> position_sigmas, angle_sigmas;
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
        summary.gaps += gap_starts;
        continue;
      }
      ++detections;
      const PlateSighting& sighting = *track.sightings[frame];
      Eigen::Vector3d variance = sighting.covariance.diagonal().cwiseProduct(
          inflation[static_cast<std::size_t>(sighting.pace)]);
      variance.head<2>() +=
          scene_->film.calibration.point_covariance(sighting.pose.x, sighting.pose.z).diagonal();
      variance.head<2>() += height_error(scene_->film.calibration.camera,
                                         scene_->plate_height,
                                         {sighting.pose.x, sighting.pose.z})
                                .cwiseAbs2();
      const std::size_t i = out.index(frame, p);
      const bool turned = scene_->shape.shows_angle();
      out.poses[i] = {sighting.pose.x, sighting.pose.z, turned ? sighting.pose.angle : nan};
      out.sigmas[i] = {
          std::sqrt(variance[0]), std::sqrt(variance[1]), turned ? std::sqrt(variance[2]) : nan};
      out.scores[i] = std::clamp(static_cast<double>(sighting.score), 0.0, 1.0);
      score_sum += out.scores[i];
      bed_.filled += sighting.filled;
      position_sigmas.push_back(std::sqrt(0.5 * (variance[0] + variance[1])));
      angle_sigmas.push_back(out.sigmas[i].angle);
    }
    summary.detections += detections;
    expected += present;
    if (present > 0) least = std::min(least, static_cast<double>(detections) / present);
  }
  summary.particles = count;
  summary.completeness = expected > 0 ? summary.detections / static_cast<double>(expected) : 0.0;
  summary.least_complete_particle = least;
  summary.mean_score = summary.detections > 0 ? score_sum / summary.detections : 0.0;
  summary.position_sigma_mm = 1.0e3 * median(position_sigmas, nan);
  summary.pixel_error_px = summary.position_sigma_mm * summary.scale_px_per_mm;
  summary.angle_sigma_deg = median(angle_sigmas, nan) / degree;
  return out;
}

// n_in + n_out = N0: whoever is neither seen in the bin at the end nor has crossed the floor's
// level is unaccounted for.
void BedTracker::count_plates(int frames) {
  const BedTracks& tracks = *tracks_;
  for (const PlateTrack& track : tracks.tracks()) {
    double lowest = 1.0e9;
    bool at_end = false;
    for (std::size_t k = 0; k < track.sightings.size(); ++k) {
      if (!track.sightings[k]) continue;
      lowest = std::min(lowest, track.sightings[k]->pose.z);
      at_end = static_cast<int>(k) + 1 == frames;
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
void BedTracker::measure_gravity(TrackingSummary& summary) {
  const double rate = spec_.camera.frame_rate;
  std::vector<double> accelerations;
  for (const PlateTrack& track : tracks_->tracks()) {
    for (std::size_t k = 2; k < track.sightings.size(); ++k) {
      const auto &a = track.sightings[k - 2], &b = track.sightings[k - 1], &c = track.sightings[k];
      if (!a || !b || !c || a->pose.z > -scene_->shape.semi_major) continue;
      const double h = summary.clock.moments[k - 1] - summary.clock.moments[k - 2],
                   next = summary.clock.moments[k] - summary.clock.moments[k - 1];
      const double bend = next * a->pose.z - (h + next) * b->pose.z + h * c->pose.z;
      accelerations.push_back(-bend * rate * rate * 2.0 / (h * next * (h + next)));
    }
  }
  constexpr std::size_t enough = 20;
  bed_.gravity_measured = accelerations.size() < enough ? nan : median(accelerations);
  const double stated = spec_.rig.gravity;
  if (std::isfinite(bed_.gravity_measured) &&
      std::abs(bed_.gravity_measured / stated - 1.0) > 0.15) {
    summary.warn(
        fmt::format("Plates fall at {:.2f} m/s2 below the orifice but gravity is {:.2f} m/s2: "
                    "frame rate or scale is wrong.",
                    bed_.gravity_measured,
                    stated));
  }
}

void BedTracker::judge(TrackingSummary& summary) const {
  std::string found = fmt::format("{} particles in the first frame", bed_.found_first);
  // Of a smeared film nobody knows
  if (tracks_) found += fmt::format(", {} ran out, {} remain", bed_.discharged, bed_.remaining);
  summary.findings.push_back(std::move(found));
  if (bed_.unaccounted > 0) {
    summary.fail(
        fmt::format("{} particle(s) were lost inside the bin: {} left and {} remain of {}.",
                    bed_.unaccounted,
                    bed_.discharged,
                    bed_.remaining,
                    bed_.found_first));
  }
  if (!bed_.doubtful_frames.empty())
    summary.warn(fmt::format("Not all particles were found in {} {}.",
                             bed_.doubtful_frames.size() == 1 ? "frame" : "frames",
                             listed(bed_.doubtful_frames)));
  constexpr double least_complete = 0.98;
  if (!is_smeared() && summary.completeness < least_complete) {
    summary.fail(
        fmt::format("Only {:.1f} % of all poses were found.", 100.0 * summary.completeness));
  }
}

// A shutter that stays open too long smears whatever moves: what stands still is all that such a
// film can tell.
datasets::Trajectories BedTracker::resting_plates(TrackingSummary& summary) {
  stagnant_.frames_apart = still_->pictures_apart();
  stagnant_.maps = still_->maps();
  for (const datasets::StagnantMap& map : stagnant_.maps) {
    stagnant_.x = map.x;
    stagnant_.height.push_back(datasets::stagnant_heights(map, scene_->box().opening));
  }
  const double interval = 1.0 / spec_.camera.frame_rate;
  summary.event_source = "first change below the orifice";
  summary.event_time_s =
      summary.clock.moments[static_cast<std::size_t>(std::max(0, opened_at_))] * interval;
  summary.event_uncertainty_s = interval;
  const auto frames = static_cast<std::size_t>(summary.frames_read);
  datasets::Trajectories out = datasets::make_trajectories(frames, bed_.found_first, true);
  std::vector<Eigen::Vector2d> centres;
  for (const PlateFit& plate : first_->plates) centres.emplace_back(plate.pose.x, plate.pose.z);
  const std::vector<std::size_t> until = still_->stay_until(centres);
  for (std::size_t k = 0; k < frames; ++k) {
    out.time[k] = summary.clock.moments[k] * interval - summary.event_time_s;
    for (std::size_t p = 0; p < first_->plates.size(); ++p) {
      const PlateFit& plate = first_->plates[p];
      if (k >= until[p]) continue;
      const std::size_t i = out.index(k, p);
      const Eigen::Vector3d sigma = plate.covariance.diagonal().cwiseSqrt();
      const bool turned = scene_->shape.shows_angle();
      out.poses[i] = {plate.pose.x, plate.pose.z, turned ? plate.pose.angle : nan};
      out.sigmas[i] = {sigma[0], sigma[1], turned ? sigma[2] : nan};
      out.scores[i] = plate.score;
      ++summary.detections;
    }
  }
  summary.particles = bed_.found_first;
  summary.completeness =
      summary.detections / (static_cast<double>(frames) * std::max(1, bed_.found_first));
  summary.warn(fmt::format(
      "Plates in motion are smeared (moving edges are {:.0f} % as sharp as resting ones): they "
      "were not tracked. The film gives the part of the bed that stands still; use a shorter "
      "exposure to track the flow.",
      100.0 * bed_.sharpness));
  return out;
}

void BedTracker::draw(cv::Mat& picture, const Camera& camera, const DrawnBody& body) const {
  draw_plate(picture, camera, body, nominal_);
}

void BedTracker::describe(nlohmann::ordered_json& film) const {
  film["bed"] = {{"particles_stated", bed_.stated},
                 {"particles_in_first_frame", bed_.found_first},
                 {"discharged", bed_.discharged},
                 {"remaining", bed_.remaining},
                 {"unaccounted", bed_.unaccounted},
                 {"filled_afterwards", bed_.filled},
                 {"lost_and_sought", bed_.losses},
                 {"size_ratio", bed_.size_ratio},
                 {"semi_major_learned_mm", bed_.semi_major_learned_mm},
                 {"semi_minor_learned_mm", bed_.semi_minor_learned_mm},
                 {"gravity_measured_m_per_s2", bed_.gravity_measured},
                 {"scan", bed_.scan},
                 {"sharpness", bed_.sharpness},
                 {"doubtful_frames", bed_.doubtful_frames}};
}

// frame, time_s, x_m, z_m: the bed stands still (datasets/imports/stagnant.h) from the floor up to
// z at x; nothing over the opening.
std::map<std::string, datasets::Table> BedTracker::tables() const {
  if (stagnant_.x.empty()) return {};
  datasets::Table table({"frame", "time_s", "x_m", "z_m"});
  for (std::size_t frame = 0; frame < stagnant_.height.size(); ++frame) {
    for (std::size_t i = 0; i < stagnant_.x.size(); ++i) {
      if (!std::isfinite(stagnant_.height[frame][i])) continue;
      table.add({std::to_string(frame),
                 datasets::number_text(time_[frame]),
                 datasets::number_text(stagnant_.x[i]),
                 datasets::number_text(stagnant_.height[frame][i])});
    }
  }
  return {{"stagnant", table}};
}

std::unique_ptr<ParticleTracker> make_bed_tracker(const datasets::TrackingSpec& spec,
                                                  const datasets::Film& film) {
  if (spec.body.kind != "plate" || !spec.rig.box) return nullptr;
  return std::make_unique<BedTracker>(spec, film);
}

}  // namespace graintruth::tracking
