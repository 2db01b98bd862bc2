// How cost and memory grow with the bed: chains of three balls in the layer and balls in space,
// from a thousand spheres to a million, each in a process of its own; and what two threads on one
// bed gain. Usage: bench_sim_scaling [TABLE_FILE] [--largest SPHERES] [--steps N] [--threads]
// --threads: the last alone.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bench/sim/child_process.h"
#include "sim/simulation.h"

namespace {

using namespace graintruth;
using namespace graintruth::bench;

const std::filesystem::path kFolder = "out/bench/scaling";

constexpr double kRadius = 0.005, kSpacing = 0.006, kGap = 1e-7;  // m

void add_box(sim::Scene& scene, const sim::Vec3& far, int material) {
  using sim::Vec3;
  for (const Vec3& axis : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY())}) {
    if (scene.planar && axis.y() != 0.0) continue;
    scene.add_wall(sim::plane_wall(Vec3::Zero(), axis, {}, material));
    scene.add_wall(sim::plane_wall(far, -axis, {}, material));
  }
  scene.add_wall(sim::plane_wall(Vec3::Zero(), Vec3::UnitZ(), {}, material));
}

// Dense beds of one height, so that only their extent differs; a hair apart, they fall into contact
// in some ten steps. In the layer chains like bricks, each row half a chain aside of the last.
sim::Scene bricks(int columns, int rows, int in_chain) {
  const double length = 2.0 * kRadius + (in_chain - 1) * kSpacing + kGap;
  sim::Scene scene;
  scene.planar = true;
  const int grain = scene.add_material({.youngs_modulus = 1e7, .poisson_ratio = 0.3});
  const int steel = scene.add_material(sim::rigid_material());
  const sim::Surfaces surfaces{.friction = 0.3, .restitution = 0.3};
  scene.surfaces.set(grain, grain, surfaces);
  scene.surfaces.set(grain, steel, surfaces);
  scene.add_type(
      sim::make_clump(sim::chain_of_spheres(in_chain, kRadius, kSpacing), {.density = 1500.0}));
  for (int k = 0; k < rows; ++k) {
    for (int i = 0; i < columns; ++i) {
      scene.add_planar_body(
          0, {(i + 0.5 + 0.5 * (k % 2)) * length, (2.0 * k + 1.0) * kRadius + (k + 1) * kGap}, 0.0);
    }
  }
  add_box(scene, {(columns + 0.5) * length, 0.0, 0.0}, steel);
  return scene;
}

// In space balls in the closest packing, square layers that lie in each other's gaps.
sim::Scene closest_balls(int spheres) {
  constexpr int kLayers = 20;
  const int side = static_cast<int>(std::lround(std::sqrt(spheres / double{kLayers})));
  sim::Scene scene;
  const int grain = scene.add_material({.youngs_modulus = 1e7, .poisson_ratio = 0.3});
  const int steel = scene.add_material(sim::rigid_material());
  const sim::Surfaces surfaces{.friction = 0.3, .restitution = 0.3};
  scene.surfaces.set(grain, grain, surfaces);
  scene.surfaces.set(grain, steel, surfaces);
  scene.add_type(sim::make_clump(sim::chain_of_spheres(1, kRadius, 0.0), {.density = 1500.0}));
  const double site = 2.0 * kRadius + kGap;
  for (int k = 0; k < kLayers; ++k) {
    const double shift = 0.5 * (1 + k % 2);
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        scene.add_body(
            0,
            {(i + shift) * site, (j + shift) * site, kRadius + kGap + k * std::sqrt(0.5) * site});
      }
    }
  }
  const double far = (side + 0.5) * site;
  add_box(scene, {far, far, 0.0}, steel);
  return scene;
}

constexpr const char* kLayer = "chains of 3 in the layer";
constexpr const char* kSpace = "balls in space";
constexpr const char* kButtons = "200 chains of 7 in the layer";

