// The mass that leaves in a second: steady, or the mean over the run where nothing was steady.
#include <limits>

#include "calibrate/compare/pooled_rule.h"
#include "calibrate/observables/discharge.h"
#include "calibrate/observables/flow_results.h"
#include "calibrate/observables/observable.h"

namespace graintruth::calibrate {

namespace {

class DischargeRate final : public Observable {
 public:
  std::string name() const override { return "discharge_rate"; }
  ChannelWords words() const override { return {"Discharge rate", "kg/s", "", ""}; }

  Channel measure(const datasets::Recording& recording,
                  const Situation& situation,
                  const Channel*) const override {
    const auto discharge = discharge_of(recording, situation);
    if (!discharge) return {};
    const BulkRig rig = bulk_rig(situation);
    Channel channel;
    const auto steady = steady_rate(*discharge, rig);
    channel.values = {rate_of(*discharge, rig)};
    channel.errors = {steady ? steady->standard_error : std::numeric_limits<double>::quiet_NaN()};
    put_discharge(*discharge, recording.tracks.has_value(), channel);
    return channel;
  }
  bool needs_tracks() const override { return true; }

  std::unique_ptr<Rule> rule(const RuleParts& parts) const override {
    auto of = parts.of(name());
    if (!of) return nullptr;
    return std::make_unique<PooledRule>(
        of->channel,
        ChannelShape{.relative = Relative::to_mean},
        [](const Channel&) { return std::vector<double>{0.0}; },
        *parts.layout,
        std::move(of->replicates));
  }
  std::vector<std::string> needs() const override { return {"flowing_density"}; }
  std::vector<std::string> requested_form() const override { return {"beverloo"}; }
  void tell_measured(const MeasuredExperiment& measured, Results& results) const override {
    tell_flow(measured, results);
  }
  void conclude(const Problem& problem,
                const Confirmed& confirmed,
                Results& results) const override {
    conclude_flow(problem, confirmed, results);
  }
  void tell_evaluation(const Problem& problem,
                       const Evaluation& evaluation,
                       Results& results) const override {
    tell_rates(problem, evaluation, results);
  }
  std::string lacking_words() const override {
    return "tracks of grains that leave, or the curve of a balance";
  }
};

}  // namespace

extern constinit const ObservableKind discharge_rate_kind{
    .name = "discharge_rate",
    .make = [](const datasets::Experiment&, datasets::TomlSection*)
        -> std::shared_ptr<const Observable> { return std::make_shared<DischargeRate>(); }};

}  // namespace graintruth::calibrate
