// The angle of repose: a straight line through each flank of the bed at rest, the mean of both.
#include <cmath>

#include "calibrate/observables/outline_results.h"
#include "calibrate/observables/profile_number.h"

namespace graintruth::calibrate {

namespace {

class AngleOfRepose final : public ProfileNumber {
 public:
  using ProfileNumber::ProfileNumber;
  void tell_measured(const MeasuredExperiment& measured, Results& results) const override {
    tell_outlines(measured, results);
  }

 protected:
  std::string_view stem() const override { return "angle_of_repose"; }
  ChannelWords plain_words() const override { return {"Angle of repose", "rad", "", ""}; }
  // A bed with one flank alone, against a wall, has the angle of that.
  std::optional<Value> read_off(const BedProfile& profile,
                                const Situation& situation) const override {
    Value read;
    double squares = 0.0;
    int flanks = 0;
    for (const Side side : {Side::left, Side::right}) {
      const auto flank = flank_of(profile, side, situation);
      if (!flank) continue;
      read.value += flank->angle;
      squares += flank->standard_error * flank->standard_error;
      ++flanks;
      read.details[side == Side::left ? "left" : "right"] = {
          flank->angle, flank->standard_error, flank->roughness, flank->from_x, flank->to_x};
    }
    if (flanks == 0) return std::nullopt;
    read.value /= flanks;
    read.error = std::sqrt(squares) / flanks;
    return read;
  }
};

}  // namespace

extern constinit const ObservableKind angle_of_repose_kind{
    .name = "angle_of_repose",
    .make = make_of_outlines<AngleOfRepose>,
    .make_of_surface = make_of_surface<AngleOfRepose>};

}  // namespace graintruth::calibrate
