// How fast the bed sinks, across its width, at one height, while it flows steadily.
#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/compare/pooled_rule.h"
#include "calibrate/observables/discharge.h"
#include "calibrate/observables/observable.h"

namespace graintruth::calibrate {

namespace {

class VelocityProfileObservable final : public Observable {
 public:
  std::string name() const override { return "velocity_profile"; }
  ChannelWords words() const override { return {"Velocity profile", "m/s", "x", "m"}; }
  std::vector<double> axis(const Situation& situation) const override {
    const BulkRig rig = bulk_rig(situation);
    const std::size_t bins = profile_bins(rig);
    std::vector<double> middles;
    for (std::size_t bin = 0; bin < bins; ++bin) {
      middles.push_back(((static_cast<double>(bin) + 0.5) / static_cast<double>(bins) - 0.5) *
                        rig.width);
    }
    return middles;
  }

  // Bins that no grain passes are not known; nor is any where there are no tracks.
  Channel measure(const datasets::Recording& recording,
                  const Situation& situation,
                  const Channel* like) const override {
    if (!situation.rig.bed) return {};
    const BulkRig rig = bulk_rig(situation);
    const std::size_t bins = profile_bins(rig);
    Channel channel{.values = std::vector<double>(bins, std::numeric_limits<double>::quiet_NaN())};
    if (!recording.tracks || recording.tracks->frames() == 0) return channel;
    std::optional<double> height;
    if (like) {
      if (const auto at = like->details.find("height_m"); at != like->details.end())
        height = at->second.front();
    }
    const BulkMeasurement bulk = measure_bulk(*recording.tracks, rig, height);
    for (const VelocitySample& sample : bulk.profile.samples) {
      const double bin = std::floor((sample.x / rig.width + 0.5) * static_cast<double>(bins));
      channel
          .values[static_cast<std::size_t>(std::clamp(bin, 0.0, static_cast<double>(bins - 1)))] =
          sample.velocity;
    }
    put_profile(bulk.profile, channel);
    channel.details["stagnant_heights_m"] = bulk.stagnant_heights;
    return channel;
  }
  bool needs_tracks() const override { return true; }

  std::unique_ptr<Rule> rule(const RuleParts& parts) const override {
    auto of = parts.of(name());
    if (!of) return nullptr;
    return std::make_unique<PooledRule>(
        of->channel,
        ChannelShape{.series = of->replicates.front().values.size(),
                     .relative = Relative::to_largest},
        [](const Channel& measured) { return std::vector<double>(measured.values.size(), 0.0); },
        *parts.layout,
        std::move(of->replicates));
  }
  std::vector<std::string> requested_form() const override { return {"kinematic"}; }
  std::string lacking_words() const override { return "tracks of a bed that flows steadily"; }
};

}  // namespace

extern constinit const ObservableKind velocity_profile_kind{
    .name = "velocity_profile",
    .make = [](const datasets::Experiment&,
               datasets::TomlSection*) -> std::shared_ptr<const Observable> {
      return std::make_shared<VelocityProfileObservable>();
    }};

}  // namespace graintruth::calibrate
