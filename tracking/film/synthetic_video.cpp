#include "tracking/film/synthetic_video.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <random>

#include "tracking/plates/plate.h"

namespace graintruth::tracking {

namespace {

constexpr int fine = 3;  // samples a pixel and direction

// Colour of the flat scene at a point of the particle plane.
cv::Vec3f ground(const SyntheticScene& scene, double x, double z, double face_height) {
  for (const datasets::Fiducial& dot : scene.spec.camera.fiducials) {
    const double tab = 1.05 * dot.diameter;  // half the side of the tab
    if (std::abs(x - dot.x) > tab || std::abs(z - dot.z) > tab) continue;
    return std::hypot(x - dot.x, z - dot.z) < 0.5 * dot.diameter ? cv::Vec3f(0.08F, 0.08F, 0.08F)
                                                                 : cv::Vec3f(0.8F, 0.82F, 0.82F);
  }
  if (const auto& face = scene.spec.rig.face) {
    constexpr double thickness = 0.02;  // m
    if (x > face->left_x && x < face->right_x && z < face_height && z > face_height - thickness)
      return {0.58F, 0.6F, 0.6F};
  }
  for (const datasets::Wall& wall : scene.spec.rig.walls) {
    const Eigen::Vector2d from(wall.from_x, wall.from_z),
        along(wall.to_x - wall.from_x, wall.to_z - wall.from_z);
    const double share = (Eigen::Vector2d(x, z) - from).dot(along) / along.squaredNorm();
    if (share < 0.0 || share > 1.0) continue;
    // Bars lie outside, away from the middle of the rig
    const double side = (x - from.x() - share * along.x()) * (from.x() < 0.0 ? -1.0 : 1.0);
    if (side > 0.0 && side < 0.012) return {0.62F, 0.64F, 0.65F};
  }
  // Uneven back wall
  const auto shade =
      static_cast<float>(scene.ground + 0.03 * std::sin(21.0 * x) * std::cos(17.0 * z));
  return {shade, 1.02F * shade, shade};
}

// Paint, light from the upper left in front, ambient and a highlight.
cv::Vec3f ball_colour(const cv::Vec3f& paint, const Eigen::Vector3d& normal) {
  const Eigen::Vector3d lamp = Eigen::Vector3d(-0.35, 0.45, 0.82).normalized();
  const double lit = std::max(0.0, normal.dot(lamp));
  const Eigen::Vector3d half = (lamp + Eigen::Vector3d::UnitZ()).normalized();
  const double gloss = 0.6 * std::pow(std::max(0.0, normal.dot(half)), 120.0);
  const auto diffuse = static_cast<float>(0.25 + 0.75 * lit);
  return paint * diffuse + cv::Vec3f::all(static_cast<float>(gloss));
}

}  // namespace

Camera make_camera(int width,
                   int height,
                   double foot_x,
                   double foot_z,
                   double distance,
                   double scale,
                   double k1,
                   double roll,
                   double pixel_aspect) {
  Camera::Parameters parameters;
  parameters << std::log(scale * distance), std::log(pixel_aspect), 0.01, -0.008, roll, foot_x,
      foot_z, std::log(distance), k1, 0.0;
  return {width, height, parameters};
}

cv::Mat draw_frame(const SyntheticScene& scene,
                   const std::vector<BodyPose>& poses,
                   double face_height,
                   int number) {
  const Camera& camera = scene.camera;
  const int width = camera.width(), height = camera.height();
  const BodyShape shape = nominal_shape(scene.spec.body, "drawn.toml");
  struct Ball {
    Eigen::Vector3d centre;
    double radius;
    cv::Vec3f paint;
    Eigen::Vector2d pixel;
    double reach;
  };
  std::vector<Ball> balls;
  for (std::size_t body = 0; body < poses.size(); ++body) {
    const auto centres = ball_centres(poses[body], shape);
    for (std::size_t b = 0; b < shape.balls; ++b) {
      Ball ball{{centres[b].x(), centres[b].y(), 0.0},
                shape.radius[b],
                scene.paints[body % scene.paints.size()],
                camera.project(centres[b].x(), centres[b].y()),
                0.0};
      ball.reach = 1.15 * shape.radius[b] * camera.jacobian(centres[b].x(), centres[b].y()).norm();
      balls.push_back(ball);
    }
  }
  cv::Mat picture(height, width, CV_32FC3);
  const Eigen::Vector3d eye = camera.position();
  // Between pixels the camera is taken as linear: undoing a lens takes time.
  const auto plane_of_row = [&](int row) {
    std::vector<Eigen::Vector2d> points;
    for (int column = 0; column <= width; ++column)
      points.push_back(camera.unproject(Eigen::Vector2d(column, row)));
    return points;
  };
  std::vector<Eigen::Vector2d> here, below = plane_of_row(0);
  for (int row = 0; row < height; ++row) {
    here = std::move(below);
    below = plane_of_row(row + 1);
    std::vector<const Ball*> in_row;
    for (const Ball& ball : balls)
      if (std::abs(ball.pixel.y() - row) < ball.reach + 1.0) in_row.push_back(&ball);
    for (int column = 0; column < width; ++column) {
      const auto at = static_cast<std::size_t>(column);
      const Eigen::Vector2d right = here[at + 1] - here[at], down = below[at] - here[at];
      cv::Vec3f sum(0, 0, 0);
      for (int i = 0; i < fine * fine; ++i) {
        const Eigen::Vector2d plane = here[at] + ((i % fine + 0.5) / fine - 0.5) * right +
                                      ((i / fine + 0.5) / fine - 0.5) * down;
        cv::Vec3f colour;
        double nearest = 1.0e9;
        for (const Ball* ball : in_row) {
          if (std::abs(ball->pixel.x() - column) > ball->reach + 1.0) continue;
          const Eigen::Vector3d ray =
              (Eigen::Vector3d(plane.x(), plane.y(), 0.0) - eye).normalized();
          const Eigen::Vector3d from = eye - ball->centre;
          const double along = ray.dot(from);
          const double root = along * along - from.squaredNorm() + ball->radius * ball->radius;
          if (root <= 0.0) continue;
          const double distance = -along - std::sqrt(root);
          if (distance >= nearest) continue;
          nearest = distance;
          colour = ball_colour(ball->paint, (from + distance * ray) / ball->radius);
        }
        sum += nearest < 1.0e8 ? colour : ground(scene, plane.x(), plane.y(), face_height);
      }
      const double uneven = 1.0 + scene.light_slope * (static_cast<double>(column) / width - 0.5);
      picture.at<cv::Vec3f>(row, column) =
          sum * static_cast<float>(255.0 * scene.light * uneven / (fine * fine));
    }
  }
  if (scene.blur_px > 0.0) cv::GaussianBlur(picture, picture, cv::Size(7, 7), scene.blur_px);
  std::mt19937 generator(scene.seed * 7919U + static_cast<unsigned>(number));
  std::normal_distribution<float> noise(0.0F, static_cast<float>(std::max(scene.noise, 1.0e-6)));
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column)
      for (int c = 0; c < 3; ++c) picture.at<cv::Vec3f>(row, column)[c] += noise(generator);
  cv::Mat result;
  picture.convertTo(result, CV_8UC3);
  return result;
}

