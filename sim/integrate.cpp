#include "sim/integrate.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <type_traits>

#include "sim/processor_variants.h"
#include "sim/transpose.h"

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
  MotionColumns<D, BlockNumbers> motion;
  VectorColumn<D, BlockNumbers> force;
  TangentColumn<D, BlockNumbers> torque;
  ScalarColumn<BlockNumbers> bound;  // m2
};

// Blocks of one share of the bodies.
template <int D, class Function>
void for_each_block(int begin, int end, Block<D>& block, const Function& function) {
  for (block.first = begin; block.first < end; block.first += kBlock) {
    block.count = std::min(kBlock, end - block.first);
    function();
  }
}

// Shares of whole blocks, few enough to hand out and small enough for the last one not to be waited
// for.
constexpr int kBodiesInShare = 16 * kBlock;

// function(begin, end, share) for all shares of the bodies.
template <int D, class Function>
void for_each_share(const Bodies<D>& bodies, Team* team, const Function& function) {
  const int shares = (bodies.count() + kBodiesInShare - 1) / kBodiesInShare;
  const auto task = [&](int, int share) {
    const int begin = share * kBodiesInShare;
    function(begin, std::min(begin + kBodiesInShare, bodies.count()), share);
  };
  if (team != nullptr && team->workers() > 1 && shares > 1) {
    team->run(shares, task);
  } else {
    for (int share = 0; share < shares; ++share) task(0, share);
  }
}

// The columns of a block of bodies.
template <int D>
struct BodyRows {
  explicit BodyRows(Bodies<D>& bodies, int first)
      : inverse_mass(bodies.inverse_mass.data() + first),
        reach_squared(bodies.reach_squared.data() + first),
        inertia(rows(bodies.inertia, first)),
        inverse_inertia(rows(bodies.inverse_inertia, first)),
        acceleration(rows(bodies.acceleration, first)),
        angular_acceleration(rows(bodies.angular_acceleration, first)) {}
  Rows inverse_mass, reach_squared;
  TangentColumn<D, Rows> inertia, inverse_inertia;
  VectorColumn<D, Rows> acceleration;
  TangentColumn<D, Rows> angular_acceleration;
};

