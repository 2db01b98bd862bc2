// Definitions of Engine, for the two files that compile it: planar_engine.cpp, spatial_engine.cpp.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "sim/engine/engine.h"

namespace graintruth::sim {
namespace engine_detail {

// Part of the skin that may be used up before the bodies' true displacements are looked at again.
constexpr double kSkinInUse = 0.7;

// The skin follows the motion, so that it lasts for about this many steps: a search costs a few
// steps, while a wide skin costs candidates in every step. Limits in smallest radii.
constexpr std::int64_t kStepsPerSkin = 60;
constexpr double kFirstSkin = 0.05, kSmallestSkin = 0.002, kLargestSkin = 0.3;

// Normal force of the springs alone, N, and the energy in them, J.
template <int D>
double elastic_force_of(const BatchView<D>& view, int k) {
  if (view.list.remembers()) return view.batch.remembered[k].elastic_force;
  return elastic_force(view.law, view.batch.stiffness.at(k), view.batch.overlap.at(k));
}
template <int D>
double elastic_energy_of(const BatchView<D>& view, int k) {
  if (view.law.normal_spring == NormalSpring::incremental) {
    const PairMaterial& pair = view.pairs[view.batch.pair[k]];
    return energy_of_force(elastic_force_of(view, k),
                           stiffness_factor_of(pair, view.batch.reduced_radius.at(k)));
  }
  return elastic_energy(view.law, view.batch.stiffness.at(k), view.batch.overlap.at(k));
}

// Books the work of dashpots and of tangential forces and rolling moments, J, and looks for the
// largest forces where there are `peaks`.
struct StepWatch {
  static constexpr bool commits = true;
  double time_step = 0.0;
  double time = 0.0;
  ContactPeaks* peaks = nullptr;
  double damping_loss = 0.0;
  double tangential_work = 0.0;
  template <int D>
  void operator()(const BatchView<D>& view) {
    tally(view);
    if (peaks != nullptr) look_for_peaks(view);
  }
  template <int D>
  void look_for_peaks(const BatchView<D>& view) {
    for (int k = 0; k < view.batch.count; ++k) {
      const int first = view.batch.first_body[k], second = view.batch.second_body[k];
      const double force = view.batch.normal_force.at(k);
      double& of_first = peaks->of_body[first];
      double& of_second = view.with_walls ? peaks->of_wall[second] : peaks->of_body[second];
      of_first = std::max(of_first, force);
      of_second = std::max(of_second, force);
      if (force <= peaks->normal_force) continue;
      peaks->normal_force = force;
      peaks->time = time;
      peaks->first = first;
      peaks->second = second;
      peaks->with_wall = view.with_walls;
    }
  }
  template <int D>
  void tally(const BatchView<D>& view) {
    const ContactBatch<D>& batch = view.batch;
    for (int k = 0; k < batch.count; ++k) {
      const double elastic = elastic_force_of(view, k);
      damping_loss += (elastic - batch.normal_force.at(k)) * batch.normal_speed.at(k) * time_step;
      tangential_work -=
          product_of(batch.tangential_force.at(k), speed_along(batch, k)) * time_step;
      if (!view.law.has_rolling_friction) continue;
      const RollingResistance<D>& rolling = batch.remembered[k].rolling;
      tangential_work -= product_of(rolling.moment, rolling.speed) * time_step;
    }
  }
  template <int D>
  static typename Motion<D>::Tangent speed_along(const ContactBatch<D>& batch, int k);
};

// The speed of the batch lacks what the spring has yet to slow down; no spring slows what slides.
template <int D>
typename Motion<D>::Tangent StepWatch::speed_along(const ContactBatch<D>& batch, int k) {
  if (batch.slides.at(k) == 0.0) return batch.tangential_speed.at(k);
  const auto normal = batch.normal.at(k), moving = predicted_motion(batch, k, batch.lever.at(k));
  return tangential_part(moving, normal, dot(moving, normal));
}

struct SpringEnergy {
  static constexpr bool commits = false;
  double normal = 0.0;
  double tangential = 0.0;  // and of rolling
  template <int D>
  void operator()(const BatchView<D>& view) {
    const ContactBatch<D>& batch = view.batch;
    for (int k = 0; k < batch.count; ++k) {
      normal += elastic_energy_of(view, k);
      const double stiffness =
          tangential_stiffness_of(view.law, view.pairs[batch.pair[k]], batch.stiffness.at(k));
      tangential += 0.5 * stiffness * product_of(batch.spring.at(k), batch.spring.at(k));
      if (!view.law.has_rolling_friction) continue;
      const auto rolled = batch.remembered[k].memory.rolled;
      tangential += 0.5 * batch.remembered[k].rolling.stiffness * product_of(rolled, rolled);
    }
  }
};

template <int D>
struct ContactRecorder {
  static constexpr bool commits = false;
  const Bodies<D>& bodies;
  std::vector<ContactReport> reports;
  void operator()(const BatchView<D>& view) {
    for (int k = 0; k < view.batch.count; ++k) reports.push_back(report_of(view, k));
  }
  ContactReport report_of(const BatchView<D>& view, int k) const {
    const ContactBatch<D>& batch = view.batch;
    const int candidate = batch.candidate[k];
    ContactReport report;
    report.first = batch.first_body[k];
    report.second = batch.second_body[k];
    report.with_wall = view.with_walls;
    report.first_sphere = view.list.first_sphere[candidate] - bodies.first_sphere[report.first];
    if (!view.with_walls) {
      report.second_sphere = view.list.second[candidate] - bodies.first_sphere[report.second];
    }
    const auto normal = batch.normal.at(k);
    report.overlap = batch.overlap.at(k);
    report.normal = to_space(to_eigen(normal));
    const auto point = batch.first.position.at(k) + lever_of(batch, k);
    report.point = to_space(to_eigen(point), bodies.layer);
    report.normal_force = batch.normal_force.at(k);
    report.tangential_force = to_space(to_eigen(as_vector(batch.tangential_force.at(k), normal)));
    report.slides = batch.slides.at(k) != 0.0;
    return report;
  }
};

// FNV-1a over the bits of doubles.
struct Hash {
  std::uint64_t value = 14695981039346656037ull;
  void add(double number) {
    std::uint64_t bits = std::bit_cast<std::uint64_t>(number);
    for (int i = 0; i < 8; ++i, bits >>= 8) value = (value ^ (bits & 0xff)) * 1099511628211ull;
  }
  void add(PlanarVector v) {
    add(v.x);
    add(v.z);
  }
  void add(SpatialVector v) {
    add(v.x);
    add(v.y);
    add(v.z);
  }
};

// The numbers of a snapshot in their order (see Snapshot): the same walk writes and reads them.
struct NumberWriter {
  std::vector<double>& numbers;
  void operator()(double value) { numbers.push_back(value); }
};
struct NumberReader {
  const double* next;
  void operator()(double& value) { value = *next++; }
};
template <class Pass>
void pass(PlanarVector& v, Pass& one) {
  one(v.x);
  one(v.z);
}
template <class Pass>
void pass(SpatialVector& v, Pass& one) {
  one(v.x);
  one(v.y);
  one(v.z);
}
template <class Pass>
void pass(double& v, Pass& one) {
  one(v);
}
template <class Column, class Pass>
void pass_row(Column& column, int i, Pass& one) {
  auto value = column.at(i);
  pass(value, one);
  column.set(i, value);
}

template <int D, class Pass>
void pass_body(Bodies<D>& bodies, int i, Pass& one) {
  BodyMotion<D>& motion = bodies.motion[i];
  pass(motion.position, one);
  pass(motion.velocity, one);
  pass(motion.velocity_now, one);
  pass(motion.spin, one);
  pass(motion.spin_now, one);
  pass(bodies.acceleration(i), one);
  pass(bodies.angular_acceleration(i), one);
  if constexpr (D == 2) {
    one(bodies.turns.angle[i]);
    pass_row(bodies.turns.direction, i, one);
  } else {
    one(bodies.turns.world_from_body.w[i]);
    one(bodies.turns.world_from_body.x[i]);
    one(bodies.turns.world_from_body.y[i]);
    one(bodies.turns.world_from_body.z[i]);
    pass_row(bodies.turns.spin_in_body, i, one);
    auto& last = bodies.turns.last_angular_acceleration;
    if (!last.x.empty()) last.set(i, bodies.angular_acceleration(i));
  }
}

template <int D, class Pass>
void pass_surface(WallSurfaces<D>& surfaces, std::size_t wall, Pass& one) {
  BodyMotion<D>& motion = surfaces.motion[wall];
  const auto pass_eigen = [&one](auto& number) {
    auto value = plain(number);
    pass(value, one);
    number = to_eigen(value);
  };
  pass(motion.velocity, one);
  pass(motion.velocity_now, one);
  pass_eigen(surfaces.load[wall].force);
  pass(motion.spin, one);
  pass(motion.spin_now, one);
  pass_eigen(surfaces.load[wall].torque);
  double turns = surfaces.turns[wall] != 0 ? 1.0 : 0.0;
  one(turns);
  surfaces.turns[wall] = turns != 0.0;
}

inline void tangent_to(double tangent, double (&numbers)[3]) { numbers[0] = tangent; }
inline void tangent_to(SpatialVector tangent, double (&numbers)[3]) {
  numbers[0] = tangent.x;
  numbers[1] = tangent.y;
  numbers[2] = tangent.z;
}
inline void tangent_from(const double (&numbers)[3], double& tangent) { tangent = numbers[0]; }
inline void tangent_from(const double (&numbers)[3], SpatialVector& tangent) {
  tangent = {numbers[0], numbers[1], numbers[2]};
}

template <int D>
void keep_touching(const ContactList<D>& list, std::vector<KeptContact>& kept) {
  for (int c = 0; c < list.count(); ++c) {
    if (!list.is_touching[c]) continue;
    KeptContact contact{.first_sphere = list.first_sphere[c],
                        .second = list.second[c],
                        .state = list.is_touching[c]};
    tangent_to(list.spring[c], contact.spring);
    if (list.remembers()) {
      contact.elastic_force = list.memory[c].elastic_force;
      contact.stiffness = list.memory[c].stiffness;
      tangent_to(list.memory[c].rolled, contact.rolled);
    }
    kept.push_back(contact);
  }
}

// Both are in the order of the candidates. `next` is the first that is not put back yet.
template <int D>
void put_back(const std::vector<KeptContact>& kept, std::size_t& next, ContactList<D>& list) {
  for (int c = 0; c < list.count(); ++c) {
    list.is_touching[c] = 0;
    if (next == kept.size() || kept[next].first_sphere != list.first_sphere[c] ||
        kept[next].second != list.second[c]) {
      continue;
    }
    list.is_touching[c] = static_cast<short>(kept[next].state);
    tangent_from(kept[next].spring, list.spring[c]);
    if (list.remembers()) {
      list.memory[c].elastic_force = kept[next].elastic_force;
      list.memory[c].stiffness = kept[next].stiffness;
      tangent_from(kept[next].rolled, list.memory[c].rolled);
    }
    ++next;
  }
}
template <int D>
void put_back(const std::vector<KeptContact>& kept, std::vector<ContactList<D>>& lists) {
  std::size_t next = 0;
  for (ContactList<D>& list : lists) put_back(kept, next, list);
  if (next != kept.size()) {
    throw std::invalid_argument("snapshot: has a contact between spheres that are not near");
  }
}

inline void require_same(std::int64_t of_snapshot, std::int64_t here, const std::string& what) {
  if (of_snapshot == here) return;
  throw std::invalid_argument("snapshot: has " + std::to_string(of_snapshot) + " " + what +
                              ", this scene has " + std::to_string(here));
}

inline std::string number(double value) { return std::to_string(value); }

}  // namespace engine_detail

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
  }
  smallest_radius_ = smallest_radius;
  skin_ = options.skin > 0.0 ? options.skin : engine_detail::kFirstSkin * smallest_radius;
  limit_.move = options.largest_move * smallest_radius;
  wall_surfaces_.resize(scene.walls.size());
  wall_surfaces_.bodies = bodies_of_walls(scene.walls);
  for (std::size_t w = 0; w < scene.walls.size(); ++w) {
    wall_surfaces_.material[w] = scene.walls[w].material;
  }
  team_ = std::make_unique<Team>(options.threads);
  for (int worker = 0; worker < options.threads; ++worker) {
    batches_.push_back(std::make_unique<ContactBatch<D>>());
  }
  slabs_.resize(slab_count_of(bodies_.count()));
  for (int slab = 0; slab < slab_count(); ++slab) {
    slabs_[slab].end = slab_range(slab, bodies_.count()).end;
    slabs_[slab].part_shift = part_shift_of(bodies_.count());
    slabs_[slab].walls.resize(scene.walls.size());
  }
  if (slab_count() > 1) bodies_.load_from_before.resize(bodies_.count());
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
    crossing_work_ = earlier->crossing_work_;
  }
  between_.resize(slab_count());
  with_walls_.resize(slab_count());
  use_pairs(scene, options);
  clear_peaks();
  list_moving_walls();
  move_walls_to(time_);
  factors_ = step_factors(choose_time_step(scene, options.time_step), global_damping_);
}

