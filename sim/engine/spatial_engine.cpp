#include "sim/engine/engine_template.h"

namespace graintruth::sim {

template class Engine<3>;

}  // namespace graintruth::sim
