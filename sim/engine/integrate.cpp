#include "sim/engine/integrate.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <type_traits>

#include "sim/engine/processor_variants.h"
#include "sim/engine/slabs.h"
#include "sim/engine/transpose.h"

namespace graintruth::sim {
namespace {

// Half-step velocity of the next step from that of the last.
inline PlanarVector next(PlanarVector before, PlanarVector acceleration, const StepFactors& step) {
  return step.keep * before + step.gain * acceleration;
}
inline SpatialVector next(SpatialVector before,
                          SpatialVector acceleration,
                          const StepFactors& step) {
  return step.keep * before + step.gain * acceleration;
}
inline double next(double before, double acceleration, const StepFactors& step) {
  return step.keep * before + step.gain * acceleration;
}

inline double squared(double v) { return v * v; }
inline double squared(PlanarVector v) { return dot(v, v); }
inline double squared(SpatialVector v) { return dot(v, v); }

inline SpatialVector product(SpatialVector a, SpatialVector b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}

// What contacts read and write lies body by body; the arithmetic runs along columns. A block of
// bodies is copied from one to the other and back.
constexpr int kBlock = 64;
// A line longer than a block, so that columns do not fight for the same place in the cache
using BlockNumbers = std::array<double, kBlock + 8>;

template <int D>
struct Block {
  int first = 0;  // body
  int count = 0;
  // Constants of the kinds of the bodies; most often they are those of the block before
  std::array<int, kBlock> kind;
  BlockNumbers inverse_mass, reach_squared, gyration;
  TangentColumn<D, BlockNumbers> inertia, inverse_inertia;

  MotionColumns<D, BlockNumbers> motion;
  // Forces and torques; then the accelerations that they give
  VectorColumn<D, BlockNumbers> linear;
  TangentColumn<D, BlockNumbers> angular;
  ScalarColumn<BlockNumbers> bound;  // m2