template <int D>
void Engine<D>::begin() {
  find_contacts();
  start();
}

template <int D>
void Engine<D>::refuse_overlap() const {
  if (!overlap_trouble_.found) return;
  throw std::invalid_argument("Scene: " + describe_overlap() +
                              "; bodies must start apart, such a contact would throw them off");
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
                                            options.tangential_damping,
                                            options.normal_spring,
                                            options.damping_form);
      pairs_[j * material_count_ + i] = pairs_[i * material_count_ + j];
    }
  }
  choose_law();
}

template <int D>
void Engine<D>::choose_law() {
  law_ = {.normal_spring = options_.normal_spring,
          .tangential_spring = options_.tangential_spring,
          .coulomb_limit = options_.coulomb_limit,
          .tension = options_.tension,
          .sharing = options_.damping_sharing,
          .linear_stiffness = options_.linear_stiffness,
          .tangential_stiffness = options_.tangential_stiffness};
  for (const PairMaterial& pair : pairs_) {
    if (pair.static_friction > pair.friction) law_.has_static_friction = true;
    if (pair.rolling_friction > 0.0) law_.has_rolling_friction = true;
  }
  for (auto* lists : {&between_, &with_walls_}) {
    for (ContactList<D>& list : *lists) list.remember(law_.needs_memory());
  }
}

