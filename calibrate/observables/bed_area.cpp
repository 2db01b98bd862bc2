// How much of the picture the bed at rest covers: the area between its outline and its floor. Times
// the depth of the box and the bulk density it is the mass that lies there.
#include <cmath>

#include "calibrate/observables/profile_number.h"

namespace graintruth::calibrate {

namespace {

class BedArea final : public ProfileNumber {
 public:
  using ProfileNumber::ProfileNumber;

 protected:
  std::string_view stem() const override { return "bed_area"; }
  ChannelWords plain_words() const override { return {"Area of the bed at rest", "m2", "", ""}; }

  // Nothing where a part of it is hidden.
  std::optional<Value> read_off(const BedProfile& profile, const Situation&) const override {
    const double width = profile.x[1] - profile.x[0];
    double area = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < profile.z.size(); ++i) {
      if (std::isnan(profile.z[i])) return std::nullopt;
      area += width * (profile.z[i] - profile.floor);
      // What is bare floor is known without an error of its own
      if (profile.z[i] > profile.floor) squares += profile.sigma[i] * profile.sigma[i];
    }
    return Value{area, width * std::sqrt(squares)};
  }
};

}  // namespace

extern constinit const ObservableKind bed_area_kind{.name = "bed_area",
                                                    .make = make_of_outlines<BedArea>,
                                                    .make_of_surface = make_of_surface<BedArea>};

}  // namespace graintruth::calibrate
