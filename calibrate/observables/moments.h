// Values at the moments of the comparison, 0, interval, 2 interval, ...
#pragma once

#include <optional>
#include <vector>

#include "calibrate/observables/observable.h"
#include "datasets/experiment/recording.h"

namespace graintruth::calibrate {

std::vector<double> measurement_times(double interval, int frames);

// The poses at these moments; as they are where they were recorded at just these.
datasets::Trajectories poses_at(const datasets::Trajectories& tracks,
                                const std::vector<double>& times);

// Whether a recording reaches from 0 to the last moment, up to half a frame.
bool spans(const std::vector<double>& time, double last);

}  // namespace graintruth::calibrate
