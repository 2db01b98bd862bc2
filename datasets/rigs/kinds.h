// Every kind of rig, one line each; each is defined in a file of this folder.
#pragma once

#include "datasets/rigs/rig_kind.h"

namespace graintruth::datasets {

extern const RigKind hopper_column_piston;
extern const RigKind flat_bin_orifice;
extern const RigKind walls_one_by_one;
extern const RigKind scene_of_a_file;

}  // namespace graintruth::datasets
