#include "sim/engine.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace graintruth::sim {
namespace {

// Part of the skin that may be used up before the bodies' true displacements are looked at again.
constexpr double kSkinInUse = 0.7;

// Books the work of dashpots and of tangential forces, J.
struct WorkTally {
  static constexpr bool commits = true;
  double time_step = 0.0;
  double damping_loss = 0.0;
  double tangential_work = 0.0;
  template <int D>
  void operator()(const ContactEvent<D>& event) {
    const double elastic = hertz_force(event.touch->stiffness, event.touch->overlap);
    damping_loss += (elastic - event.force->normal) * event.motion->normal_speed * time_step;
    tangential_work -= product_of(event.force->tangential, event.motion->tangential) * time_step;
  }
};

struct SpringEnergy {
  static constexpr bool commits = false;
  double normal = 0.0;
  double tangential = 0.0;
  template <int D>
  void operator()(const ContactEvent<D>& event) {
    normal += hertz_energy(event.touch->stiffness, event.touch->overlap);
    const double stiffness = event.pair->tangential_ratio * event.touch->stiffness;
    tangential += 0.5 * stiffness * product_of(event.spring, event.spring);
  }
};

template <int D>
struct ContactRecorder {
  static constexpr bool commits = false;
  const Bodies<D>& bodies;
  const ContactList<D>& between;
  const ContactList<D>& with_walls;
  std::vector<ContactReport> reports;
  void operator()(const ContactEvent<D>& event) {
    const ContactList<D>& list = event.with_wall ? with_walls : between;
    ContactReport report;
    report.first = event.group->first;
    report.second = event.group->second;
    report.with_wall = event.with_wall;
    report.first_sphere = list.first_sphere[event.candidate] - bodies.first_sphere[report.first];
    if (!event.with_wall) {
      report.second_sphere =
          list.second_sphere[event.candidate] - bodies.first_sphere[report.second];
    }
    report.overlap = event.touch->overlap;
    report.normal = to_space(event.touch->normal);
    report.normal_force = event.force->normal;
    report.tangential_force = to_space(as_vector(event.force->tangential, event.touch->normal));
    report.slides = event.force->slides;
    reports.push_back(report);
  }
};

// FNV-1a over the bits of doubles.
struct Hash {
  std::uint64_t value = 14695981039346656037ull;
  void add(double number) {
    std::uint64_t bits = std::bit_cast<std::uint64_t>(number);
    for (int i = 0; i < 8; ++i, bits >>= 8) value = (value ^ (bits & 0xff)) * 1099511628211ull;
  }
  template <class Vector>
  void add_vector(const Vector& vector) {
    for (Eigen::Index i = 0; i < vector.size(); ++i) add(vector[i]);
  }
};

std::string number(double value) { return std::to_string(value); }

}  // namespace

template <int D>
Engine<D>::Engine(const Scene& scene, const SimulationOptions& options, const Engine* earlier)
    : options_(options),
      gravity_(to_motion<D>(scene.gravity)),
      bodies_(make_bodies<D>(scene)),
      walls_at_rest_(scene.walls),
      global_damping_(options.global_damping) {
  double smallest_radius = 0.0;
  for (const Body& body : scene.bodies) {
    const Clump& type = scene.types[body.type];
    if (smallest_radius == 0.0 || type.smallest_radius < smallest_radius) {
      smallest_radius = type.smallest_radius;
    }
    reach_squared_.push_back(type.bounding_radius * type.bounding_radius);
  }
  skin_ = options.skin > 0.0 ? options.skin : 0.1 * smallest_radius;
  largest_move_ = options.largest_move * smallest_radius;
  wall_surfaces_.resize(scene.walls.size());
  use_pairs(scene, options);
  if (earlier != nullptr) {
    walls_at_rest_ = earlier->walls_at_rest_;
    between_ = earlier->between_;
    with_walls_ = earlier->with_walls_;
    time_ = earlier->time_;
    slip_time_ = earlier->slip_time_;
    contact_steps_ = earlier->contact_steps_;
    searches_ = earlier->searches_;
    damping_loss_ = earlier->damping_loss_;
    tangential_work_ = earlier->tangential_work_;
    wall_work_ = earlier->wall_work_;
  }
  list_moving_walls();
  move_walls_to(time_);
  find_contacts();
  factors_ = step_factors(choose_time_step(scene, options.time_step), global_damping_);
  start();
}

