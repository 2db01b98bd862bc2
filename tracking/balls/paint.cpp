#include "tracking/balls/paint.h"

#include <algorithm>
#include <cmath>

#include "tracking/median.h"

namespace graintruth::tracking {

namespace {

// A sample of the grid with both neighbours on each side, and how the looks change there.
struct Node {
  std::size_t index = 0;
  float u = 0.0F, v = 0.0F;       // radii
  Eigen::Vector3f along, across;  // grey levels a metre
};

std::vector<Node> nodes_of(const TextureGrid& grid, const std::vector<Eigen::Vector3f>& looks) {
  std::vector<Node> nodes;
  const auto width = static_cast<float>(2.0 * grid.step);
  for (std::size_t i = 0; i < grid.samples.size(); ++i) {
    const auto& n = grid.samples[i].neighbours;
    if (n[0] < 0 || n[1] < 0 || n[2] < 0 || n[3] < 0) continue;
    const auto look = [&](int k) { return looks[static_cast<std::size_t>(k)]; };
    nodes.push_back({i,
                     static_cast<float>(grid.samples[i].u),
                     static_cast<float>(grid.samples[i].v),
                     (look(n[1]) - look(n[0])) / width,
                     (look(n[3]) - look(n[2])) / width});
  }
  return nodes;
}

// Sums of one ball and channel: motion along and across the axis, turn, and stretch; then gain,
// light, and the light's two slopes.
constexpr int motions = 4, lights = 4;
using Row = Eigen::Matrix<double, motions + lights, 1>;
using Normal = Eigen::Matrix<double, motions + lights, motions + lights>;

struct PaintPull {
  // Along, across, turn, stretch
  Eigen::Matrix4d all = Eigen::Matrix4d::Zero();
  Eigen::Vector4d gain = Eigen::Vector4d::Zero();
  double likeness = 0.0;

  Eigen::Vector3d change() const {
    // What tells nothing of a direction moves nothing there
    Eigen::Matrix3d held = information();
    held.diagonal() *= 1.0 + 1.0e-9;
    return held.ldlt().solve(gain.head<3>());
  }
  // Of the rigid body
  Eigen::Matrix3d information() const { return all.topLeftCorner<3, 3>(); }
  double stretch() const {
    Eigen::Matrix4d held = all;
    held.diagonal() *= 1.0 + 1.0e-9;
    return held.ldlt().solve(gain)[3];
  }
};

// How one frame differs from the looks that the nodes were made of.
PaintPull pull_of(const std::array<TexturePatch, 2>& patches,
                  const BodyShape& shape,
                  const std::array<std::vector<Node>, 2>& nodes,
                  const std::array<std::vector<Eigen::Vector3f>, 2>& looks,
                  bool robust) {
  const std::array<double, 2> lever = {-shape.first_share * shape.separation,
                                       (1.0 - shape.first_share) * shape.separation};
  PaintPull pull;
  std::vector<Row> rows;
  std::vector<double> values, rest;
  double both = 0.0, now = 0.0, before = 0.0;  // products of what is seen and remembered
  for (std::size_t ball = 0; ball < 2; ++ball) {
    const TexturePatch& patch = patches[ball];
    const double radius = shape.radius[ball];
    const auto count = nodes[ball].size();
    for (int c = 0; c < 3; ++c) {
      rows.clear();
      values.clear();
      for (const Node& node : nodes[ball]) {
        const double along = node.along[c], across = node.across[c];
        const double turn = across * (lever[ball] + radius * node.u) - along * radius * node.v;
        Row& row = rows.emplace_back();
        row << -along, -across, -turn, (ball == 0 ? 0.5 : -0.5) * along, looks[ball][node.index][c],
            1.0, node.u, node.v;
        values.push_back(patch.colour(node.index)[c]);
      }
      Normal normal;
      Row right;
      Eigen::LDLT<Eigen::Matrix4d> light;
      double scale = 0.0;
      const int rounds = robust ? 2 : 1;
      for (int round = 0; round < rounds; ++round) {
        normal.setZero();
        right.setZero();
        for (std::size_t i = 0; i < count; ++i) {
          const double q = round > 0 ? rest[i] / (2.0 * scale) : 0.0;
          const double weight = 1.0 / (1.0 + q * q);
          normal.noalias() += weight * rows[i] * rows[i].transpose();
          right += weight * values[i] * rows[i];
        }
        normal.diagonal().tail<lights>().array() += 1.0e-6;
        light.compute(normal.bottomRightCorner<lights, lights>());
        // What is left where light alone explains the difference
        const Eigen::Vector4d even = light.solve(right.tail<lights>());
        rest.resize(count);
        std::vector<double> sizes(count);
        for (std::size_t i = 0; i < count; ++i) {
          rest[i] = values[i] - rows[i].tail<lights>().dot(even);
          sizes[i] = std::abs(rest[i]);
        }
        constexpr double normal_quartile = 0.6745, rounding = 0.3;  // of whole grey levels
        scale = std::max(rounding, median(std::move(sizes)) / normal_quartile);
      }
      const double unit = 1.0 / (scale * scale);
      const Eigen::Matrix<double, motions, lights> cross = normal.topRightCorner<motions, lights>();
      pull.all += unit * (normal.topLeftCorner<motions, motions>() -
                          cross * light.solve(cross.transpose()));
      pull.gain += unit * (right.head<motions>() - cross * light.solve(right.tail<lights>()));
      // What light and its slopes leave of what is seen, and of what is remembered
      Eigen::Matrix3d plane = 1.0e-9 * Eigen::Matrix3d::Identity();
      Eigen::Matrix<double, 3, 2> sums = Eigen::Matrix<double, 3, 2>::Zero();
      for (std::size_t i = 0; i < count; ++i) {
        const Eigen::Vector3d slope = rows[i].tail<3>();
        plane += slope * slope.transpose();
        sums += slope * Eigen::RowVector2d(values[i], rows[i][motions]);
      }
      const Eigen::Matrix<double, 3, 2> slopes = plane.ldlt().solve(sums);
      for (std::size_t i = 0; i < count; ++i) {
        const Eigen::RowVector2d beyond = Eigen::RowVector2d(values[i], rows[i][motions]) -
                                          rows[i].tail<3>().transpose() * slopes;
        both += unit * beyond[0] * beyond[1];
        now += unit * beyond[0] * beyond[0];
        before += unit * beyond[1] * beyond[1];
      }
    }
  }
  pull.likeness = now > 0.0 && before > 0.0 ? both / std::sqrt(now * before) : 0.0;
  return pull;
}

}  // namespace

void Paint::learn(const std::array<TexturePatch, 2>& patches, float least_weight) {
  if (patches[0].values.empty() || patches[1].values.empty()) return;
  const float weight = std::max(least_weight, 1.0F / static_cast<float>(frames + 1));
  for (std::size_t ball = 0; ball < 2; ++ball) {
    const std::size_t size = patches[ball].values.size() / 3;
    looks[ball].resize(size, Eigen::Vector3f::Zero());
    for (std::size_t i = 0; i < size; ++i)
      looks[ball][i] += weight * (patches[ball].colour(i) - looks[ball][i]);
  }
  ++frames;
}

BodyPose moved(const BodyPose& pose, const Eigen::Vector3d& change) {
  const double cosine = std::cos(pose.angle), sine = std::sin(pose.angle);
  return {pose.x + cosine * change[0] - sine * change[1],
          pose.z + sine * change[0] + cosine * change[1],
          pose.angle + change[2]};
}

Eigen::Matrix3d in_laboratory(const Eigen::Matrix3d& information, double angle) {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  axes.topLeftCorner<2, 2>() << std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle);
  return axes.transpose() * information * axes;
}

