#include "tracking/registry.h"

#include <fmt/format.h>

#include <array>

#include "datasets/input_error.h"
#include "tracking/ball_tracker.h"
#include "tracking/bed_tracker.h"
#include "tracking/disc_tracker.h"
#include "tracking/plate_tracker.h"
#include "tracking/rod_tracker.h"

namespace graintruth::tracking {

namespace {

// Makes a tracker, or nothing where the body is of another kind. Throws InputError where it is of
// its kind but cannot be followed in this view.
using Maker = std::unique_ptr<ParticleTracker> (*)(const datasets::TrackingSpec&,
                                                   const datasets::Film&);

constexpr std::array<Maker, 5> makers = {
    make_ball_tracker,
    make_bed_tracker,
    make_disc_tracker,
    make_plate_tracker,
    make_rod_tracker,
};

}  // namespace

std::unique_ptr<ParticleTracker> make_tracker(const datasets::TrackingSpec& spec,
                                              const datasets::Film& film) {
  for (const Maker make : makers)
    if (auto tracker = make(spec, film)) return tracker;
  throw datasets::InputError(fmt::format("{}: particle: no tracker follows bodies of kind '{}'",
                                         film.experiment.string(),
                                         spec.body.kind));
}

}  // namespace graintruth::tracking