// Accelerations at the start, so that the first half-step velocities are v(-1/2) = v0 - a0 dt/2
// (thesis 2.16).
template <int D>
void Engine<D>::start() {
  StepOnly observe;
  add_forces(observe);
  find_accelerations(gravity_, factors_, limit_, bodies_);
  shift_half_step(-factors_.half, global_damping_, bodies_);
}

template <int D>
template <class Law, class Observer>
void Engine<D>::add_forces_of_slab(const Law& law, int slab, int worker, Observer& observe) {
  const ForceSetting setting{&pairs_, material_count_, slip_time_, options_.largest_overlap};
  ContactBatch<D>& batch = *batches_[worker];
  SlabLoads<D>& loads = slabs_[slab];
  if constexpr (Observer::commits) {
    const auto [begin, end] = slab_range(slab, bodies_.count());
    std::fill(bodies_.load.begin() + begin, bodies_.load.begin() + end, Load<D>{});
  }
  add_pair_forces<D>(law, setting, between_[slab], bodies_, batch, loads, observe);
  add_wall_forces<D>(
      law, setting, walls_, wall_surfaces_, with_walls_[slab], bodies_, batch, loads, observe);
}

// Observers look at one batch after the other.
template <int D>
template <class Law, class Observer>
void Engine<D>::add_forces_of_law(const Law& law, Observer& observe) {
  Team* team = std::is_same_v<Observer, StepOnly> ? team_.get() : nullptr;
  for_each_shared(slab_count(), team, [&](int worker, int slab) {
    add_forces_of_slab(law, slab, worker, observe);
  });
}