template <int D>
void Engine<D>::use_pairs(const Scene& scene, const SimulationOptions& options) {
  material_count_ = static_cast<int>(scene.materials.size());
  pairs_.assign(static_cast<std::size_t>(material_count_) * material_count_, {});
  for (int i = 0; i < material_count_; ++i) {
    for (int j = i; j < material_count_; ++j) {
      const bool both_rigid = std::isinf(scene.materials[i].youngs_modulus) &&
                              std::isinf(scene.materials[j].youngs_modulus);
      if (both_rigid) continue;  // two walls never touch
      pairs_[i * material_count_ + j] = mix(scene.materials[i],
                                            scene.materials[j],
                                            scene.surfaces.of(i, j),
                                            options.tension,
                                            options.tangential_damping);
      pairs_[j * material_count_ + i] = pairs_[i * material_count_ + j];
    }
  }
}

// Accelerations at the start, so that the first half-step velocities are v(-1/2) = v0 - a0 dt/2
// (thesis 2.16).
template <int D>
void Engine<D>::start() {
  StepOnly visit;
  add_forces(visit);
  for (int i = 0; i < bodies_.count(); ++i) {
    bodies_.acceleration[i] = next_velocity(bodies_, i, gravity_, factors_).acceleration;
    const auto next = next_spin(bodies_, i, factors_);
    if constexpr (D == 2) {
      bodies_.angular_acceleration[i] = next.acceleration;
    } else {
      bodies_.turns.acceleration_in_body[i] = next.acceleration;
    }
    shift_half_step(bodies_, i, -factors_.half);
  }
}

template <int D>
template <bool Clipped, class Visitor>
int Engine<D>::add_forces_of_law(Visitor& visit) {
  const ForceSetting<D> setting{
      &pairs_, options_.damping_sharing, slip_time_, options_.largest_overlap};
  return add_pair_forces<D, Clipped>(
             setting, between_, bodies_, touches_, overlap_trouble_, visit) +
         add_wall_forces<D, Clipped>(setting,
                                     walls_,
                                     wall_surfaces_,
                                     with_walls_,
                                     bodies_,
                                     touches_,
                                     overlap_trouble_,
                                     visit);
}

template <int D>
template <class Visitor>
void Engine<D>::add_forces(Visitor& visit) {
  if constexpr (Visitor::commits) {
    std::fill(bodies_.force.begin(), bodies_.force.end(), Vec<D>::Zero());
    std::fill(bodies_.torque.begin(), bodies_.torque.end(), Motion<D>::no_spin());
    clear_wall_forces();
  }
  const int touching = options_.tension == Tension::clipped ? add_forces_of_law<true>(visit)
                                                            : add_forces_of_law<false>(visit);
  if constexpr (Visitor::commits) contact_steps_ += touching;
}

template <int D>
bool Engine<D>::step(double time) {
  // 1. Forces where the bodies are now
  if (options_.tally_work) {
    WorkTally tally{factors_.time_step};
    add_forces(tally);
    damping_loss_ += tally.damping_loss;
    tangential_work_ += tally.tangential_work;
    for (const int w : moving_walls_) {
      const WallSurface<D>& wall = wall_surfaces_[w];
      const double power =
          wall.force.dot(wall.velocity_now) + product_of(wall.torque, wall.spin_now);
      wall_work_ -= power * factors_.time_step;
    }
  } else {
    StepOnly visit;
    add_forces(visit);
  }
  if (overlap_trouble_.found) {
    trouble_ = describe_overlap();
    return false;
  }
  // 2. Leapfrog
  if (!integrate()) return false;
  slip_time_ = factors_.time_step;
  // 3. Walls, and new candidates when something may have come near
  move_walls_to(time);
  if (2.0 * travel_ + wall_travel_ > skin_) find_contacts_if_moved();
  return true;
}

template <int D>
bool Engine<D>::integrate() {
  const double move_squared = largest_move_ * largest_move_;
  const double dt_squared = factors_.time_step * factors_.time_step;
  double worst = 0.0;
  for (int i = 0; i < bodies_.count(); ++i) {
    const NextVelocity<D> next = next_velocity(bodies_, i, gravity_, factors_);
    const auto spinning = next_spin(bodies_, i, factors_);

    // Guard: (|v| + |w| reach)^2 <= 2 (v^2 + w^2 reach^2); the comparison is false for NaN
    const double linear = next.velocity.squaredNorm();
    const double angular = spinning.squared() * reach_squared_[i];
    const double bound = 2.0 * (linear + angular) * dt_squared;
    if (!(bound <= move_squared)) {
      const double move = (std::sqrt(linear) + std::sqrt(angular)) * factors_.time_step;
      if (!(move <= largest_move_)) {
        trouble_ = "body " + std::to_string(i) + " would move " + number(1e3 * move) +
                   " mm in one step, limit " + number(1e3 * largest_move_) + " mm, at " +
                   number(time_) + " s";
        return false;
      }
    }
    worst = bound > worst ? bound : worst;

    move(bodies_, i, next, factors_);
    turn(bodies_, i, spinning, factors_);
    place_spheres(bodies_, i);
  }
  travel_ += std::sqrt(worst);
  return true;
}

