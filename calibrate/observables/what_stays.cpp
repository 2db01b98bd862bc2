// How many grains are still there at the end.
#include "calibrate/compare/pooled_rule.h"
#include "calibrate/observables/discharge.h"
#include "calibrate/observables/observable.h"

namespace graintruth::calibrate {

namespace {

class WhatStays final : public Observable {
 public:
  std::string name() const override { return "what_stays"; }
  ChannelWords words() const override { return {"Grains that stay", "-", "", ""}; }

  Channel measure(const datasets::Recording& recording,
                  const Situation& situation,
                  const Channel*) const override {
    const auto discharge = discharge_of(recording, situation);
    if (!discharge) return {};
    Channel channel{
        .values = {discharge->particles - static_cast<double>(discharge->times.size())}};
    channel.details["grains"] = {static_cast<double>(discharge->particles)};
    return channel;
  }
  bool needs_tracks() const override { return true; }

  std::unique_ptr<Rule> rule(const RuleParts& parts) const override {
    auto of = parts.of(name());
    if (!of) return nullptr;
    return std::make_unique<PooledRule>(
        of->channel,
        ChannelShape{.resolution = 1.0},  // grains are counted whole
        [](const Channel& measured) { return measured.details.at("grains"); },
        *parts.layout,
        std::move(of->replicates));
  }
  std::vector<std::string> requested_form() const override { return {}; }
  std::string lacking_words() const override {
    return "tracks of grains that leave, or the curve of a balance";
  }
};

}  // namespace

extern constinit const ObservableKind what_stays_kind{
    .name = "what_stays",
    .make = [](const datasets::Experiment&, datasets::TomlSection*)
        -> std::shared_ptr<const Observable> { return std::make_shared<WhatStays>(); }};

}  // namespace graintruth::calibrate
