// Chapter 5 from printed data: particles of equal volume, what the shape study ran with.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "app/thesis/targets.h"
#include "sim/laws/time_step.h"
#include "sim/shapes/profile.h"

namespace graintruth::app {

namespace {

const std::string parameters = "table_5_1_parameters";
const std::string scalars = "ch5_scalars";

}  // namespace

// R_n = R (1/n)^(1/3)   (5.1)
void examine_eq_5_1(Examination& exam, const ThesisData& thesis) {
  const std::string name = "eq_5_1_element_radius";
  const datasets::Table& table = thesis.table(name);
  const double centimetre = unit_in_si("cm");
  const double radius = thesis.si(parameters, "radius_equivalent_sphere");
  const double volume = 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const int count = table.integer(row, "aspect_ratio_n");
    const double element = sim::chain_of_volume(count, count, volume).front().radius / centimetre;
    const std::string n = fmt::format("n = {}: ", count);
    exam.compare(n + "radius", thesis.cell(name, row, "element_radius_cm", "cm"), element);
    exam.compare(
        n + "length", thesis.cell(name, row, "particle_length_cm", "cm"), 2.0 * count * element);
    exam.compare(n + "projected area",
                 thesis.cell(name, row, "projected_area_cm2", "cm2"),
                 count * std::numbers::pi * element * element);
    exam.compare(
        n + "layer thickness", thesis.cell(name, row, "layer_thickness_cm", "cm"), 2.0 * element);
  }
  const double weight = thesis.number(parameters, "particles") *
                        thesis.si(parameters, "particle_density") * volume * 9.81;
  exam.compare("weight of the bed, derived", thesis.printed(scalars, "weight_of_bed"), weight);
}

void examine_table_5_1(Examination& exam, const ThesisData& thesis) {
  const datasets::Table& table = thesis.table(parameters);
  const double particles = thesis.number(parameters, "particles");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string& parameter = table.text(row, "parameter");
    const Printed printed = thesis.cell(parameters, row, "value", table.text(row, "unit"));
    const std::string spheres = "element_spheres_AR";
    if (parameter.starts_with(spheres)) {
      exam.compare(
          parameter, printed, particles * Printed{parameter.substr(spheres.size())}.value());
    } else if (parameter == "time_step") {
      // Eq 1.28 without the pi (errata 1), of the smallest spheres: those of aspect ratio 4
      const datasets::Table& radii = thesis.table("eq_5_1_element_radius");
      const sim::Material material{thesis.si(parameters, "elastic_modulus"),
                                   thesis.number(parameters, "poisson_ratio")};
      const auto step = [&](std::size_t of) {
        return sim::rayleigh_time_step(radii.number(of, "element_radius_cm") * unit_in_si("cm"),
                                       thesis.si(parameters, "particle_density"),
                                       material) /
               std::numbers::pi;
      };
      Printed two_digits = printed;
      two_digits.text = thesis.worded("table-5.1", "time step").text;
      exam.compare(parameter,
                   two_digits,
                   step(radii.rows() - 1),
                   fmt::format("eq 1.28 without the pi, spheres of aspect ratio 4; spheres of 1 cm "
                               "would allow {:.3e} s (errata 59)",
                               step(0)));
    } else {
      exam.take(parameter, printed);
    }
  }
  exam.compare_worded("hopper width in diameters",
                      thesis.si(parameters, "hopper_width") /
                          (2.0 * thesis.si(parameters, "radius_equivalent_sphere")));
}

void examine_table_5_2(Examination& exam, const ThesisData& thesis) {
  const std::string name = "table_5_2_solid_fraction_shape";
  const datasets::Table& table = thesis.table(name);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string ratio = fmt::format("aspect ratio {}: ", table.text(row, "aspect_ratio"));
    // simulate_table_5_2 puts what is stored of the beds in their place
    for (const char* column : {"skewness", "kurtosis"}) {
      exam.not_run(ratio + column,
                   thesis.cell(name, row, column, "-"),
                   "no bed of study-shape is stored in this folder");
    }
  }
  // The kurtosis of a normal distribution is 3
  exam.compare_worded(
      "text: a higher kurtosis is closer to normal",
      (table.number(table.rows() - 1, "kurtosis") - 3.0) - (table.number(0, "kurtosis") - 3.0));
}

}  // namespace graintruth::app