namespace {

// Paints `colour(point)` over the part of a disc of the plane for which it is not empty, sampled
// `fine` times a pixel and direction.
template <typename Colour>
void paint(
    cv::Mat& picture, const Camera& camera, double x, double z, double reach, Colour&& colour) {
  const Eigen::Vector2d centre = camera.project(x, z);
  const Eigen::Matrix2d to_plane = camera.jacobian(x, z).inverse();
  const Eigen::Vector2d half = reach * camera.jacobian(x, z).rowwise().norm();
  for (int row = static_cast<int>(centre.y() - half.y()) - 1; row <= centre.y() + half.y() + 1;
       ++row) {
    for (int column = static_cast<int>(centre.x() - half.x()) - 1;
         column <= centre.x() + half.x() + 1;
         ++column) {
      if (row < 0 || column < 0 || row >= picture.rows || column >= picture.cols) continue;
      cv::Vec3f& pixel = picture.at<cv::Vec3f>(row, column);
      cv::Vec3f sum(0, 0, 0);
      for (int i = 0; i < fine * fine; ++i) {
        const Eigen::Vector2d at(column + (i % fine + 0.5) / fine - 0.5,
                                 row + (i / fine + 0.5) / fine - 0.5);
        cv::Vec3f sample = pixel;
        colour(Eigen::Vector2d(to_plane * (at - centre)), sample);
        sum += sample;
      }
      pixel = sum / static_cast<float>(fine * fine);
    }
  }
}

void paint_bars(cv::Mat& picture, const SyntheticBed& bed, bool is_open) {
  const datasets::OpenBox& box = *bed.scene.spec.rig.box;
  const double side = 0.5 * box.width, edge = 0.5 * box.opening;
  constexpr double thickness = 4.0e-3, step = 1.0e-3;  // m
  const auto square = [&](double x, double z) {
    paint(picture, bed.scene.camera, x, z, step, [&](const Eigen::Vector2d& d, cv::Vec3f& sample) {
      if (std::abs(d.x()) <= 0.51 * step && std::abs(d.y()) <= 0.51 * step) sample = bed.bars;
    });
  };
  for (double depth = 0.5 * step; depth < thickness; depth += step) {
    for (double z = 0.5 * step - thickness; z < box.height; z += step) {
      square(-side - depth, z);
      square(side + depth, z);
    }
    for (double x = -side + 0.5 * step; x < side; x += step)
      if (!is_open || std::abs(x) > edge) square(x, -depth);
  }
}

}  // namespace

