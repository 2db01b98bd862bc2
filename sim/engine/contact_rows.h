// Between bodies and the rows of a batch: which candidates touch, what the law needs of their
// bodies, and what its forces do to them.
#pragma once

#include "sim/engine/contact_batch.h"
#include "sim/engine/contacts.h"
#include "sim/engine/slab_loads.h"
#include "sim/engine/wall_surfaces.h"

namespace graintruth::sim {

// What the force loop needs besides bodies and contacts.
struct ForceSetting {
  const PairTable* pairs;
  int material_count;
  double slip_time;        // s; how long the half-step velocities have moved the bodies
  double largest_overlap;  // share of the smaller radius above which the run is no longer trusted
};

// The rows of the candidates of a range that touch: their number, `candidate` and `was_touching`.
// With `commits` the list is told.
void find_touching(const CandidateRange& range,
                   bool commits,
                   const Bodies<2>& bodies,
                   ContactList<2>& list,
                   ContactBatch<2>& batch);
void find_touching(const CandidateRange& range,
                   bool commits,
                   const Bodies<3>& bodies,
                   ContactList<3>& list,
                   ContactBatch<3>& batch);

// What the law needs of the bodies and the history of these rows.
void gather_pairs(const ForceSetting& setting,
                  const ContactList<2>& list,
                  const Bodies<2>& bodies,
                  ContactBatch<2>& batch);
void gather_pairs(const ForceSetting& setting,
                  const ContactList<3>& list,
                  const Bodies<3>& bodies,
                  ContactBatch<3>& batch);

// The same at walls. Overlap and normal are there already.
void gather_walls(const ForceSetting& setting,
                  const ContactList<2>& list,
                  const Bodies<2>& bodies,
                  const WallSurfaces<2>& surfaces,
                  ContactBatch<2>& batch);
void gather_walls(const ForceSetting& setting,
                  const ContactList<3>& list,
                  const Bodies<3>& bodies,
                  const WallSurfaces<3>& surfaces,
                  ContactBatch<3>& batch);

// Action and reaction; on the first bodies alone.
void load_pairs(ContactBatch<2>& batch, Bodies<2>& bodies, SlabLoads<2>& slab);
void load_pairs(ContactBatch<3>& batch, Bodies<3>& bodies, SlabLoads<3>& slab);
void load_first(ContactBatch<2>& batch, Bodies<2>& bodies);
void load_first(ContactBatch<3>& batch, Bodies<3>& bodies);

}  // namespace graintruth::sim
