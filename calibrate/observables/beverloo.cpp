// Beverloo's C and k, from the rates of all conditions together.
#include "calibrate/observables/laws_rule.h"
#include "calibrate/observables/observable.h"

namespace graintruth::calibrate {

namespace {

class Beverloo final : public Observable {
 public:
  std::string name() const override { return "beverloo"; }
  ChannelWords words() const override { return {"Beverloo's C and k", "-", "", ""}; }
  // Of all conditions, so of no single recording
  Channel measure(const datasets::Recording&, const Situation&, const Channel*) const override {
    return {};
  }
  bool needs_tracks() const override { return true; }
  std::vector<std::string> needs() const override { return {"discharge_rate"}; }
  std::unique_ptr<Rule> rule(const RuleParts& parts) const override {
    return make_laws_rule(Law::beverloo, parts);
  }
  std::string lacking_words() const override {
    return "tracks of grains that flow steadily through two orifices that are calibrated on";
  }
};

}  // namespace

extern constinit const ObservableKind beverloo_kind{
    .name = "beverloo",
    .make = [](const datasets::Experiment&, datasets::TomlSection*)
        -> std::shared_ptr<const Observable> { return std::make_shared<Beverloo>(); }};

}  // namespace graintruth::calibrate
