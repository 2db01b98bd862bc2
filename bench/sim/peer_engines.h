// Input decks that make LAMMPS and LIGGGHTS run the same bed, and the reading of what they leave.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/sim/peer_cases.h"

namespace graintruth::bench {

// A program that can run a case: `prepare` writes its decks into a folder, `command` runs `steps`
// steps there, `result` reads the spheres of the last step.
struct PeerEngine {
  std::string name;
  std::string program;
  void (*prepare)(const PeerCase&, const std::vector<Pose>&, const std::filesystem::path& folder);
  std::vector<std::string> (*command)(int steps);
  std::vector<PlacedSphere> (*result)(const PeerCase&, const std::filesystem::path& folder);
};

// Debian's lammps: Hertz normal force, Tsuji dashpots, Mindlin spring with history (pair style
// granular), rigid bodies by rigid/small. Planar beds lie in its x-y plane.
PeerEngine lammps();

// Debian's liggghts: model hertz tangential history, multisphere clumps. It reads no bodies from a
// file: every clump is packed into a region of the size of a point.
PeerEngine liggghts();

}  // namespace graintruth::bench
