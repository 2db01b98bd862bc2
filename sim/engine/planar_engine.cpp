#include "sim/engine/engine_template.h"

namespace graintruth::sim {

template class Engine<2>;

}  // namespace graintruth::sim
