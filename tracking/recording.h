// At what rate a film holds pictures, which is not always what a laboratory calls its frame rate.
#pragma once

#include "datasets/experiment.h"

namespace graintruth::tracking {

// The experiment with the rate at which pictures can be had from this film: twice the frame rate
// where frames are woven of two fields and the stated rate is that of the frames.
datasets::Experiment as_recorded(const datasets::Experiment& experiment,
                                 const datasets::Replicate& replicate);

}  // namespace graintruth::tracking