template <int D>
void Engine<D>::move_walls_to(double time) {
  if (walls_.size() != walls_at_rest_.size()) walls_ = walls_at_rest_;
  const double before = time_;
  double fastest = 0.0;
  for (const int w : moving_walls_) {
    const Wall& rest = walls_at_rest_[w];
    place_wall(rest, time, walls_[w]);
    set_surface(w, 0.5 * (before + time), time);
    fastest = std::max(fastest, fastest_point(rest));
  }
  wall_travel_ += fastest * (time - before);
  time_ = time;
}

template <int D>
void Engine<D>::list_moving_walls() {
  moving_walls_.clear();
  for (std::size_t w = 0; w < walls_at_rest_.size(); ++w) {
    if (!is_still(walls_at_rest_[w])) moving_walls_.push_back(static_cast<int>(w));
  }
}

// Only of the walls that had candidates: a mesh has many that never do.
template <int D>
void Engine<D>::clear_wall_forces() {
  for (const int w : loaded_walls_) {
    wall_surfaces_[w].force.setZero();
    wall_surfaces_[w].torque = Motion<D>::no_spin();
  }
  if (!loaded_walls_are_old_) return;
  loaded_walls_.clear();
  for (const ContactGroup& group : with_walls_.groups) loaded_walls_.push_back(group.second);
  std::sort(loaded_walls_.begin(), loaded_walls_.end());
  loaded_walls_.erase(std::unique(loaded_walls_.begin(), loaded_walls_.end()), loaded_walls_.end());
  loaded_walls_are_old_ = false;
}

template <int D>
void Engine<D>::set_surface(int wall, double middle, double time) {
  const Twist before = surface_twist(walls_at_rest_[wall], middle);
  const Twist now = surface_twist(walls_at_rest_[wall], time);
  WallSurface<D>& surface = wall_surfaces_[wall];
  surface.velocity = to_motion<D>(before.velocity);
  surface.velocity_now = to_motion<D>(now.velocity);
  surface.spin = to_spin<D>(before.spin);
  surface.spin_now = to_spin<D>(now.spin);
  surface.turns = !before.spin.isZero(0.0) || !now.spin.isZero(0.0);
}

template <int D>
double Engine<D>::largest_displacement() const {
  double largest = 0.0;
  for (int i = 0; i < bodies_.count(); ++i) {
    // The chord of a turn by phi at distance r is 2 r sin(phi/2)
    double chord = 0.0;
    if constexpr (D == 2) {
      chord = (bodies_.turns.direction[i] - searched_turns_.direction[i]).norm();
    } else {
      const double cosine =
          bodies_.turns.world_from_body[i].dot(searched_turns_.world_from_body[i]);
      chord = 2.0 * std::sqrt(std::max(1.0 - cosine * cosine, 0.0));
    }
    largest = std::max(
        largest,
        (bodies_.position[i] - searched_position_[i]).norm() + chord * bodies_.bounding_radius[i]);
  }
  return largest;
}

template <int D>
void Engine<D>::find_contacts_if_moved() {
  travel_ = largest_displacement();
  if (2.0 * travel_ + wall_travel_ > kSkinInUse * skin_) find_contacts();
}

template <int D>
void Engine<D>::find_contacts() {
  search_.find(bodies_, walls_, pairs_, material_count_, skin_, between_, with_walls_);
  std::size_t most = 0;
  for (const ContactList<D>* list : {&between_, &with_walls_}) {
    for (const ContactGroup& group : list->groups) {
      most = std::max(most, static_cast<std::size_t>(group.end - group.begin));
    }
  }
  if (touches_.size() < most) touches_.resize(most);
  loaded_walls_are_old_ = true;
  searched_position_ = bodies_.position;
  searched_turns_ = bodies_.turns;
  travel_ = 0.0;
  wall_travel_ = 0.0;
  ++searches_;
}

