// Tracks of the filmed two-ball particles against the truth of their data set.
//
// The tracked point is the midpoint of the two ball centres; the truth file gives the centre of
// mass. The midpoint is rebuilt from placement.csv: radii r1, r2 and centre distance d give the
// offset between the two along the axis (the solid of two overlapping balls). Which ball lies at
// which end is not in the files; the end that fits is taken.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/store/trajectories.h"

namespace graintruth::bench {

// Errors summed over poses. Those over sigma are against the centre of mass, which is what a stated
// sigma speaks of; the others are of the midpoint.
struct PairErrors {
  double x2 = 0.0, z2 = 0.0, angle2 = 0.0;                 // squared: m, rad
  double mid_x2 = 0.0, mid_z2 = 0.0;                       // squared, over sigma, of the midpoint
  double over_x2 = 0.0, over_z2 = 0.0, over_angle2 = 0.0;  // squared, over sigma
  double within_x = 0.0, within_z = 0.0, within_angle = 0.0;  // poses within two sigma
  double worst = 0.0;                                         // m
  double frames = 0.0, seen = 0.0;
  double strangers = 0.0;  // poses nearer to another particle's true place than to its own

  PairErrors& operator+=(const PairErrors& other);
  double root(double sum) const;  // of the mean over what was seen
  double share(double sum) const { return seen > 0.0 ? sum / seen : 0.0; }
};

struct PairBody {
  std::string colour;
  PairErrors errors;
};

// One a particle. `truth` holds NAME_tracks.csv and NAME_placement.csv, NAME being that of the
// replicate ("rep1").
std::vector<PairBody> compare_pairs(const datasets::Trajectories& tracks,
                                    const std::filesystem::path& truth,
                                    const std::string& name);

}  // namespace graintruth::bench
