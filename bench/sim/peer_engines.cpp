#include "bench/sim/peer_engines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "bench/sim/child_process.h"

namespace graintruth::bench {
namespace {

using sim::Mat3;
using sim::Vec3;

std::ofstream open_deck(const std::filesystem::path& file) {
  std::ofstream out(file);
  out.precision(17);
  return out;
}

double longest_reach(const PeerCase& bed) {
  double reach = 0.0;
  for (const auto& sphere : bed.spheres) {
    reach = std::max(reach, sphere.centre.norm() + sphere.radius);
  }
  return reach;
}

double largest_radius(const PeerCase& bed) {
  double radius = 0.0;
  for (const auto& sphere : bed.spheres) radius = std::max(radius, sphere.radius);
  return radius;
}

// Density that gives the spheres of a clump, each counted whole, its mass.
double density_of_spheres(const PeerCase& bed) {
  double volume = 0.0;
  for (const auto& sphere : bed.spheres) {
    volume += 4.0 / 3.0 * std::numbers::pi * std::pow(sphere.radius, 3);
  }
  return bed.mass / volume;
}

bool has_clumps(const PeerCase& bed) { return bed.spheres.size() > 1; }

// World axes of LAMMPS: a planar bed is turned from x-z into its x-y plane.
Mat3 lammps_axes(const PeerCase& bed) {
  Mat3 axes = Mat3::Identity();
  if (bed.planar) axes << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return axes;
}

void write_lammps_data(const PeerCase& bed,
                       const std::vector<PlacedSphere>& spheres,
                       const std::filesystem::path& file) {
  const Mat3 axes = lammps_axes(bed);
  const double below = bed.orifice > 0.0 ? -2.0 : -0.1;
  std::ofstream out = open_deck(file);
  out << bed.name << "\n\n" << spheres.size() << " atoms\n1 atom types\n\n";
  out << 0.0 << ' ' << bed.width << " xlo xhi\n";
  if (bed.planar) {
    out << below << ' ' << bed.height << " ylo yhi\n-0.02 0.02 zlo zhi\n";
  } else {
    out << 0.0 << ' ' << bed.depth << " ylo yhi\n" << below << ' ' << bed.height << " zlo zhi\n";
  }
  out << "\nAtoms # sphere\n\n";
  const double density = density_of_spheres(bed);
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    out << i + 1 << " 1 " << 2.0 * spheres[i].radius << ' ' << density << ' '
        << (axes * spheres[i].centre).transpose() << '\n';
  }
  out << "\nMolecules\n\n";
  for (std::size_t i = 0; i < spheres.size(); ++i)
    out << i + 1 << ' ' << spheres[i].body + 1 << '\n';
}

// Mass, centre, inertia tensor in world axes (xx yy zz xy xz yz), momenta and images of every
// clump.
void write_lammps_bodies(const PeerCase& bed,
                         const std::vector<Pose>& poses,
                         const std::filesystem::path& file) {
  const Mat3 axes = lammps_axes(bed);
  std::ofstream out = open_deck(file);
  out << poses.size() << '\n';
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Mat3 turn = axes * poses[i].orientation.toRotationMatrix();
    Mat3 inertia = turn * bed.inertia.asDiagonal() * turn.transpose();
    if (bed.planar) inertia(0, 2) = inertia(1, 2) = 0.0;  // round-off of the turn
    out << i + 1 << ' ' << bed.mass << ' ' << (axes * poses[i].position).transpose() << ' '
        << inertia.diagonal().transpose() << ' ' << inertia(0, 1) << ' ' << inertia(0, 2) << ' '
        << inertia(1, 2) << " 0 0 0 0 0 0 0 0 0\n";
  }
}