cv::Mat draw_bed(const SyntheticBed& bed,
                 const std::vector<datasets::Pose>& poses,
                 bool is_open,
                 int number) {
  const SyntheticScene& scene = bed.scene;
  const PlateShape plate = plate_shape(scene.spec.body);
  cv::Mat picture(scene.camera.height(), scene.camera.width(), CV_32FC3);
  picture.setTo(cv::Scalar(bed.ground[0], bed.ground[1], bed.ground[2]));
  for (const datasets::Fiducial& dot : scene.spec.camera.fiducials) {
    const double tab = 1.05 * dot.diameter;
    paint(picture,
          scene.camera,
          dot.x,
          dot.z,
          1.5 * tab,
          [&](const Eigen::Vector2d& d, cv::Vec3f& sample) {
            if (std::max(std::abs(d.x()), std::abs(d.y())) > tab) return;
            sample = cv::Vec3f::all(d.norm() < 0.5 * dot.diameter ? 0.05F : 0.85F);
          });
  }
  paint_bars(picture, bed, is_open);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const datasets::Pose& pose = poses[k];
    const cv::Vec3f& colour = scene.paints[k % scene.paints.size()];
    const double c = std::cos(pose.angle), s = std::sin(pose.angle);
    paint(picture,
          scene.camera,
          pose.x,
          pose.z,
          plate.semi_major,
          [&](const Eigen::Vector2d& d, cv::Vec3f& sample) {
            const double u = (c * d.x() + s * d.y()) / plate.semi_major;
            const double v = (c * d.y() - s * d.x()) / plate.semi_minor;
            const double r = std::hypot(u, v);
            if (r > 1.0) return;
            const bool hole = bed.holes && std::hypot(std::abs(u) - 0.3, v) < 0.12;
            const double rim = r > 0.85 ? 0.15 * d.y() / plate.semi_minor : 0.0;
            sample =
                hole ? cv::Vec3f(bed.ground) : cv::Vec3f(colour * static_cast<float>(0.9 + rim));
          });
  }
  picture *= 255.0 * scene.light;
  if (scene.blur_px > 0.0) cv::GaussianBlur(picture, picture, cv::Size(7, 7), scene.blur_px);
  cv::Mat noise(picture.size(), CV_32FC3), result;
  cv::RNG generator(scene.seed * 7919U + static_cast<unsigned>(number));
  generator.fill(noise, cv::RNG::NORMAL, 0.0, scene.noise);
  picture += noise;
  picture.convertTo(result, CV_8UC3);
  return result;
}

void write_film(const std::filesystem::path& file,
                const std::vector<cv::Mat>& frames,
                double frame_rate) {
  cv::VideoWriter writer(file.string(),
                         cv::CAP_FFMPEG,
                         cv::VideoWriter::fourcc('F', 'F', 'V', '1'),
                         frame_rate,
                         frames.front().size());
  for (const cv::Mat& frame : frames) writer.write(frame);
}

}  // namespace graintruth::tracking
