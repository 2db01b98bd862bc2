// Films with known truth: glossy balls, single or in pairs, dots on tabs, walls and a sinking
// face, drawn through a known camera. For tests and for choosing options; the tracker does not
// use it.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "datasets/experiment/tracking_spec.h"
#include "datasets/store/trajectories.h"
#include "tracking/balls/refine.h"
#include "tracking/view/camera.h"

namespace graintruth::tracking {

struct SyntheticScene {
  datasets::TrackingSpec spec;  // camera, walls, moving face, box, body
  Camera camera;
  std::vector<cv::Vec3f> paints;  // blue, green, red of each body, 0..1
  double light = 1.0;             // brightness of everything, in the middle of the picture
  double light_slope = 0.0;  // how much brighter its right edge is than its left, share of light
  float ground = 0.40F;      // brightness of the back wall, 0..1
  double noise = 2.0;        // grey levels
  double blur_px = 0.6;      // of the lens
  unsigned seed = 1;
};

// A camera straight above (foot_x, foot_z), `distance` m away, `scale` px/m at the particle plane,
// slightly rolled.
Camera make_camera(int width,
                   int height,
                   double foot_x,
                   double foot_z,
                   double distance,
                   double scale,
                   double k1,
                   double roll,
                   double pixel_aspect = 1.0);

// Plates in a bin: the same camera, dots, noise and blur; `paints` are those of the plates.
struct SyntheticBed {
  SyntheticScene scene;
  cv::Vec3f ground{0.15F, 0.15F, 0.15F};  // blue, green, red, 0..1
  cv::Vec3f bars{0.5F, 0.5F, 0.5F};       // of the walls and the lid
  bool holes = true;                      // two in each plate, which show how it lies
};

// One frame of it: each plate with a rim that is lighter on its upper side and two dark holes. The
// lid closes the orifice unless `is_open`.
cv::Mat draw_bed(const SyntheticBed& bed,
                 const std::vector<datasets::Pose>& poses,
                 bool is_open,
                 int number);

// One frame; `number` only seeds its noise.
cv::Mat draw_frame(const SyntheticScene& scene,
                   const std::vector<BodyPose>& poses,
                   double face_height,
                   int number);

// Lossless (FFV1 in avi).
void write_film(const std::filesystem::path& file,
                const std::vector<cv::Mat>& frames,
                double frame_rate);

}  // namespace graintruth::tracking
