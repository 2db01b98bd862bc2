#include "sim/simulation.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <variant>

#include "sim/engine/engine.h"

namespace graintruth::sim {
namespace {

constexpr int kStepsBetweenQuestions = 256;

// A rest of a run shorter than this share of a step is rounding of the caller's times.
constexpr double kShareOfStep = 1e-6;

void require(bool fulfilled, const std::string& field, double value, const std::string& rule) {
  if (fulfilled) return;
  throw std::invalid_argument("SimulationOptions: " + field + " is " + std::to_string(value) +
                              ", " + rule);
}

}  // namespace

void check(const SimulationOptions& options) {
  require(options.tangential_damping >= 0.0,
          "tangential_damping",
          options.tangential_damping,
          "must not be below 0");
  require(options.global_damping >= 0.0,
          "global_damping",
          options.global_damping,
          "must not be below 0");
  const bool is_linear = options.normal_spring == NormalSpring::linear;
  require(is_linear == (options.linear_stiffness > 0.0),
          "linear_stiffness",
          options.linear_stiffness,
          "must be above 0 with a linear spring and 0 without one");
  const bool is_constant = options.tangential_spring == TangentialSpring::constant;
  require(is_constant == (options.tangential_stiffness > 0.0),
          "tangential_stiffness",
          options.tangential_stiffness,
          "must be above 0 with a constant tangential spring and 0 without one");
  require(options.skin >= 0.0, "skin", options.skin, "must not be below 0");
  require(options.largest_move > 0.0, "largest_move", options.largest_move, "must be above 0");
  require(options.threads >= 1, "threads", options.threads, "must be at least 1");
  require(
      options.largest_overlap > 0.0, "largest_overlap", options.largest_overlap, "must be above 0");
}

namespace {

// The step of the scene; with a linear spring also at most what that needs.
double longest_step_of(const Scene& scene, const SimulationOptions& options) {
  const double step = choose_time_step(scene, options.time_step);
  // 1.5 times as stiff as Hertz
  if (options.normal_spring == NormalSpring::secant) return std::sqrt(1.0 / 1.5) * step;
  if (options.normal_spring != NormalSpring::linear) return step;
  return std::min(step, linear_time_step(scene, options.linear_stiffness, options.time_step));
}

}  // namespace

struct Simulation::Engines {
  Scene scene;  // without its bodies, which the engine has
  SimulationOptions options;
  double longest_step;
  std::variant<Engine<2>, Engine<3>> engine;
  State state;

  Engines(Scene start, const SimulationOptions& chosen)
      : scene(std::move(start)),
        options(chosen),
        longest_step(longest_step_of(scene, chosen)),
        engine(scene.planar
                   ? std::variant<Engine<2>, Engine<3>>(std::in_place_index<0>, scene, chosen)
                   : std::variant<Engine<2>, Engine<3>>(std::in_place_index<1>, scene, chosen)) {
    scene.bodies = std::vector<Body>();
    const auto begin = [](auto& begun) {
      begun.begin();
      begun.refuse_overlap();
    };
    std::visit(begin, engine);
  }

