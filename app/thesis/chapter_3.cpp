#include "app/thesis/chapter_3.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/thesis/button.h"

namespace graintruth::app::chapter_3 {

double critical_step(const ThesisData& thesis) { return thesis.number(misc, "critical_time_step"); }

std::string inputs_of(const ThesisData& thesis, const std::string& study) {
  const sim::Material material = button_material(thesis);
  return fmt::format("{} E={} nu={} step={} weight={}",
                     thesis.settings_text(study),
                     material.youngs_modulus,
                     material.poisson_ratio,
                     critical_step(thesis),
                     thesis.number(misc, "weight_two_sphere_particle"));
}

double number_at(const Studies::Json& json, const char* key) { return json.at(key).get<double>(); }

std::vector<double> numbers_at(const Studies::Json& json, const char* key) {
  return json.at(key).get<std::vector<double>>();
}

double largest_of(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

}  // namespace graintruth::app::chapter_3
