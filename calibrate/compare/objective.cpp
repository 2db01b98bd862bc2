#include "calibrate/compare/objective.h"

#include <cmath>

namespace graintruth::calibrate {

double pseudo_huber(double z) { return std::sqrt(1.0 + 0.25 * z * z) - 1.0; }

double loss_of(datasets::ObjectiveForm form, double z) {
  if (form == datasets::ObjectiveForm::smooth) return pseudo_huber(z);
  return std::abs(z) > 1.0 ? 1.0 : 0.0;
}

}  // namespace graintruth::calibrate
