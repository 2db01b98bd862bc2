#include "tracking/registry.h"

#include <fmt/format.h>

#include <array>

#include "datasets/store/input_error.h"

namespace graintruth::tracking {

// Makes a tracker, or nothing where the body is of another kind. Throws InputError where it is of
// its kind but cannot be followed in this view.
using Maker = std::unique_ptr<ParticleTracker>(const datasets::TrackingSpec&,
                                               const datasets::Film&);

#define KIND(maker) Maker maker;
#include "tracking/trackers.def"
#undef KIND

namespace {

constexpr std::array makers = {
#define KIND(maker) &maker,
#include "tracking/trackers.def"
#undef KIND
};

}  // namespace

std::unique_ptr<ParticleTracker> make_tracker(const datasets::TrackingSpec& spec,
                                              const datasets::Film& film) {
  for (Maker* const make : makers)
    if (auto tracker = make(spec, film)) return tracker;
  throw datasets::InputError(fmt::format("{}: particle: no tracker follows bodies of kind '{}'",
                                         film.experiment.string(),
                                         spec.body.kind));
}

}  // namespace graintruth::tracking
