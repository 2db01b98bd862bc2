// The camera of an experiment as its file states it: the clock, the pixels, and what gives scale.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace graintruth::datasets {

class TomlSection;

// A picture, by what it holds. Where it lies decides nothing.
struct StatedPicture {
  std::filesystem::path file;
  std::string hash;
};

// A dark disc on a light ground, in the plane of the particle centres.
struct Fiducial {
  double x = 0.0, z = 0.0;  // m, centre
  double diameter = 0.0;    // m
};

// A place in that plane that somebody found in the picture.
struct CameraPoint {
  double column = 0.0, row = 0.0;  // px, integers at pixel centres
  double x = 0.0, z = 0.0;         // m
};

// A chessboard in that plane, level. Its columns and rows of inner corners count from the lower
// left.
struct Chessboard {
  int columns = 0, rows = 0;
  double square = 0.0;                   // m
  double x = 0.0, z = 0.0;               // m, of the lower left inner corner
  std::optional<StatedPicture> picture;  // where it is seen; else in the film's first frame
};

// Something of known length in that plane.
struct Stick {
  std::array<double, 2> from{}, to{};  // px, column and row of its ends
  double length = 0.0;                 // m
  double length_uncertainty = 0.0;     // m, one standard deviation
  std::array<double, 2> origin{};      // px, of the point (0, 0)
};

// A length in that plane that is known as well, and only checks the scale.
struct CheckedLength {
  std::array<double, 2> from{}, to{};  // px, column and row of its ends
  double length = 0.0;                 // m
  double length_uncertainty = 0.0;     // m, one standard deviation
};

// A part of the picture that nobody looks at.
struct MaskPolygon {
  std::vector<std::array<double, 2>> corners;  // px, column and row
};

// Pictures of a chessboard that was held anywhere before the same camera.
struct LensBoard {
  int columns = 0, rows = 0;  // of inner corners
  std::vector<StatedPicture> pictures;
};

struct Camera {
  double frame_rate = 0.0;    // Hz, true rate of the recording
  double pixel_aspect = 1.0;  // width of a pixel over its height
  // What gives scale: one of these four
  std::vector<Fiducial> fiducials;
  std::vector<CameraPoint> points;
  std::optional<Chessboard> chessboard;
  std::optional<Stick> stick;
  double click_error = 0.5;  // px, one standard deviation of clicked points and ends of the stick
  std::optional<LensBoard> lens;
  // Left, top, right and bottom edge of what is looked at, px; without it the whole picture.
  std::optional<std::array<int, 4>> region;
  // When the event should be seen, in seconds of film, if the laboratory noted it. Only checks what
  // is found.
  std::optional<double> noted_event_time;
  // Lists that are not empty where they are there
  std::optional<std::vector<CheckedLength>> checks;
  std::optional<std::vector<MaskPolygon>> masks;
};

// Reads and checks [camera]; pictures that it names lie in `folder`. Where there are films, a scale
// is needed.
Camera read_camera(TomlSection section, const std::filesystem::path& folder, bool films);

}  // namespace graintruth::datasets
