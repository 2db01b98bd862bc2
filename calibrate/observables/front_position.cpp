// How far the bed has come to reach beyond where it stood before the event, both sides together, at
// the moments of the comparison.
#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/observables/bed_profile.h"
#include "calibrate/observables/moments.h"

namespace graintruth::calibrate {

namespace {

// Grain diameters: between two columns the foot is known by a straight line
constexpr double least_error = 0.25;

class FrontPosition final : public OfSurface {
 public:
  using OfSurface::OfSurface;

  std::vector<double> axis(const Situation& situation) const override {
    return measurement_times(situation.measurement.frame_interval, situation.measurement.frames);
  }

  // At the moment of the outline that is nearest. What has come to rest stays: a simulation ends
  // there.
  Channel measure(const datasets::Recording& recording,
                  const Situation& situation,
                  const Channel* like) const override {
    const datasets::Outline* outline = outline_in(recording);
    if (!outline) return {};
    Channel channel;
    for (const double time : axis(situation)) {
      const std::vector<double>& times = outline->time;
      const auto nearest = std::min_element(times.begin(), times.end(), [&](double a, double b) {
        return std::abs(a - time) < std::abs(b - time);
      });
      const BedProfile profile =
          profile_at(*outline, static_cast<std::size_t>(nearest - times.begin()), situation);
      channel.values.push_back(foot_of(profile, Side::right, situation) -
                               foot_of(profile, Side::left, situation) -
                               first_width(situation, surface()));
    }
    if (like && like->is_known()) return channel;
    if (std::none_of(channel.values.begin(), channel.values.end(), [](double value) {
          return std::isfinite(value);
        })) {
      return {};
    }
    return channel;
  }

  std::unique_ptr<Rule> rule(const RuleParts& parts) const override {
    return rule_of_outlines(parts, name(), least_error);
  }

 protected:
  std::string_view stem() const override { return "front_position"; }
  ChannelWords plain_words() const override { return {"Way of the front", "m", "time", "s"}; }
};

}  // namespace

extern constinit const ObservableKind front_position_kind{
    .name = "front_position",
    .make = make_of_outlines<FrontPosition>,
    .make_of_surface = make_of_surface<FrontPosition>};

}  // namespace graintruth::calibrate
