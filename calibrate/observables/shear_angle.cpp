// The shear angle of a bed that stays beside an opening through which the rest has left: a straight
// line through each of its slopes, which rise from the opening outwards; the mean of both.
#include <cmath>

#include "calibrate/observables/outline_results.h"
#include "calibrate/observables/profile_number.h"

namespace graintruth::calibrate {

namespace {

class ShearAngle final : public ProfileNumber {
 public:
  using ProfileNumber::ProfileNumber;
  void tell_measured(const MeasuredExperiment& measured, Results& results) const override {
    tell_outlines(measured, results);
  }

 protected:
  std::string_view stem() const override { return "shear_angle"; }
  ChannelWords plain_words() const override { return {"Shear angle", "rad", "", ""}; }

  std::optional<Value> read_off(const BedProfile& profile,
                                const Situation& situation) const override {
    Value read;
    double squares = 0.0;
    int slopes = 0;
    for (const Side side : {Side::left, Side::right}) {
      const auto slope = slope_of(profile, side, situation);
      if (!slope) continue;
      read.value += slope->angle;
      squares += slope->standard_error * slope->standard_error;
      ++slopes;
      read.details[side == Side::left ? "left" : "right"] = {
          slope->angle, slope->standard_error, slope->roughness, slope->from_x, slope->to_x};
    }
    if (slopes == 0) return std::nullopt;
    read.value /= slopes;
    read.error = std::sqrt(squares) / slopes;
    return read;
  }
};

}  // namespace

extern constinit const ObservableKind shear_angle_kind{
    .name = "shear_angle",
    .make = make_of_outlines<ShearAngle>,
    .make_of_surface = make_of_surface<ShearAngle>};

}  // namespace graintruth::calibrate