template <int D>
template <class Observer>
void Engine<D>::begin_slabs() {
  if constexpr (Observer::commits) {
    clear_wall_forces();
  }
  for (SlabLoads<D>& slab : slabs_) {
    slab.contact_count = 0;
    slab.puts_off = std::is_same_v<Observer, StepOnly> && shares_slabs();
    if constexpr (Observer::commits) {
      for (const int w : loaded_walls_) slab.walls[w] = {};
    }
  }
}

// What slabs do to each other's bodies and to the walls, in their order.
template <int D>
template <class Observer>
void Engine<D>::sum_slabs() {
  for (const SlabLoads<D>& slab : slabs_) {
    const OverlapTrouble& trouble = slab.trouble;
    const bool is_worse = !overlap_trouble_.found || trouble.overlap > overlap_trouble_.overlap;
    if (trouble.found && is_worse) overlap_trouble_ = trouble;
    if constexpr (!Observer::commits) continue;
    contact_steps_ += slab.contact_count;
    for (const int w : loaded_walls_) {
      wall_surfaces_.load[w].force += slab.walls[w].force;
      wall_surfaces_.load[w].torque += slab.walls[w].torque;
    }
  }
  if (!Observer::commits || slab_count() == 1) return;
  const int parts = part_of(bodies_.count() - 1, slabs_[0].part_shift) + 1;
  for_each_shared(parts, team_.get(), [this](int, int part) { sum_part(part); });
}

