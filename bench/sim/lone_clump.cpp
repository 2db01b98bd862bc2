#include "bench/sim/lone_clump.h"

#include <cmath>
#include <fstream>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "bench/sim/child_process.h"
#include "sim/simulation.h"

namespace graintruth::bench {
namespace {

using sim::Mat3;
using sim::Vec3;

double density_of_spheres(const LoneClump& clump) {
  double volume = 0.0;
  for (const auto& sphere : clump.spheres) {
    volume += 4.0 / 3.0 * std::numbers::pi * std::pow(sphere.radius, 3);
  }
  return clump.mass / volume;
}

std::ofstream open_deck(const std::filesystem::path& file) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream out(file);
  out.precision(17);
  return out;
}

// One run, with dumps (id x y z) on the way: a second run command would start contacts afresh.
void write_looks(const LoneClump& clump, const char* format, std::ostream& out) {
  int every = clump.look_at_steps.back();
  for (const int look : clump.look_at_steps) every = std::gcd(every, look);
  out << "dump look all custom " << every << " look.* id x y z\ndump_modify look sort id format "
      << format << "\nrun " << clump.look_at_steps.back() << '\n';
}

SphereTrack read_looks(const LoneClump& clump, const std::filesystem::path& folder) {
  SphereTrack track;
  for (const int look : clump.look_at_steps) {
    std::ifstream in(folder / ("look." + std::to_string(look)));
    std::string line;
    while (std::getline(in, line)) {
      if (line.rfind("ITEM: ATOMS", 0) == 0) break;
    }
    std::vector<Vec3> centres;
    int id = 0;
    Vec3 centre;
    while (in >> id >> centre.x() >> centre.y() >> centre.z()) centres.push_back(centre);
    if (centres.size() != clump.spheres.size()) {
      throw std::runtime_error("no spheres in look." + std::to_string(look) + " of " +
                               folder.string());
    }
    track.push_back(centres);
  }
  return track;
}

}  // namespace

sim::Quat LoneClump::orientation() const {
  if (!is_upright) return sim::Quat::Identity();
  return sim::Quat(Eigen::AngleAxisd(-0.5 * std::numbers::pi, Vec3::UnitY()));
}

SphereTrack track_by_graintruth(const LoneClump& clump) {
  sim::Scene scene;
  scene.gravity = clump.gravity;
  const int grain = scene.add_material(clump.material);
  const int wall = scene.add_material(clump.material);
  scene.surfaces.set(grain, wall, {clump.friction, clump.restitution});
  const int type = scene.add_type(
      sim::make_clump(clump.spheres, {.mass = clump.mass, .inertia = clump.inertia}, grain));
  scene.add_body(type, clump.position, clump.orientation(), clump.velocity, clump.angular_velocity);
  scene.add_wall(sim::plane_wall(Vec3::Zero(), Vec3::UnitZ(), {}, wall));
  sim::Simulation simulation(scene,
                             {.time_step = {.fraction = 1.0,
                                            .impact_speed = 1e-3,
                                            .steps_per_contact = 1.0,
                                            .largest = clump.time_step}});
  SphereTrack track;
  for (const int look : clump.look_at_steps) {
    const sim::RunSummary summary = simulation.run_until(look * clump.time_step);
    if (summary.status != sim::RunStatus::completed) throw std::runtime_error(summary.message);
    const sim::State& state = simulation.state();
    std::vector<Vec3> centres;
    for (const sim::ElementSphere& sphere : scene.types[type].spheres) {
      centres.push_back(state.position[0] + state.orientation[0] * sphere.centre);
    }
    track.push_back(centres);
  }
  return track;
}

