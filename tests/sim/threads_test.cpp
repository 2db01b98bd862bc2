// What threads share, and that it changes no bit. Run under the thread sanitizer as well.
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "sim/simulation.h"
#include "tests/sim/hashed_runs.h"

namespace graintruth::sim {
namespace {

// Runs share nothing: as many threads as there are runs, or one, give the same bits.
TEST(Threads, RunsAtOnceGiveTheSameBits) {
  std::vector<HashedRun> runs = hashed_runs();
  for (HashedRun& run : runs) run.duration = 0.03;
  std::vector<std::uint64_t> together(runs.size());
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    threads.emplace_back([&, i] { together[i] = runs[i].hash(); });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < runs.size(); ++i) EXPECT_EQ(runs[i].hash(), together[i]);
}

Scene bed_of_slabs(bool planar) {
  const Surfaces surfaces{.friction = 0.3, .restitution = 0.6};
  const scenes::BedSize flat{.columns = 40, .rows = 30, .spheres = 1, .gap = 1e-5};
  const scenes::BedSize deep{.columns = 9, .rows = 9, .depth = 8, .spheres = 1, .gap = 1e-5};
  return scenes::falling_bed(planar ? flat : deep, planar, surfaces);
}

// Beds of more than one slab of bodies, which threads share.
TEST(Threads, ChangeNoBit) {
  for (const bool planar : {true, false}) {
    const Scene scene = bed_of_slabs(planar);
    std::vector<std::uint64_t> hashes;
    for (const int threads : {1, 2, 3}) {
      Simulation simulation(scene, {.threads = threads});
      const RunSummary run = simulation.run_until(0.015);
      EXPECT_GT(run.mean_contacts, 100.0);
      hashes.push_back(simulation.state_hash());
    }
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_EQ(hashes[0], hashes[2]);
  }
}

// With bodies in the opposite order other pairs reach over two slabs, but the physics is the same.
TEST(Threads, SlabsLoseNoForce) {
  const Scene scene = bed_of_slabs(true);
  Scene other = scene;
  std::reverse(other.bodies.begin(), other.bodies.end());
  Simulation first(scene), second(other);
  first.run_until(0.01);
  second.run_until(0.01);
  ASSERT_GT(first.contacts().size(), 100u);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Vec3& there = second.state().position[scene.bodies.size() - 1 - i];
    EXPECT_LT((first.state().position[i] - there).norm(), 1e-9);
  }
  Vec3 on_floor = first.wall_force(0);
  EXPECT_NEAR((on_floor - second.wall_force(0)).norm() / on_floor.norm(), 0.0, 1e-3);
}

}  // namespace
}  // namespace graintruth::sim