sim::Scene bed_of(const std::string& kind, int spheres) {
  if (kind == kButtons) return bricks(20, 10, 7);
  return kind == kLayer ? bricks(spheres / 3 / 40, 40, 3) : closest_balls(spheres);
}

struct Size {
  long spheres = 0;
  double contacts = 0.0;  // a sphere, at the end
};

// `steps` steps of a bed.
Size run_bed(const std::string& kind, int spheres, int steps, int threads) {
  sim::Scene scene = bed_of(kind, spheres);
  const auto count = static_cast<long>(scene.bodies.size() * scene.types[0].spheres.size());
  sim::Simulation simulation(std::move(scene), {.threads = threads});
  const double step = simulation.time_step();
  const sim::RunSummary run = simulation.run_until(steps * step);
  if (run.status != sim::RunStatus::completed) throw std::runtime_error(run.message);
  return {count, run.mean_contacts / static_cast<double>(count)};
}

// That in a child process, which tells the size in a file of its folder.
void run_own_bed(const std::string& kind, int spheres, int steps) {
  const Size size = run_bed(kind, spheres, steps, 1);
  std::ofstream("size") << size.spheres << ' ' << size.contacts << '\n';
}

Size read_size(const std::filesystem::path& folder) {
  Size size;
  std::ifstream(folder / "size") >> size.spheres >> size.contacts;
  return size;
}

ProcessCost cost_of(const std::string& kind, int spheres, int steps) {
  std::filesystem::create_directories(kFolder);
  const std::string self = std::filesystem::canonical("/proc/self/exe");
  return run_program(
      {self, "--own", kind, std::to_string(spheres), std::to_string(steps)}, kFolder, "run.log");
}

// Cost of a step from a long and a short run, so that what is done once does not count.
std::string row_of(const std::string& kind, int spheres, int steps) {
  const int few = steps / 10;
  const ProcessCost once = cost_of(kind, spheres, few), whole = cost_of(kind, spheres, steps);
  const Size size = read_size(kFolder);
  const double per_step = (whole.cpu_time - once.cpu_time) / (steps - few);
  char text[200];
  std::snprintf(text,
                sizeof text,
                "| %s | %ld | %.2f | %.4g | %.0f | %.0f |",
                kind.c_str(),
                size.spheres,
                size.contacts,
                1e3 * per_step,
                1e9 * per_step / static_cast<double>(size.spheres),
                whole.peak_memory_mib * 1048576.0 / static_cast<double>(size.spheres));
  return text;
}

// Peak memory of a long run against a short one.
std::string growth_line(int few, int many) {
  const double before = cost_of(kButtons, 1400, few).peak_memory_mib;
  const double after = cost_of(kButtons, 1400, many).peak_memory_mib;
  char text[200];
  std::snprintf(text,
                sizeof text,
                "%s: peak memory %.2f MiB after %d steps, %.2f MiB after %d (%+.2f %%)",
                kButtons,
                before,
                few,
                after,
                many,
                100.0 * (after / before - 1.0));
  return text;
}

// A bed in a process of its own that stands ready: built, and a few steps old, so that what is done
// once does not count.
class ReadyBed {
 public:
  ReadyBed(const std::string& kind, int spheres, int steps, int threads) {
    int go[2], ready[2];
    if (pipe(go) != 0 || pipe(ready) != 0) throw std::runtime_error("no pipe for a bed");
    process_ = fork();
    if (process_ < 0) throw std::runtime_error("no process for a bed");
    if (process_ == 0) {
      close(go[1]);
      close(ready[0]);
      _exit(run_when_told(kind, spheres, steps, threads, go[0], ready[1]));
    }
    close(go[0]);
    close(ready[1]);
    go_ = go[1];
    char sign = 0;
    const bool is_ready = read(ready[0], &sign, 1) == 1;
    close(ready[0]);
    if (!is_ready) throw std::runtime_error("a bed for threads could not be built");
  }
  ReadyBed(const ReadyBed&) = delete;
  ReadyBed& operator=(const ReadyBed&) = delete;
  ~ReadyBed() { close(go_); }