void prepare_lammps(const PeerCase& bed,
                    const std::vector<Pose>& poses,
                    const std::filesystem::path& folder) {
  write_lammps_data(bed, placed_spheres(bed, poses), folder / "bed.data");
  write_lammps_bodies(bed, poses, folder / "bed.bodies");
  std::ostringstream law;
  law.precision(17);
  law << "hertz/material " << bed.material.youngs_modulus << ' ' << bed.restitution << ' '
      << bed.material.poisson_ratio << " tangential mindlin NULL 0.0 ";
  const auto with_friction = [&](double friction) {
    return law.str() + std::to_string(friction) + " damping tsuji";
  };
  const std::string wall = "granular " + with_friction(bed.wall_friction);
  const char up = bed.planar ? 'y' : 'z';

  std::ofstream out = open_deck(folder / "in.bed");
  out << "units si\ndimension " << (bed.planar ? 2 : 3) << "\nnewton off\natom_style sphere\n"
      << "atom_modify map array\nboundary f f " << (bed.planar ? 'p' : 'f') << "\n"
      << "fix clump_of all property/atom mol ghost yes\n"
      << "read_data bed.data fix clump_of NULL Molecules\n"
      << "neighbor " << bed.lammps_skin << " bin\nneigh_modify delay 0 every 1 check yes\n"
      << "comm_modify vel yes";
  if (has_clumps(bed)) {
    out << " cutoff " << 2.0 * (longest_reach(bed) + largest_radius(bed)) + bed.lammps_skin
        << "\nneigh_modify exclude molecule/intra all";
  }
  out << "\npair_style granular\npair_coeff * * " << with_friction(bed.friction) << '\n'
      << "fix sides all wall/gran " << wall << " xplane 0 " << bed.width << '\n';
  if (!bed.planar) out << "fix ends all wall/gran " << wall << " yplane 0 " << bed.depth << '\n';
  if (bed.orifice == 0.0) {
    out << "fix floor all wall/gran " << wall << ' ' << up << "plane 0 NULL\n";
  } else {
    const double left = 0.5 * (bed.width - bed.orifice), right = bed.width - left;
    out << "region left block -0.2 " << left << " -0.02 0 INF INF side out\n"
        << "region right block " << right << ' ' << bed.width + 0.2 << " -0.02 0 INF INF side out\n"
        << "fix left all wall/gran/region " << wall << " region left\n"
        << "fix right all wall/gran/region " << wall << " region right\n";
  }
  out << "fix weight all gravity 9.81 vector 0 " << (bed.planar ? "-1 0" : "0 -1");
  if (has_clumps(bed)) {
    out << " disable\nfix motion all rigid/small molecule infile bed.bodies gravity weight"
        << " reinit no\n";
  } else {
    out << "\nfix motion all nve/sphere\n";
  }
  if (bed.planar) out << "fix layer all enforce2d\n";
  out << "timestep " << bed.time_step << "\nthermo 100000\nthermo_style custom step atoms\n"
      << "thermo_modify lost ignore\nrun ${steps}\n"
      << "write_dump all custom bed.dump id x y z radius modify sort id format float %.17g\n";
}

// The last "ITEM: ATOMS" block: id x y z radius, sorted by id; clump by clump.
std::vector<PlacedSphere> read_dump(const PeerCase& bed,
                                    const std::filesystem::path& file,
                                    const Mat3& world_from_dump) {
  std::ifstream in(file);
  std::string line;
  std::vector<PlacedSphere> spheres;
  while (std::getline(in, line)) {
    if (line.rfind("ITEM: ATOMS", 0) == 0) break;
  }
  int id = 0;
  PlacedSphere sphere{};
  Vec3 centre;
  while (in >> id >> centre.x() >> centre.y() >> centre.z() >> sphere.radius) {
    sphere.body = (id - 1) / static_cast<int>(bed.spheres.size());
    sphere.centre = world_from_dump * centre;
    spheres.push_back(sphere);
  }
  return spheres;
}

// A strip of floor as two triangles.
void write_strip(const std::filesystem::path& file, double from, double to) {
  constexpr double kHalfDepth = 0.1;  // m
  const Vec3 corners[4] = {{from, -kHalfDepth, 0.0},
                           {to, -kHalfDepth, 0.0},
                           {to, kHalfDepth, 0.0},
                           {from, kHalfDepth, 0.0}};
  std::ofstream out = open_deck(file);
  out << "solid strip\n";
  for (const auto& triangle : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
    out << "facet normal 0 0 1\nouter loop\n";
    for (const int corner : triangle) out << "vertex " << corners[corner].transpose() << '\n';
    out << "endloop\nendfacet\n";
  }
  out << "endsolid strip\n";
}

