#include "calibrate/knowledge/sensitivity.h"

#include <algorithm>
#include <openturns/ComposedDistribution.hxx>
#include <openturns/LowDiscrepancyExperiment.hxx>
#include <openturns/SaltelliSensitivityAlgorithm.hxx>
#include <openturns/SobolIndicesExperiment.hxx>
#include <openturns/SobolSequence.hxx>
#include <openturns/Uniform.hxx>

namespace graintruth::calibrate {

std::vector<double> total_sensitivities(const Surrogate& surrogate, std::size_t dimension) {
  constexpr OT::UnsignedInteger base = 512;  // times dimension + 2 places
  // 1. Two designs and their mixtures, of a low-discrepancy sequence: nothing is drawn
  const OT::ComposedDistribution cube(
      OT::ComposedDistribution::DistributionCollection(dimension, OT::Uniform(0.0, 1.0)));
  const OT::LowDiscrepancyExperiment experiment(
      OT::SobolSequence(dimension), cube, base, /*restart=*/true);
  const OT::Sample inputs = OT::SobolIndicesExperiment(experiment).generate();
  // 2. The surrogate there
  std::vector<UnitPoint> places;
  for (OT::UnsignedInteger i = 0; i < inputs.getSize(); ++i) {
    places.emplace_back();
    for (OT::UnsignedInteger d = 0; d < dimension; ++d) places.back().push_back(inputs(i, d));
  }
  OT::Sample outputs(inputs.getSize(), 1);
  const std::vector<Surrogate::Prediction> predictions = surrogate.predict(places);
  for (std::size_t i = 0; i < predictions.size(); ++i) outputs(i, 0) = predictions[i].mean;
  // 3. Its indices
  const OT::Point total =
      OT::SaltelliSensitivityAlgorithm(inputs, outputs, base).getTotalOrderIndices();
  std::vector<double> indices;
  for (const double index : total) indices.push_back(std::clamp(index, 0.0, 1.0));
  return indices;
}

}  // namespace graintruth::calibrate
