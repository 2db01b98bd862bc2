#include "tracking/view/scale.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "datasets/store/input_error.h"
#include "tracking/view/chessboard.h"

namespace graintruth::tracking {

using datasets::InputError;

namespace {

void require_size(const cv::Size& found,
                  const cv::Size& wanted,
                  const std::filesystem::path& file) {
  if (found == wanted) return;
  throw InputError(
      fmt::format("{}: the picture has {} x {} pixels but the film {} x {}; take it with the "
                  "camera as it films",
                  file.string(),
                  found.width,
                  found.height,
                  wanted.width,
                  wanted.height));
}

SeenScale fiducials_in(const cv::Mat& grey, const datasets::Camera& stated) {
  SeenScale seen{.name = "fiducials", .given = static_cast<int>(stated.fiducials.size())};
  seen.sightings = find_fiducials(grey, stated.fiducials, stated.pixel_aspect);
  for (const FiducialSighting& sighting : seen.sightings) {
    const datasets::Fiducial& dot = stated.fiducials[static_cast<std::size_t>(sighting.fiducial)];
    seen.references.push_back({sighting.fiducial, dot.x, dot.z, dot.diameter, sighting.pixel});
  }
  seen.found = static_cast<int>(seen.references.size());
  return seen;
}

SeenScale clicked(const datasets::Camera& stated) {
  SeenScale seen{.name = "points",
                 .given = static_cast<int>(stated.points.size()),
                 .found = static_cast<int>(stated.points.size()),
                 .expected_sigma_px = stated.click_error};
  for (const datasets::CameraPoint& point : stated.points)
    seen.references.push_back({static_cast<int>(seen.references.size()),
                               point.x,
                               point.z,
                               0.0,
                               {point.column, point.row}});
  return seen;
}

SeenScale corners_in(const cv::Mat& first_frame, const datasets::Chessboard& board) {
  cv::Mat grey = first_frame;
  if (board.picture) {
    const std::filesystem::path& file = board.picture->file;
    grey = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
    if (grey.empty())
      throw InputError(fmt::format("{}: the picture cannot be read", file.string()));
    require_size(grey.size(), first_frame.size(), file);
  }
  SeenScale seen{.name = "corners", .given = board.columns * board.rows};
  for (const BoardCorner& corner : find_board(grey, board.columns, board.rows))
    seen.references.push_back({static_cast<int>(seen.references.size()),
                               board.x + corner.column * board.square,
                               board.z + corner.row * board.square,
                               0.0,
                               corner.pixel});
  seen.found = static_cast<int>(seen.references.size());
  return seen;
}

// What to do where too few references were found.
std::string advice(const SeenScale& seen,
                   const datasets::Camera& stated,
                   const datasets::Film& film) {
  if (const auto& board = stated.chessboard) {
    return fmt::format(
        "{}: no whole chessboard of {} x {} inner corners is seen{}; show all of it with a light "
        "rim, and count corners where four squares meet",
        (board->picture ? board->picture->file : film.video).string(),
        board->columns,
        board->rows,
        board->picture ? "" : " in the first frame");
  }
  return fmt::format(
      "{}: only {} of {} {} were found in the first frame, at least {} are needed; check that the "
      "dots are dark on a light ground, unobstructed, and that their positions in the experiment "
      "file are right",
      film.video.string(),
      seen.found,
      seen.given,
      seen.name,
      fewest_references);
}

KnownLens lens_from(const datasets::LensBoard& board, const cv::Size& size) {
  std::vector<std::filesystem::path> views;
  for (const datasets::StatedPicture& picture : board.pictures) views.push_back(picture.file);
  const Lens lens = calibrate_lens(views, board.columns, board.rows, Distortion::two_radial_terms);
  require_size(lens.size, size, views.front());
  return {lens.focal_px,
          lens.focal_sigma_px,
          lens.k1,
          lens.k1_sigma,
          lens.k2,
          lens.k2_sigma,
          lens.principal_point};
}

}  // namespace

SeenScale look_for_scale(const datasets::Camera& stated,
                         const cv::Mat& first_frame,
                         const datasets::Film& film) {
  if (stated.stick) return {.name = "stick", .given = 1, .found = 1};
  if (!stated.points.empty()) return clicked(stated);
  cv::Mat grey;
  cv::cvtColor(first_frame, grey, cv::COLOR_BGR2GRAY);
  if (stated.chessboard) return corners_in(grey, *stated.chessboard);
  if (stated.fiducials.empty()) {
    throw InputError(fmt::format("{}: camera.fiducials_mm is missing; a film needs a scale",
                                 film.experiment.string()));
  }
  return fiducials_in(grey, stated);
}

Calibration calibrate(const SeenScale& seen,
                      const datasets::Camera& stated,
                      const cv::Size& size,
                      const datasets::Film& film) {
  CalibrationOptions options{.width = size.width,
                             .height = size.height,
                             .pixel_aspect = stated.pixel_aspect,
                             .expected_sigma_px = seen.expected_sigma_px};
  if (stated.lens) options.lens = lens_from(*stated.lens, size);
  if (const auto& stick = stated.stick) {
    const Eigen::Vector2d from(stick->from[0], stick->from[1]), to(stick->to[0], stick->to[1]);
    return level_camera(
        {.from = from,
         .to = to,
         .length = stick->length,
         // Both ends were clicked
         .relative_sigma = std::hypot(std::numbers::sqrt2 * stated.click_error / (to - from).norm(),
                                      stick->length_uncertainty / stick->length),
         .origin = {stick->origin[0], stick->origin[1]}},
        options);
  }
  // Scatter tells nothing of so few clicks
  if (!stated.points.empty()) options.least_sigma_px = stated.click_error;
  if (seen.references.size() < fewest_references) throw InputError(advice(seen, stated, film));
  return calibrate(seen.references, options);
}

}  // namespace graintruth::tracking
