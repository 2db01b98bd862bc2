#include "sim/laws/material.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/laws/restitution.h"

namespace graintruth::sim {

double shear_modulus(const Material& material) {
  return material.youngs_modulus / (2.0 * (1.0 + material.poisson_ratio));
}

void check(const Material& material) {
  if (!(material.youngs_modulus > 0.0)) {
    throw std::invalid_argument("Material: youngs_modulus is " +
                                std::to_string(material.youngs_modulus) + " Pa, must be above 0");
  }
  if (!(material.poisson_ratio > -1.0 && material.poisson_ratio < 0.5)) {
    throw std::invalid_argument("Material: poisson_ratio is " +
                                std::to_string(material.poisson_ratio) +
                                ", must be above -1 and below 0.5");
  }
}

void check(const Surfaces& surfaces) {
  if (!(surfaces.friction >= 0.0) || std::isinf(surfaces.friction)) {
    throw std::invalid_argument("Surfaces: friction is " + std::to_string(surfaces.friction) +
                                ", must be finite and not below 0");
  }
  if (!(surfaces.static_friction >= 0.0) || std::isinf(surfaces.static_friction) ||
      (surfaces.static_friction > 0.0 && surfaces.static_friction < surfaces.friction)) {
    throw std::invalid_argument("Surfaces: static_friction is " +
                                std::to_string(surfaces.static_friction) +
                                ", must be finite and not below friction, " +
                                std::to_string(surfaces.friction) + ", or 0 for the same");
  }
  if (!(surfaces.rolling_friction >= 0.0) || std::isinf(surfaces.rolling_friction)) {
    throw std::invalid_argument("Surfaces: rolling_friction is " +
                                std::to_string(surfaces.rolling_friction) +
                                ", must be finite and not below 0");
  }
  if (!(surfaces.restitution > 0.0 && surfaces.restitution <= 1.0)) {
    throw std::invalid_argument("Surfaces: restitution is " + std::to_string(surfaces.restitution) +
                                ", must be above 0 and at most 1");
  }
}

PairMaterial mix(const Material& first,
                 const Material& second,
                 const Surfaces& surfaces,
                 Tension tension,
                 double tangential_damping_ratio,
                 NormalSpring spring,
                 DampingForm form) {
  check(first);
  check(second);
  check(surfaces);
  const auto normal_compliance = [](const Material& m) {
    return (1.0 - m.poisson_ratio * m.poisson_ratio) / m.youngs_modulus;
  };
  const auto shear_compliance = [](const Material& m) {
    return (2.0 - m.poisson_ratio) / shear_modulus(m);
  };
  const double normal = normal_compliance(first) + normal_compliance(second);
  const double shear = shear_compliance(first) + shear_compliance(second);
  if (!(normal > 0.0)) {
    throw std::invalid_argument("mix: both materials are rigid, a contact needs one elastic body");
  }
  PairMaterial pair;
  pair.normal_modulus = 1.0 / normal;
  pair.tangential_ratio = 4.0 * normal / shear;
  pair.friction = surfaces.friction;
  pair.static_friction = std::max(surfaces.static_friction, surfaces.friction);
  pair.rolling_friction = surfaces.rolling_friction;
  const bool is_exact = form == DampingForm::exact;
  pair.damping_ratio =
      damping_ratio_for(surfaces.restitution, is_exact ? tension : Tension::allowed, spring);
  // c_n = 2 sqrt(5/6) beta sqrt(k_n m*) with the tangent stiffness k_n (thesis 1.22, Tsuji et al.
  // 1992); without the 5/6 for a linear spring and in the thesis's form
  const bool is_hertz = is_exact && spring != NormalSpring::linear;
  pair.normal_damping = 2.0 * (is_hertz ? std::sqrt(5.0 / 6.0) : 1.0) * pair.damping_ratio;
  // The tangent stiffness of F = k_n d is 1.5 k_n
  if (spring == NormalSpring::secant) pair.normal_damping *= std::sqrt(1.5);
  // The same with k_t: c_t / c_n = sqrt(k_t / k_n)
  pair.tangential_damping = tangential_damping_ratio * std::sqrt(pair.tangential_ratio);
  return pair;
}

}  // namespace graintruth::sim
