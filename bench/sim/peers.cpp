// Cost of a step beside LAMMPS and LIGGGHTS: same beds, same start, same time step, interleaved.
// Usage: bench_sim_peers [FIGURES_FILE] [--case NAME] [--repeats N]. What an engine does once is
// subtracted: a step costs (CPU time of the long run - of the short run)/(difference of steps),
// median over the repeats.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>

#include "bench/sim/child_process.h"
#include "bench/sim/peer_cases.h"
#include "bench/sim/peer_engines.h"

namespace {

using namespace graintruth;
using namespace graintruth::bench;

constexpr const char* kOwnName = "Graintruth";
constexpr const char* kResultFile = "bed.poses";

const std::filesystem::path kFolder = "out/bench/peers";

PeerCase case_named(const std::string& name) {
  for (const PeerCase& peer_case : peer_cases()) {
    if (peer_case.name == name) return peer_case;
  }
  throw std::runtime_error("there is no case " + name);
}

// The child process that runs our own engine: simulate `steps` steps, leave the poses in the
// working folder.
void run_own(const std::string& name, int steps, const std::filesystem::path& states) {
  const PeerCase bed = case_named(name);
  sim::Simulation simulation(scene_of(bed, settled_bed(bed, states)), options_of(bed));
  const sim::RunSummary summary = simulation.run_until(steps * bed.time_step);
  if (summary.status != sim::RunStatus::completed || summary.steps != steps) {
    throw std::runtime_error("the run ended after " + std::to_string(summary.steps) +
                             " steps: " + summary.message);
  }
  const sim::State& state = simulation.state();
  std::ofstream out(kResultFile);
  out.precision(17);
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    const sim::Quat& turn = state.orientation[i];
    out << state.position[i].transpose() << ' ' << turn.w() << ' ' << turn.vec().transpose()
        << '\n';
  }
}

std::vector<PlacedSphere> own_result(const PeerCase& bed, const std::filesystem::path& folder) {
  std::ifstream in(folder / kResultFile);
  std::vector<Pose> poses(bed.clump_count);
  for (Pose& pose : poses) {
    in >> pose.position.x() >> pose.position.y() >> pose.position.z() >> pose.orientation.w() >>
        pose.orientation.x() >> pose.orientation.y() >> pose.orientation.z();
  }
  return placed_spheres(bed, poses);
}

struct Measured {
  std::vector<double> step_times;  // s of CPU, one a repeat
  double peak_memory_mib = 0.0;
  ContactCount at_start, at_end;
  double median() const {
    std::vector<double> sorted = step_times;
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
  }
};

std::string words_of(const ContactCount& count) {
  return std::to_string(count.between_spheres) + '+' + std::to_string(count.with_walls);
}

// One line: what a step costs each engine, the ratio to the faster peer, the contacts.
std::string line_of(const PeerCase& bed,
                    const ContactCount& start,
                    const std::map<std::string, Measured>& measured) {
  std::ostringstream line;
  line.precision(4);
  line << bed.name << ": " << words_of(start) << " contacts, " << start.bodies_per_body
       << " touching bodies or walls each";
  double fastest_peer = 0.0;
  for (const auto& [name, result] : measured) {
    line << "; " << name << ' ' << 1e6 * result.median() << " us/step, contacts "
         << words_of(result.at_start) << " to " << words_of(result.at_end) << ", "
         << result.peak_memory_mib << " MiB";
    if (name == kOwnName) continue;
    if (fastest_peer == 0.0 || result.median() < fastest_peer) fastest_peer = result.median();
  }
  const Measured& own = measured.at(kOwnName);
  if (fastest_peer > 0.0) line << "; " << fastest_peer / own.median() << " x the faster peer";
  return line.str();
}

std::string compare(const PeerCase& bed, const std::vector<PeerEngine>& peers, int repeats) {
  const std::filesystem::path states = std::filesystem::absolute(kFolder / "states");
  const std::vector<Pose> start = settled_bed(bed, states);
  const std::string self = std::filesystem::canonical("/proc/self/exe");

  struct Runner {
    std::string name;
    std::filesystem::path folder;
    const PeerEngine* peer;  // none: our own engine
    std::vector<std::string> command(const std::string& own,
                                     const PeerCase& bed,
                                     int steps,
                                     const std::string& states) const {
      if (peer != nullptr) return peer->command(steps);
      return {own, "--own", bed.name, std::to_string(steps), states};
    }
    ContactCount contacts(const PeerCase& bed) const {
      return count_contacts(bed,
                            peer != nullptr ? peer->result(bed, folder) : own_result(bed, folder));
    }
  };
  std::vector<Runner> runners{{kOwnName, kFolder / bed.name / "graintruth", nullptr}};
  for (const PeerEngine& peer : peers) {
    runners.push_back({peer.name, kFolder / bed.name / peer.program, &peer});
  }
  for (const Runner& runner : runners) {
    std::filesystem::create_directories(runner.folder);
    if (runner.peer != nullptr) runner.peer->prepare(bed, start, runner.folder);
  }

  std::map<std::string, Measured> measured;
  for (const Runner& runner : runners) {
    run_program(runner.command(self, bed, 0, states), runner.folder, "run.log");
    measured[runner.name].at_start = runner.contacts(bed);
  }
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (const Runner& runner : runners) {
      Measured& result = measured[runner.name];
      double cpu_time[2] = {};
      const int steps[2] = {bed.short_run, bed.long_run};
      for (int k = 0; k < 2; ++k) {
        const ProcessCost cost =
            run_program(runner.command(self, bed, steps[k], states), runner.folder, "run.log");
        cpu_time[k] = cost.cpu_time;
        result.peak_memory_mib = std::max(result.peak_memory_mib, cost.peak_memory_mib);
      }
      result.step_times.push_back((cpu_time[1] - cpu_time[0]) / (steps[1] - steps[0]));
      if (repeat + 1 == repeats) result.at_end = runner.contacts(bed);
    }
  }
  return line_of(bed, count_contacts(bed, placed_spheres(bed, start)), measured);
}

int run(int argc, char** argv) {
  if (argc == 5 && std::strcmp(argv[1], "--own") == 0) {
    run_own(argv[2], std::atoi(argv[3]), argv[4]);
    return EXIT_SUCCESS;
  }
  std::filesystem::path file = kFolder / "peers.figures";
  std::string only;
  int repeats = 5;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--case") == 0 && i + 1 < argc) {
      only = argv[++i];
    } else if (std::strcmp(argv[i], "--repeats") == 0 && i + 1 < argc) {
      repeats = std::max(std::atoi(argv[++i]), 1);
    } else {
      file = argv[i];
    }
  }
  std::vector<PeerEngine> peers;
  for (const PeerEngine& peer : {lammps(), liggghts()}) {
    if (is_installed(peer.program)) {
      peers.push_back(peer);
    } else {
      std::printf("%s is not installed (no %s on PATH): NOT RUN\n",
                  peer.name.c_str(),
                  peer.program.c_str());
    }
  }
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path());
  std::ofstream figures(file);
  for (const PeerCase& bed : peer_cases()) {
    if (!only.empty() && bed.name != only) continue;
    const std::string line = compare(bed, peers, repeats);
    std::cout << line << std::endl;
    figures << line << std::endl;
  }
  return EXIT_SUCCESS;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return EXIT_FAILURE;
  }
}
