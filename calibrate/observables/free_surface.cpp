// The free surface of a bed at rest: its height in every column, in the last moment of the outline.
#include <cmath>

#include "calibrate/observables/bed_profile.h"
#include "calibrate/observables/outline_results.h"

namespace graintruth::calibrate {

namespace {

// How finely the mean edge of a column is defined at all (datasets/store/silhouette.h), in grain
// diameters: what is claimed to be known better counts as known so well.
constexpr double least_error = 0.01;

class FreeSurface final : public Observable {
 public:
  std::string name() const override { return "free_surface"; }
  ChannelWords words() const override { return {"Free surface at rest", "m", "place", "m"}; }
  std::vector<double> axis(const Situation& situation) const override {
    return columns_of(situation);
  }

  Channel measure(const datasets::Recording& recording,
                  const Situation& situation,
                  const Channel* like) const override {
    const auto profile = profile_at_rest(recording, situation);
    if (!profile || !apex_of(*profile)) {
      // Of a simulation all grains have left what is looked at
      if (!like || !like->is_known()) return {};
      return {.values =
                  std::vector<double>(like->values.size(), situation.rig.seen_outline->floor_z)};
    }
    Channel channel{.values = profile->z};
    if (!recording.outline->sigma.empty()) channel.errors = profile->sigma;
    return channel;
  }
  bool needs_outline() const override { return true; }

  std::unique_ptr<Rule> rule(const RuleParts& parts) const override {
    return rule_of_outlines(parts, name(), least_error, bottom_of(parts.situations->front()));
  }
  void tell_measured(const MeasuredExperiment& measured, Results& results) const override {
    tell_outlines(measured, results);
  }
  std::string lacking_words() const override { return lacking_outline; }
};

}  // namespace

extern constinit const ObservableKind free_surface_kind{.name = "free_surface",
                                                        .make = make_of_outlines<FreeSurface>};

}  // namespace graintruth::calibrate
