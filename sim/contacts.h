// Candidate contacts: pairs of element spheres, and spheres with walls, near enough to touch before
// the next search. Each carries its tangential spring from step to step.
#pragma once

#include <span>
#include <vector>

#include "sim/bodies.h"
#include "sim/contact_law.h"
#include "sim/neighbours.h"
#include "sim/walls.h"

namespace graintruth::sim {

// Candidates [begin, end) that are gathered into one batch. A group, all candidates between the
// same two bodies or between a body and a wall, is gathered as a whole, unless it is too large for
// a batch; the range then is a part of it.
struct CandidateRange {
  int begin, end;
  bool is_part;
};

// Bodies are taken together in slabs of so many, by their indices: each slab has its own list of
// candidates, those of which its bodies are the first. What happens inside a slab is summed in the
// order of its groups; what its groups do to bodies of later slabs is summed apart, slab by slab.
// So the bits do not depend on who does which slab.
constexpr int kBodiesInSlab = 512;
inline int slab_of(int body) { return body / kBodiesInSlab; }
inline int slab_count_of(int bodies) { return bodies > 0 ? slab_of(bodies - 1) + 1 : 1; }

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
// its spring. One slab after the other, so that no more than one list is there twice.
template <int D>
class ContactSearch {
 public:
  void find(const Bodies<D>& bodies,
            const std::vector<Wall>& walls,
            double margin,
            std::vector<ContactList<D>>& between_bodies,
            std::vector<ContactList<D>>& with_walls);

 private:
  void find_pairs(const Bodies<D>& bodies, double margin, std::vector<ContactList<D>>& lists);
  void add_pair(const Bodies<D>& bodies, const IndexPair& near, double margin);
  void find_walls(const Bodies<D>& bodies,
                  const std::vector<Wall>& walls,
                  double margin,
                  std::vector<ContactList<D>>& lists);
  template <class Order>
  void finish_slab(const Order& order, ContactList<D>& list);

  CellList cells_;
  ContactList<D> fresh_;  // of the slab in hand
  std::vector<Box> wall_boxes_;
};

}  // namespace graintruth::sim