// Steps of almost no length while clumps are packed, so that those already there do not move.
void insert_clumps(const PeerCase& bed, const std::vector<Pose>& poses, std::ostream& out) {
  constexpr int kBatch = 200;       // clumps a step
  constexpr double kPoint = 1e-10;  // m
  out << "fix motion all multisphere\n"
      << "fix shape all particletemplate/multisphere 15485863 atom_type 1 density constant "
      << density_of_spheres(bed) << " nspheres " << bed.spheres.size() << " ntry 200000 spheres";
  for (const auto& sphere : bed.spheres) {
    out << ' ' << sphere.centre.transpose() << ' ' << sphere.radius;
  }
  out << " type 1 mass " << bed.mass << " inertia_tensor " << bed.inertia.x() << " 0 0 "
      << bed.inertia.y() << " 0 " << bed.inertia.z() << " use_volume";
  if (bed.planar) out << " fflag on off on tflag off on off";
  out << "\nfix shapes all particledistribution/discrete 32452843 1 shape 1.0\ntimestep 1e-14\n";
  for (std::size_t first = 0; first < poses.size(); first += kBatch) {
    const std::size_t last = std::min(first + kBatch, poses.size());
    for (std::size_t i = first; i < last; ++i) {
      const Vec3 low = poses[i].position - Vec3::Constant(kPoint);
      const Vec3 high = poses[i].position + Vec3::Constant(kPoint);
      const sim::Quat& turn = poses[i].orientation;
      out << "region place" << i << " block " << low.x() << ' ' << high.x() << ' ' << low.y() << ' '
          << high.y() << ' ' << low.z() << ' ' << high.z() << " volume_limit 1e-40 units box\n"
          << "fix clump" << i
          << " all insert/pack seed 32452867 distributiontemplate shapes maxattempt 100 verbose no"
          << " insert_every once overlapcheck no orientation constant " << turn.w() << ' '
          << turn.x() << ' ' << turn.y() << ' ' << turn.z() << " vel constant 0. 0. 0. region place"
          << i << " particles_in_region 1 ntry_mc 2000\n";
    }
    out << "run 1\n";
    for (std::size_t i = first; i < last; ++i) {
      out << "unfix clump" << i << "\nregion place" << i << " delete\n";
    }
  }
}

void insert_spheres(const PeerCase& bed, const std::vector<Pose>& poses, std::ostream& out) {
  for (const Pose& pose : poses) {
    out << "create_atoms 1 single " << pose.position.transpose() << " units box\n";
  }
  out << "set group all diameter " << 2.0 * largest_radius(bed) << " density "
      << density_of_spheres(bed) << "\nfix motion all nve/sphere\n";
}

