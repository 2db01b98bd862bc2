// Where spheres touch walls, each surface once: edges that walls share, and facets of one wall body
// that lie in one plane or on each other.
#pragma once

#include <vector>

#include "sim/engine/contacts.h"
#include "sim/shapes/walls.h"

namespace graintruth::sim {

// A sphere that touches a wall.
template <int D>
struct WallTouch {
  int candidate;  // in the contact list
  // The candidate whose spring it carries on, and what that did at the last step: its own, or that
  // of the part of the same wall body from which the sphere has come over
  int carries_on;
  int was_touching;
  double overlap;                     // m
  typename Motion<D>::Vector normal;  // unit, towards the wall
  bool is_edge;
  bool counts;
  bool has_deeper_twin;
};

// Fills `touches` with what touches now, in the order of the list, which is not changed. `walls`
// are where they are now. Of the parts of one wall body that a sphere touches
//   an edge or a corner that they share counts once, as with any other walls
//   those of one normal count once: the one that it touches deepest, of equals the first
// What counts no longer hands its spring to the touch with the normal nearest to its own, when that
// is new: over a seam a contact goes on.
template <int D>
void find_wall_touches(const std::vector<Wall>& walls,
                       const WallBodies& wall_bodies,
                       const Bodies<D>& bodies,
                       const ContactList<D>& list,
                       std::vector<WallTouch<D>>& touches);

}  // namespace graintruth::sim
