// Candidate contacts: pairs of element spheres, and spheres with walls, near enough to touch before
// the next search. Grouped by pair of bodies; each carries its tangential spring from step to step.
#pragma once

#include <span>
#include <vector>

#include "sim/bodies.h"
#include "sim/contact_law.h"
#include "sim/neighbours.h"
#include "sim/walls.h"

namespace graintruth::sim {

// All candidates between the same two bodies, or between a body and a wall: [begin, end) in the
// candidate arrays.
struct ContactGroup {
  int first;   // body
  int second;  // body, or wall
  int begin, end;
  int pair;             // index into the pair materials
  double reduced_mass;  // kg; a wall's partner has its own mass
};

// Candidates [begin, end) that are gathered into one batch: whole groups, or a part of a group that
// is too large for a batch.
struct CandidateRange {
  int begin, end;
  bool is_part;
};

// Bodies are taken together in slabs of so many, by their indices. What happens inside a slab is
// summed in the order of its groups; what its groups do to bodies of later slabs is put off and
// added afterwards, slab by slab. So the bits do not depend on who does which slab.
constexpr int kBodiesInSlab = 512;
inline int slab_of(int body) { return body / kBodiesInSlab; }
inline int slab_count_of(int bodies) { return bodies > 0 ? slab_of(bodies - 1) + 1 : 1; }

// A range is closed when it holds this many candidates; those of one more group may come on top.
constexpr int kCandidatesInRange = 64;

template <int D>
struct ContactList {
  std::vector<ContactGroup> groups;
  std::vector<CandidateRange> ranges;  // none reaches over two slabs
  std::vector<int> first_range;        // of each slab, by its groups' first bodies; and the end
  std::vector<int> group_of;
  std::vector<int> first_sphere;
  std::vector<int> second_sphere;        // 0 with walls
  std::vector<double> reach;             // m; sum of the radii
  std::vector<double> stiffness_factor;  // N/m^1.5; 2 E* sqrt(R*)
  std::vector<typename Motion<D>::Tangent> spring;
  // kOpen, kTouching or kSliding; not bytes, whose stores could alias everything
  std::vector<int> is_touching;
  std::vector<ContactMemory<D>> memory;  // one a candidate, or none while the law needs none

  void clear();
  // Whether candidates have a memory. One that begins is empty.
  void remember(bool yes);
  void add(int first, int second, double sum_of_radii, double factor);
  // Makes a group of the candidates added since the last one, if there are any.
  void close_group(int first, int second, int pair, double reduced_mass);
  // After the last group.
  void find_slabs(int slab_count);
  std::span<const CandidateRange> ranges_of(int slab) const {
    return {ranges.data() + first_range[slab], ranges.data() + first_range[slab + 1]};
  }
  int count() const { return static_cast<int>(reach.size()); }
  bool remembers() const { return remembers_; }

 private:
  bool remembers_ = false;
};

// Fills both lists anew with everything closer than `margin` (m); what touches keeps its spring.
template <int D>
class ContactSearch {
 public:
  void find(const Bodies<D>& bodies,
            const std::vector<Wall>& walls,
            const PairTable& pairs,
            int material_count,
            double margin,
            ContactList<D>& between_bodies,
            ContactList<D>& with_walls);

 private:
  void find_pairs(const Bodies<D>& bodies,
                  const PairTable& pairs,
                  int material_count,
                  double margin,
                  ContactList<D>& list);
  void add_pair(const Bodies<D>& bodies,
                const IndexPair& near,
                const PairTable& pairs,
                int material_count,
                double margin,
                ContactList<D>& list);
  void find_walls(const Bodies<D>& bodies,
                  const std::vector<Wall>& walls,
                  const PairTable& pairs,
                  int material_count,
                  double margin,
                  ContactList<D>& list);

  CellList cells_;
  std::vector<Vec<D>> centres_;
  std::vector<Box> wall_boxes_;
};

}  // namespace graintruth::sim