void write_liggghts_deck(const PeerCase& bed,
                         const std::vector<Pose>& poses,
                         const std::filesystem::path& folder) {
  const std::string law = "model hertz tangential history";
  const std::string plane = " all wall/gran " + law + " primitive type 2 ";
  const double below = bed.orifice > 0.0 ? -2.0 : -0.1;
  std::ofstream out = open_deck(folder / "in.bed");
  out << "units si\nhard_particles yes\natom_style granular\natom_modify map array sort 0 0\n"
      << "boundary f f f\nnewton off\ncommunicate single vel yes\n"
      << "region room block -0.02 " << bed.width + 0.02 << " -0.05 " << bed.depth + 0.05 << ' '
      << below << ' ' << bed.height << " units box\ncreate_box 2 room\n"
      << "neighbor " << bed.liggghts_skin << " bin\nneigh_modify delay 0\n";
  const auto& solid = bed.material;
  const auto property = [&](const char* name, double grain, double wall) {
    out << "fix " << name << " all property/global " << name << " peratomtypepair 2 " << grain
        << ' ' << wall << ' ' << wall << ' ' << grain << '\n';
  };
  out << "fix modulus all property/global youngsModulus peratomtype " << solid.youngs_modulus << ' '
      << solid.youngs_modulus << "\nfix poisson all property/global poissonsRatio peratomtype "
      << solid.poisson_ratio << ' ' << solid.poisson_ratio << '\n';
  property("coefficientRestitution", bed.restitution, bed.restitution);
  property("coefficientFriction", bed.friction, bed.wall_friction);
  out << "pair_style gran " << law << "\npair_coeff * *\n"
      << "fix left" << plane << "xplane 0.\nfix right" << plane << "xplane " << bed.width << '\n';
  if (!bed.planar) {
    out << "fix front" << plane << "yplane 0.\nfix back" << plane << "yplane " << bed.depth << '\n';
  }
  if (bed.orifice == 0.0) {
    out << "fix floor" << plane << "zplane 0.\n";
  } else {
    const double strip = 0.5 * (bed.width - bed.orifice);
    write_strip(folder / "left.stl", -0.01, strip);
    write_strip(folder / "right.stl", bed.width - strip, bed.width + 0.01);
    out << "fix left_strip all mesh/surface file left.stl type 2\n"
        << "fix right_strip all mesh/surface file right.stl type 2\n"
        << "fix floor all wall/gran " << law << " mesh n_meshes 2 meshes left_strip right_strip\n";
  }
  out << "fix weight all gravity 9.81 vector 0. 0. -1.\nthermo 100000\n"
      << "thermo_style custom step atoms\nthermo_modify lost ignore norm no\n";
  if (has_clumps(bed)) {
    insert_clumps(bed, poses, out);
  } else {
    insert_spheres(bed, poses, out);
  }
  out << "timestep " << bed.time_step << "\nrun ${steps}\n"
      << "dump last all custom 1 bed.dump id x y z radius\n"
      << "dump_modify last sort id format \"%d %.17g %.17g %.17g %.17g\"\nrun 0\n";
}

std::vector<std::string> deck_command(const char* program, int steps) {
  return {program, "-in", "in.bed", "-log", "none", "-var", "steps", std::to_string(steps)};
}

// LIGGGHTS finds a clump's centre of mass by throwing points at it, even where the mass is given,
// and so misses by some 1e-5 m: deeper than contacts overlap. How far it has put the spheres from
// where they belong in the body frame, seen on a single clump, m. The same for every clump.
Vec3 misplacement_by_liggghts(const PeerCase& bed, const std::filesystem::path& folder) {
  const Pose pose{Vec3(0.5 * bed.width, 0.5 * bed.depth, 0.5 * bed.height), sim::Quat::Identity()};
  write_liggghts_deck(bed, {pose}, folder);
  run_program(deck_command("liggghts", 0), folder, "run.log");
  const std::vector<PlacedSphere> spheres = read_dump(bed, folder / "bed.dump", Mat3::Identity());
  return spheres.front().centre - pose.position - bed.spheres.front().centre;
}

void prepare_liggghts(const PeerCase& bed,
                      const std::vector<Pose>& poses,
                      const std::filesystem::path& folder) {
  std::vector<Pose> placed = poses;
  if (has_clumps(bed)) {
    const Vec3 misplacement = misplacement_by_liggghts(bed, folder);
    for (Pose& pose : placed) pose.position -= pose.orientation * misplacement;
    if (bed.planar) {
      for (Pose& pose : placed) pose.position.y() = -misplacement.y();
    }
  }
  write_liggghts_deck(bed, placed, folder);
}

}  // namespace

PeerEngine lammps() {
  return {"LAMMPS",
          "lmp",
          prepare_lammps,
          [](int steps) { return deck_command("lmp", steps); },
          [](const PeerCase& bed, const std::filesystem::path& folder) {
            return read_dump(bed, folder / "bed.dump", lammps_axes(bed).transpose());
          }};
}

PeerEngine liggghts() {
  return {"LIGGGHTS",
          "liggghts",
          prepare_liggghts,
          [](int steps) { return deck_command("liggghts", steps); },
          [](const PeerCase& bed, const std::filesystem::path& folder) {
            return read_dump(bed, folder / "bed.dump", Mat3::Identity());
          }};
}

}  // namespace graintruth::bench
