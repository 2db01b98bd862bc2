#include "datasets/experiment/camera.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>

#include "datasets/experiment/pictures.h"
#include "datasets/store/fingerprint.h"
#include "datasets/store/toml_section.h"

namespace graintruth::datasets {

namespace {

constexpr std::size_t fewest_places = 4;  // that tell scale and tilt
constexpr int fewest_corners = 3, most_corners = 100;

std::vector<Fiducial> read_fiducials(TomlSection& section) {
  const auto centres = section.rows("fiducials", 2, length_units);
  if (centres.empty()) return {};
  const double diameter = section.quantity("fiducial_diameter", length_units, positive);
  std::vector<Fiducial> fiducials;
  for (const auto& centre : centres) fiducials.push_back({centre[0], centre[1], diameter});
  if (fiducials.size() < fewest_places) {
    section.fail(
        section.has("fiducials_m") ? "fiducials_m" : "fiducials_mm",
        fmt::format("gives {} fiducials, but at least {} are needed to find scale and tilt",
                    fiducials.size(),
                    fewest_places));
  }
  return fiducials;
}

// mm = [x, z], or another unit of length.
std::vector<double> read_place(TomlSection& section) {
  std::optional<std::vector<double>> place;
  for (const Unit& unit : length_units) {
    const auto numbers = section.optional_numbers(unit.suffix, 2, plain);
    if (!numbers) continue;
    if (place) section.fail(unit.suffix, "gives the place a second time");
    place = {(*numbers)[0] * unit.in_si, (*numbers)[1] * unit.in_si};
  }
  if (!place) section.fail("mm", "is missing; write mm = [x, z]");
  return *place;
}

std::vector<CameraPoint> read_points(TomlSection& camera) {
  std::vector<CameraPoint> points;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (TomlSection& section : camera.sections("point")) {
    const auto place = read_place(section);
    const auto pixel = section.numbers("px", 2, plain);
    points.push_back({pixel[0], pixel[1], place[0], place[1]});
    sum += Eigen::Vector2d(place[0], place[1]);
    section.finish();
  }
  if (points.empty()) return points;
  if (points.size() < fewest_places) {
    camera.fail("point",
                fmt::format("is given {} time(s), but at least {} points are needed to find scale "
                            "and tilt; of a length alone [camera.stick] makes a scale",
                            points.size(),
                            fewest_places));
  }
  // How far they spread along their line and across it
  const Eigen::Vector2d mean = sum / static_cast<double>(points.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const CameraPoint& point : points) {
    const Eigen::Vector2d off = Eigen::Vector2d(point.x, point.z) - mean;
    spread += off * off.transpose();
  }
  const Eigen::Vector2d squares =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvalues();
  constexpr double least_spread = 0.02;  // across over along: a millimetre in five centimetres
  if (!(squares[0] > least_spread * least_spread * squares[1]))
    camera.fail("point", "gives points that lie on one line; spread them over the picture");
  return points;
}

StatedPicture read_picture(TomlSection& section,
                           std::string_view key,
                           const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file))
    section.fail(key, fmt::format("names '{}', but there is no such file", file.string()));
  return {file, file_hash(file)};
}

Chessboard read_chessboard(TomlSection section, const std::filesystem::path& folder) {
  Chessboard board;
  board.columns = section.whole_number("columns", fewest_corners, most_corners);
  board.rows = section.whole_number("rows", fewest_corners, most_corners);
  board.square = section.quantity("square", length_units, positive);
  board.x = section.optional_quantity("x", length_units).value_or(0.0);
  board.z = section.optional_quantity("z", length_units).value_or(0.0);
  if (const auto picture = section.optional_text("picture"))
    board.picture = read_picture(section, "picture", folder / *picture);
  section.finish();
  return board;
}

std::array<double, 2> pixel(const std::vector<double>& numbers) { return {numbers[0], numbers[1]}; }

// Two ends in the picture, and how far they are apart: of a Stick or a CheckedLength.
template <class Length>
void read_length(TomlSection& section, Length& known) {
  known.from = pixel(section.numbers("from", 2, pixel_units));
  known.to = pixel(section.numbers("to", 2, pixel_units));
  if (known.from == known.to) section.fail("to_px", "is the same point as from_px");
  known.length = section.quantity("length", length_units, positive);
  known.length_uncertainty =
      section.optional_quantity("length_uncertainty", length_units, positive).value_or(0.0);
}

Stick read_stick(TomlSection section) {
  Stick stick;
  read_length(section, stick);
  const auto origin = section.optional_numbers("origin", 2, pixel_units);
  stick.origin = origin ? pixel(*origin) : stick.from;
  section.finish();
  return stick;
}