template <int D>
void Engine<D>::use_time_step(double time_step) {
  if (time_step == factors_.time_step) return;
  const StepFactors changed = step_factors(time_step, global_damping_);
  for (int i = 0; i < bodies_.count(); ++i) {
    shift_half_step(bodies_, i, factors_.half - changed.half);
  }
  factors_ = changed;
}

template <int D>
void Engine<D>::use_global_damping(double per_second) {
  global_damping_ = per_second;
  factors_ = step_factors(factors_.time_step, global_damping_);
}

template <int D>
void Engine<D>::use_wall_motion(int wall, const WallMotion& motion) {
  walls_at_rest_[wall] = walls_[wall];
  walls_at_rest_[wall].motion = motion;
  walls_at_rest_[wall].motion.start_time = std::max(motion.start_time, time_);
  list_moving_walls();
  set_surface(wall, time_, time_);
}

template <int D>
void Engine<D>::use_wall_drag(int wall, const WallMotion& drag) {
  walls_at_rest_[wall].drag = drag;
  walls_at_rest_[wall].drag.start_time = std::max(drag.start_time, time_);
  list_moving_walls();
  set_surface(wall, time_, time_);
}

template <int D>
void Engine<D>::open_wall(int wall, double time) {
  walls_at_rest_[wall].opens_at = time;
  list_moving_walls();
  place_wall(walls_at_rest_[wall], time_, walls_[wall]);
}

template <int D>
void Engine<D>::clear_velocities() {
  for (int i = 0; i < bodies_.count(); ++i) {
    bodies_.velocity_now[i].setZero();
    bodies_.velocity[i].setZero();
    bodies_.spin_now[i] = Motion<D>::no_spin();
    bodies_.spin[i] = Motion<D>::no_spin();
    if constexpr (D == 3) bodies_.turns.spin_in_body[i].setZero();
    shift_half_step(bodies_, i, -factors_.half);
  }
}

template <int D>
Energy Engine<D>::energy() {
  SpringEnergy springs;
  add_forces(springs);
  Energy energy;
  energy.elastic = springs.normal + springs.tangential;
  for (int i = 0; i < bodies_.count(); ++i) {
    const double mass = bodies_.mass[i];
    energy.kinetic += 0.5 * mass * bodies_.velocity_now[i].squaredNorm();
    if constexpr (D == 2) {
      energy.kinetic += 0.5 * bodies_.inertia[i] * bodies_.spin_now[i] * bodies_.spin_now[i];
    } else {
      const Vec3 spin = bodies_.turns.world_from_body[i].conjugate() * bodies_.spin_now[i];
      energy.kinetic += 0.5 * spin.dot(bodies_.inertia[i].cwiseProduct(spin));
    }
    energy.gravity -= mass * gravity_.dot(bodies_.position[i]);
  }
  energy.damping_loss = damping_loss_;
  energy.friction_loss = options_.tally_work ? tangential_work_ - springs.tangential : 0.0;
  energy.wall_work = wall_work_;
  return energy;
}

template <int D>
std::vector<ContactReport> Engine<D>::contacts() {
  ContactRecorder<D> recorder{bodies_, between_, with_walls_, {}};
  add_forces(recorder);
  return recorder.reports;
}

template <int D>
std::uint64_t Engine<D>::state_hash() const {
  Hash hash;
  hash.add(time_);
  for (int i = 0; i < bodies_.count(); ++i) {
    hash.add_vector(bodies_.position[i]);
    hash.add_vector(bodies_.velocity[i]);
    if constexpr (D == 2) {
      hash.add(bodies_.turns.angle[i]);
      hash.add(bodies_.spin[i]);
    } else {
      hash.add_vector(bodies_.turns.world_from_body[i].coeffs());
      hash.add_vector(bodies_.turns.spin_in_body[i]);
    }
  }
  for (const ContactList<D>* list : {&between_, &with_walls_}) {
    for (int c = 0; c < list->count(); ++c) {
      if (!list->is_touching[c]) continue;
      if constexpr (D == 2) {
        hash.add(list->spring[c]);
      } else {
        hash.add_vector(list->spring[c]);
      }
    }
  }
  return hash.value;
}

template <int D>
std::string Engine<D>::describe_overlap() const {
  const OverlapTrouble& worst = overlap_trouble_;
  return "body " + std::to_string(worst.first) + " overlaps " +
         (worst.with_wall ? "wall " : "body ") + std::to_string(worst.second) + " by " +
         number(1e3 * worst.overlap) + " mm at " + number(time_) + " s, more than " +
         number(options_.largest_overlap) + " of a radius";
}

template class Engine<2>;
template class Engine<3>;

}  // namespace graintruth::sim
