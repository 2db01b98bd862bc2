// How far the bed at rest reaches beyond where it stood before the event, both sides together.
#include <cmath>
#include <limits>

#include "calibrate/observables/profile_number.h"

namespace graintruth::calibrate {

namespace {

class RunOut final : public ProfileNumber {
 public:
  using ProfileNumber::ProfileNumber;

 protected:
  std::string_view stem() const override { return "run_out"; }
  ChannelWords plain_words() const override { return {"Run-out", "m", "", ""}; }
  std::optional<Value> read_off(const BedProfile& profile,
                                const Situation& situation) const override {
    const double length =
        foot_of(profile, Side::right, situation) - foot_of(profile, Side::left, situation);
    if (!std::isfinite(length)) return std::nullopt;
    return Value{length - first_width(situation, surface()),
                 std::numeric_limits<double>::quiet_NaN()};
  }
};

}  // namespace

extern constinit const ObservableKind run_out_kind{.name = "run_out",
                                                   .make = make_of_outlines<RunOut>,
                                                   .make_of_surface = make_of_surface<RunOut>};

}  // namespace graintruth::calibrate
