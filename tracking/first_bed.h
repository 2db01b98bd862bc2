// The bed in the first frame: every plate found and fitted, and what plates look like learned from
// them.
#pragma once

#include <vector>

#include "tracking/bed_scene.h"

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

}  // namespace graintruth::tracking
