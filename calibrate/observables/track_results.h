// What is told of tracks, and of other values that replicates repeat: the thesis's agreement, with
// everything that one needs to read it, mean tracks and bands.
#pragma once

#include <string_view>

#include "calibrate/problem.h"
#include "calibrate/result/confirmation.h"
#include "calibrate/result/results.h"

namespace graintruth::calibrate {

// Values of tracks: x, z and angle of every grain at every moment.
ChannelShape shape_of_tracks(std::size_t grains);

// Root of the mean over bodies and moments of the squared distance of positions, m. Unseen ones are
// left out.
double rms_position(const std::vector<double>& a,
                    const std::vector<double>& b,
                    const ChannelShape& shape);

void tell_tracks(const MeasuredExperiment& measured, Results& results);
// Of the first condition that is calibrated on.
void conclude_agreement(std::string_view observable,
                        const Problem& problem,
                        const Confirmed& confirmed,
                        Results& results);

// Agreement in both forms, and the distance of positions, of one evaluation.
void tell_agreement(std::string_view observable,
                    const Problem& problem,
                    const Evaluation& evaluation,
                    Results& results);

}  // namespace graintruth::calibrate
