#include "tracking/event/start_of_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "datasets/store/input_error.h"

namespace graintruth::tracking {

using datasets::InputError;

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// When the particles that rest on the moving face at first follow it, by their mean height.
std::optional<Event> fit_onset_of_resting(const FilmView& view,
                                          const std::vector<BodyTrack>& tracks,
                                          const std::vector<double>& moments) {
  const datasets::MovingFace& face = *view.spec.rig.face;
  const double interval = 1.0 / view.spec.camera.frame_rate;
  HeightRecord resting;
  const double reach = 0.15 * view.shape.radius[0];
  std::vector<std::size_t> on_face;
  for (std::size_t body = 0; body < tracks.size(); ++body) {
    if (!tracks[body].fits[0]) continue;
    const auto centres = ball_centres(tracks[body].fits[0]->pose, view.shape);
    const double lowest =
        std::min(centres[0].y() - view.shape.radius[0], centres[1].y() - view.shape.radius[1]);
    const double middle = tracks[body].fits[0]->pose.x;
    if (middle > face.left_x && middle < face.right_x && lowest < face.face_z + reach &&
        lowest > face.face_z - reach)
      on_face.push_back(body);
  }
  if (on_face.empty()) return std::nullopt;
  for (std::size_t frame = 0; frame < tracks.front().fits.size(); ++frame) {
    double sum = 0.0;
    for (const std::size_t body : on_face) {
      const auto& fit = tracks[body].fits[frame];
      sum += fit ? fit->pose.z : nan;
    }
    resting.time.push_back(moments[frame] * interval);
    resting.height.push_back(sum / static_cast<double>(on_face.size()));
  }
  return fit_onset(resting, face.velocity_z);
}

datasets::Trajectories places_of(const std::vector<BodyTrack>& tracks) {
  const std::size_t frames = tracks.front().fits.size();
  auto places = datasets::make_trajectories(frames, static_cast<int>(tracks.size()), false);
  for (std::size_t body = 0; body < tracks.size(); ++body) {
    for (std::size_t k = 0; k < frames; ++k) {
      if (!tracks[body].fits[k]) continue;
      const BodyPose& pose = tracks[body].fits[k]->pose;
      places.poses[places.index(k, body)] = {pose.x, pose.z, pose.angle};
    }
  }
  return places;
}

// The first of three frames in a row in which any particle is away from its rest by five times the
// jitter of rest; -1 where none moves.
int first_moved_frame(const datasets::Trajectories& tracks, const Camera& camera) {
  int earliest = -1;
  const std::size_t frames = tracks.frames();
  constexpr std::size_t fewest = 8;
  for (std::size_t body = 0; frames >= fewest && body < static_cast<std::size_t>(tracks.particles);
       ++body) {
    const auto at = [&](std::size_t k) -> const datasets::Pose& {
      return tracks.poses[tracks.index(k, body)];
    };
    const datasets::Pose& rest = at(0);
    if (!std::isfinite(rest.x)) continue;
    std::vector<double> steps;
    for (std::size_t k = 1; k < frames; ++k)
      if (std::isfinite(at(k).x) && std::isfinite(at(k - 1).x))
        steps.push_back(std::hypot(at(k).x - at(k - 1).x, at(k).z - at(k - 1).z));
    std::sort(steps.begin(), steps.end());
    const double pixel = 1.0 / camera.scale(rest.x, rest.z);
    const double jitter =
        steps.empty() ? pixel
                      : std::max(0.05 * pixel, std::min(steps[steps.size() / 10], 0.3 * pixel));
    int run = 0;
    for (std::size_t k = 1; k < frames; ++k) {
      // Not seen compares false
      const bool away = std::hypot(at(k).x - rest.x, at(k).z - rest.z) > 5.0 * jitter;
      run = away ? run + 1 : 0;
      if (run == 3) {
        const int start = static_cast<int>(k) - 2;
        if (earliest < 0 || start < earliest) earliest = start;
        break;
      }
    }
  }
  return earliest;
}

void compare_with_noted(const Event& event,
                        const std::optional<double>& noted,
                        double interval,
                        TrackingSummary& summary) {
  if (!noted || std::abs(event.time - *noted) <= 3.0 * event.uncertainty + 0.5 * interval) return;
  summary.warn(
      fmt::format("Motion starts at {:.3f} s of film (+- {:.3f} s, {}), but {:.3f} s was noted.",
                  event.time,
                  event.uncertainty,
                  event.how,
                  *noted));
}

}  // namespace

