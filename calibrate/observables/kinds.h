// Every observable, one line each; each is defined in a file of this folder.
#pragma once

#include "calibrate/observables/observable.h"

namespace graintruth::calibrate {

extern const ObservableKind tracks_kind;
extern const ObservableKind heap_height_kind;
extern const ObservableKind discharge_rate_kind;
extern const ObservableKind what_stays_kind;
extern const ObservableKind flowing_density_kind;
extern const ObservableKind velocity_profile_kind;
extern const ObservableKind beverloo_kind;
extern const ObservableKind kinematic_kind;
extern const ObservableKind own_curve_kind;

}  // namespace graintruth::calibrate
