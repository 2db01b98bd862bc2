#include "tracking/view/texture.h"

#include <algorithm>
#include <cmath>

namespace graintruth::tracking {

namespace {

// The grid: samples every twelfth of a radius, out to where the sphere turns away too far to be
// seen well.
constexpr int samples_per_radius = 12;
constexpr double reach = 0.8;  // of the radius
constexpr float value_scale = 16.0F;

}  // namespace

TextureGrid make_texture_grid(const BodyShape& shape, std::size_t ball) {
  constexpr int n = samples_per_radius;
  // A seventh of a radius short of the plane in which the two balls meet
  const double seam = 0.5 * shape.separation / shape.radius[ball] - 1.0 / 7.0;
  const double sign = ball == 0 ? 1.0 : -1.0;
  std::array<std::array<int, 2 * n + 1>, 2 * n + 1> at;
  for (auto& row : at) row.fill(-1);
  TextureGrid grid;
  grid.ball = ball;
  grid.step = shape.radius[ball] / samples_per_radius;
  for (int i = -n; i <= n; ++i) {
    for (int j = -n; j <= n; ++j) {
      const double u = static_cast<double>(i) / n, v = static_cast<double>(j) / n;
      if (std::hypot(u, v) > reach || sign * u > seam) continue;
      at[static_cast<std::size_t>(i + n)][static_cast<std::size_t>(j + n)] =
          static_cast<int>(grid.samples.size());
      grid.samples.push_back({u, v, {}});
    }
  }
  const auto look = [&](int i, int j) {
    return std::abs(i) > n || std::abs(j) > n
               ? -1
               : at[static_cast<std::size_t>(i + n)][static_cast<std::size_t>(j + n)];
  };
  for (TextureGrid::Sample& s : grid.samples) {
    const int i = static_cast<int>(std::lround(s.u * n)),
              j = static_cast<int>(std::lround(s.v * n));
    s.neighbours = {look(i - 1, j), look(i + 1, j), look(i, j - 1), look(i, j + 1)};
  }
  return grid;
}

TexturePatch sample_texture(const EdgeImage& image,
                            const Camera& camera,
                            const BodyShape& shape,
                            const BodyPose& pose,
                            const TextureGrid& grid) {
  const std::size_t ball = grid.ball;
  TexturePatch patch;
  patch.pose = pose;
  patch.centre = ball_centres(pose, shape)[ball];
  const double radius = shape.radius[ball];
  const Eigen::Vector2d axis(std::cos(pose.angle), std::sin(pose.angle));
  const Eigen::Vector2d across(-axis.y(), axis.x());
  const Eigen::Vector2d& c = patch.centre;
  // Locally the camera is affine: pixel = middle + J (x, z) + parallax h, and what is nearer looks
  // larger.
  const Eigen::Vector2d middle = camera.project(c.x(), c.y());
  const Eigen::Matrix2d jacobian = camera.jacobian(c.x(), c.y());
  const Eigen::Vector2d parallax =
      (camera.project(Eigen::Vector3d(c.x(), c.y(), radius)) - middle);  // px a radius of height
  const double nearer = radius / camera.position().z();
  patch.values.reserve(3 * grid.samples.size());
  for (const TextureGrid::Sample& s : grid.samples) {
    const double height = std::sqrt(1.0 - s.u * s.u - s.v * s.v);
    const Eigen::Vector2d pixel =
        middle + (1.0 + nearer * height) * radius * (jacobian * (s.u * axis + s.v * across)) +
        height * parallax;
    if (!image.contains(pixel, 2.0)) {
      patch.values.clear();
      return patch;
    }
    const Eigen::Vector3f colour = value_scale * image.at(pixel);
    for (int channel = 0; channel < 3; ++channel)
      patch.values.push_back(static_cast<std::int16_t>(std::lround(colour[channel])));
  }
  return patch;
}

std::vector<TextureShift> align_textures(const std::vector<TexturePatch>& patches,
                                         const TextureGrid& grid) {
  std::vector<TextureShift> shifts(patches.size());
  const std::size_t size = grid.samples.size();
  // 1. The mean of all frames, and its gradient
  std::vector<Eigen::Vector3f> mean(size, Eigen::Vector3f::Zero());
  int count = 0;
  for (const TexturePatch& patch : patches) {
    if (patch.values.empty()) continue;
    for (std::size_t i = 0; i < size; ++i)
      for (int c = 0; c < 3; ++c)
        mean[i][c] += static_cast<float>(patch.values[3 * i + static_cast<std::size_t>(c)]);
    ++count;
  }
  if (count < 2) return shifts;
  for (Eigen::Vector3f& value : mean) value /= value_scale * static_cast<float>(count);
  const auto step = static_cast<float>(grid.step);
  struct Node {
    std::size_t index;
    float u, v;
    Eigen::Vector3f du, dv;  // grey levels a metre
  };
  std::vector<Node> nodes;
  for (std::size_t i = 0; i < size; ++i) {
    const auto& n = grid.samples[i].neighbours;
    if (n[0] < 0 || n[1] < 0 || n[2] < 0 || n[3] < 0) continue;
    const auto value = [&](int k) { return mean[static_cast<std::size_t>(k)]; };
    nodes.push_back({i,
                     static_cast<float>(grid.samples[i].u),
                     static_cast<float>(grid.samples[i].v),
                     (value(n[1]) - value(n[0])) / (2.0F * step),
                     (value(n[3]) - value(n[2])) / (2.0F * step)});
  }
  // 2. Each patch = gain * mean - gradient * shift + slope of light, by least squares; samples off
  // the rest (highlights do not turn with the body) count less. Cauchy weights; their scale is that
  // of the frame before, and the first frame's is ten grey levels.
  using Row = Eigen::Matrix<float, 6, 1>;
  using Normal = Eigen::Matrix<float, 6, 6>;
  Eigen::Array3f sigma = Eigen::Array3f::Constant(10.0F);
  std::vector<std::array<float, 3>> residuals(nodes.size());
  std::vector<float> sizes(nodes.size());
  for (std::size_t k = 0; k < patches.size(); ++k) {
    const TexturePatch& patch = patches[k];
    if (patch.values.empty()) continue;
    for (auto& r : residuals) r = {0.0F, 0.0F, 0.0F};
    for (int round = 0; round < 2; ++round) {
      Eigen::Matrix2f information = Eigen::Matrix2f::Zero();
      Eigen::Vector2f gain = Eigen::Vector2f::Zero();
      std::array<Eigen::LDLT<Eigen::Matrix4f>, 3> nuisance;
      std::array<Normal, 3> normals;
      std::array<Row, 3> rights;
      for (int c = 0; c < 3; ++c) {
        const auto channel = static_cast<std::size_t>(c);
        Normal normal = Normal::Zero();
        Row right = Row::Zero();
        // Shifts in units of a grid step, so that single precision suffices
        for (std::size_t i = 0; i < nodes.size(); ++i) {
          const Node& node = nodes[i];
          const float q = residuals[i][channel] / (2.0F * sigma[c]);
          const float weight = 1.0F / (1.0F + q * q);
          Row row;
          row << -step * node.du[c], -step * node.dv[c], 0.02F * mean[node.index][c], 1.0F, node.u,
              node.v;
          const float y = static_cast<float>(patch.values[3 * node.index + channel]) / value_scale -
                          mean[node.index][c];
          normal.noalias() += weight * row * row.transpose();
          right += weight * y * row;
        }
        normal.diagonal().tail<4>().array() += 1.0e-3F;
        nuisance[channel].compute(normal.bottomRightCorner<4, 4>());
        normals[channel] = normal;
        rights[channel] = right;
        const float unit = 1.0F / (sigma[c] * sigma[c]);
        const Eigen::Matrix<float, 2, 4> cross = normal.topRightCorner<2, 4>();
        information += unit * (normal.topLeftCorner<2, 2>() -
                               cross * nuisance[channel].solve(cross.transpose()));
        gain += unit * (right.head<2>() - cross * nuisance[channel].solve(right.tail<4>()));
      }
      const Eigen::Matrix2f held = information + 1.0e-3F * Eigen::Matrix2f::Identity();
      const Eigen::Vector2f shift = held.ldlt().solve(gain);
      for (int c = 0; c < 3; ++c) {
        const auto channel = static_cast<std::size_t>(c);
        Row solution;
        solution.head<2>() = shift;
        solution.tail<4>() = nuisance[channel].solve(
            rights[channel].tail<4>() - normals[channel].bottomLeftCorner<4, 2>() * shift);
        for (std::size_t i = 0; i < nodes.size(); ++i) {
          const Node& node = nodes[i];
          Row row;
          row << -step * node.du[c], -step * node.dv[c], 0.02F * mean[node.index][c], 1.0F, node.u,
              node.v;
          residuals[i][channel] =
              static_cast<float>(patch.values[3 * node.index + channel]) / value_scale -
              mean[node.index][c] - row.dot(solution);
          sizes[i] = std::abs(residuals[i][channel]);
        }
        const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
        std::nth_element(sizes.begin(), middle, sizes.end());
        sigma[c] = std::max(0.3F, *middle / 0.6745F);
      }
      shifts[k].shift = shift.cast<double>() * step;
      shifts[k].information = information.cast<double>() / (step * step);
    }
  }
  return shifts;
}

std::vector<std::vector<WitnessedPose>> join_witnesses(const std::vector<BodyWitness>& bodies) {
  // What of an outline's error stays the same along the clip, as a share of its variance: a shadow
  // or a wall beside a body moves with it. Half of its standard deviation: chosen on the bundled
  // films, whose truth is known, so their z-scores are no independent evidence for it.
  constexpr double lasting_share = 0.25;
  std::vector<std::vector<WitnessedPose>> result;
  struct Ball {
    std::vector<Eigen::Vector2d> miss;   // outline minus texture in the frame of the body, m
    std::vector<Eigen::Vector2d> place;  // lab axes seen from the body: the ball's centre, m
    std::vector<std::size_t> frame;
    Eigen::Vector2d mean_miss = Eigen::Vector2d::Zero(), mean_place = Eigen::Vector2d::Zero();
  };
  std::vector<std::array<Ball, 2>> all(bodies.size());
  const auto body_axes = [](double angle) {
    Eigen::Matrix2d axes;
    axes << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    return axes;
  };
  // 1. Shifts, and what remains between the two witnesses
  double product = 0.0, square = 0.0;
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    const BodyWitness& witness = bodies[body];
    for (std::size_t b = 0; b < 2; ++b) {
      Ball& ball = all[body][b];
      const auto shifts = align_textures(witness.patches[b], witness.grids[b]);
      for (std::size_t k = 0; k < shifts.size(); ++k) {
        const double determinant = shifts[k].information.determinant();
        if (!(determinant > 0.0)) continue;
        const TexturePatch& patch = witness.patches[b][k];
        const Eigen::Matrix2d axes = body_axes(patch.pose.angle);
        const Eigen::Vector2d seen = patch.centre + axes * shifts[k].shift;
        const Eigen::Vector2d outline = ball_centres(witness.outline[k].pose, witness.shape)[b];
        ball.miss.push_back(axes.transpose() * (outline - seen));
        ball.place.push_back(axes.transpose() * outline);
        ball.frame.push_back(k);
      }
      const auto n = static_cast<double>(std::max<std::size_t>(1, ball.miss.size()));
      for (std::size_t i = 0; i < ball.miss.size(); ++i) {
        ball.mean_miss += ball.miss[i] / n;
        ball.mean_place += ball.place[i] / n;
      }
      for (std::size_t i = 0; i < ball.miss.size(); ++i) {
        product += (ball.miss[i] - ball.mean_miss).dot(ball.place[i] - ball.mean_place);
        square += (ball.place[i] - ball.mean_place).squaredNorm();
      }
    }
  }
  const double growth = square > 0.0 ? product / square : 0.0;
  // 2. Each body
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    const BodyWitness& witness = bodies[body];
    std::vector<WitnessedPose>& poses = result.emplace_back(witness.outline);
    std::array<Ball, 2>& balls = all[body];
    std::array<std::vector<Eigen::Vector2d>, 2> correction;  // body frame, one a frame
    std::array<std::vector<char>, 2> has;
    double disagreement = 0.0, stated = 0.0;  // m^2 per axis: between the witnesses, of the outline
    std::size_t compared = 0;
    // Light and highlights do not turn with the body: a shift that stays the same in the picture,
    // for both balls, is not believed to be motion.
    //   miss = own offset of the ball + (lab seen from the body) * common shift
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    for (std::size_t b = 0; b < 2; ++b) {
      const Ball& ball = balls[b];
      for (std::size_t i = 0; i < ball.miss.size(); ++i) {
        Eigen::Matrix<double, 2, 6> rows = Eigen::Matrix<double, 2, 6>::Zero();
        rows.leftCols<2>() = body_axes(witness.patches[b][ball.frame[i]].pose.angle).transpose();
        rows.middleCols<2>(static_cast<Eigen::Index>(2 + 2 * b)).setIdentity();
        normal += rows.transpose() * rows;
        right += rows.transpose() * (ball.miss[i] - growth * ball.place[i]);
      }
    }
    // A body that does not turn cannot tell the two apart: as if in one frame the shift had been
    // seen to be zero.
    normal += Eigen::Matrix<double, 6, 6>::Identity();
    const Eigen::Matrix<double, 6, 1> offsets = normal.ldlt().solve(right);
    for (std::size_t b = 0; b < 2; ++b) {
      correction[b].assign(poses.size(), Eigen::Vector2d::Zero());
      has[b].assign(poses.size(), 0);
      Ball& ball = balls[b];
      for (std::size_t i = 0; i < ball.miss.size(); ++i) {
        const std::size_t k = ball.frame[i];
        const Eigen::Matrix2d axes = body_axes(witness.patches[b][k].pose.angle);
        correction[b][k] =
            -(ball.miss[i] - growth * ball.place[i] - axes.transpose() * offsets.head<2>() -
              offsets.segment<2>(static_cast<Eigen::Index>(2 + 2 * b)));
        has[b][k] = 1;
        disagreement += 0.5 * correction[b][k].squaredNorm();
        const auto& c = witness.outline[k].covariance;
        stated +=
            0.5 * (c(0, 0) + c(1, 1)) + 0.5 * c(2, 2) * std::pow(0.5 * witness.shape.separation, 2);
        ++compared;
      }
    }
    if (compared < 16) continue;
    disagreement /= static_cast<double>(compared);
    stated /= static_cast<double>(compared);
    // The texture's own scatter: the separation of the balls is the same in all frames, as outline
    // poses have it, so what corrections change of it is error.
    double scatter = 0.0;
    std::size_t both = 0;
    for (std::size_t k = 0; k < poses.size(); ++k) {
      if (!has[0][k] || !has[1][k]) continue;
      scatter += 0.5 * std::pow(correction[1][k].x() - correction[0][k].x(), 2);
      ++both;
    }
    if (both < 8) continue;
    scatter /= static_cast<double>(both);
    const double outline_scatter = std::clamp(disagreement - scatter, 0.0, 2.0 * stated);
    const double texture = std::max(scatter, disagreement - outline_scatter);
    const double trust = outline_scatter / (outline_scatter + texture + 1.0e-18);
    const double separation = witness.shape.separation;
    for (std::size_t k = 0; k < poses.size(); ++k) {
      if (!has[0][k] || !has[1][k]) continue;
      WitnessedPose& pose = poses[k];
      const Eigen::Matrix2d axes = body_axes(pose.pose.angle);
      // Rigid: the tracked point moves with the weighted mean, the angle with the difference across
      const double share = witness.shape.first_share;
      const Eigen::Vector2d shift = (1.0 - share) * correction[0][k] + share * correction[1][k];
      const double turn = (correction[1][k].y() - correction[0][k].y()) / separation;
      const Eigen::Vector2d moved = axes * shift;
      pose.pose.x += trust * moved.x();
      pose.pose.z += trust * moved.y();
      pose.pose.angle += trust * turn;
      pose.covariance *= lasting_share + (1.0 - lasting_share) * (1.0 - trust);
      const double own = trust * texture;
      pose.covariance(0, 0) += own * ((1.0 - share) * (1.0 - share) + share * share);
      pose.covariance(1, 1) += own * ((1.0 - share) * (1.0 - share) + share * share);
      pose.covariance(2, 2) += own * 2.0 / (separation * separation);
    }
  }
  return result;
}

}  // namespace graintruth::tracking
