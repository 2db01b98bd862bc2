// The bed in the first frame: every plate found and fitted, and what plates look like learned from
// them.
#pragma once

#include <vector>

#include "tracking/plates/bed_scene.h"

namespace graintruth::tracking {

struct FirstBed {
  std::vector<PlateFit> plates;  // from the lowest to the highest
  LitLook look;
  double usual_gain = 0.0;     // grey levels
  double edge_radius = 1.0;    // see PlateLook
  double contact_scale = 1.0;  // typical touching scale of neighbours that touch; 0: too few
};

// `parity` as in VideoReader. Empty `plates` where nothing looks like a plate.
FirstBed find_bed(const BedScene& scene, const cv::Mat& frame, int parity);
// The same in any view: `contrast` is that of its region, `gain` the usual contrast of a plate,
// grey levels, `pixel` the width of one, m.
FirstBed find_bed(
    const BedView& view, const cv::Mat1f& contrast, double gain, double pixel, int parity);

// What may be a plate, at least this share of the usual contrast.
inline constexpr double least_share_of_gain = 0.35;

// Takes out of a fit what is no plate: badly explained, too faint, or inside a better one.
void drop_impostors(BedFit& fit, double usual_gain);

}  // namespace graintruth::tracking
