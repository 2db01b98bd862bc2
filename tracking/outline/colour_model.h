// The colours of something as a mixture of Gaussians, learned from pixels that surely show it.
#pragma once

#include <Eigen/Dense>
#include <opencv2/core.hpp>
#include <vector>

namespace graintruth::tracking {

class ColourModel {
 public:
  using Colour = Eigen::Vector3f;  // blue, green, red; grey levels

  ColourModel() = default;
  // At most `components` Gaussians; `noise` (grey levels, one standard deviation of a pixel) is the
  // least that any of them is wide. Same colours, same model. At least one colour is needed.
  ColourModel(const std::vector<Colour>& colours, int components, double noise);

  bool is_known() const { return !parts_.empty(); }
  // Logarithm of the density of the likeliest Gaussian at a colour, up to one constant for all.
  float log_density(const Colour& colour) const;
  float log_density(const cv::Vec3b& colour) const {
    return log_density(Colour(colour[0], colour[1], colour[2]));
  }

 private:
  struct Part {
    Colour mean;
    Eigen::Matrix3f factor;  // of the inverse covariance: |factor (c - mean)|^2
    float offset = 0.0F;
  };
  std::vector<Part> parts_;
};

// Share of two sets of colours that their models would take for the other: of half of each, by
// models of the other halves. 0.5: they look the same.
double confusion(const std::vector<ColourModel::Colour>& one,
                 const std::vector<ColourModel::Colour>& other,
                 int components,
                 double noise);

// Every so-manyth pixel of the mask, at most `most`.
void gather(const cv::Mat& picture,
            const cv::Mat1b& mask,
            std::size_t most,
            std::vector<ColourModel::Colour>& colours);

}  // namespace graintruth::tracking
