// How high the heap of all grains reaches, for films in which they cannot be told apart: the height
// of the highest grain's centre.
#include <cmath>
#include <limits>

#include "calibrate/compare/repeated_rule.h"
#include "calibrate/observables/moments.h"
#include "calibrate/observables/observable.h"
#include "calibrate/observables/track_results.h"

namespace graintruth::calibrate {

namespace {

class HeapHeight final : public Observable {
 public:
  std::string name() const override { return "heap_height"; }
  ChannelWords words() const override { return {"Height of the heap", "m", "time", "s"}; }
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
    for (std::size_t frame = 0; frame < seen.frames(); ++frame) {
      double height = std::numeric_limits<double>::quiet_NaN(), error = height;
      for (std::size_t grain = 0; grain < static_cast<std::size_t>(seen.particles); ++grain) {
        const std::size_t i = seen.index(frame, grain);
        if (!(seen.poses[i].z > height) && std::isfinite(height)) continue;
        height = seen.poses[i].z;
        if (!seen.sigmas.empty()) error = seen.sigmas[i].z;
      }
      channel.values.push_back(height);
      if (!seen.sigmas.empty()) channel.errors.push_back(error);
    }
    return channel;
  }
  bool needs_tracks() const override { return true; }
  bool gives_agreement() const override { return true; }

  std::unique_ptr<Rule> rule(const RuleParts& parts) const override {
    auto of = parts.of(name());
    if (!of) return nullptr;
    return std::make_unique<RepeatedRule>(
        of->channel,
        ChannelShape{.widths = Widths::own_replicates, .least_error = {1.0e-5}},  // m
        parts.form,
        *parts.layout,
        std::move(of->replicates));
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
    return "tracks from the start event to the last moment";
  }
};

}  // namespace

extern constinit const ObservableKind heap_height_kind{
    .name = "heap_height",
    .make = [](const datasets::Experiment&, datasets::TomlSection*)
        -> std::shared_ptr<const Observable> { return std::make_shared<HeapHeight>(); }};

}  // namespace graintruth::calibrate
