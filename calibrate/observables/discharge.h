// What observables of a bed that runs out have in common: a recording as bulk measures see it, and
// these measures in a channel's details and back.
#pragma once

#include "calibrate/flow/bulk_measure.h"
#include "calibrate/observables/observable.h"

namespace graintruth::calibrate {

// From tracks, or else from the discharge; none where a recording has neither.
std::optional<Discharge> discharge_of(const datasets::Recording& recording,
                                      const Situation& situation);

// As channels of an experiment hold it. `of` finds a channel by its observable's name; null where
// there is none.
BulkMeasurement bulk_from(const std::function<const Channel*(std::string_view)>& of);

void put_discharge(const Discharge& discharge, bool of_tracks, Channel& channel);
void put_bed(const BedShape& bed, Channel& channel);
void put_profile(const VelocityProfile& profile, Channel& channel);

}  // namespace graintruth::calibrate
