#include "app/thesis/button.h"

#include <cmath>
#include <numbers>

namespace graintruth::app {

namespace {

const std::string table = "table_4_3_macro_properties";

}  // namespace

Ellipse button_ellipse(const ThesisData& thesis) {
  return {thesis.si(table, "semi_axis_a"), thesis.si(table, "semi_axis_b")};
}

sim::Material button_material(const ThesisData& thesis) {
  return {thesis.si(table, "elastic_modulus"), thesis.number(table, "poisson_ratio")};
}

double button_density(const ThesisData& thesis) {
  const Ellipse ellipse = button_ellipse(thesis);
  return thesis.si(table, "mass") /
         (std::numbers::pi * ellipse.along * ellipse.across * thesis.si(table, "thickness"));
}

double button_diameter(const ThesisData& thesis) {
  const Ellipse ellipse = button_ellipse(thesis);
  return 2.0 * std::sqrt(ellipse.along * ellipse.across);
}

sim::ProfileFit button_fit(const ThesisData& thesis) {
  const Ellipse ellipse = button_ellipse(thesis);
  const int spheres =
      static_cast<int>(std::lround(thesis.number(table, "element_spheres_per_model_particle")));
  return sim::fit_profile(sim::ellipse_profile(ellipse.along, ellipse.across), spheres + 1);
}

}  // namespace graintruth::app
