// What a film of balls shows besides the particles: its camera, noise and rig, and how
// particles look in it.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "datasets/experiment/tracking_spec.h"
#include "tracking/balls/limb_model.h"
#include "tracking/balls/locate.h"
#include "tracking/balls/refine.h"
#include "tracking/event/event.h"
#include "tracking/view/film_camera.h"

namespace graintruth::tracking {

struct FilmView {
  const datasets::TrackingSpec& spec;
  int count = 0;      // of the particles
  BodyShape nominal;  // as the experiment states it
  BodyShape shape;    // sizes as they look in this film; nominal until the first picture is known
  FilmCamera camera;
  PlaneRegion region;                 // where particles can be
  double camera_noise = 1.0;          // grey levels, of a pixel
  double edge_noise = 1.0;            // grey levels, of edges
  std::optional<LimbModel> limb;      // from the first picture on
  std::vector<datasets::Wall> walls;  // as seen: in the particle plane, and their front edges
  std::optional<FaceWatcher> face;

  const Camera& lens() const { return camera.calibration.camera; }
  // Walls, and the moving face where it was last seen.
  Surroundings surroundings() const;
  std::vector<BallCandidate> candidates_in(const cv::Mat& frame, const BodyShape& sought) const;
  // What looks like a body of this shape beside these surroundings; the distance of two candidates
  // may be off the separation by `tolerance`, relative.
  std::vector<BodyFit> fits_in(const cv::Mat& frame,
                               const EdgeImage& image,
                               const BodyShape& sought,
                               double tolerance,
                               const Surroundings& surroundings) const;
  // Follows the moving face, where there is one, into the next frame, taken at `moment` (see
  // VideoReader).
  void watch_face(const cv::Mat& frame, double moment);
};

// The distances of candidates where neighbours are known may be off by as much.
constexpr double known_tolerance = 0.15;

// From the first frame, on which `camera` was calibrated; `nominal` is the body's shape as stated.
FilmView view_of(const datasets::TrackingSpec& spec,
                 const BodyShape& nominal,
                 const FilmCamera& camera,
                 const cv::Mat& first_frame);

}  // namespace graintruth::tracking
