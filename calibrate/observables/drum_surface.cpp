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

class DrumSurface final : public OfSurface {
 public:
  using OfSurface::OfSurface;

  std::vector<double> axis(const Situation& situation) const override {
    return columns_of(situation, surface());
  }

  Channel measure(const datasets::Recording& recording,
                  const Situation& situation,
                  const Channel* like) const override {
    const datasets::Outline* outline = outline_in(recording);
    if (!outline) return {};
    const auto steady = steady_surface(*outline, situation);
    if (!steady) {
      if (!like || !like->is_known()) return {};
      return {.values = std::vector<double>(like->values.size(), std::nan(""))};
    }
    Channel channel{.values = steady->mean};
    for (const double sd : steady->sd)
      channel.errors.push_back(sd / std::sqrt(steady->independent));
    channel.details["sd_m"] = steady->sd;
    channel.details["slope"] = {steady->slope, steady->slope_error, steady->slope_sd};
    channel.details["independent"] = {steady->independent};
    channel.details["is_drifting"] = {steady->is_drifting ? 1.0 : 0.0};
    return channel;
  }
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
    return rule_of_outlines(
        parts, name(), least_error, bottom_of(parts.situations->front(), surface()));
  }
  void tell_measured(const MeasuredExperiment& measured, Results& results) const override {
    tell_outlines(measured, results);
  }
  std::string lacking_words() const override {
    return OfSurface::lacking_words() + ", with at least 20 moments of a drum that turns steadily";
  }

 protected:
  std::string_view stem() const override { return "drum_surface"; }
  ChannelWords plain_words() const override {
    return {"Mean surface in the drum", "m", "place", "m"};
  }
};

}  // namespace

// A drum has one surface
extern constinit const ObservableKind drum_surface_kind{.name = "drum_surface",
                                                        .make = make_of_outlines<DrumSurface>};

}  // namespace graintruth::calibrate
