// How high the bed at rest is above its floor: its highest column.
#include "calibrate/observables/profile_number.h"

namespace graintruth::calibrate {

namespace {

class FinalHeight final : public ProfileNumber {
 public:
  std::string name() const override { return "final_height"; }
  ChannelWords words() const override { return {"Height of the bed at rest", "m", "", ""}; }

 protected:
  std::optional<Value> read_off(const BedProfile& profile,
                                const Situation& situation) const override {
    const std::size_t apex = *apex_of(profile);
    return Value{profile.z[apex] - situation.rig.seen_outline->floor_z, profile.sigma[apex]};
  }
};

}  // namespace

extern constinit const ObservableKind final_height_kind{.name = "final_height",
                                                        .make = make_of_outlines<FinalHeight>};

}  // namespace graintruth::calibrate
