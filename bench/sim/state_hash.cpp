// The state hash of a few short runs: every build, on any machine with the same mathematical
// library, prints the same. Usage: bench_sim_state_hash
#include <cstdio>

#include "tests/sim/hashed_runs.h"

int main() {
  for (const auto& run : graintruth::sim::hashed_runs()) {
    std::printf("%016llx  %s\n", static_cast<unsigned long long>(run.hash()), run.name);
  }
}
