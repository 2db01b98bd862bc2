// The kinematic model's B, from the velocity profile of each condition.
#include "calibrate/observables/laws_rule.h"
#include "calibrate/observables/observable.h"

namespace graintruth::calibrate {

namespace {

class Kinematic final : public Observable {
 public:
  std::string name() const override { return "kinematic"; }
  ChannelWords words() const override { return {"Kinematic B", "m", "", ""}; }
  // Of the mean profile of a condition, so of no single recording
  Channel measure(const datasets::Recording&, const Situation&, const Channel*) const override {
    return {};
  }
  bool needs_tracks() const override { return true; }
  std::vector<std::string> needs() const override { return {"velocity_profile"}; }
  std::unique_ptr<Rule> rule(const RuleParts& parts) const override {
    return make_laws_rule(Law::kinematic, parts);
  }
  std::string lacking_words() const override {
    return "tracks of a bed that flows steadily, of two replicates of a condition";
  }
};

}  // namespace

extern constinit const ObservableKind kinematic_kind{
    .name = "kinematic",
    .make = [](const datasets::Experiment&, datasets::TomlSection*)
        -> std::shared_ptr<const Observable> { return std::make_shared<Kinematic>(); }};

}  // namespace graintruth::calibrate
