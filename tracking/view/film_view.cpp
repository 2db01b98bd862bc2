#include "tracking/view/film_view.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tracking/balls/bodies.h"

namespace graintruth::tracking {

namespace {

// Where particles can be: about the walls and the start places; the whole picture where
// nothing is known.
PlaneRegion search_region(const datasets::TrackingSpec& spec, const Camera& camera, double radius) {
  PlaneRegion seen{1.0e9, -1.0e9, 1.0e9, -1.0e9};
  const auto include = [](PlaneRegion& region, double x, double z) {
    region.left = std::min(region.left, x);
    region.right = std::max(region.right, x);
    region.bottom = std::min(region.bottom, z);
    region.top = std::max(region.top, z);
  };
  for (double column : {0.0, camera.width() - 1.0}) {
    for (double row : {0.0, camera.height() - 1.0}) {
      const Eigen::Vector2d corner = camera.unproject({column, row});
      include(seen, corner.x(), corner.y());
    }
  }
  PlaneRegion rig{1.0e9, -1.0e9, 1.0e9, -1.0e9};
  for (const auto& wall : spec.rig.walls) {
    include(rig, wall.from_x, wall.from_z);
    include(rig, wall.to_x, wall.to_z);
  }
  for (const auto& start : spec.starts) {
    include(rig, start.x - 2.5 * radius, start.z - 2.5 * radius);
    include(rig, start.x + 2.5 * radius, start.z + 2.5 * radius);
  }
  if (rig.left >= rig.right || rig.bottom >= rig.top) return seen;
  // Particles may lie above the ends of the walls.
  return {std::max(seen.left, rig.left - radius),
          std::min(seen.right, rig.right + radius),
          std::max(seen.bottom, rig.bottom - radius),
          std::min(seen.top, rig.top + 4.0 * radius)};
}

}  // namespace

Surroundings FilmView::surroundings() const {
  Surroundings result;
  result.walls = walls;
  if (face) {
    const double height = face->last_height();
    result.walls.push_back({"face", spec.rig.face->left_x, height, spec.rig.face->right_x, height});
  }
  return result;
}

std::vector<BallCandidate> FilmView::candidates_in(const cv::Mat& frame,
                                                   const BodyShape& sought) const {
  const double radius = 0.5 * (sought.radius[0] + sought.radius[1]);
  std::vector<BallCandidate> candidates =
      locate_balls(frame, lens(), region, radius, camera_noise, 8 * count + 16);
  if (sought.balls == 2) return candidates;
  // A dot as large as a ball is as round as one.
  std::erase_if(candidates, [&](const BallCandidate& candidate) {
    return std::any_of(spec.camera.fiducials.begin(),
                       spec.camera.fiducials.end(),
                       [&](const datasets::Fiducial& dot) {
                         return std::hypot(candidate.x - dot.x, candidate.z - dot.z) < 0.5 * radius;
                       });
  });
  return candidates;
}

std::vector<BodyFit> FilmView::fits_in(const cv::Mat& frame,
                                       const EdgeImage& image,
                                       const BodyShape& sought,
                                       double tolerance,
                                       const Surroundings& surroundings) const {
  return fit_bodies(image,
                    lens(),
                    sought,
                    possible_poses(sought, candidates_in(frame, sought), tolerance),
                    surroundings,
                    edge_noise);
}

void FilmView::watch_face(const cv::Mat& frame, double moment) {
  if (!face) return;
  cv::Mat grey;
  cv::cvtColor(frame, grey, cv::COLOR_BGR2GRAY);
  face->measure(grey, lens(), moment);
}

FilmView view_of(const datasets::TrackingSpec& spec,
                 const BodyShape& nominal,
                 const FilmCamera& camera,
                 const cv::Mat& first_frame) {
  FilmView view{spec, *spec.body.count, nominal, nominal, camera};
  const double noise = camera_noise(first_frame);
  view.camera_noise = std::max(1.0, noise);
  view.edge_noise = edge_noise(first_frame, noise);
  view.region = search_region(spec, view.lens(), nominal.radius[0]);
  // Bars reach half the gap towards the camera; their front edges are seen beside their place in
  // the plane.
  view.walls = spec.rig.walls;
  for (const datasets::Wall& wall : spec.rig.walls) {
    const double front = 0.5 * spec.rig.pane_gap;
    const Eigen::Vector2d from = view.lens().unproject(
        view.lens().project(Eigen::Vector3d(wall.from_x, wall.from_z, front)));
    const Eigen::Vector2d to =
        view.lens().unproject(view.lens().project(Eigen::Vector3d(wall.to_x, wall.to_z, front)));
    view.walls.push_back({"front edge", from.x(), from.y(), to.x(), to.y()});
  }
  if (spec.rig.face) view.face.emplace(*spec.rig.face, spec.camera.frame_rate);
  view.watch_face(first_frame, 0.0);
  return view;
}

}  // namespace graintruth::tracking