PaintFit fit_paint(const EdgeImage& image,
                   const Camera& camera,
                   const BodyShape& shape,
                   const BodyPose& start,
                   const std::array<TextureGrid, 2>& grids,
                   const Paint& paint) {
  PaintFit fit;
  fit.pose = start;
  if (!paint.is_known()) return fit;
  std::array<std::vector<Node>, 2> nodes;
  for (std::size_t ball = 0; ball < 2; ++ball)
    nodes[ball] = nodes_of(grids[ball], paint.looks[ball]);
  constexpr int iterations = 8, plain = 2;  // highlights count in full in the first ones
  for (int iteration = 0; iteration <= iterations; ++iteration) {
    std::array<TexturePatch, 2> patches;
    for (std::size_t ball = 0; ball < 2; ++ball) {
      patches[ball] = sample_texture(image, camera, shape, fit.pose, grids[ball]);
      if (patches[ball].values.empty()) return fit;
    }
    const PaintPull pull = pull_of(patches, shape, nodes, paint.looks, iteration >= plain);
    fit.likeness = pull.likeness;
    fit.information = in_laboratory(pull.information(), fit.pose.angle);
    if (iteration == iterations) break;
    const Eigen::Vector3d change = pull.change();
    if (!change.allFinite()) return fit;
    // No step further than a grid cell: beyond it the looks are not straight
    const double cell = grids[0].step;
    const double largest =
        std::max(change.head<2>().norm(), 0.5 * std::abs(change[2]) * shape.separation);
    fit.pose = moved(fit.pose, change * std::min(1.0, cell / std::max(largest, 1.0e-3 * cell)));
    constexpr double negligible = 1.0e-3;
    if (largest < negligible * cell) iteration = std::max(iteration, iterations - 1);
  }
  fit.found = true;
  return fit;
}

std::vector<PaintShift> compare_paint(const std::vector<std::array<TexturePatch, 2>>& frames,
                                      const BodyShape& shape,
                                      const std::array<TextureGrid, 2>& grids) {
  std::vector<PaintShift> shifts(frames.size());
  Paint mean;
  for (const auto& patches : frames) mean.learn(patches, 0.0F);
  if (mean.frames < 2) return shifts;
  std::array<std::vector<Node>, 2> nodes;
  for (std::size_t ball = 0; ball < 2; ++ball)
    nodes[ball] = nodes_of(grids[ball], mean.looks[ball]);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (frames[k][0].values.empty() || frames[k][1].values.empty()) continue;
    const PaintPull pull = pull_of(frames[k], shape, nodes, mean.looks, true);
    const Eigen::Vector3d change = pull.change();
    const Eigen::Matrix3d covariance = pull.information().inverse();
    // Balls that show nothing say nothing; and beyond a grid cell the looks are not straight
    const double cell = grids[0].step;
    if (!change.allFinite() || !covariance.allFinite() || change.head<2>().norm() > 2.0 * cell ||
        !(covariance.diagonal().head<2>().maxCoeff() < cell * cell))
      continue;
    shifts[k] = {true, change, pull.information(), pull.likeness, pull.stretch()};
  }
  return shifts;
}

}  // namespace graintruth::tracking