// Change of the spin per second and its square half a step on; in body axes in space.
struct PlanarSpins {
  ScalarColumn<Rows> before;
  PlanarSpins(Bodies<2>&, Block<2>& block) : before(rows(block.motion.spin)) {}
  double acceleration(const BodyRows<2>& rows, const StepFactors&, int k, double torque) const {
    return torque * rows.inverse_inertia.at(k);
  }
};
// Without gyroscopic terms where all bodies of the block are round.
template <bool kTurnsGyrate>
struct SpatialSpins {
  RotationColumn<Rows> world_from_body;
  VectorColumn<3, Rows> before;
  Rows gyration;
  SpatialSpins(Bodies<3>& bodies, Block<3>& block)
      : world_from_body(rows(bodies.turns.world_from_body, block.first)),
        before(rows(bodies.turns.spin_in_body, block.first)),
        gyration(bodies.gyration.data() + block.first) {}
  SpatialVector acceleration(const BodyRows<3>& rows,
                             const StepFactors& step,
                             int k,
                             SpatialVector torque_in_space) const {
    const SpatialVector inertia = rows.inertia.at(k);
    const SpatialVector inverse = rows.inverse_inertia.at(k);
    const SpatialVector spin = before.at(k);
    const SpatialVector torque = turned_back(world_from_body.at(k), torque_in_space);
    if constexpr (!kTurnsGyrate) return product(torque, inverse);
    // Each iteration gains a factor w dt, about 1e-2 or less
    SpatialVector found = rows.angular_acceleration.at(k);
    found = once_more(found, torque, spin, inertia, inverse, gyration[k], step);
    found = once_more(found, torque, spin, inertia, inverse, gyration[k], step);
    found = once_more(found, torque, spin, inertia, inverse, gyration[k], step);
    return once_more(found, torque, spin, inertia, inverse, gyration[k], step);
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
      columns_of(block.force, block.torque));
  for (int k = fours; k < block.count; ++k) {
    block.force.set(k, load[k].force);
    block.torque.set(k, load[k].torque);
  }
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
  BodyRows<D> row(bodies, block.first);
  const Spins spins(bodies, block);
  int sound = 0;
#pragma GCC ivdep
  for (int k = 0; k < count; ++k) {
    const auto acceleration = row.inverse_mass[k] * block.force.at(k) + gravity;
    const auto angular = spins.acceleration(row, step, k, block.torque.at(k));
    row.acceleration.set(k, acceleration);
    row.angular_acceleration.set(k, angular);
    const double turn = squared(next(spins.before.at(k), angular, step)) * dt_squared;
    const double go = squared(next(block.motion.velocity.at(k), acceleration, step)) * dt_squared;
    const double bound = 2.0 * (go + turn * row.reach_squared[k]);
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
[[gnu::always_inline]] inline void advance_centre(const StepFactors& step,
                                                  const BodyRows<D>& row,
                                                  int k,
                                                  MotionColumns<D, BlockNumbers>& motion) {
  const auto acceleration = row.acceleration.at(k);
  const auto velocity = next(motion.velocity.at(k), acceleration, step);
  motion.position.set(k, motion.position.at(k) + step.time_step * velocity);
  motion.velocity.set(k, velocity);
  motion.velocity_now.set(k, step.predict * velocity + step.half * acceleration);
}

[[gnu::always_inline]] inline void advance_of(const StepFactors& step,
                                              Bodies<2>& bodies,
                                              Block<2>& block) {
  const int count = block.count;
  const BodyRows<2> row(bodies, block.first);
  Rows angles = bodies.turns.angle.data() + block.first;
  VectorColumn<2, Rows> direction = rows(bodies.turns.direction, block.first);
#pragma GCC ivdep
  for (int k = 0; k < count; ++k) {
    advance_centre(step, row, k, block.motion);
    const double angular = row.angular_acceleration.at(k);
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
  const BodyRows<3> row(bodies, block.first);
  RotationColumn<Rows> rotation = rows(bodies.turns.world_from_body, block.first);
  VectorColumn<3, Rows> spin_in_body = rows(bodies.turns.spin_in_body, block.first);
#pragma GCC ivdep
  for (int k = 0; k < count; ++k) {
    advance_centre(step, row, k, block.motion);
    const SpatialVector angular = row.angular_acceleration.at(k);
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
  read_loads(bodies, block);
  read_motions(bodies, block);
  return find_accelerations_of<2, PlanarSpins>(gravity, step, limit, block, bodies, largest);
}
GRAINTRUTH_FOR_EACH_PROCESSOR int find_accelerations_in(SpatialVector gravity,
                                                        const StepFactors& step,
                                                        const StepLimit& limit,
                                                        Block<3>& block,
                                                        Bodies<3>& bodies,
                                                        double& largest) {
  read_loads(bodies, block);
  read_motions(bodies, block);
  double gyration = 0.0;
  for (int k = 0; k < block.count; ++k) gyration += bodies.gyration[block.first + k];
  if (gyration == 0.0) {
    return find_accelerations_of<3, SpatialSpins<false>>(
        gravity, step, limit, block, bodies, largest);
  }
  return find_accelerations_of<3, SpatialSpins<true>>(gravity, step, limit, block, bodies, largest);
}
GRAINTRUTH_FOR_EACH_PROCESSOR void advance_in(const StepFactors& step,
                                              Bodies<2>& bodies,
                                              Block<2>& block) {
  read_motions(bodies, block);
  advance_of(step, bodies, block);
  write_motions(block, bodies);
  for (int k = 0; k < block.count; ++k) place_spheres(bodies, block.first + k);
}
GRAINTRUTH_FOR_EACH_PROCESSOR void advance_in(const StepFactors& step,
                                              Bodies<3>& bodies,
                                              Block<3>& block) {
  read_motions(bodies, block);
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
  for_each_share(bodies, team, [&](int begin, int end, int) {
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
  for_each_share(bodies, team, [&](int begin, int end, int) {
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
  const auto velocity = next(bodies.motion[i].velocity, bodies.acceleration.at(i), step);
  return {std::sqrt(squared(velocity)),
          std::abs(next(bodies.motion[i].spin, bodies.angular_acceleration.at(i), step))};
}
Speeds next_speeds(const StepFactors& step, const Bodies<3>& bodies, int i) {
  const auto velocity = next(bodies.motion[i].velocity, bodies.acceleration.at(i), step);
  const auto spin = next(bodies.turns.spin_in_body.at(i), bodies.angular_acceleration.at(i), step);
  return {std::sqrt(squared(velocity)), std::sqrt(squared(spin))};
}

void shift_half_step(double later, double global_damping, Bodies<2>& bodies) {
  for (int i = 0; i < bodies.count(); ++i) {
    BodyMotion<2>& motion = bodies.motion[i];
    motion.velocity =
        motion.velocity + later * (bodies.acceleration.at(i) - global_damping * motion.velocity);
    motion.spin += later * (bodies.angular_acceleration.at(i) - global_damping * motion.spin);
  }
}
void shift_half_step(double later, double global_damping, Bodies<3>& bodies) {
  for (int i = 0; i < bodies.count(); ++i) {
    BodyMotion<3>& motion = bodies.motion[i];
    motion.velocity =
        motion.velocity + later * (bodies.acceleration.at(i) - global_damping * motion.velocity);
    const SpatialVector before = bodies.turns.spin_in_body.at(i);
    const SpatialVector spin =
        before + later * (bodies.angular_acceleration.at(i) - global_damping * before);
    bodies.turns.spin_in_body.set(i, spin);
    motion.spin = turned_by(bodies.turns.world_from_body.at(i), spin);
  }
}

}  // namespace graintruth::sim
