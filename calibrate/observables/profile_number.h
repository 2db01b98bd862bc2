// One number that is read off the profile of a bed at rest. Replicates of all conditions tell how
// much it scatters.
#pragma once

#include <optional>

#include "calibrate/observables/bed_profile.h"

namespace graintruth::calibrate {

class ProfileNumber : public OfSurface {
 public:
  using OfSurface::OfSurface;

  // Number, standard deviation of its measurement (NaN: none known) and details.
  struct Value {
    double value = 0.0, error = 0.0;
    std::map<std::string, std::vector<double>> details = {};
  };

  // A simulation whose bed has spread so far that it does not tell it counts as one in which
  // nothing moves.
  Channel measure(const datasets::Recording& recording,
                  const Situation& situation,
                  const Channel* like) const override {
    const auto profile = profile_at_rest(recording, situation, surface());
    std::optional<Value> read;
    if (profile && apex_of(*profile)) read = read_off(*profile, situation);
    if (!read) return like && like->is_known() ? Channel{.values = {at_rest}} : Channel{};
    return {.values = {read->value}, .errors = {read->error}, .details = read->details};
  }
  std::unique_ptr<Rule> rule(const RuleParts& parts) const override;

 protected:
  static constexpr double at_rest = 0.0;

  // Nothing where the profile does not tell it.
  virtual std::optional<Value> read_off(const BedProfile& profile,
                                        const Situation& situation) const = 0;
};

}  // namespace graintruth::calibrate