  template <class Function>
  decltype(auto) visit(Function function) {
    return std::visit(function, engine);
  }
  // Indices into the types of the scene.
  const std::vector<int>& types_of_bodies() {
    return visit([](const auto& e) -> const std::vector<int>& { return e.bodies().kind; });
  }
  const State& refreshed_state() {
    visit([this](const auto& e) {
      write_state(e.bodies(), state);
      state.time = e.time();
    });
    return state;
  }
};

Simulation::Simulation(Scene scene, const SimulationOptions& options) {
  check(scene);
  check(options);
  engines_ = std::make_unique<Engines>(std::move(scene), options);
}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

namespace {

// Steps an engine through one stretch of time. False when the run must end; the summary then says
// why.
template <int D>
bool run_stretch(Engine<D>& engine,
                 double from,
                 double length,
                 std::int64_t step_count,
                 const SimulationOptions& options,
                 const Sampling& sampling,
                 RunSummary& summary) {
  const double time_step = length / static_cast<double>(step_count);
  engine.use_time_step(time_step);
  summary.time_step = time_step;
  for (std::int64_t i = 1; i <= step_count; ++i) {
    if (options.largest_step_count > 0 && summary.steps >= options.largest_step_count) {
      summary.status = RunStatus::timed_out;
      summary.message = "stopped after " + std::to_string(summary.steps) + " steps";
      return false;
    }
    if (sampling.should_stop && summary.steps % kStepsBetweenQuestions == 0 &&
        sampling.should_stop()) {
      summary.status = RunStatus::timed_out;
      summary.message = "stopped by the caller after " + std::to_string(summary.steps) + " steps";
      return false;
    }
    if (!engine.step(i == step_count ? from + length : from + static_cast<double>(i) * time_step)) {
      summary.status = RunStatus::unstable;
      summary.message = engine.trouble();
      return false;
    }
    ++summary.steps;
  }
  return true;
}

}  // namespace

RunSummary Simulation::run_until(double time, const Sampling& sampling) {
  Engines& all = *engines_;
  RunSummary summary;
  all.visit([&](auto& engine) {
    const double start = engine.time();
    const double whole = time - start;
    const std::int64_t contacts_before = engine.contact_steps();
    const std::int64_t searches_before = engine.searches();
    const double interval = sampling.interval > 0.0 ? sampling.interval : whole;
    const auto observe = [&] {
      if (sampling.observer) sampling.observer(all.refreshed_state());
    };
    if (sampling.interval > 0.0) observe();
    for (std::int64_t k = 0; whole > 0.0; ++k) {
      const double done = static_cast<double>(k) * interval;
      const double length = std::min(interval, whole - done);
      if (length <= kShareOfStep * all.longest_step) break;
      const auto count = static_cast<std::int64_t>(
          std::max(std::ceil(length / all.longest_step - kShareOfStep), 1.0));
      if (!run_stretch(engine, start + done, length, count, all.options, sampling, summary)) break;
      observe();
    }
    summary.time = engine.time();
    summary.searches = engine.searches() - searches_before;
    if (summary.steps > 0) {
      summary.mean_contacts = static_cast<double>(engine.contact_steps() - contacts_before) /
                              static_cast<double>(summary.steps);
    }
  });
  return summary;
}

const State& Simulation::state() const { return engines_->refreshed_state(); }

double Simulation::time() const {
  return engines_->visit([](const auto& engine) { return engine.time(); });
}

double Simulation::time_step() const { return engines_->longest_step; }

void Simulation::set_surfaces(int first_material, int second_material, const Surfaces& surfaces) {
  Engines& all = *engines_;
  all.scene.surfaces.set(first_material, second_material, surfaces);
  all.visit([&](auto& engine) { engine.use_pairs(all.scene, all.options); });
}

void Simulation::set_global_damping(double per_second) {
  engines_->options.global_damping = per_second;
  check(engines_->options);
  engines_->visit([&](auto& engine) { engine.use_global_damping(per_second); });
}

void Simulation::set_time_step(const TimeStepOptions& options) {
  SimulationOptions changed = engines_->options;
  changed.time_step = options;
  engines_->longest_step = longest_step_of(scene_now(), changed);
  engines_->options.time_step = options;
}

void Simulation::set_wall_motion(int wall, const WallMotion& motion) {
  engines_->visit([&](auto& engine) { engine.use_wall_motion(wall, motion); });
}

void Simulation::set_wall_drag(int wall, const WallMotion& drag) {
  engines_->visit([&](auto& engine) { engine.use_wall_drag(wall, drag); });
}

void Simulation::open_wall(int wall, double time) {
  engines_->visit([=](auto& engine) { engine.open_wall(wall, time); });
}

void Simulation::add_bodies(const std::vector<Body>& bodies) {
  Engines& all = *engines_;
  Scene next = all.scene;
  next.bodies = scene_now().bodies;
  next.bodies.insert(next.bodies.end(), bodies.begin(), bodies.end());
  check(next);
  all.longest_step = longest_step_of(next, all.options);
  all.visit([&](auto& engine) {
    std::decay_t<decltype(engine)> grown(next, all.options, &engine);
    grown.begin();
    engine = std::move(grown);
  });
}

void Simulation::remove_bodies(const std::vector<int>& indices) {
  Engines& all = *engines_;
  const auto count = static_cast<int>(all.types_of_bodies().size());
  std::vector<char> gone(all.types_of_bodies().size(), 0);
  for (const int i : indices) {
    if (i < 0 || i >= count) {
      throw std::invalid_argument("remove_bodies: there is no body " + std::to_string(i));
    }
    gone[static_cast<std::size_t>(i)] = 1;
  }
  if (std::count(gone.begin(), gone.end(), 0) == 0) {
    throw std::invalid_argument("remove_bodies: at least one body must stay");
  }
  std::vector<std::int64_t> first_sphere = {0};
  for (const int type : all.types_of_bodies()) {
    const std::size_t spheres = all.scene.types[static_cast<std::size_t>(type)].spheres.size();
    first_sphere.push_back(first_sphere.back() + static_cast<std::int64_t>(spheres));
  }
  const Snapshot left = without_bodies(save(), gone, first_sphere);
  // The new engine begins among walls that stand where they are now; the snapshot then gives it
  // their motion, and the state of every contact.
  Scene start = all.scene;
  const std::vector<Body> before = scene_now().bodies;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (gone[i] == 0) start.bodies.push_back(before[i]);
  }
  all.visit([&](auto& engine) {
    start.walls = engine.walls_now();
    std::decay_t<decltype(engine)> smaller(start, all.options);
    smaller.begin();
    smaller.refuse_overlap();
    smaller.restore(left);
    engine = std::move(smaller);
  });
}