std::optional<std::vector<CheckedLength>> read_checks(TomlSection& camera) {
  std::vector<CheckedLength> checks;
  for (TomlSection& section : camera.sections("check")) {
    read_length(section, checks.emplace_back());
    section.finish();
  }
  if (checks.empty()) return std::nullopt;
  return checks;
}

std::optional<std::vector<MaskPolygon>> read_masks(TomlSection& camera) {
  std::vector<MaskPolygon> masks;
  for (TomlSection& section : camera.sections("mask")) {
    MaskPolygon& mask = masks.emplace_back();
    for (const std::vector<double>& corner : section.rows("corners", 2, pixel_units))
      mask.corners.push_back(pixel(corner));
    if (mask.corners.size() < 3)
      section.fail("corners_px", "must be a list of at least 3 corners [column, row]");
    section.finish();
  }
  if (masks.empty()) return std::nullopt;
  return masks;
}

LensBoard read_lens(TomlSection section, const std::filesystem::path& folder) {
  LensBoard lens;
  lens.columns = section.whole_number("columns", fewest_corners, most_corners);
  lens.rows = section.whole_number("rows", fewest_corners, most_corners);
  for (const std::string& name : section.texts("pictures")) {
    const auto pictures = pictures_of(folder / name);
    for (const std::filesystem::path& picture : pictures)
      lens.pictures.push_back(read_picture(section, "pictures", picture));
    if (pictures.empty()) lens.pictures.push_back(read_picture(section, "pictures", folder / name));
  }
  constexpr std::size_t fewest_pictures = 3;
  if (lens.pictures.size() < fewest_pictures) {
    section.fail("pictures",
                 fmt::format("names {} picture(s), but at least {} of a board held differently are "
                             "needed",
                             lens.pictures.size(),
                             fewest_pictures));
  }
  section.finish();
  return lens;
}

std::array<int, 4> read_region(TomlSection& section, const std::vector<double>& edges) {
  std::array<int, 4> region{};
  for (std::size_t i = 0; i < region.size(); ++i) {
    if (edges[i] < 0.0 || edges[i] != std::floor(edges[i]) || edges[i] > 1.0e5)
      section.fail("region_px", "must hold whole numbers of pixels: left, top, right, bottom");
    region[i] = static_cast<int>(edges[i]);
  }
  if (region[0] >= region[2] || region[1] >= region[3])
    section.fail("region_px",
                 "must be left, top, right, bottom, with left < right and top < bottom");
  return region;
}

}  // namespace

Camera read_camera(TomlSection section, const std::filesystem::path& folder, bool films) {
  Camera camera;
  camera.frame_rate = section.quantity("frame_rate", rate_units, positive);
  camera.pixel_aspect = section.optional_quantity("pixel_aspect", plain, positive).value_or(1.0);
  camera.noted_event_time = section.optional_quantity("noted_event", time_units, not_negative);
  // 1. What gives scale
  std::string scale;
  const auto note = [&](bool is_given, const char* key) {
    if (is_given && !scale.empty()) {
      section.fail(
          key, fmt::format("gives the scale a second time, after '{}'; keep one of them", scale));
    }
    if (is_given) scale = key;
  };
  camera.fiducials = read_fiducials(section);
  note(!camera.fiducials.empty(), section.has("fiducials_m") ? "fiducials_m" : "fiducials_mm");
  camera.points = read_points(section);
  note(!camera.points.empty(), "point");
  if (auto board = section.optional_section("chessboard"))
    camera.chessboard = read_chessboard(*board, folder);
  note(camera.chessboard.has_value(), "chessboard");
  if (auto stick = section.optional_section("stick")) camera.stick = read_stick(*stick);
  note(camera.stick.has_value(), "stick");
  if (films && scale.empty()) {
    section.fail("fiducials_mm",
                 "is missing; films need a scale: fiducials_mm and fiducial_diameter_mm, "
                 "[[camera.point]], [camera.chessboard] or [camera.stick]");
  }
  camera.checks = read_checks(section);
  if (!camera.points.empty() || camera.stick || camera.checks)
    camera.click_error = section.optional_quantity("click_error", pixel_units, positive)
                             .value_or(camera.click_error);
  // 2. The lens, and what is looked at
  if (auto lens = section.optional_section("lens")) camera.lens = read_lens(*lens, folder);
  if (const auto edges = section.optional_numbers("region", 4, pixel_units))
    camera.region = read_region(section, *edges);
  camera.masks = read_masks(section);
  section.optional_text("annotation");  // read before, see annotation.h
  section.finish();
  return camera;
}

}  // namespace graintruth::datasets