  void start() const {
    if (write(go_, "g", 1) != 1) throw std::runtime_error("a bed for threads does not start");
  }
  void wait() const {
    int status = 0;
    if (waitpid(process_, &status, 0) != process_ || status != 0) {
      throw std::runtime_error("a run of the bed for threads failed");
    }
  }

 private:
  static int run_when_told(
      const std::string& kind, int spheres, int steps, int threads, int go, int ready) {
    constexpr int kStepsBefore = 100;
    sim::Simulation simulation(bed_of(kind, spheres), {.threads = threads});
    const double step = simulation.time_step();
    simulation.run_until(kStepsBefore * step);
    char sign = 'r';
    if (write(ready, &sign, 1) != 1 || read(go, &sign, 1) != 1) return EXIT_FAILURE;
    const sim::RunSummary run = simulation.run_until((kStepsBefore + steps) * step);
    return run.status == sim::RunStatus::completed ? EXIT_SUCCESS : EXIT_FAILURE;
  }

  pid_t process_ = -1;
  int go_ = -1;
};

constexpr int kStepsOfThreads = 4;  // times those of the other beds

// Two threads on a bed of 5000 clumps against two processes of one thread, in turns; seconds by the
// clock, so other work on the machine counts.
std::string threads_line(int steps) {
  constexpr int kSpheres = 15000, kRepeats = 5;
  const auto seconds_of = [&](int processes, int threads) {
    std::vector<std::unique_ptr<ReadyBed>> beds;
    for (int p = 0; p < processes; ++p) {
      beds.push_back(std::make_unique<ReadyBed>(kLayer, kSpheres, steps, threads));
    }
    const auto start = std::chrono::steady_clock::now();
    for (const auto& bed : beds) bed->start();
    for (const auto& bed : beds) bed->wait();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  std::vector<double> shares, speed_ups;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    const double two_threads = seconds_of(1, 2), two_processes = seconds_of(2, 1);
    shares.push_back(0.5 * two_processes / two_threads);
    speed_ups.push_back(seconds_of(1, 1) / two_threads);
  }
  std::sort(shares.begin(), shares.end());
  std::sort(speed_ups.begin(), speed_ups.end());
  char text[200];
  std::snprintf(
      text,
      sizeof text,
      "two threads on %d chains of 3: %.2f of the throughput of two processes, %.2f times "
      "one thread (medians of %d)",
      kSpheres / 3,
      shares[kRepeats / 2],
      speed_ups[kRepeats / 2],
      kRepeats);
  return text;
}

int run(int argc, char** argv) {
  if (argc == 5 && std::strcmp(argv[1], "--own") == 0) {
    run_own_bed(argv[2], std::atoi(argv[3]), std::atoi(argv[4]));
    return EXIT_SUCCESS;
  }
  std::filesystem::path file = kFolder / "scaling.figures";
  int largest = 1000000, steps = 1000;
  bool only_threads = false;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--largest") == 0 && i + 1 < argc) {
      largest = std::atoi(argv[++i]);
    } else if (std::strcmp(argv[i], "--threads") == 0) {
      only_threads = true;
    } else if (std::strcmp(argv[i], "--steps") == 0 && i + 1 < argc) {
      steps = std::atoi(argv[++i]);
    } else {
      file = argv[i];
    }
  }
  if (only_threads) {
    std::cout << threads_line(kStepsOfThreads * steps) << std::endl;
    return EXIT_SUCCESS;
  }
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path());
  std::ofstream figures(file);
  const auto say = [&](const std::string& line) {
    std::cout << line << std::endl;
    figures << line << std::endl;
  };
  say("| bed | spheres | contacts a sphere | ms a step | ns a step and sphere | bytes a sphere |");
  say("|---|---|---|---|---|---|");
  for (const char* kind : {kLayer, kSpace}) {
    for (int spheres = 1000; spheres <= largest; spheres *= 10) say(row_of(kind, spheres, steps));
  }
  say(growth_line(10000, largest));
  say(threads_line(kStepsOfThreads * steps));
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