SphereTrack track_by_lammps(const LoneClump& clump, const std::filesystem::path& folder) {
  const sim::Quat orientation = clump.orientation();
  const Mat3 turn = orientation.toRotationMatrix();
  const Mat3 inertia = turn * clump.inertia.asDiagonal() * turn.transpose();
  const Vec3 momentum = inertia * clump.angular_velocity;
  open_deck(folder / "clump.body")
      << "1\n1 " << clump.mass << ' ' << clump.position.transpose() << ' '
      << inertia.diagonal().transpose() << ' ' << inertia(0, 1) << ' ' << inertia(0, 2) << ' '
      << inertia(1, 2) << ' ' << clump.velocity.transpose() << ' ' << momentum.transpose()
      << " 0 0 0\n";
  std::ofstream out = open_deck(folder / "in.clump");
  out << "units si\nnewton off\natom_style sphere\natom_modify map array\nboundary f f f\n"
      << "region room block -1 1 -1 1 -0.5 1\ncreate_box 1 room\n"
      << "fix clump_of all property/atom mol ghost yes\n";
  for (const auto& sphere : clump.spheres) {
    out << "create_atoms 1 single " << (clump.position + orientation * sphere.centre).transpose()
        << '\n';
  }
  const double gravity = clump.gravity.norm();
  const Vec3 down = gravity > 0.0 ? Vec3(clump.gravity / gravity) : Vec3(-Vec3::UnitZ());
  out << "set group all diameter " << 2.0 * clump.spheres.front().radius
      << "\nset group all density " << density_of_spheres(clump) << "\nset group all mol 1\n"
      << "comm_modify vel yes cutoff 0.1\nneighbor 0.002 bin\n"
      << "neigh_modify delay 0 exclude molecule/intra all\npair_style granular\n";
  const auto law = [&](std::ostream& to) {
    to << "hertz/material " << clump.material.youngs_modulus << ' ' << clump.restitution << ' '
       << clump.material.poisson_ratio << " tangential mindlin NULL 0.0 " << clump.friction
       << " damping tsuji";
  };
  out << "pair_coeff * * ";
  law(out);
  out << "\nfix floor all wall/gran granular ";
  law(out);
  out << " zplane 0 NULL\nfix weight all gravity " << gravity << " vector " << down.transpose()
      << " disable\nfix motion all rigid/small molecule infile clump.body gravity weight reinit "
         "no\n"
      << "timestep " << clump.time_step
      << "\nthermo 1000000\nthermo_style custom step atoms\nthermo_modify lost ignore\n";
  write_looks(clump, "float %.17g", out);
  out.close();
  run_program({"lmp", "-in", "in.clump", "-log", "none"}, folder, "run.log");
  return read_looks(clump, folder);
}

SphereTrack track_by_liggghts(const LoneClump& clump, const std::filesystem::path& folder) {
  constexpr double kPoint = 1e-11;  // m
  const sim::Quat turn = clump.orientation();
  std::ofstream out = open_deck(folder / "in.clump");
  out << "units si\nhard_particles yes\natom_style granular\natom_modify map array sort 0 0\n"
      << "boundary f f f\nnewton off\ncommunicate single vel yes\n"
      << "region room block -1 1 -1 1 -0.5 1 units box\ncreate_box 1 room\nneighbor 0.002 bin\n"
      << "neigh_modify delay 0\nfix modulus all property/global youngsModulus peratomtype "
      << clump.material.youngs_modulus
      << "\nfix poisson all property/global poissonsRatio peratomtype "
      << clump.material.poisson_ratio
      << "\nfix e all property/global coefficientRestitution peratomtypepair 1 "
      << clump.restitution << "\nfix mu all property/global coefficientFriction peratomtypepair 1 "
      << clump.friction << "\npair_style gran model hertz tangential history\npair_coeff * *\n"
      << "fix floor all wall/gran model hertz tangential history primitive type 1 zplane 0.\n";
  const double gravity = clump.gravity.norm();
  if (gravity > 0.0) {
    out << "fix weight all gravity " << gravity << " vector "
        << (clump.gravity / gravity).transpose() << '\n';
  }
  const Vec3 low = clump.position - Vec3::Constant(kPoint);
  const Vec3 high = clump.position + Vec3::Constant(kPoint);
  out << "fix motion all multisphere\nfix shape all particletemplate/multisphere 15485863 "
         "atom_type 1"
      << " density constant " << density_of_spheres(clump) << " nspheres " << clump.spheres.size()
      << " ntry 2000000 spheres";
  for (const auto& sphere : clump.spheres) {
    out << ' ' << sphere.centre.transpose() << ' ' << sphere.radius;
  }
  out << " type 1 mass " << clump.mass << " inertia_tensor " << clump.inertia.x() << " 0 0 "
      << clump.inertia.y() << " 0 " << clump.inertia.z() << " use_volume\n"
      << "fix shapes all particledistribution/discrete 32452843 1 shape 1.0\n"
      << "region place block " << low.x() << ' ' << high.x() << ' ' << low.y() << ' ' << high.y()
      << ' ' << low.z() << ' ' << high.z() << " volume_limit 1e-40 units box\n"
      << "fix clump all insert/pack seed 32452867 distributiontemplate shapes maxattempt 100"
      << " insert_every once overlapcheck no orientation constant " << turn.w() << ' ' << turn.x()
      << ' ' << turn.y() << ' ' << turn.z() << " vel constant " << clump.velocity.transpose()
      << " omega constant " << clump.angular_velocity.transpose()
      << " region place particles_in_region 1 ntry_mc 2000\n"
      << "thermo 1000000\nthermo_style custom step atoms\ntimestep 1e-14\nrun 1\nreset_timestep 0\n"
      << "thermo_modify lost ignore\ntimestep " << clump.time_step << '\n';
  write_looks(clump, "\"%d %.17g %.17g %.17g\"", out);
  out.close();
  run_program({"liggghts", "-in", "in.clump", "-log", "none"}, folder, "run.log");
  return read_looks(clump, folder);
}

}  // namespace graintruth::bench
