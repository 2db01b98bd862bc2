// Engine: the order of one step, for planar or spatial motion. Simulation chooses which at run
// time.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sim/engine/bodies.h"
#include "sim/engine/contacts.h"
#include "sim/engine/forces.h"
#include "sim/engine/integrate.h"
#include "sim/engine/snapshot.h"
#include "sim/engine/team.h"
#include "sim/simulation.h"

namespace graintruth::sim {

template <int D>
class Engine {
 public:
  // With `earlier`, an engine of the same scene with fewer bodies, it goes on from there: at its
  // time, with its walls, contacts and tallies. Before the first step it must begin; the scene is
  // no longer needed then.
  Engine(const Scene& scene, const SimulationOptions& options, const Engine* earlier = nullptr);
  void begin();
  // Throws std::invalid_argument when bodies are too deep in each other or in a wall.
  void refuse_overlap() const;

  // One step of the current time step to `time` (s). False when it cannot be trusted; `trouble()`
  // says why.
  bool step(double time);
  const std::string& trouble() const { return trouble_; }

  void use_time_step(double time_step);
  void use_global_damping(double per_second);
  void use_pairs(const Scene& scene, const SimulationOptions& options);
  void use_wall_motion(int wall, const WallMotion& motion);
  void use_wall_drag(int wall, const WallMotion& drag);
  void open_wall(int wall, double time);
  void clear_velocities();

  // Everything that decides how this engine goes on. Putting it back needs an engine of the same
  // bodies and walls; throws std::invalid_argument when they are others.
  void save(Snapshot& snapshot) const;
  void restore(const Snapshot& snapshot);

  double time() const { return time_; }
  double time_step() const { return factors_.time_step; }
  std::int64_t contact_steps() const { return contact_steps_; }
  std::int64_t searches() const { return searches_; }
  const Bodies<D>& bodies() const { return bodies_; }
  const std::vector<Wall>& walls_now() const { return walls_; }
  Vec3 wall_force(int wall) const { return to_space(wall_surfaces_.load[wall].force); }

  // Look at the contacts as the next step will see them; nothing is changed.
  Energy energy();
  std::vector<ContactReport> contacts();
  ContactPeaks take_peaks();
  std::uint64_t state_hash() const;

 private:
  template <class Observer>
  void add_forces(Observer& observe);
  template <class Law, class Observer>
  void add_forces_of_law(const Law& law, Observer& observe);
  template <class Law, class Observer>
  void add_forces_of_slab(const Law& law, int slab, int worker, Observer& observe);
  template <class Observer>
  void begin_slabs();
  template <class Observer>
  void sum_slabs();
  void sum_part(int part);
  bool shares_slabs() const { return slab_count() > 1 && team_->workers() > 1; }
  int slab_count() const { return static_cast<int>(slabs_.size()); }
  void choose_law();
  void start();
  void clear_peaks();
  void add_watched_forces();
  void find_contacts();
  void find_contacts_if_moved();
  double fitting_skin() const;
  void narrow_skin();
  double largest_displacement() const;
  void move_walls_to(double time);
  void set_surface(int wall, double middle, double time);
  void list_moving_walls();
  void clear_wall_forces();
  bool integrate();
  void bring_into_cell();
  std::string describe_overlap() const;
  std::string describe_move() const;

  SimulationOptions options_;
  Vec<D> gravity_;
  PairTable pairs_;
  ChosenLaw law_;
  int material_count_ = 0;
  Bodies<D> bodies_;
  std::vector<Wall> walls_at_rest_, walls_;
  WallSurfaces<D> wall_surfaces_;
  std::vector<int> moving_walls_;     // that move, drag or open: of a mesh most do not
  std::vector<int> loaded_walls_;     // with candidates near them in the last step
  bool loaded_walls_are_old_ = true;  // the candidates have changed since
  ContactSearch<D> search_;
  std::vector<ContactList<D>> between_, with_walls_;  // of each slab
  std::unique_ptr<Team> team_;
  std::vector<std::unique_ptr<ContactBatch<D>>> batches_;  // one a worker
  std::vector<SlabLoads<D>> slabs_;

  double time_ = 0.0;
  StepFactors factors_;
  double global_damping_ = 0.0;
  double slip_time_ = 0.0;  // s; length of the step that brought the bodies here
  StepLimit limit_;
  double smallest_radius_ = 0.0;  // m
  double skin_ = 0.0;             // m
  double travel_ = 0.0;           // m; bound on the path of any surface point since the last search
  double wall_travel_ = 0.0;      // m; the same for walls
  std::vector<typename Motion<D>::Vector> searched_position_;
  typename TurnsOf<D>::Orientations searched_turns_;  // at the last search

  OverlapTrouble overlap_trouble_;
  std::string trouble_;
  std::int64_t contact_steps_ = 0;
  std::int64_t searches_ = 0;
  std::int64_t steps_ = 0;
  std::int64_t searched_at_step_ = 0;
  double damping_loss_ = 0.0;  // J
  double tangential_work_ =
      0.0;                  // J; taken out of the motion by tangential forces, stored part included
  double wall_work_ = 0.0;  // J
  double crossing_work_ = 0.0;  // J; of gravity, on the ways back into a periodic cell
  ContactPeaks peaks_;
};

}  // namespace graintruth::sim