void Simulation::clear_velocities() {
  engines_->visit([](auto& engine) { engine.clear_velocities(); });
}

Snapshot Simulation::save() const {
  Snapshot snapshot;
  engines_->visit([&](const auto& engine) { engine.save(snapshot); });
  snapshot.longest_time_step = engines_->longest_step;
  return snapshot;
}

void Simulation::restore(const Snapshot& snapshot) {
  engines_->visit([&](auto& engine) { engine.restore(snapshot); });
  engines_->longest_step = snapshot.longest_time_step;
  engines_->options.global_damping = snapshot.global_damping;
}

Energy Simulation::energy() const {
  return engines_->visit([](auto& engine) { return engine.energy(); });
}

std::vector<ContactReport> Simulation::contacts() const {
  return engines_->visit([](auto& engine) { return engine.contacts(); });
}

ContactPeaks Simulation::take_peaks() {
  return engines_->visit([](auto& engine) { return engine.take_peaks(); });
}

Vec3 Simulation::wall_force(int wall) const {
  return engines_->visit([wall](const auto& engine) { return engine.wall_force(wall); });
}

Scene Simulation::scene_now() const {
  Scene scene = engines_->scene;
  const State& now = engines_->refreshed_state();
  const std::vector<int>& types = engines_->types_of_bodies();
  scene.bodies.resize(types.size());
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    Body& body = scene.bodies[i];
    body.type = types[i];
    body.position = now.position[i];
    body.orientation = now.orientation[i];
    body.velocity = now.velocity[i];
    body.angular_velocity = now.angular_velocity[i];
    if (scene.planar) body.picture_angle = now.picture_angle[i];
  }
  engines_->visit([&](const auto& engine) {
    for (std::size_t w = 0; w < scene.walls.size(); ++w) {
      const Wall rest = scene.walls[w];
      scene.walls[w] = engine.walls_now()[w];
      scene.walls[w].motion = rest.motion;
      scene.walls[w].drag = rest.drag;
    }
  });
  return scene;
}

std::uint64_t Simulation::state_hash() const {
  return engines_->visit([](const auto& engine) { return engine.state_hash(); });
}

}  // namespace graintruth::sim