template <int D>
void Engine<D>::sum_part(int part) {
  for (SlabLoads<D>& slab : slabs_) {
    for (const DeferredLoad<D>& deferred : slab.deferred[part]) {
      add(deferred.load, bodies_.load_from_before[deferred.body]);
    }
    slab.deferred[part].clear();
  }
  const int shift = slabs_[0].part_shift;
  const int end = std::min((part + 1) << shift, bodies_.count());
  for (int i = part << shift; i < end; ++i) {
    add(bodies_.load_from_before[i], bodies_.load[i]);
    bodies_.load_from_before[i] = {};
  }
}

template <int D>
template <class Observer>
void Engine<D>::add_forces(Observer& observe) {
  begin_slabs<Observer>();
  if (law_ == ChosenLaw{}) {
    add_forces_of_law(DefaultLaw{}, observe);
  } else {
    add_forces_of_law(law_, observe);
  }
  sum_slabs<Observer>();
}

template <int D>
bool Engine<D>::step(double time) {
  // 1. Forces where the bodies are now
  if (options_.tally_work || options_.keep_peaks) {
    add_watched_forces();
  } else {
    StepOnly observe;
    add_forces(observe);
  }
  if (overlap_trouble_.found) {
    trouble_ = describe_overlap();
    return false;
  }
  // 2. Leapfrog
  if (!integrate()) return false;
  slip_time_ = factors_.time_step;
  ++steps_;
  // 3. Walls, and new candidates when something may have come near
  move_walls_to(time);
  if (2.0 * travel_ + wall_travel_ > skin_) {
    find_contacts_if_moved();
  } else if (steps_ == searched_at_step_ + engine_detail::kStepsPerSkin) {
    narrow_skin();
  }
  return true;
}

template <int D>
void Engine<D>::add_watched_forces() {
  engine_detail::StepWatch watch{
      factors_.time_step, time_, options_.keep_peaks ? &peaks_ : nullptr};
  add_forces(watch);
  if (!options_.tally_work) return;
  damping_loss_ += watch.damping_loss;
  tangential_work_ += watch.tangential_work;
  for (const int w : moving_walls_) {
    const WallLoad<D>& load = wall_surfaces_.load[w];
    const BodyMotion<D>& motion = wall_surfaces_.motion[w];
    const double power = dot(plain(load.force), motion.velocity_now) +
                         product_of(plain(load.torque), motion.spin_now);
    wall_work_ -= power * factors_.time_step;
  }
}

template <int D>
void Engine<D>::clear_peaks() {
  peaks_ = {};
  if (!options_.keep_peaks) return;
  peaks_.of_body.assign(bodies_.count(), 0.0);
  peaks_.of_wall.assign(walls_at_rest_.size(), 0.0);
}

template <int D>
ContactPeaks Engine<D>::take_peaks() {
  ContactPeaks taken = std::move(peaks_);
  clear_peaks();
  return taken;
}

template <int D>
bool Engine<D>::integrate() {
  const StepBound bound = find_accelerations(gravity_, factors_, limit_, bodies_, team_.get());
  if (bound.suspects > 0) {
    trouble_ = describe_move();
    if (!trouble_.empty()) return false;
  }
  advance(factors_, bodies_, team_.get());
  bring_into_cell();
  travel_ += bound.largest_move;
  return true;
}

// At every step, so that it does not depend on when contacts are searched. What a body's weight
// would do on the way back is no work.
template <int D>
void Engine<D>::bring_into_cell() {
  if (!bodies_.cell.is_periodic) return;
  for (int i = 0; i < bodies_.count(); ++i) {
    const auto shift = sim::bring_into_cell(bodies_, i);
    crossing_work_ += bodies_.kind_of(i).mass * dot(plain(gravity_), shift);
  }
}

