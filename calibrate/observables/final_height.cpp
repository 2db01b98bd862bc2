// How high the bed at rest is above its floor: its highest column.
#include "calibrate/observables/profile_number.h"

namespace graintruth::calibrate {

namespace {

class FinalHeight final : public ProfileNumber {
 public:
  using ProfileNumber::ProfileNumber;

 protected:
  std::string_view stem() const override { return "final_height"; }
  ChannelWords plain_words() const override { return {"Height of the bed at rest", "m", "", ""}; }
  std::optional<Value> read_off(const BedProfile& profile, const Situation&) const override {
    const std::size_t apex = *apex_of(profile);
    return Value{profile.z[apex] - profile.floor, profile.sigma[apex]};
  }
};

}  // namespace

extern constinit const ObservableKind final_height_kind{
    .name = "final_height",
    .make = make_of_outlines<FinalHeight>,
    .make_of_surface = make_of_surface<FinalHeight>};

}  // namespace graintruth::calibrate
