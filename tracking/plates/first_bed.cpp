#include "tracking/plates/first_bed.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "tracking/median.h"
#include "tracking/plates/plate_bank.h"

namespace graintruth::tracking {

namespace {

constexpr double good_score = 0.9;        // good enough to learn from
constexpr double least_score = 0.8;       // below this it is no plate
constexpr double deepest_overlap = 0.85;  // touching scale; hard plates do not overlap at all
constexpr int rounds = 6;                 // of fitting and learning
constexpr double longest_step_px = 2.0;

// Neighbours that touch: the lower quarter of the touching scales of the nearest pairs. In a bed at
// rest every plate rests on two others at least, so that a third of its six neighbours touch it.
double contact_scale_of(const std::vector<PlateFit>& plates, const PlateShape& shape) {
  std::vector<double> scales;
  for (std::size_t k = 0; k < plates.size(); ++k) {
    for (std::size_t other = 0; other < k; ++other) {
      const datasets::Pose &a = plates[k].pose, &b = plates[other].pose;
      if (std::hypot(a.x - b.x, a.z - b.z) > 2.6 * shape.semi_major) continue;
      const double scale = touching_scale(a, b, shape);
      constexpr double neighbours = 1.25;
      if (scale < neighbours) scales.push_back(scale);
    }
  }
  constexpr std::size_t enough = 40;
  if (scales.size() < enough) return 0.0;
  std::sort(scales.begin(), scales.end());
  return scales[scales.size() / 4];
}

}  // namespace

void drop_impostors(BedFit& fit, double usual_gain) {
  std::vector<PlateFit> measured(fit.size());
  for (std::size_t k = 0; k < fit.size(); ++k) {
    if (!fit.is_present(k)) continue;
    measured[k] = fit.measure(k);
    const bool is_plate = measured[k].score > least_score &&
                          measured[k].gain > least_share_of_gain * usual_gain &&
                          measured[k].visible > 0.5;
    if (!is_plate) fit.remove(k);
  }
  const double reach = 2.0 * fit.view().shape.semi_major;
  for (std::size_t k = 0; k < fit.size(); ++k) {
    for (std::size_t other = 0; other < k && fit.is_present(k); ++other) {
      if (!fit.is_present(other)) continue;
      const datasets::Pose &a = fit.pose(k), &b = fit.pose(other);
      if (std::hypot(a.x - b.x, a.z - b.z) > reach ||
          touching_scale(a, b, fit.view().shape) > deepest_overlap)
        continue;
      fit.remove(measured[k].score < measured[other].score ? k : other);
    }
  }
}

FirstBed find_bed(const BedScene& scene, const cv::Mat& frame, int parity) {
  return find_bed(scene.view(false),
                  contrast_of(frame, scene.region, scene.contrast),
                  scene.contrast.gain,
                  scene.pixel(),
                  parity);
}

FirstBed find_bed(
    const BedView& view, const cv::Mat1f& contrast, double gain, double pixel, int parity) {
  const int row_step = parity < 0 ? 1 : 2;
  const int first_row = parity < 0 ? 0 : (parity + view.region.y) % 2;
  // 1. Candidates, as plain discs as sharp as a pixel
  PlateLook look(0.8 * pixel / view.shape.semi_minor);
  SideLight light;
  auto lit = std::make_unique<LitLook>(look);
  BedFit fit(view, *lit, contrast.clone(), first_row, row_step);
  const auto add_candidates = [&](const cv::Mat1f& unexplained) {
    const auto found = find_plates(view, unexplained, least_share_of_gain * gain);
    for (const PlateCandidate& candidate : found) fit.add(candidate.pose, candidate.gain);
    return found.size();
  };
  add_candidates(contrast);
  // 2. Fit and learn in turn: first the look, then the light
  for (int round = 0; round < rounds; ++round) {
    const int sweeps = round < 2 ? 6 : 3;
    for (int i = 0; i < sweeps; ++i) fit.sweep(longest_step_px * pixel);
    if (round > 0) drop_impostors(fit, gain);
    // What was overlooked stands out once the others are explained
    if (round == 1 && add_candidates(fit.residual()) > 0)
      for (int i = 0; i < 6; ++i) fit.sweep(longest_step_px * pixel);
    PlateLook::Gatherer looks;
    LightGatherer lights;
    for (std::size_t k = 0; k < fit.size(); ++k) {
      if (!fit.is_present(k) || fit.measure(k).score < good_score) continue;
      fit.gather(k, look, looks);
      fit.gather(k, lights);
    }
    look = looks.look(look);
    if (round > 0) light = lights.light(light);
    auto next = std::make_unique<LitLook>(look, light, view.shape);
    fit.set_look(*next);
    lit = std::move(next);
  }
  for (int i = 0; i < 4; ++i) fit.sweep(longest_step_px * pixel);
  drop_impostors(fit, gain);
  // 3. What there is
  FirstBed bed{.plates = {}, .look = *lit, .edge_radius = look.edge_radius()};
  std::vector<double> gains;
  for (std::size_t k = 0; k < fit.size(); ++k) {
    if (!fit.is_present(k)) continue;
    PlateFit plate = fit.measure(k);
    plate.pose.angle -= std::numbers::pi * std::floor(plate.pose.angle / std::numbers::pi);
    bed.plates.push_back(plate);
    gains.push_back(plate.gain);
  }
  std::stable_sort(bed.plates.begin(), bed.plates.end(), [](const auto& a, const auto& b) {
    return a.pose.z < b.pose.z;
  });
  bed.usual_gain = median(gains);
  bed.contact_scale = contact_scale_of(bed.plates, view.shape);
  return bed;
}

}  // namespace graintruth::tracking
