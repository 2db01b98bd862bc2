#include "calibrate/knowledge/outline_doubts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibrate/compare/hypothesis_tests.h"
#include "calibrate/knowledge/foreign_replicates.h"
#include "calibrate/observables/bed_profile.h"
#include "calibrate/observables/steady_surface.h"

namespace graintruth::calibrate {

namespace {

using datasets::Outline;
using datasets::SeenOutline;
using datasets::Warning;

constexpr double three_sigma = 3.0;

// The outlines of one replicate, and how they are measured.
struct Seen {
  std::string name;
  Situation situation;
  const datasets::Recording* recording = nullptr;

  double grain() const { return situation.particle.diameter; }
  const SeenOutline& rig() const { return *situation.rig.seen_outline; }
};

std::string at_surface(const Outline& outline) {
  return outline.surface.empty() ? "" : fmt::format(" '{}'", outline.surface);
}

void doubt_ends(const Seen& seen, const Outline& outline, std::vector<Warning>& doubts) {
  const auto profile = profile_at_rest(*seen.recording, seen.situation, outline.surface);
  if (!profile || !apex_of(*profile)) return;
  const SeenOutline::Surface surface = surface_of(seen.situation, outline.surface);
  const Span first = first_span(seen.situation, outline.surface);
  for (const Side side : {Side::left, Side::right}) {
    const bool to_left = side == Side::left;
    const double end = to_left ? surface.from_x : surface.to_x;
    if (first.is_any() && std::abs((to_left ? first.from : first.to) - end) < seen.grain())
      continue;
    const double foot = foot_of(*profile, side, seen.situation);
    if (!(std::abs(foot - end) < seen.grain() || (to_left ? foot < end : foot > end))) continue;
    doubts.push_back(datasets::first_line(
        fmt::format("{}: the bed{} at rest reaches to {:.4g} mm, the end at {:.4g} mm: what stops "
                    "it there is not friction alone.",
                    seen.name,
                    at_surface(outline),
                    1e3 * foot,
                    1e3 * end),
        fmt::format("the bed of {} reaches the end of its rig", seen.name),
        "Take fewer grains or a wider rig"));
  }
}

void doubt_rest(const Seen& seen, const Outline& outline, std::vector<Warning>& doubts) {
  constexpr double falling_times = 10.0, smallest = 0.1, wide = 1.5;  // grains
  const double window = falling_times * std::sqrt(2.0 * seen.grain() / seen.situation.rig.gravity);
  const std::size_t last = outline.time.size() - 1;
  std::size_t before = last;
  while (before > 0 && outline.time[last] - outline.time[before] < window) --before;
  if (before == last || outline.time[last] <= 0.0 || outline.time[before] < 0.0) return;
  const BedProfile now = profile_at(outline, last, seen.situation);
  const BedProfile then = profile_at(outline, before, seen.situation);
  int moved = 0;
  for (std::size_t i = 0; i < now.z.size(); ++i) {
    const double change = std::abs(now.z[i] - then.z[i]);
    const double error = std::hypot(now.sigma[i], then.sigma[i]);
    // Where one of them is bare floor, only the other one has an error
    const double known = std::isfinite(error)           ? error
                         : std::isfinite(now.sigma[i])  ? now.sigma[i]
                         : std::isfinite(then.sigma[i]) ? then.sigma[i]
                                                        : 0.0;
    if (change > three_sigma * known && change > smallest * seen.grain()) ++moved;
  }
  const double width = now.x[1] - now.x[0];
  if (moved * width < wide * seen.grain()) return;
  doubts.push_back(datasets::first_line(
      fmt::format("{}: in the last {:.2g} s {} columns of the bed{} still change by more than "
                  "their errors: the recording ends before the bed is at rest.",
                  seen.name,
                  outline.time[last] - outline.time[before],
                  moved,
                  at_surface(outline)),
      fmt::format("the bed of {} is not at rest in the end", seen.name),
      "Film until nothing moves any more"));
}

// Where a column stands against one end, the bed stays higher there than at the other.
void doubt_side(const Seen& seen, const Outline& outline, std::vector<Warning>& doubts) {
  const SeenOutline::Surface surface = surface_of(seen.situation, outline.surface);
  const auto mirrored = [&](const std::string& seen_there) {
    doubts.push_back(datasets::first_line(
        fmt::format(
            "{}: {}: the picture is mirrored, or x points to the left.", seen.name, seen_there),
        fmt::format("the picture of {} is mirrored", seen.name),
        "Correct the scale, or the table"));
  };
  if (const auto& drum = seen.rig().drum) {
    const auto steady = steady_surface(outline, seen.situation);
    if (!steady || drum->turning == 0.0) return;
    // A drum that turns clockwise as seen carries its bed up on the left
    const double rises = steady->slope * (drum->turning > 0.0 ? 1.0 : -1.0);
    if (rises < -three_sigma * steady->slope_error)
      mirrored(fmt::format("the surface rises to the {}, but the drum is said to turn {}",
                           steady->slope > 0.0 ? "right" : "left",
                           drum->turning > 0.0 ? "counter-clockwise" : "clockwise"));
    return;
  }
  const Span first = first_span(seen.situation, outline.surface);
  const double middle = 0.5 * (surface.from_x + surface.to_x);
  if (!first.is_any() || (first.from < middle && first.to > middle)) return;
  const auto profile = profile_at_rest(*seen.recording, seen.situation, outline.surface);
  if (!profile) return;
  double here = 0.0, there = 0.0;  // m2
  for (std::size_t i = 0; i < profile->x.size(); ++i) {
    if (std::isnan(profile->z[i])) continue;
    const double height = profile->z[i] - profile->floor;
    const double x = profile->x[i], opposite = 2.0 * middle - x;
    if (x > first.from && x < first.to) here += height;
    if (opposite > first.from && opposite < first.to) there += height;
  }
  if (there > here)
    mirrored(fmt::format("the bed at rest is higher on the {} than where it stood before",
                         first.to < middle ? "right" : "left"));
}

// What stands between an end and a gate is as wide as is stated.
void doubt_width(const Seen& seen, const Outline& outline, std::vector<Warning>& doubts) {
  const SeenOutline::Surface surface = surface_of(seen.situation, outline.surface);
  const Span first = first_span(seen.situation, outline.surface);
  if (!first.is_any() || outline.time.front() > 0.0) return;
  const BedProfile before = profile_at(outline, 0, seen.situation);
  if (!apex_of(before)) return;
  for (const Side side : {Side::left, Side::right}) {
    const double stated = side == Side::left ? first.from : first.to;
    const double end = side == Side::left ? surface.from_x : surface.to_x;
    if (std::abs(stated - end) < seen.grain()) continue;  // a wall hides what goes beyond
    const double foot = foot_of(before, side, seen.situation);
    if (!(std::abs(foot - stated) > 0.5 * seen.grain())) continue;
    doubts.push_back(datasets::first_line(
        fmt::format("{}: before the event the bed reaches to {:.4g} mm, but the rig says {:.4g} "
                    "mm: the scale is off, or the rig is another one.",
                    seen.name,
                    1e3 * foot,
                    1e3 * stated),
        fmt::format("the bed of {} does not fit its rig", seen.name),
        "Check the scale and the keys of [rig]"));
  }
}

// m: middle of the area under a heap at rest; NaN where a part of it is hidden.
double middle_of(const BedProfile& profile) {
  double area = 0.0, moment = 0.0;
  for (std::size_t i = 0; i < profile.x.size(); ++i) {
    const double height = profile.z[i] - profile.floor;
    area += height;
    moment += height * profile.x[i];
  }
  return moment / area;
}

void doubt_centres(std::span<const Seen> all, std::vector<Warning>& doubts) {
  const auto& mover = all.front().rig().mover;
  if (!mover || !(mover->radius > 0.0)) return;
  double axis = 0.0;
  for (const Eigen::Vector2d& corner : mover->drawing)
    axis += corner.x() / static_cast<double>(mover->drawing.size());
  std::vector<double> aside;
  for (const Seen& seen : all) {
    const auto profile = profile_at_rest(*seen.recording, seen.situation);
    const double middle = profile ? middle_of(*profile) : std::nan("");
    if (std::isfinite(middle)) aside.push_back(middle - axis);
  }
  if (aside.size() < 2) return;
  const auto n = static_cast<double>(aside.size());
  double mean = 0.0, squares = 0.0;
  for (const double one : aside) mean += one / n;
  for (const double one : aside) squares += (one - mean) * (one - mean);
  const double error = std::sqrt(squares / (n - 1.0) / n);
  const double t = student_t_quantile(1.0 - 0.5 * false_alarm, n - 1.0);
  constexpr double quarter = 0.25;  // of a grain, as a foot is known
  if (!(std::abs(mean) > quarter * all.front().grain() && std::abs(mean) > t * error)) return;
  doubts.push_back(datasets::first_line(
      fmt::format("The heaps lie {:+.2g} mm off the axis of the tube, which is {:.2g} grains and "
                  "more than chance: the tube stood elsewhere, or x = 0 lies elsewhere.",
                  1e3 * mean,
                  std::abs(mean) / all.front().grain()),
      "the heaps lie off the axis of the tube",
      "Put the origin of the scale on the axis of the tube"));
}

}  // namespace

std::vector<Warning> doubts_about_outlines(const datasets::Experiment& experiment,
                                           std::span<const datasets::Recording> recordings) {
  std::vector<Warning> doubts;
  std::vector<Seen> all;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const datasets::Replicate& replicate = experiment.replicates[i];
    if (!replicate.rig.seen_outline) continue;
    all.push_back({.name = replicate.name,
                   .situation = {.particle = experiment.particle,
                                 .rig = replicate.rig,
                                 .measurement = experiment.measurement},
                   .recording = &recordings[i]});
    const Seen& seen = all.back();
    for (const Outline& outline : recordings[i].outlines) {
      if (outline.time.empty() || outline.column.size() < 2) continue;
      doubt_side(seen, outline, doubts);
      if (seen.rig().drum) continue;
      doubt_rest(seen, outline, doubts);
      doubt_width(seen, outline, doubts);
      if (!runs_out_below(seen.situation, outline.surface)) doubt_ends(seen, outline, doubts);
    }
  }
  if (!all.empty()) doubt_centres(all, doubts);
  return doubts;
}

}  // namespace graintruth::calibrate
