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

#include "datasets/experiment/tracking_spec.h"
#include "tracking/particle_tracker.h"
#include "tracking/view/camera.h"

namespace graintruth::tracking {

// Bright and apart from one another; particles take them in turn.
extern const std::array<cv::Scalar, 6> particle_colours;

// OpenCV takes coordinates in 1/16 pixel: with `drawing_shift`.
inline constexpr int drawing_shift = 4;
cv::Point fixed(const Eigen::Vector2d& pixel);

void draw_line(cv::Mat& picture,
               const Eigen::Vector2d& from,
               const Eigen::Vector2d& to,
               const cv::Scalar& colour,
               int thickness = 1);

// A thing of its own: filled with a darker shade of its colour, with a dark rim.
void fill_outline(cv::Mat& picture,
                  const std::vector<Eigen::Vector2d>& outline,
                  const cv::Scalar& colour);

// A closed outline as the body asks: filled, or lines.
void draw_outline(cv::Mat& picture,
                  const std::vector<Eigen::Vector2d>& outline,
                  const DrawnBody& body);

// The long axis of a body: in its colour over a film, dark on a filled one.
void draw_axis(cv::Mat& picture,
               const Eigen::Vector2d& from,
               const Eigen::Vector2d& to,
               const DrawnBody& body);

// Walls, and what moves where it is at a time after the start event (s), as the experiment states
// them: a face; of a rig whose bed's outline is seen, its floor, and a tube, gate or drum.
void draw_rig(cv::Mat& picture,
              const Camera& camera,
              const datasets::SeenRig& rig,
              double time,
              const cv::Scalar& colour,
              int thickness);

// The free surface at one moment of an outline: a step for each column that is seen.
void draw_surface(cv::Mat& picture,
                  const Camera& camera,
                  const datasets::Outline& outline,
                  std::size_t moment,
                  const cv::Scalar& colour,
                  int thickness);

// What lies below it, down to the rig's floor or the shell of its drum.
void fill_bed(cv::Mat& picture,
              const Camera& camera,
              const datasets::Outline& outline,
              std::size_t moment,
              const datasets::SeenOutline& rig,
              const cv::Scalar& colour);

// With a dark rim, to be read on any ground.
void write_text(cv::Mat& picture,
                const std::string& text,
                const cv::Point& at,
                double size,
                const cv::Scalar& colour);

// A picture in the format that the ending names, whole or not at all; `quality` is that of JPEG.
// Throws InputError when it cannot be written.
void write_still(const std::filesystem::path& file, const cv::Mat& picture, int quality = 90);

// An H.264 film that gets its name when it is finished and whole. Throws InputError when it cannot
// be written.
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
  int written_ = 0;  // pictures
  cv::VideoWriter writer_;
};

}  // namespace graintruth::tracking
