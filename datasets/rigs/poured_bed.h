// What rigs share into which a bed of grains is poured before anything happens: how many grains, on
// which sites they begin, and how long they settle.
#pragma once

#include <functional>

#include "datasets/rigs/rig_kind.h"

namespace graintruth::datasets {

// Share of the room that loosely poured grains fill: random loose packing of balls with friction
// lies between 0.55 and 0.62 (Scott 1960; Song, Wang and Makse 2008). For estimates of levels.
inline constexpr double poured_fraction = 0.6;

// m3, of one grain; balls that overlap count whole, so this is an upper bound for clumps.
double grain_volume(const Particle& particle);

// How many grains are in the rig: particle.count, or what [rig] says by `filled_mass` or
// `filled_height`, a level above the lowest point. `room_below` is the room up to a level, m3, of
// which grains take `poured_fraction`.
// Says where it stands if there are none, or two answers. A count that is not particle.count goes
// into the rig, whose grains these are.
int poured_count(RigSection& section,
                 const RigContext& context,
                 const std::function<double(double level)>& room_below,
                 Rig& rig);

// m: how high about so many grains stand in a vessel of this cross-section.
double poured_height(const Particle& particle, int count, double cross_section);

// m: no bed poured between panes so far apart is higher than this where about so many grains stand
// `level` high: along each wall a quarter of a grain stays empty, and the surface is rough.
double highest_level(const Particle& particle, double level, double depth);

// m: how far sites of a lattice are apart from which grains begin. Every grain lies a little off
// its site. Closer ones fill twice as much of the room, for vessels that cannot be filled from
// above.
enum class LatticeKind { loose, close };
double lattice_pitch(const Particle& particle, LatticeKind kind);

// The filling from such a lattice over the box from `low` to `high`, where given
// inside this room alone.
SceneFill filling_from_lattice(const Particle& particle,
                               LatticeKind kind,
                               const Eigen::Vector3d& low,
                               const Eigen::Vector3d& high,
                               const std::optional<SceneRoom>& within);

// Two phases before the event: the grains come down no faster than `impact` (m/s) against a weak
// drag, then rest without it.
void settle_poured_bed(double impact, Rig& rig);

// What follows the event: a phase for the time that what is released needs (s), then rest. Both are
// recorded at this interval (s).
struct Released {
  std::string phase;  // its name
  double lasts = 0.0, rests_at_most = 0.0, interval = 0.0;
};
void release_poured_bed(const Released& released, double impact, Rig& rig);

// A flat wall through these corners.
SceneWall flat_wall(std::string name, std::vector<Eigen::Vector3d> corners);

}  // namespace graintruth::datasets
