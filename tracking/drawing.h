// What every drawing on films shares: colours, sub-pixel lines, text, and files that are whole or
// not there.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

#include "datasets/experiment.h"
#include "datasets/trajectories.h"
#include "tracking/camera.h"
#include "tracking/plate.h"

namespace graintruth::tracking {

// Bright and apart from one another; particles take them in turn.
extern const std::array<cv::Scalar, 6> particle_colours;

// OpenCV takes coordinates in 1/16 pixel: with `drawing_shift`.
inline constexpr int drawing_shift = 4;
cv::Point fixed(const Eigen::Vector2d& pixel);

// Walls, and the piston where it is at a time after the start event (s), as the experiment states
// them.
void draw_rig(cv::Mat& picture,
              const Camera& camera,
              const datasets::Rig& rig,
              double time,
              const cv::Scalar& colour,
              int thickness);

// What the camera sees of a plate's rim, px; of one whose angle is not known its nominal lie.
std::vector<Eigen::Vector2d> plate_outline(const Camera& camera,
                                           const datasets::Pose& pose,
                                           const PlateShape& shape);

// With a dark rim, to be read on any ground.
void write_text(cv::Mat& picture,
                const std::string& text,
                const cv::Point& at,
                double size,
                const cv::Scalar& colour);

// A JPEG file, whole or not at all. Throws InputError when it cannot be written.
void write_still(const std::filesystem::path& file, const cv::Mat& picture, int quality = 90);

// An H.264 film that gets its name when it is finished. Throws InputError when it cannot be
// written.
class FilmWriter {
 public:
  FilmWriter(std::filesystem::path file, double frame_rate);
  // Removes what was not finished.
  ~FilmWriter();
  FilmWriter(const FilmWriter&) = delete;
  FilmWriter& operator=(const FilmWriter&) = delete;

  void write(const cv::Mat& picture);
  void finish();

 private:
  std::filesystem::path file_;
  double frame_rate_;
  cv::VideoWriter writer_;
};

}  // namespace graintruth::tracking