// The first body whose next step is too long; empty when the bound was only too careful.
template <int D>
std::string Engine<D>::describe_move() const {
  using engine_detail::number;
  for (int i = 0; i < bodies_.count(); ++i) {
    const Speeds speeds = next_speeds(factors_, bodies_, i);
    const double turn = speeds.angular * factors_.time_step;
    const double move =
        speeds.linear * factors_.time_step + turn * bodies_.kind_of(i).bounding_radius;
    const std::string body = "body " + std::to_string(i);
    const std::string at = ", at " + number(time_) + " s";
    if (!(move <= limit_.move)) {
      return body + " would move " + number(1e3 * move) + " mm in one step, limit " +
             number(1e3 * limit_.move) + " mm" + at;
    }
    if (!(turn <= limit_.turn)) {
      return body + " would turn " + number(turn) + " rad in one step, limit " +
             number(limit_.turn) + " rad" + at;
    }
  }
  return {};
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
    wall_surfaces_.load[w] = {};
  }
  if (!loaded_walls_are_old_) return;
  loaded_walls_.clear();
  for (const ContactList<D>& list : with_walls_) {
    loaded_walls_.insert(loaded_walls_.end(), list.second.begin(), list.second.end());
  }
  std::sort(loaded_walls_.begin(), loaded_walls_.end());
  loaded_walls_.erase(std::unique(loaded_walls_.begin(), loaded_walls_.end()), loaded_walls_.end());
  loaded_walls_are_old_ = false;
}

template <int D>
void Engine<D>::set_surface(int wall, double middle, double time) {
  const Twist before = surface_twist(walls_at_rest_[wall], middle);
  const Twist now = surface_twist(walls_at_rest_[wall], time);
  BodyMotion<D>& motion = wall_surfaces_.motion[wall];
  motion.velocity = plain(to_motion<D>(before.velocity));
  motion.velocity_now = plain(to_motion<D>(now.velocity));
  motion.spin = plain(to_spin<D>(before.spin));
  motion.spin_now = plain(to_spin<D>(now.spin));
  wall_surfaces_.turns[wall] = !before.spin.isZero(0.0) || !now.spin.isZero(0.0);
}

template <int D>
double Engine<D>::largest_displacement() const {
  double largest = 0.0;
  for (int i = 0; i < bodies_.count(); ++i) {
    // The chord of a turn by phi at distance r is 2 r sin(phi/2); a ball does not change by turning
    double chord = 0.0;
    if (bodies_.are_balls) {
      chord = 0.0;
    } else if constexpr (D == 2) {
      chord = length_of_vector(bodies_.turns.direction.at(i) - searched_turns_.at(i));
    } else {
      const double cosine = product_of(bodies_.turns.world_from_body.at(i), searched_turns_.at(i));
      chord = 2.0 * std::sqrt(std::max(1.0 - cosine * cosine, 0.0));
    }
    auto moved = bodies_.motion[i].position - searched_position_[i];
    if (bodies_.cell.is_periodic) moved = moved + shift_to_nearest(bodies_.cell, moved);
    const double path = length_of_vector(moved);
    largest = std::max(largest, path + chord * bodies_.kind_of(i).bounding_radius);
  }
  return largest;
}

template <int D>
void Engine<D>::find_contacts_if_moved() {
  travel_ = largest_displacement();
  if (2.0 * travel_ + wall_travel_ <= engine_detail::kSkinInUse * skin_) return;
  if (options_.skin == 0.0) skin_ = fitting_skin();
  find_contacts();
}

// Results do not depend on the skin: it decides only how many candidates are looked at.
template <int D>
double Engine<D>::fitting_skin() const {
  using namespace engine_detail;
  const double path_per_step =
      (2.0 * travel_ + wall_travel_) / static_cast<double>(steps_ - searched_at_step_);
  return std::clamp(static_cast<double>(kStepsPerSkin) * path_per_step / kSkinInUse,
                    kSmallestSkin * smallest_radius_,
                    kLargestSkin * smallest_radius_);
}