std::optional<Event> find_first_motion(const datasets::Trajectories& tracks,
                                       const Camera& camera,
                                       double frame_rate,
                                       const std::vector<double>& moments) {
  const int earliest = first_moved_frame(tracks, camera);
  if (earliest <= 1) return std::nullopt;
  Event event;
  const double before = moments[static_cast<std::size_t>(earliest) - 1],
               moved = moments[static_cast<std::size_t>(earliest)];
  event.time = 0.5 * (before + moved) / frame_rate;
  event.uncertainty = (moved - before) / frame_rate;
  event.how = "first motion";
  return event;
}

Event start_of_a_film(const std::optional<Event>& found,
                      const datasets::Camera& camera,
                      TrackingSummary& summary) {
  const double interval = 1.0 / camera.frame_rate;
  const auto& noted = camera.noted_event_time;
  if (found) {
    compare_with_noted(*found, noted, interval, summary);
    return *found;
  }
  Event event;
  event.time = noted.value_or(0.0);
  event.uncertainty = interval;
  event.how = noted ? "noted by the laboratory" : "first frame of the film";
  return event;
}

Event find_start(const FilmView& view,
                 const std::vector<BodyTrack>& tracks,
                 const std::string& where,
                 TrackingSummary& summary) {
  const double interval = 1.0 / view.spec.camera.frame_rate;
  const auto& noted = view.spec.camera.noted_event_time;
  std::optional<Event> event;
  if (view.face) {
    const datasets::MovingFace& face = *view.spec.rig.face;
    event = fit_onset(view.face->record(), face.velocity_z);
    // Second witness: the particles that rest on the face at first
    const std::optional<Event> witness = fit_onset_of_resting(view, tracks, summary.clock.moments);
    if (!event && witness) {
      event = witness;
      event->how = "particles on the piston";
      // Held back by its neighbours a particle sinks more slowly than the piston at first and
      // catches up later: the line through its path meets the rest up to a frame late.
      event->uncertainty = std::max(event->uncertainty, interval);
      summary.warn(
          "The piston's face could not be followed; the start of motion is that of the particles "
          "resting on it.");
    } else if (event && witness && std::abs(event->time - witness->time) > 2.0 * interval) {
      summary.warn(fmt::format(
          "The piston seems to start at {:.3f} s of film but the particles on it at {:.3f} s.",
          event->time,
          witness->time));
    }
    if (event && std::abs(event->speed / face.velocity_z - 1.0) > 0.05) {
      summary.warn(
          fmt::format("The piston moves at {:.1f} mm/s on the film but the experiment says {:.1f} "
                      "mm/s: frame rate, scale "
                      "or speed is wrong.",
                      1.0e3 * event->speed,
                      1.0e3 * face.velocity_z));
    }
  } else {
    event = find_first_motion(
        places_of(tracks), view.lens(), view.spec.camera.frame_rate, summary.clock.moments);
  }
  // Without a rig there is nothing that a start could be of
  const datasets::SeenRig& rig = view.spec.rig;
  if (rig.walls.empty() && !rig.face) return start_of_a_film(event, view.spec.camera, summary);
  if (!event) {
    if (!noted) {
      throw InputError(fmt::format(
          "{}: the start of motion cannot be found on the film (it must show at least a few "
          "frames before it); cut the film less closely or give camera.noted_event_s",
          where));
    }
    event.emplace();
    event->time = *noted;
    event->uncertainty = interval;
    event->how = "noted by the laboratory";
    summary.fail(fmt::format(
        "The start of motion could not be found on the film; the noted time {:.3f} s was used.",
        *noted));
  } else {
    compare_with_noted(*event, noted, interval, summary);
  }
  return *event;
}

}  // namespace graintruth::tracking
