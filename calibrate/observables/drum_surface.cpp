// The mean surface of a bed in a drum that turns steadily: its height in every column.
#include <fmt/format.h>

#include <cmath>

#include "calibrate/observables/outline_results.h"
#include "calibrate/observables/steady_surface.h"

namespace graintruth::calibrate {

namespace {

// Fewer independent moments tell a mean, but not how well it is known.
constexpr double fewest_independent = 5.0;
constexpr double least_error = 0.01;  // grain diameters, as of a free surface at rest

class DrumSurface final : public Observable {
 public:
  std::string name() const override { return "drum_surface"; }
  ChannelWords words() const override { return {"Mean surface in the drum", "m", "place", "m"}; }
  std::vector<double> axis(const Situation& situation) const override {
    return columns_of(situation);
  }

  Channel measure(const datasets::Recording& recording,
                  const Situation& situation,
                  const Channel* like) const override {
    if (!recording.outline || recording.outline->column.size() < 2) return {};
    const auto surface = steady_surface(*recording.outline, situation);
    if (!surface) {
      if (!like || !like->is_known()) return {};
      return {.values = std::vector<double>(like->values.size(), std::nan(""))};
    }
    Channel channel{.values = surface->mean};
    for (const double sd : surface->sd)
      channel.errors.push_back(sd / std::sqrt(surface->independent));
    channel.details["sd_m"] = surface->sd;
    channel.details["slope"] = {surface->slope, surface->slope_error, surface->slope_sd};
    channel.details["independent"] = {surface->independent};
    channel.details["is_drifting"] = {surface->is_drifting ? 1.0 : 0.0};
    return channel;
  }
  bool needs_outline() const override { return true; }
  std::string contradiction(const Channel& channel, const Situation&) const override {
    if (!channel.is_known()) return "";
    if (channel.details.at("is_drifting").front() > 0.0) {
      return "the surface drifts to the end of the recording, so the drum is not steady yet; let "
             "it "
             "turn for longer before you film";
    }
    const double independent = channel.details.at("independent").front();
    if (independent >= fewest_independent) return "";
    return fmt::format(
        "the slope of the surface changes so slowly that the recording is worth {:.1f} independent "
        "looks at it, but at least {:.0f} are needed; film for longer",
        independent,
        fewest_independent);
  }

  std::unique_ptr<Rule> rule(const RuleParts& parts) const override {
    return rule_of_outlines(parts, name(), least_error, bottom_of(parts.situations->front()));
  }
  void tell_measured(const MeasuredExperiment& measured, Results& results) const override {
    tell_outlines(measured, results);
  }
  std::string lacking_words() const override {
    return std::string(lacking_outline) +
           ", with at least 20 moments of a drum that turns steadily";
  }
};

}  // namespace

extern constinit const ObservableKind drum_surface_kind{.name = "drum_surface",
                                                        .make = make_of_outlines<DrumSurface>};

}  // namespace graintruth::calibrate
