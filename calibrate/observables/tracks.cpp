// Where every grain is, and how it is turned, at the moments of the comparison.
#include "calibrate/compare/repeated_rule.h"
#include "calibrate/observables/moments.h"
#include "calibrate/observables/observable.h"
#include "calibrate/observables/track_results.h"

namespace graintruth::calibrate {

namespace {

class Tracks final : public Observable {
 public:
  std::string name() const override { return "tracks"; }
  ChannelWords words() const override { return {"Tracks", "m, m, rad", "time", "s"}; }
  std::vector<double> axis(const Situation& situation) const override {
    return measurement_times(situation.measurement.frame_interval, situation.measurement.frames);
  }

  Channel measure(const datasets::Recording& recording,
                  const Situation& situation,
                  const Channel*) const override {
    const auto& tracks = recording.tracks;
    if (!tracks || !spans(tracks->time, situation.measurement.last_time())) return {};
    const datasets::Trajectories seen = poses_at(*tracks, axis(situation));
    Channel channel;
    for (const datasets::Pose& pose : seen.poses) {
      for (const double value : {pose.x, pose.z, pose.angle}) channel.values.push_back(value);
    }
    for (const datasets::Pose& sigma : seen.sigmas) {
      for (const double value : {sigma.x, sigma.z, sigma.angle}) channel.errors.push_back(value);
    }
    return channel;
  }
  bool needs_tracks() const override { return true; }
  bool gives_agreement() const override { return true; }

  std::unique_ptr<Rule> rule(const RuleParts& parts) const override {
    auto of = parts.of(name());
    if (!of) return nullptr;
    const auto moments = static_cast<std::size_t>(parts.situations->front().measurement.frames);
    const ChannelShape shape = shape_of_tracks(of->replicates.front().values.size() / moments / 3);
    return std::make_unique<RepeatedRule>(
        of->channel, shape, parts.form, *parts.layout, std::move(of->replicates));
  }
  void tell_measured(const MeasuredExperiment& measured, Results& results) const override {
    tell_tracks(measured, results);
  }
  void conclude(const Problem& problem,
                const Confirmed& confirmed,
                Results& results) const override {
    conclude_agreement(name(), problem, confirmed, results);
  }
  void tell_evaluation(const Problem& problem,
                       const Evaluation& evaluation,
                       Results& results) const override {
    tell_agreement(name(), problem, evaluation, results);
  }
  std::string lacking_words() const override {
    return "tracks of every grain from the start event to the last moment";
  }
};

}  // namespace

extern constinit const ObservableKind tracks_kind{
    .name = "tracks",
    .make = [](const datasets::Experiment&, datasets::TomlSection*)
        -> std::shared_ptr<const Observable> { return std::make_shared<Tracks>(); }};

}  // namespace graintruth::calibrate
