// Save and restart: a simulation goes on with the same bits as one that was never interrupted.
#include "sim/engine/snapshot.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <stdexcept>

#include "sim/simulation.h"
#include "tests/sim/scenes.h"

namespace graintruth::sim {
namespace {

Scene relaxed_rig(bool planar) {
  Scene scene = scenes::micro_rig(0.3, 0.7);
  scene.planar = planar;
  relax_overlaps(scene);
  return scene;
}

// The piston starts, damping and friction change on the way: all of it must survive.
void change_things(Simulation& simulation) {
  simulation.set_global_damping(2.0);
  simulation.set_surfaces(0, 0, {.friction = 0.2, .restitution = 0.8});
  simulation.set_wall_motion(4, {.velocity = Vec3(0.0, 0.0, -0.1)});
}

TEST(Snapshot, GoesOnWithTheSameBits) {
  for (const bool planar : {true, false}) {
    const Scene scene = relaxed_rig(planar);
    Simulation whole(scene, {.tally_work = true});
    whole.run_until(0.02);
    change_things(whole);
    whole.run_until(0.05);
    const std::vector<std::byte> bytes = to_bytes(whole.save());
    whole.run_until(0.1);

    Simulation restarted(scene, {.tally_work = true});
    restarted.restore(snapshot_from_bytes(bytes));
    restarted.run_until(0.1);
    EXPECT_EQ(restarted.time(), whole.time());
    EXPECT_EQ(restarted.state_hash(), whole.state_hash());
    EXPECT_EQ(restarted.energy().damping_loss, whole.energy().damping_loss);
    EXPECT_EQ(restarted.energy().friction_loss, whole.energy().friction_loss);
    EXPECT_EQ(restarted.energy().wall_work, whole.energy().wall_work);
    EXPECT_EQ(restarted.wall_force(4), whole.wall_force(4));
    EXPECT_EQ(restarted.contacts().size(), whole.contacts().size());
  }
}

// Laws whose contacts remember more than a spring.
TEST(Snapshot, KeepsWhatContactsRemember) {
  const SimulationOptions laws[] = {{.tangential_spring = TangentialSpring::mindlin_scaled},
                                    {.normal_spring = NormalSpring::incremental}};
  for (const bool planar : {true, false}) {
    for (const SimulationOptions& law : laws) {
      Scene scene = relaxed_rig(planar);
      scene.surfaces.set(0, 1, {.friction = 0.3, .restitution = 0.7, .rolling_friction = 0.02});
      Simulation whole(scene, law), forgetful(scene, law);
      whole.run_until(0.05);
      const Snapshot snapshot = snapshot_from_bytes(to_bytes(whole.save()));
      Snapshot poorer = snapshot;
      for (KeptContact& contact : poorer.with_walls) contact.rolled[0] = contact.rolled[1] = 0.0;
      whole.run_until(0.08);
      Simulation restarted(scene, law);
      restarted.restore(snapshot);
      restarted.run_until(0.08);
      EXPECT_EQ(restarted.state_hash(), whole.state_hash());
      forgetful.restore(poorer);
      forgetful.run_until(0.08);
      EXPECT_NE(forgetful.state_hash(), whole.state_hash());
    }
  }
}

// A body far from all others is taken out: they must go on as if it had stayed, bit for bit.
TEST(Snapshot, TakingABodyOutLeavesTheOthersAlone) {
  for (const bool planar : {true, false}) {
    Scene scene = relaxed_rig(planar);
    Body lonely = scene.bodies.front();
    lonely.position.z() += 3.0;
    scene.bodies.insert(scene.bodies.begin() + 4, lonely);
    Simulation whole(scene), thinned(scene);
    for (Simulation* simulation : {&whole, &thinned}) {
      simulation->run_until(0.02);
      change_things(*simulation);
      simulation->run_until(0.05);
    }
    ASSERT_FALSE(thinned.contacts().empty());
    thinned.remove_bodies({4});
    EXPECT_EQ(thinned.contacts().size(), whole.contacts().size());
    for (Simulation* simulation : {&whole, &thinned}) simulation->run_until(0.1);
    State expected = whole.state();
    expected.position.erase(expected.position.begin() + 4);
    expected.velocity.erase(expected.velocity.begin() + 4);
    EXPECT_EQ(thinned.state().position, expected.position);
    EXPECT_EQ(thinned.state().velocity, expected.velocity);
  }
}

TEST(Snapshot, BodiesThatAreNotThereCannotBeTakenOut) {
  Simulation simulation(relaxed_rig(true));
  EXPECT_THROW(simulation.remove_bodies({10}), std::invalid_argument);
  EXPECT_THROW(simulation.remove_bodies({-1}), std::invalid_argument);
  EXPECT_THROW(simulation.remove_bodies({0, 1, 2, 3, 4, 5, 6, 7, 8, 9}), std::invalid_argument);
}

TEST(Snapshot, SavingChangesNothing) {
  const Scene scene = relaxed_rig(true);
  Simulation looked_at(scene), left_alone(scene);
  for (const double time : {0.01, 0.02, 0.03}) {
    looked_at.run_until(time);
    looked_at.save();
    left_alone.run_until(time);
  }
  EXPECT_EQ(looked_at.state_hash(), left_alone.state_hash());
}

TEST(Snapshot, BytesComeBackAsTheyWere) {
  Simulation simulation(relaxed_rig(false));
  simulation.run_until(0.02);
  const std::vector<std::byte> bytes = to_bytes(simulation.save());
  EXPECT_EQ(to_bytes(snapshot_from_bytes(bytes)), bytes);
}

RC_GTEST_PROP(Snapshot, DamagedBytesAreRefused, ()) {
  static const std::vector<std::byte> whole = [] {
    Simulation simulation(relaxed_rig(true));
    simulation.run_until(0.01);
    return to_bytes(simulation.save());
  }();
  std::vector<std::byte> damaged = whole;
  if (*rc::gen::arbitrary<bool>()) {
    damaged.resize(*rc::gen::inRange<std::size_t>(0, whole.size()));
  } else {
    damaged[*rc::gen::inRange<std::size_t>(0, whole.size())] ^= std::byte{0x10};
  }
  RC_ASSERT_THROWS_AS(snapshot_from_bytes(damaged), std::invalid_argument);
}

TEST(Snapshot, OfAnotherSceneIsRefused) {
  const Snapshot snapshot = Simulation(relaxed_rig(true)).save();
  Scene fewer = relaxed_rig(true);
  fewer.bodies.pop_back();
  Simulation other(fewer);
  EXPECT_THROW(other.restore(snapshot), std::invalid_argument);
  Simulation spatial(relaxed_rig(false));
  EXPECT_THROW(spatial.restore(snapshot), std::invalid_argument);
}

}  // namespace
}  // namespace graintruth::sim
