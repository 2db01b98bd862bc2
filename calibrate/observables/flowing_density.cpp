// How densely the bed lies while it flows steadily: mass over the area that it takes in the
// picture.
#include <limits>

#include "calibrate/compare/pooled_rule.h"
#include "calibrate/observables/discharge.h"
#include "calibrate/observables/observable.h"

namespace graintruth::calibrate {

namespace {

class FlowingDensity final : public Observable {
 public:
  std::string name() const override { return "flowing_density"; }
  ChannelWords words() const override { return {"Density of the flowing bed", "kg/m2", "", ""}; }

  Channel measure(const datasets::Recording& recording,
                  const Situation& situation,
                  const Channel*) const override {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    if (!recording.tracks || recording.tracks->frames() == 0 || !situation.rig.bed)
      return {.values = {nan}};
    const BulkMeasurement bulk = measure_bulk(*recording.tracks, bulk_rig(situation));
    Channel channel{.values = {bulk.flowing_density > 0.0 ? bulk.flowing_density : nan}};
    put_bed(bulk.at_rest, channel);
    return channel;
  }
  bool needs_tracks() const override { return true; }

  std::unique_ptr<Rule> rule(const RuleParts& parts) const override {
    auto of = parts.of(name());
    if (!of) return nullptr;
    return std::make_unique<PooledRule>(
        of->channel,
        ChannelShape{.relative = Relative::to_mean},
        [](const Channel& measured) { return measured.values; },  // as dense as it lies
        *parts.layout,
        std::move(of->replicates));
  }
  std::string lacking_words() const override { return "tracks of a bed that flows steadily"; }
};

}  // namespace

extern constinit const ObservableKind flowing_density_kind{
    .name = "flowing_density",
    .make = [](const datasets::Experiment&, datasets::TomlSection*)
        -> std::shared_ptr<const Observable> { return std::make_shared<FlowingDensity>(); }};

}  // namespace graintruth::calibrate