  Block() { kind.fill(-1); }
};

template <int D>
[[gnu::always_inline]] inline void find_kinds(const Bodies<D>& bodies, Block<D>& block) {
  for (int k = 0; k < block.count; ++k) {
    const int index = bodies.kind[block.first + k];
    if (block.kind[k] == index) continue;
    const BodyKind<D>& kind = bodies.kinds[index];
    block.kind[k] = index;
    block.inverse_mass[k] = kind.inverse_mass;
    block.reach_squared[k] = kind.bounding_radius * kind.bounding_radius;
    block.gyration[k] = kind.gyration;
    block.inertia.set(k, kind.inertia);
    block.inverse_inertia.set(k, kind.inverse_inertia);
  }
}

// Blocks of one slab of bodies.
template <int D, class Function>
void for_each_block(int begin, int end, Block<D>& block, const Function& function) {
  for (block.first = begin; block.first < end; block.first += kBlock) {
    block.count = std::min(kBlock, end - block.first);
    function();
  }
}

// Change of the spin per second and its square half a step on; in body axes in space.
struct PlanarSpins {
  ScalarColumn<Rows> before, inverse_inertia;
  PlanarSpins(Bodies<2>&, Block<2>& block)
      : before(rows(block.motion.spin)), inverse_inertia(rows(block.inverse_inertia)) {}
  double acceleration(const StepFactors&, int k, double torque) const {
    return torque * inverse_inertia.at(k);
  }
};
// Without gyroscopic terms where all bodies of the block are round.
template <bool kTurnsGyrate>
struct SpatialSpins {
  RotationColumn<Rows> world_from_body;
  VectorColumn<3, Rows> before, moments, inverse_moments;
  VectorColumn<3, Rows> last;
  Rows gyration;
  SpatialSpins(Bodies<3>& bodies, Block<3>& block)
      : world_from_body(rows(bodies.turns.world_from_body, block.first)),
        before(rows(bodies.turns.spin_in_body, block.first)),
        moments(rows(block.inertia)),
        inverse_moments(rows(block.inverse_inertia)),
        gyration(block.gyration.data()) {
    if constexpr (kTurnsGyrate) last = rows(bodies.turns.last_angular_acceleration, block.first);
  }
  SpatialVector acceleration(const StepFactors& step, int k, SpatialVector torque_in_space) {
    const SpatialVector inertia = moments.at(k);
    const SpatialVector inverse = inverse_moments.at(k);
    const SpatialVector spin = before.at(k);
    const SpatialVector torque = turned_back(world_from_body.at(k), torque_in_space);
    if constexpr (!kTurnsGyrate) return product(torque, inverse);
    // Each iteration gains a factor w dt, about 1e-2 or less
    SpatialVector found = last.at(k);
    found = once_more(found, torque, spin, inertia, inverse, gyration[k], step);
    found = once_more(found, torque, spin, inertia, inverse, gyration[k], step);
    found = once_more(found, torque, spin, inertia, inverse, gyration[k], step);
    found = once_more(found, torque, spin, inertia, inverse, gyration[k], step);
    last.set(k, found);
    return found;
  }
  static SpatialVector once_more(SpatialVector acceleration,
                                 SpatialVector torque,
                                 SpatialVector spin,
                                 SpatialVector inertia,
                                 SpatialVector inverse,
                                 double gyration,
                                 const StepFactors& step) {
    const SpatialVector middle = spin + step.half * acceleration;
    return product(torque - gyration * cross(middle, product(inertia, middle)), inverse);
  }
};

// Motions and loads of the block to its columns and back: four bodies at a time, the last few one
// by one.
template <int D>
[[gnu::always_inline]] inline void read_motions(const Bodies<D>& bodies, Block<D>& block) {
  const BodyMotion<D>* motion = bodies.motion.data() + block.first;
  const int fours = block.count & -4;
  const auto of = [motion](int k) -> const BodyMotion<D>& { return motion[k]; };
  const auto columns = columns_of(block.motion);
  if constexpr (D == 2) {
    to_columns(fours, of, columns);
  } else {
    // Position and velocity; the spin is read in body axes
    to_columns(fours,
               of,
               std::array<Rows, 6>{
                   columns[0], columns[1], columns[2], columns[3], columns[4], columns[5]});
  }
  for (int k = fours; k < block.count; ++k) {
    block.motion.position.set(k, motion[k].position);
    block.motion.velocity.set(k, motion[k].velocity);
    block.motion.spin.set(k, motion[k].spin);
  }
}
template <int D>
[[gnu::always_inline]] inline void write_motions(Block<D>& block, Bodies<D>& bodies) {
  BodyMotion<D>* motion = bodies.motion.data() + block.first;
  const int fours = block.count & -4;
  to_records(
      fours, columns_of(block.motion), [motion](int k) -> BodyMotion<D>& { return motion[k]; });
  for (int k = fours; k < block.count; ++k) {
    motion[k] = {block.motion.position.at(k),
                 block.motion.velocity.at(k),
                 block.motion.velocity_now.at(k),
                 block.motion.spin.at(k),
                 block.motion.spin_now.at(k)};
  }
}
template <int D>
[[gnu::always_inline]] inline void read_loads(const Bodies<D>& bodies, Block<D>& block) {
  const Load<D>* load = bodies.load.data() + block.first;
  const int fours = block.count & -4;
  to_columns(
      fours,
      [load](int k) -> const Load<D>& { return load[k]; },
      columns_of(block.linear, block.angular));
  for (int k = fours; k < block.count; ++k) {
    block.linear.set(k, load[k].force);
    block.angular.set(k, load[k].torque);
  }
}
template <int D>
[[gnu::always_inline]] inline void write_loads(Block<D>& block, Bodies<D>& bodies) {
  Load<D>* load = bodies.load.data() + block.first;
  const int fours = block.count & -4;
  to_records(fours, columns_of(block.linear, block.angular), [load](int k) -> Load<D>& {
    return load[k];
  });
  for (int k = fours; k < block.count; ++k) load[k] = {block.linear.at(k), block.angular.at(k)};
}

// (|v| + |w| reach)^2 <= 2 (v^2 + w^2 reach^2); the comparisons are false for NaN. `largest` is the
// largest bound so far, m2.
template <int D, class Spins>
[[gnu::always_inline]] inline int find_accelerations_of(typename Motion<D>::Vector gravity,
                                                        const StepFactors& step,
                                                        const StepLimit& limit,
                                                        Block<D>& block,
                                                        Bodies<D>& bodies,
                                                        double& largest) {
  const double dt_squared = step.time_step * step.time_step;
  const double move_squared = limit.move * limit.move;
  const double turn_squared = limit.turn * limit.turn;
  const int count = block.count;
  Spins spins(bodies, block);
  int sound = 0;
#pragma GCC ivdep
  for (int k = 0; k < count; ++k) {
    const auto acceleration = block.inverse_mass[k] * block.linear.at(k) + gravity;
    const auto angular = spins.acceleration(step, k, block.angular.at(k));
    block.linear.set(k, acceleration);
    block.angular.set(k, angular);
    const double turn = squared(next(spins.before.at(k), angular, step)) * dt_squared;
    const double go = squared(next(block.motion.velocity.at(k), acceleration, step)) * dt_squared;
    const double bound = 2.0 * (go + turn * block.reach_squared[k]);
    block.bound.set(k, bound);
    sound += (bound <= move_squared ? 1 : 0) & (turn <= turn_squared ? 1 : 0);
  }
  double most = largest;
#pragma omp simd reduction(max : most)
  for (int k = 0; k < count; ++k) most = block.bound.at(k) > most ? block.bound.at(k) : most;
  largest = most;
  return count - sound;
}

template <int D>
[[gnu::always_inline]] inline void advance_centre(const StepFactors& step, int k, Block<D>& block) {
  MotionColumns<D, BlockNumbers>& motion = block.motion;
  const auto acceleration = block.linear.at(k);
  const auto velocity = next(motion.velocity.at(k), acceleration, step);
  motion.position.set(k, motion.position.at(k) + step.time_step * velocity);
  motion.velocity.set(k, velocity);
  motion.velocity_now.set(k, step.predict * velocity + step.half * acceleration);
}

[[gnu::always_inline]] inline void advance_of(const StepFactors& step,
                                              Bodies<2>& bodies,
                                              Block<2>& block) {
  const int count = block.count;
  Rows angles = bodies.turns.angle.data() + block.first;
  VectorColumn<2, Rows> direction = rows(bodies.turns.direction, block.first);
#pragma GCC ivdep
  for (int k = 0; k < count; ++k) {
    advance_centre(step, k, block);
    const double angular = block.angular.at(k);
    const double spin = next(block.motion.spin.at(k), angular, step);
    block.motion.spin.set(k, spin);
    block.motion.spin_now.set(k, step.predict * spin + step.half * angular);
    const double angle = spin * step.time_step;
    angles[k] += angle;
    const SmallTurn small = small_turn(angle);
    const PlanarVector old = direction.at(k);
    const PlanarVector turned{old.x * small.cosine - old.z * small.sine,
                              old.z * small.cosine + old.x * small.sine};
    // First-order renormalisation: the length is 1 to round-off already
    direction.set(k, (1.5 - 0.5 * dot(turned, turned)) * turned);
  }
}

// q(N+1) = q(N) exp(w dt / 2), w in body axes
[[gnu::always_inline]] inline void advance_of(const StepFactors& step,
                                              Bodies<3>& bodies,
                                              Block<3>& block) {
  const int count = block.count;
  RotationColumn<Rows> rotation = rows(bodies.turns.world_from_body, block.first);
  VectorColumn<3, Rows> spin_in_body = rows(bodies.turns.spin_in_body, block.first);
#pragma GCC ivdep
  for (int k = 0; k < count; ++k) {
    advance_centre(step, k, block);
    const SpatialVector angular = block.angular.at(k);
    const SpatialVector spin = next(spin_in_body.at(k), angular, step);
    spin_in_body.set(k, spin);
    const HalfTurn half = half_turn(squared(spin) * step.half * step.half);
    const SpatialVector vector = (step.half * half.sine_over_angle) * spin;
    const Rotation turned = rotation.at(k) * Rotation{half.cosine, vector.x, vector.y, vector.z};
    // First-order renormalisation: the length is 1 to round-off already
    const Rotation world_from_body = (1.5 - 0.5 * squared(turned)) * turned;
    rotation.set(k, world_from_body);
    block.motion.spin.set(k, turned_by(world_from_body, spin));
    block.motion.spin_now.set(
        k, turned_by(world_from_body, step.predict * spin + step.half * angular));
  }
}

GRAINTRUTH_FOR_EACH_PROCESSOR int find_accelerations_in(PlanarVector gravity,
                                                        const StepFactors& step,
                                                        const StepLimit& limit,
                                                        Block<2>& block,
                                                        Bodies<2>& bodies,
                                                        double& largest) {
  find_kinds(bodies, block);
  read_loads(bodies, block);
  read_motions(bodies, block);
  const int suspects =
      find_accelerations_of<2, PlanarSpins>(gravity, step, limit, block, bodies, largest);
  write_loads(block, bodies);
  return suspects;
}
GRAINTRUTH_FOR_EACH_PROCESSOR int find_accelerations_in(SpatialVector gravity,
                                                        const StepFactors& step,
                                                        const StepLimit& limit,
                                                        Block<3>& block,
                                                        Bodies<3>& bodies,
                                                        double& largest) {
  find_kinds(bodies, block);
  read_loads(bodies, block);
  read_motions(bodies, block);
  double gyration = 0.0;
  for (int k = 0; k < block.count; ++k) gyration += block.gyration[k];
  const int suspects = gyration == 0.0 ? find_accelerations_of<3, SpatialSpins<false>>(
                                             gravity, step, limit, block, bodies, largest)
                                       : find_accelerations_of<3, SpatialSpins<true>>(
                                             gravity, step, limit, block, bodies, largest);
  write_loads(block, bodies);
  return suspects;
}
GRAINTRUTH_FOR_EACH_PROCESSOR void advance_in(const StepFactors& step,
                                              Bodies<2>& bodies,
                                              Block<2>& block) {
  read_motions(bodies, block);
  read_loads(bodies, block);
  advance_of(step, bodies, block);
  write_motions(block, bodies);
  for (int k = 0; k < block.count; ++k) place_spheres(bodies, block.first + k);
}
GRAINTRUTH_FOR_EACH_PROCESSOR void advance_in(const StepFactors& step,
                                              Bodies<3>& bodies,
                                              Block<3>& block) {
  read_motions(bodies, block);
  read_loads(bodies, block);
  advance_of(step, bodies, block);
  write_motions(block, bodies);
  for (int k = 0; k < block.count; ++k) place_spheres(bodies, block.first + k);
}

template <int D>
StepBound find_all_accelerations(typename Motion<D>::Vector gravity,
                                 const StepFactors& step,
                                 const StepLimit& limit,
                                 Bodies<D>& bodies,
                                 Team* team) {
  std::atomic<double> largest_of_all = 0.0;
  std::atomic<int> suspects_of_all = 0;
  for_each_shared(slab_count_of(bodies.count()), team, [&](int, int slab) {
    const auto [begin, end] = slab_range(slab, bodies.count());
    Block<D> block;
    double largest = 0.0;
    int suspects = 0;
    for_each_block(begin, end, block, [&] {
      suspects += find_accelerations_in(gravity, step, limit, block, bodies, largest);
    });
    suspects_of_all += suspects;
    // The largest of all, whoever comes last
    double before = largest_of_all;
    while (before < largest && !largest_of_all.compare_exchange_weak(before, largest)) {
    }
  });
  return {std::sqrt(largest_of_all), suspects_of_all};
}

template <int D>
void advance_all(const StepFactors& step, Bodies<D>& bodies, Team* team) {
  for_each_shared(slab_count_of(bodies.count()), team, [&](int, int slab) {
    const auto [begin, end] = slab_range(slab, bodies.count());
    Block<D> block;
    for_each_block(begin, end, block, [&] { advance_in(step, bodies, block); });
  });
}

}  // namespace

StepBound find_accelerations(const Vec2& gravity,
                             const StepFactors& step,
                             const StepLimit& limit,
                             Bodies<2>& bodies,
                             Team* team) {
  return find_all_accelerations<2>(plain(gravity), step, limit, bodies, team);
}
StepBound find_accelerations(const Vec3& gravity,
                             const StepFactors& step,
                             const StepLimit& limit,
                             Bodies<3>& bodies,
                             Team* team) {
  return find_all_accelerations<3>(plain(gravity), step, limit, bodies, team);
}

void advance(const StepFactors& step, Bodies<2>& bodies, Team* team) {
  advance_all(step, bodies, team);
}
void advance(const StepFactors& step, Bodies<3>& bodies, Team* team) {
  advance_all(step, bodies, team);
}

Speeds next_speeds(const StepFactors& step, const Bodies<2>& bodies, int i) {
  const auto velocity = next(bodies.motion[i].velocity, bodies.acceleration(i), step);
  return {std::sqrt(squared(velocity)),
          std::abs(next(bodies.motion[i].spin, bodies.angular_acceleration(i), step))};
}
Speeds next_speeds(const StepFactors& step, const Bodies<3>& bodies, int i) {
  const auto velocity = next(bodies.motion[i].velocity, bodies.acceleration(i), step);
  const auto spin = next(bodies.turns.spin_in_body.at(i), bodies.angular_acceleration(i), step);
  return {std::sqrt(squared(velocity)), std::sqrt(squared(spin))};
}

void shift_half_step(double later, double global_damping, Bodies<2>& bodies) {
  for (int i = 0; i < bodies.count(); ++i) {
    BodyMotion<2>& motion = bodies.motion[i];
    motion.velocity =
        motion.velocity + later * (bodies.acceleration(i) - global_damping * motion.velocity);
    motion.spin += later * (bodies.angular_acceleration(i) - global_damping * motion.spin);
  }
}
void shift_half_step(double later, double global_damping, Bodies<3>& bodies) {
  for (int i = 0; i < bodies.count(); ++i) {
    BodyMotion<3>& motion = bodies.motion[i];
    motion.velocity =
        motion.velocity + later * (bodies.acceleration(i) - global_damping * motion.velocity);
    const SpatialVector before = bodies.turns.spin_in_body.at(i);
    const SpatialVector spin =
        before + later * (bodies.angular_acceleration(i) - global_damping * before);
    bodies.turns.spin_in_body.set(i, spin);
    motion.spin = turned_by(bodies.turns.world_from_body.at(i), spin);
  }
}

}  // namespace graintruth::sim