// A skin that lasts much longer than planned holds candidates that nobody needs.
template <int D>
void Engine<D>::narrow_skin() {
  if (options_.skin > 0.0) return;
  travel_ = largest_displacement();
  const double skin = fitting_skin();
  if (skin > 0.5 * skin_) return;
  skin_ = skin;
  find_contacts();
}

template <int D>
void Engine<D>::find_contacts() {
  search_.find(bodies_, walls_, wall_surfaces_.bodies, skin_, *team_, between_, with_walls_);
  searched_position_.resize(bodies_.count());
  for (int i = 0; i < bodies_.count(); ++i) searched_position_[i] = bodies_.motion[i].position;
  if (!bodies_.are_balls) searched_turns_ = orientations_of(bodies_.turns);
  loaded_walls_are_old_ = true;
  travel_ = 0.0;
  wall_travel_ = 0.0;
  searched_at_step_ = steps_;
  ++searches_;
}

template <int D>
void Engine<D>::use_time_step(double time_step) {
  if (time_step == factors_.time_step) return;
  const StepFactors changed = step_factors(time_step, global_damping_);
  shift_half_step(factors_.half - changed.half, global_damping_, bodies_);
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
    BodyMotion<D>& motion = bodies_.motion[i];
    motion.velocity_now = Motion<D>::no_vector();
    motion.velocity = Motion<D>::no_vector();
    motion.spin_now = Motion<D>::no_tangent();
    motion.spin = Motion<D>::no_tangent();
    if constexpr (D == 3) bodies_.turns.spin_in_body.set(i, Motion<D>::no_tangent());
  }
  shift_half_step(-factors_.half, global_damping_, bodies_);
}

template <int D>
Energy Engine<D>::energy() {
  engine_detail::SpringEnergy springs;
  add_forces(springs);
  Energy energy;
  energy.elastic = springs.normal + springs.tangential;
  for (int i = 0; i < bodies_.count(); ++i) {
    const double mass = bodies_.kind_of(i).mass;
    const BodyMotion<D>& motion = bodies_.motion[i];
    energy.kinetic += 0.5 * mass * dot(motion.velocity_now, motion.velocity_now);
    const auto inertia = bodies_.kind_of(i).inertia;
    if constexpr (D == 2) {
      energy.kinetic += 0.5 * inertia * motion.spin_now * motion.spin_now;
    } else {
      const SpatialVector spin = turned_back(bodies_.turns.world_from_body.at(i), motion.spin_now);
      energy.kinetic += 0.5 * (inertia.x * spin.x * spin.x + inertia.y * spin.y * spin.y +
                               inertia.z * spin.z * spin.z);
    }
    energy.gravity -= mass * dot(plain(gravity_), motion.position);
  }
  energy.gravity += crossing_work_;
  energy.damping_loss = damping_loss_;
  energy.friction_loss = options_.tally_work ? tangential_work_ - springs.tangential : 0.0;
  energy.wall_work = wall_work_;
  return energy;
}

template <int D>
std::vector<ContactReport> Engine<D>::contacts() {
  engine_detail::ContactRecorder<D> recorder{bodies_, {}};
  add_forces(recorder);
  return recorder.reports;
}

template <int D>
std::uint64_t Engine<D>::state_hash() const {
  engine_detail::Hash hash;
  hash.add(time_);
  for (int i = 0; i < bodies_.count(); ++i) {
    hash.add(bodies_.motion[i].position);
    hash.add(bodies_.motion[i].velocity);
    if constexpr (D == 2) {
      hash.add(bodies_.turns.angle[i]);
      hash.add(bodies_.motion[i].spin);
    } else {
      const Rotation world_from_body = bodies_.turns.world_from_body.at(i);
      hash.add(world_from_body.w);
      hash.add(SpatialVector{world_from_body.x, world_from_body.y, world_from_body.z});
      hash.add(bodies_.turns.spin_in_body.at(i));
    }
  }
  for (const auto* lists : {&between_, &with_walls_}) {
    for (const ContactList<D>& list : *lists) {
      for (int c = 0; c < list.count(); ++c) {
        if (!list.is_touching[c]) continue;
        hash.add(list.spring[c]);
        if (!list.remembers()) continue;
        hash.add(list.memory[c].elastic_force);
        hash.add(list.memory[c].stiffness);
        hash.add(list.memory[c].rolled);
      }
    }
  }
  return hash.value;
}

