// Channels in the archives of store/archive.h.
#pragma once

#include "calibrate/observables/channel.h"
#include "datasets/store/archive.h"

namespace graintruth::calibrate {

template <class Archive>
void list_fields(Archive& archive, Channel& channel) {
  auto& [values, errors, details] = channel;
  archive("values", values)("errors", errors)("details", details);
}

}  // namespace graintruth::calibrate
