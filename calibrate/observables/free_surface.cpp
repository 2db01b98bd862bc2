// The free surface of a bed at rest: its height in every column, in the last moment of the outline.
#include <cmath>

#include "calibrate/observables/bed_profile.h"
#include "calibrate/observables/outline_results.h"

namespace graintruth::calibrate {

namespace {

// How finely the mean edge of a column is defined at all (datasets/store/silhouette.h), in grain
// diameters: what is claimed to be known better counts as known so well.
constexpr double least_error = 0.01;

class FreeSurface final : public OfSurface {
 public:
  using OfSurface::OfSurface;

  std::vector<double> axis(const Situation& situation) const override {
    return columns_of(situation, surface());
  }

  Channel measure(const datasets::Recording& recording,
                  const Situation& situation,
                  const Channel* like) const override {
    const auto profile = profile_at_rest(recording, situation, surface());
    if (!profile || !apex_of(*profile)) {
      // Of a simulation all grains have left what is looked at
      if (!like || !like->is_known()) return {};
      return {.values = std::vector<double>(like->values.size(),
                                            surface_of(situation, surface()).floor_z)};
    }
    Channel channel{.values = profile->z};
    if (!outline_in(recording)->sigma.empty()) channel.errors = profile->sigma;
    return channel;
  }

  std::unique_ptr<Rule> rule(const RuleParts& parts) const override {
    return rule_of_outlines(
        parts, name(), least_error, bottom_of(parts.situations->front(), surface()));
  }
  void tell_measured(const MeasuredExperiment& measured, Results& results) const override {
    tell_outlines(measured, results);
  }

 protected:
  std::string_view stem() const override { return "free_surface"; }
  ChannelWords plain_words() const override { return {"Free surface at rest", "m", "place", "m"}; }
};

}  // namespace

extern constinit const ObservableKind free_surface_kind{
    .name = "free_surface",
    .make = make_of_outlines<FreeSurface>,
    .make_of_surface = make_of_surface<FreeSurface>};

}  // namespace graintruth::calibrate
