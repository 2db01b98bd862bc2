#include "tracking/outline/colour_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

namespace graintruth::tracking {

namespace {

using Colour = ColourModel::Colour;

// Lloyd's means from starts far apart (Arthur and Vassilvitskii 2007), with a fixed seed.
std::vector<int> clusters(const std::vector<Colour>& colours, int count) {
  std::mt19937_64 generator(1);
  std::vector<Colour> means = {colours[colours.size() / 2]};
  std::vector<float> nearest(colours.size(), std::numeric_limits<float>::infinity());
  while (static_cast<int>(means.size()) < count) {
    double sum = 0.0;
    for (std::size_t i = 0; i < colours.size(); ++i) {
      nearest[i] = std::min(nearest[i], (colours[i] - means.back()).squaredNorm());
      sum += nearest[i];
    }
    if (sum == 0.0) break;
    // 53 bits, the same on every machine
    double left = sum * static_cast<double>(generator() >> 11U) * 0x1.0p-53;
    std::size_t chosen = 0;
    while (chosen + 1 < colours.size() && left >= nearest[chosen]) left -= nearest[chosen++];
    means.push_back(colours[chosen]);
  }
  std::vector<int> label(colours.size(), 0);
  constexpr int rounds = 12;
  for (int round = 0; round < rounds; ++round) {
    std::vector<Eigen::Vector3d> sums(means.size(), Eigen::Vector3d::Zero());
    std::vector<double> sizes(means.size(), 0.0);
    for (std::size_t i = 0; i < colours.size(); ++i) {
      float least = std::numeric_limits<float>::infinity();
      for (std::size_t k = 0; k < means.size(); ++k) {
        const float square = (colours[i] - means[k]).squaredNorm();
        if (square >= least) continue;
        least = square;
        label[i] = static_cast<int>(k);
      }
      sums[static_cast<std::size_t>(label[i])] += colours[i].cast<double>();
      sizes[static_cast<std::size_t>(label[i])] += 1.0;
    }
    for (std::size_t k = 0; k < means.size(); ++k)
      if (sizes[k] > 0.0) means[k] = (sums[k] / sizes[k]).cast<float>();
  }
  return label;
}

}  // namespace

ColourModel::ColourModel(const std::vector<Colour>& colours, int components, double noise) {
  const std::vector<int> label = clusters(colours, components);
  for (int k = 0; k < components; ++k) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double size = 0.0;
    for (std::size_t i = 0; i < colours.size(); ++i) {
      if (label[i] != k) continue;
      mean += colours[i].cast<double>();
      size += 1.0;
    }
    if (size == 0.0) continue;
    mean /= size;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < colours.size(); ++i) {
      if (label[i] != k) continue;
      const Eigen::Vector3d off = colours[i].cast<double>() - mean;
      covariance += off * off.transpose();
    }
    covariance /= size;
    covariance.diagonal().array() += noise * noise;
    const Eigen::Matrix3d inverse = covariance.inverse();
    Part part;
    part.mean = mean.cast<float>();
    part.factor = Eigen::LLT<Eigen::Matrix3d>(inverse).matrixU().toDenseMatrix().cast<float>();
    part.offset = static_cast<float>(std::log(size / static_cast<double>(colours.size())) -
                                     0.5 * std::log(covariance.determinant()));
    parts_.push_back(part);
  }
}

float ColourModel::log_density(const Colour& colour) const {
  float best = -std::numeric_limits<float>::infinity();
  for (const Part& part : parts_) {
    const Colour off = colour - part.mean;
    best = std::max(best, part.offset - 0.5F * (part.factor * off).squaredNorm());
  }
  return best;
}

double confusion(const std::vector<Colour>& one,
                 const std::vector<Colour>& other,
                 int components,
                 double noise) {
  const auto halves = [](const std::vector<Colour>& all) {
    std::array<std::vector<Colour>, 2> parts;
    for (std::size_t i = 0; i < all.size(); ++i) parts[i % 2].push_back(all[i]);
    return parts;
  };
  const auto a = halves(one), b = halves(other);
  if (a[1].empty() || b[1].empty()) return 0.5;
  const ColourModel of_one(a[0], components, noise), of_other(b[0], components, noise);
  const auto wrong =
      [](const std::vector<Colour>& all, const ColourModel& own, const ColourModel& foreign) {
        double count = 0.0;
        for (const Colour& colour : all) {
          const float mine = own.log_density(colour), theirs = foreign.log_density(colour);
          if (mine <= theirs) count += mine < theirs ? 1.0 : 0.5;
        }
        return count / static_cast<double>(all.size());
      };
  return 0.5 * (wrong(a[1], of_one, of_other) + wrong(b[1], of_other, of_one));
}

void gather(const cv::Mat& picture,
            const cv::Mat1b& mask,
            std::size_t most,
            std::vector<Colour>& colours) {
  const auto all = static_cast<std::size_t>(cv::countNonZero(mask));
  if (all == 0 || most == 0) return;
  const std::size_t stride = (all + most - 1) / most;
  std::size_t number = 0;
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) {
      if (mask(row, column) == 0 || number++ % stride != 0) continue;
      const auto& c = picture.at<cv::Vec3b>(row, column);
      colours.emplace_back(c[0], c[1], c[2]);
    }
  }
}

}  // namespace graintruth::tracking
