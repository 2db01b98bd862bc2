// Candidate contacts: pairs of element spheres, and spheres with walls, near enough to touch before
// the next search. Each carries its tangential spring from step to step.
#pragma once

#include <span>
#include <vector>

#include "sim/engine/bodies.h"
#include "sim/engine/neighbours.h"
#include "sim/engine/slabs.h"
#include "sim/laws/contact_law.h"
#include "sim/shapes/walls.h"

namespace graintruth::sim {

// Candidates [begin, end) that are gathered into one batch. A group, all candidates between the
// same two bodies or between a body and the walls of one body, is gathered as a whole, unless it is
// too large for a batch; the range then is a part of it.
struct CandidateRange {
  int begin, end;
  bool is_part;
};

// Each slab has its own list of candidates, those of which its bodies are the first. What happens
// inside a slab is summed in the order of its groups; what its groups do to bodies of later slabs
// is summed apart, slab by slab. So the bits do not depend on who does which slab.

// The candidates of one slab.
template <int D>
struct ContactList {
  // In the order of bodies, then of partners, then of spheres
  std::vector<int> first_sphere;
  std::vector<int> second;  // sphere; or wall
  std::vector<typename Motion<D>::Tangent> spring;
  // kOpen, kTouching or kSliding; not bytes, whose stores could alias everything
  std::vector<short> is_touching;
  std::vector<ContactMemory<D>> memory;  // one a candidate, or none while the law needs none
  std::vector<CandidateRange> ranges;

  void clear();
  // Whether candidates have a memory. One that begins is empty.
  void remember(bool yes);
  void add(int first, int second_one);
  // Makes a group of the candidates added since the last one, if there are any.
  void close_group();
  int count() const { return static_cast<int>(first_sphere.size()); }
  bool remembers() const { return remembers_; }

 private:
  bool remembers_ = false;
};

// Fills the lists of all slabs anew with everything closer than `margin` (m); what touches keeps
// its spring. No more lists than there are workers are there twice.
template <int D>
class ContactSearch {
 public:
  void find(const Bodies<D>& bodies,
            const std::vector<Wall>& walls,
            const WallBodies& wall_bodies,
            double margin,
            Team& team,
            std::vector<ContactList<D>>& between_bodies,
            std::vector<ContactList<D>>& with_walls);

 private:
  // What a worker needs for a slab.
  struct Desk {
    ContactList<D> fresh;
    std::vector<IndexPair> pairs;
  };
  void find_pairs(const Bodies<D>& bodies,
                  double margin,
                  const SlabRange& slab,
                  Desk& desk,
                  ContactList<D>& list) const;
  void find_walls(const Bodies<D>& bodies,
                  const std::vector<Wall>& walls,
                  const WallBodies& wall_bodies,
                  double margin,
                  const SlabRange& slab,
                  ContactList<D>& fresh,
                  ContactList<D>& list) const;

  CellList<D> cells_;
  std::vector<Desk> desks_;
  std::vector<double> radii_;  // of the kinds of bodies
  std::vector<Box> wall_boxes_;
};

}  // namespace graintruth::sim