template <int D>
void Engine<D>::save(Snapshot& snapshot) const {
  using namespace engine_detail;
  snapshot.dimensions = D;
  snapshot.body_count = bodies_.count();
  snapshot.sphere_count = bodies_.sphere_count();
  snapshot.time = time_;
  snapshot.time_step = factors_.time_step;
  snapshot.slip_time = slip_time_;
  snapshot.global_damping = global_damping_;
  snapshot.damping_loss = damping_loss_;
  snapshot.tangential_work = tangential_work_;
  snapshot.wall_work = wall_work_;
  snapshot.crossing_work = crossing_work_;
  snapshot.pairs = pairs_;
  snapshot.walls = walls_at_rest_;
  // Of copies, because the same walk puts the numbers back
  NumberWriter body_numbers{snapshot.bodies};
  Bodies<D> bodies = bodies_;
  for (int i = 0; i < bodies.count(); ++i) pass_body(bodies, i, body_numbers);
  NumberWriter surface_numbers{snapshot.wall_surfaces};
  WallSurfaces<D> surfaces = wall_surfaces_;
  for (std::size_t w = 0; w < walls_at_rest_.size(); ++w)
    pass_surface(surfaces, w, surface_numbers);
  for (const ContactList<D>& list : between_) keep_touching(list, snapshot.between_bodies);
  for (const ContactList<D>& list : with_walls_) keep_touching(list, snapshot.with_walls);
}

template <int D>
void Engine<D>::restore(const Snapshot& snapshot) {
  using namespace engine_detail;
  const auto size = [](const auto& vector) { return static_cast<std::int64_t>(vector.size()); };
  const std::int64_t walls = size(walls_at_rest_);
  require_same(snapshot.dimensions, D, "dimensions");
  require_same(snapshot.body_count, bodies_.count(), "bodies");
  require_same(snapshot.sphere_count, bodies_.sphere_count(), "spheres");
  require_same(size(snapshot.walls), walls, "walls");
  require_same(size(snapshot.pairs), size(pairs_), "pairs of materials");
  require_same(size(snapshot.bodies), bodies_.count() * numbers_per_body(D), "numbers of bodies");
  require_same(size(snapshot.wall_surfaces),
               walls * numbers_per_wall_surface(D),
               "numbers of wall surfaces");

  time_ = snapshot.time;
  slip_time_ = snapshot.slip_time;
  global_damping_ = snapshot.global_damping;
  factors_ = step_factors(snapshot.time_step, global_damping_);
  damping_loss_ = snapshot.damping_loss;
  tangential_work_ = snapshot.tangential_work;
  wall_work_ = snapshot.wall_work;
  crossing_work_ = snapshot.crossing_work;
  pairs_ = snapshot.pairs;
  choose_law();
  walls_at_rest_ = snapshot.walls;
  walls_ = walls_at_rest_;
  list_moving_walls();
  for (const int w : moving_walls_) place_wall(walls_at_rest_[w], time_, walls_[w]);
  NumberReader body_numbers{snapshot.bodies.data()};
  for (int i = 0; i < bodies_.count(); ++i) {
    pass_body(bodies_, i, body_numbers);
    place_spheres(bodies_, i);
  }
  NumberReader surface_numbers{snapshot.wall_surfaces.data()};
  for (std::size_t w = 0; w < walls_at_rest_.size(); ++w) {
    pass_surface(wall_surfaces_, w, surface_numbers);
  }
  overlap_trouble_ = {};
  for (SlabLoads<D>& slab : slabs_) slab.trouble = {};
  trouble_.clear();
  find_contacts();
  put_back(snapshot.between_bodies, between_);
  put_back(snapshot.with_walls, with_walls_);
}

template <int D>
std::string Engine<D>::describe_overlap() const {
  const OverlapTrouble& worst = overlap_trouble_;
  return "body " + std::to_string(worst.first) + " overlaps " +
         (worst.with_wall ? "wall " : "body ") + std::to_string(worst.second) + " by " +
         engine_detail::number(1e3 * worst.overlap) + " mm at " + engine_detail::number(time_) +
         " s, more than " + engine_detail::number(options_.largest_overlap) + " of a radius";
}

}  // namespace graintruth::sim
