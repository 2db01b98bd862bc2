#include "tracking/view/chessboard.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "datasets/store/input_error.h"

namespace graintruth::tracking {

namespace {

constexpr std::size_t fewest_views = 3;
constexpr double bad_view = 3.0;  // times the median residual of a view

struct View {
  std::filesystem::path file;
  std::vector<cv::Point2f> corners;
};

// In the order in which OpenCV finds them; none where no whole board is seen.
std::vector<cv::Point2f> corners_in(const cv::Mat& grey, int columns, int rows) {
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCorners(grey, {columns, rows}, corners)) return {};
  // The window must not reach the next corner.
  const double pitch = cv::norm(corners[1] - corners[0]);
  const int half = std::clamp(static_cast<int>(0.4 * pitch), 2, 11);
  cv::cornerSubPix(grey,
                   corners,
                   {half, half},
                   {-1, -1},
                   {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 100, 1e-3});
  return corners;
}

struct Fit {
  Lens lens;
  std::vector<double> residuals;  // px rms, one a view
};

Fit fit(const std::vector<View>& views,
        int columns,
        int rows,
        const cv::Size& size,
        Distortion distortion_terms) {
  std::vector<cv::Point3f> board;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column)
      board.emplace_back(static_cast<float>(column), static_cast<float>(row), 0.0F);
  }
  std::vector<std::vector<cv::Point3f>> places(views.size(), board);
  std::vector<std::vector<cv::Point2f>> corners;
  for (const View& view : views) corners.push_back(view.corners);
  cv::Mat camera = cv::Mat::eye(3, 3, CV_64F), distortion, sigmas, per_view;
  int flags = cv::CALIB_FIX_ASPECT_RATIO;
  if (distortion_terms == Distortion::two_radial_terms)
    flags |= cv::CALIB_ZERO_TANGENT_DIST | cv::CALIB_FIX_K3;
  Fit result;
  result.lens.rms_px = cv::calibrateCamera(places,
                                           corners,
                                           size,
                                           camera,
                                           distortion,
                                           cv::noArray(),
                                           cv::noArray(),
                                           sigmas,
                                           cv::noArray(),
                                           per_view,
                                           flags);
  // Of f_x, f_y, c_x, c_y, k1, k2, ...; with one aspect f_y is the one that was varied
  result.lens.focal_sigma_px = std::max(sigmas.at<double>(0), sigmas.at<double>(1));
  result.lens.k1_sigma = sigmas.at<double>(4);
  result.lens.k2_sigma = sigmas.at<double>(5);
  result.lens.size = size;
  result.lens.focal_px = camera.at<double>(0, 0);
  result.lens.principal_point = {camera.at<double>(0, 2), camera.at<double>(1, 2)};
  result.lens.k1 = distortion.at<double>(0);
  result.lens.k2 = distortion.at<double>(1);
  result.lens.p1 = distortion.at<double>(2);
  result.lens.p2 = distortion.at<double>(3);
  result.lens.k3 = distortion.at<double>(4);
  for (int view = 0; view < per_view.rows; ++view)
    result.residuals.push_back(per_view.at<double>(view));
  return result;
}

}  // namespace

Lens calibrate_lens(const std::vector<std::filesystem::path>& files,
                    int columns,
                    int rows,
                    Distortion distortion) {
  std::vector<View> views;
  std::vector<std::filesystem::path> unseen;
  cv::Size size;
  for (const std::filesystem::path& file : files) {
    const cv::Mat grey = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
    if (grey.empty() || (size.area() > 0 && grey.size() != size)) {
      throw datasets::InputError(
          fmt::format("{}: {}.",
                      file.string(),
                      grey.empty() ? "the picture cannot be read"
                                   : "the picture's size differs from that of the first"));
    }
    size = grey.size();
    View view{file, corners_in(grey, columns, rows)};
    if (view.corners.empty()) {
      unseen.push_back(file);
      continue;
    }
    views.push_back(std::move(view));
  }
  const auto require_views = [&] {
    if (views.size() >= fewest_views) return;
    throw datasets::InputError(
        fmt::format("{}: of {} pictures only {} show a whole chessboard of {} x {} inner corners; "
                    "at least {} are needed.",
                    files.empty() ? "chessboard" : files.front().parent_path().string(),
                    files.size(),
                    views.size(),
                    columns,
                    rows,
                    fewest_views));
  };
  require_views();
  Fit found = fit(views, columns, rows, size, distortion);
  std::vector<double> sorted = found.residuals;
  std::nth_element(sorted.begin(),
                   sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                   sorted.end());
  const double median = sorted[sorted.size() / 2];
  const auto worst = std::max_element(found.residuals.begin(), found.residuals.end());
  const double worst_px = *worst;
  const std::filesystem::path worst_view =
      views[static_cast<std::size_t>(worst - found.residuals.begin())].file;
  std::vector<View> good;
  std::vector<std::filesystem::path> discarded;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (found.residuals[i] > bad_view * median) {
      discarded.push_back(views[i].file);
    } else {
      good.push_back(views[i]);
    }
  }
  if (!discarded.empty()) {
    views = std::move(good);
    require_views();
    found = fit(views, columns, rows, size, distortion);
  }
  for (const View& view : views) found.lens.used.push_back(view.file);
  found.lens.unseen = std::move(unseen);
  found.lens.discarded = std::move(discarded);
  found.lens.worst = worst_view;
  found.lens.worst_px = worst_px;
  found.lens.median_px = median;
  return std::move(found.lens);
}

std::vector<BoardCorner> find_board(const cv::Mat& grey, int columns, int rows) {
  const std::vector<cv::Point2f> corners = corners_in(grey, columns, rows);
  if (corners.empty()) return {};
  const auto corner = [&](int along, int across) {
    return corners[static_cast<std::size_t>(across * columns + along)];
  };
  // Along a line of the list, and from line to line: one runs more to the right, the other upwards
  const cv::Point2f along = corner(columns - 1, 0) - corner(0, 0);
  const cv::Point2f across = corner(0, rows - 1) - corner(0, 0);
  const bool lies = std::abs(along.x) * cv::norm(across) < std::abs(across.x) * cv::norm(along);
  const cv::Point2f right = lies ? across : along, up = lies ? along : across;
  const int width = lies ? rows : columns, height = lies ? columns : rows;
  std::vector<BoardCorner> board;
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const int to_right = right.x < 0.0F ? width - 1 - column : column;
      const int upwards = up.y > 0.0F ? height - 1 - row : row;  // rows of pixels grow downwards
      const cv::Point2f at = lies ? corner(upwards, to_right) : corner(to_right, upwards);
      board.push_back({column, row, {at.x, at.y}});
    }
  }
  return board;
}

}  // namespace graintruth::tracking
