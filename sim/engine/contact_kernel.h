// The arithmetic of a batch of contacts, several contacts at a time.
#pragma once

#include "sim/engine/contact_batch.h"
#include "sim/laws/contact_law.h"

namespace graintruth::sim {

// Overlap, normal and stiffness of the gathered pairs of spheres.
void find_geometry(const PairTable& pairs, ContactBatch<2>& batch);
void find_geometry(const PairTable& pairs, ContactBatch<3>& batch);

// Stiffness of the gathered contacts with walls, whose overlap is known.
void find_wall_stiffness(const PairTable& pairs, ContactBatch<2>& batch);
void find_wall_stiffness(const PairTable& pairs, ContactBatch<3>& batch);

// Whether an overlap may be more than a share of the smaller radius. R* is not above that radius
// and not below half of it, so a bound with R* clears most batches at once.
bool may_be_deeper(double share, const ContactBatch<2>& batch);
bool may_be_deeper(double share, const ContactBatch<3>& batch);

// Stiffness of the contacts of each group, for sharing the damping.
void sum_groups(ContactBatch<2>& batch);
void sum_groups(ContactBatch<3>& batch);

// Number of the rows of each group, to each of them.
void count_groups(int rows, const double* group, double* count);

// Forces and moments of the batch; springs are advanced.
void apply_law(const DefaultLaw& law, const PairTable& pairs, ContactBatch<2>& batch);
void apply_law(const DefaultLaw& law, const PairTable& pairs, ContactBatch<3>& batch);
void apply_law(const ChosenLaw& law, const PairTable& pairs, ContactBatch<2>& batch);
void apply_law(const ChosenLaw& law, const PairTable& pairs, ContactBatch<3>& batch);

}  // namespace graintruth::sim
