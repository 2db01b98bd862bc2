// Frames for other programs to look at: ParaView (.vtp, .pvd) and OVITO (LAMMPS dump).
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

namespace graintruth::datasets {

// All element spheres at one moment, one entry a sphere in every array.
struct SphereCloud {
  std::vector<Eigen::Vector3d> centre;    // m
  std::vector<double> radius;             // m
  std::vector<Eigen::Vector3d> velocity;  // m/s; of the sphere's centre
  std::vector<int> particle;              // from 1
  std::vector<int> type;                  // from 1
};

using Patch = std::vector<Eigen::Vector3d>;  // m; corners of a flat polygon

// Points with the arrays radius, velocity, particle, type (VTK XML, text).
std::string vtp_of_spheres(const SphereCloud& cloud);
// Polygons with the array wall, the index of the wall of each patch.
std::string vtp_of_patches(const std::vector<Patch>& patches, const std::vector<int>& wall);
// The collection of such files: time (s) and name of each.
std::string pvd_of(const std::vector<std::pair<double, std::string>>& files);
// One snapshot of a LAMMPS dump: id mol type x y z radius vx vy vz, SI units.
std::string lammps_snapshot(const SphereCloud& cloud, long step);

}  // namespace graintruth::datasets
