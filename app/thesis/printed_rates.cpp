#include "app/thesis/printed_rates.h"

namespace graintruth::app {

std::vector<calibrate::DischargeRate> printed_rates(const ThesisData& thesis,
                                                    const std::string& name,
                                                    double diameter) {
  const datasets::Table& table = thesis.table(name);
  std::vector<calibrate::DischargeRate> rates;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    rates.push_back(
        {.orifice = table.number(row, "orifice_D_cm") * unit_in_si("cm"),
         .rate = table.number(row, "flow_rate_q_g_per_s") * unit_in_si("g"),
         .density = table.number(row, "areal_density_rho_g_per_cm2") * unit_in_si("g/cm2"),
         .particle_diameter = diameter});
  }
  return rates;
}

}  // namespace graintruth::app
