// graintruth.sim: the library sim/ as a Python module. Names, units and defaults are those of its
// headers. What goes in are objects and keyword arguments; what comes out are plain namespaces of
// numbers and numpy arrays, copied.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string_view>

#include "sim/simulation.h"

namespace py = pybind11;
using namespace py::literals;

namespace graintruth::sim {
namespace {

using Array = py::array_t<double>;

// An array of a row for each of `items`, filled by `write(item, row)`.
template <class Items, class Write>
Array rows_of(const Items& items, int columns, const Write& write) {
  const auto rows = static_cast<py::ssize_t>(items.size());
  Array array(std::vector<py::ssize_t>{rows, columns});
  double* row = array.mutable_data();
  for (const auto& item : items) {
    write(item, row);
    row += columns;
  }
  return array;
}

Array rows_of(const std::vector<Vec3>& vectors) {
  return rows_of(vectors, 3, [](const Vec3& v, double* row) { std::copy_n(v.data(), 3, row); });
}

// w, x, y, z
Array rows_of(const std::vector<Quat>& rotations) {
  return rows_of(rotations, 4, [](const Quat& q, double* row) {
    row[0] = q.w();
    row[1] = q.x();
    row[2] = q.y();
    row[3] = q.z();
  });
}

Quat rotation_of(const std::array<double, 4>& wxyz) {
  return Quat(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).normalized();
}

py::object named(const py::dict& members) {
  return py::module_::import("types").attr("SimpleNamespace")(**members);
}

py::object seen(const State& state) {
  py::dict members("time"_a = state.time,
                   "position"_a = rows_of(state.position),
                   "orientation"_a = rows_of(state.orientation),
                   "velocity"_a = rows_of(state.velocity),
                   "angular_velocity"_a = rows_of(state.angular_velocity));
  if (!state.picture_angle.empty()) {
    const auto bodies = static_cast<py::ssize_t>(state.picture_angle.size());
    members["picture_angle"] = Array(bodies, state.picture_angle.data());
  }
  return named(members);
}

py::object energy_of(const Simulation& simulation) {
  const Energy energy = simulation.energy();
  return named(py::dict("kinetic"_a = energy.kinetic,
                        "gravity"_a = energy.gravity,
                        "elastic"_a = energy.elastic,
                        "damping_loss"_a = energy.damping_loss,
                        "friction_loss"_a = energy.friction_loss,
                        "wall_work"_a = energy.wall_work,
                        "total"_a = energy.total()));
}

// Columns, as pandas.DataFrame takes them.
py::dict contacts_of(const Simulation& simulation) {
  py::list first, second, with_wall, overlap, normal_force, slides;
  std::vector<Vec3> normals, tangential_forces;
  for (const ContactReport& contact : simulation.contacts()) {
    first.append(contact.first);
    second.append(contact.second);
    with_wall.append(contact.with_wall);
    overlap.append(contact.overlap);
    normal_force.append(contact.normal_force);
    slides.append(contact.slides);
    normals.push_back(contact.normal);
    tangential_forces.push_back(contact.tangential_force);
  }
  return py::dict("first"_a = first,
                  "second"_a = second,
                  "with_wall"_a = with_wall,
                  "overlap"_a = overlap,
                  "normal_force"_a = normal_force,
                  "slides"_a = slides,
                  "normal"_a = py::list(rows_of(normals)),
                  "tangential_force"_a = py::list(rows_of(tangential_forces)));
}

std::string_view name_of(RunStatus status) {
  switch (status) {
    case RunStatus::unstable:
      return "unstable";
    case RunStatus::timed_out:
      return "timed_out";
    default:
      return "completed";
  }
}

// Python hears of Ctrl-C only when asked; what its observer throws ends the run too.
py::object run_until(Simulation& simulation,
                     double time,
                     double interval,
                     const py::object& observer) {
  Sampling sampling{.interval = interval};
  if (!observer.is_none()) sampling.observer = [&](const State& state) { observer(seen(state)); };
  sampling.should_stop = [] { return PyErr_CheckSignals() != 0; };
  const RunSummary run = simulation.run_until(time, sampling);
  if (PyErr_Occurred()) throw py::error_already_set();
  return named(py::dict("status"_a = name_of(run.status),
                        "message"_a = run.message,
                        "time"_a = run.time,
                        "steps"_a = run.steps,
                        "time_step"_a = run.time_step,
                        "mean_contacts"_a = run.mean_contacts));
}

void add_particles(py::module_& module) {
  py::class_<Material>(module, "Material")
      .def(py::init<double, double>(), "youngs_modulus"_a, "poisson_ratio"_a);
  module.def("rigid_material", &rigid_material);
  py::class_<Surfaces>(module, "Surfaces")
      .def(py::init<double, double, double>(),
           "friction"_a = 0.0,
           "restitution"_a = 1.0,
           "static_friction"_a = 0.0);
  py::class_<ElementSphere>(module, "ElementSphere")
      .def(py::init<Vec3, double>(), "centre"_a, "radius"_a)
      .def_readonly("centre", &ElementSphere::centre)
      .def_readonly("radius", &ElementSphere::radius);
  py::class_<Clump>(module, "Clump")
      .def_readonly("spheres", &Clump::spheres)
      .def_readonly("mass", &Clump::mass)
      .def_readonly("inertia", &Clump::inertia)
      .def_readonly("volume", &Clump::volume);
  module.def(
      "make_clump",
      [](std::vector<ElementSphere> spheres,
         std::optional<double> density,
         std::optional<double> mass,
         std::optional<Vec3> inertia,
         int material) {
        return make_clump(std::move(spheres), {density, mass, std::move(inertia)}, material);
      },
      "spheres"_a,
      "density"_a = py::none(),
      "mass"_a = py::none(),
      "inertia"_a = py::none(),
      "material"_a = 0);
  module.def("chain_of_spheres", &chain_of_spheres, "count"_a, "radius"_a, "spacing"_a);
}

void add_walls(py::module_& module) {
  const auto at_rest = Vec3::Zero();
  py::class_<WallMotion>(module, "WallMotion")
      .def(py::init<Vec3, double, double, Vec3, Vec3>(),
           "velocity"_a = at_rest,
           "start_time"_a = 0.0,
           "end_time"_a = std::numeric_limits<double>::infinity(),
           "angular_velocity"_a = at_rest,
           "pivot"_a = at_rest);
  py::class_<Wall>(module, "Wall")
      .def_readwrite("motion", &Wall::motion)
      .def_readwrite("drag", &Wall::drag)
      .def_readwrite("opens_at", &Wall::opens_at)
      .def_readwrite("body", &Wall::body);
  const auto motion = "motion"_a = WallMotion();
  const auto material = "material"_a = 0;
  module.def("segment_wall", &segment_wall, "start"_a, "end"_a, motion, material);
  module.def("plane_wall", &plane_wall, "point"_a, "normal"_a, motion, material);
  module.def("polygon_wall", &polygon_wall, "corners"_a, motion, material);
  module.def(
      "mesh_walls",
      [](const std::vector<Vec3>& corners, int body, const WallMotion& motion, int material) {
        return mesh_walls(corners, body, motion, material).facets;
      },
      "corners"_a,
      "body"_a = 0,
      motion,
      material);
  module.def("disk_wall", &disk_wall, "centre"_a, "normal"_a, "radius"_a, motion, material);
  module.def("cylinder_wall", &cylinder_wall, "start"_a, "end"_a, "radius"_a, motion, material);
}

void add_scene(py::module_& module) {
  py::class_<Scene>(module, "Scene")
      .def(py::init([](bool planar, const Vec3& gravity) {
             Scene scene;
             scene.planar = planar;
             scene.gravity = gravity;
             return scene;
           }),
           "planar"_a = false,
           "gravity"_a = Scene().gravity)
      .def("add_material", &Scene::add_material, "material"_a)
      .def(
          "set_surfaces",
          [](Scene& scene, int first, int second, const Surfaces& surfaces) {
            scene.surfaces.set(first, second, surfaces);
          },
          "first_material"_a,
          "second_material"_a,
          "surfaces"_a)
      .def("add_type", &Scene::add_type, "clump"_a)
      .def(
          "add_body",
          [](Scene& scene,
             int type,
             const Vec3& position,
             const std::array<double, 4>& orientation,
             const Vec3& velocity,
             const Vec3& angular_velocity) {
            return scene.add_body(
                type, position, rotation_of(orientation), velocity, angular_velocity);
          },
          "type"_a,
          "position"_a,
          "orientation"_a = py::make_tuple(1.0, 0.0, 0.0, 0.0),
          "velocity"_a = Vec3(0.0, 0.0, 0.0),
          "angular_velocity"_a = Vec3(0.0, 0.0, 0.0))
      .def("add_planar_body",
           &Scene::add_planar_body,
           "type"_a,
           "position"_a,
           "picture_angle"_a,
           "velocity"_a = Vec2(0.0, 0.0),
           "picture_spin"_a = 0.0)
      .def("add_wall", &Scene::add_wall, "wall"_a);
  module.def("critical_time_step", &critical_time_step, "scene"_a);
}

void add_simulation(py::module_& module) {
  const SimulationOptions defaults;
  py::class_<Simulation>(module, "Simulation")
      .def(py::init([](const Scene& scene,
                       double time_step_fraction,
                       double largest_time_step,
                       double impact_speed,
                       double tangential_damping,
                       double global_damping,
                       bool tally_work) {
             SimulationOptions options;
             options.time_step.fraction = time_step_fraction;
             options.time_step.largest = largest_time_step;
             options.time_step.impact_speed = impact_speed;
             options.tangential_damping = tangential_damping;
             options.global_damping = global_damping;
             options.tally_work = tally_work;
             return Simulation(scene, options);
           }),
           "scene"_a,
           py::kw_only(),
           "time_step_fraction"_a = defaults.time_step.fraction,
           "largest_time_step"_a = defaults.time_step.largest,
           "impact_speed"_a = defaults.time_step.impact_speed,
           "tangential_damping"_a = defaults.tangential_damping,
           "global_damping"_a = defaults.global_damping,
           "tally_work"_a = defaults.tally_work)
      .def("run_until", &run_until, "time"_a, "interval"_a = 0.0, "observer"_a = py::none())
      .def_property_readonly("state", [](const Simulation& s) { return seen(s.state()); })
      .def_property_readonly("time_step", &Simulation::time_step)
      .def("set_surfaces",
           &Simulation::set_surfaces,
           "first_material"_a,
           "second_material"_a,
           "surfaces"_a)
      .def("set_wall_motion", &Simulation::set_wall_motion, "wall"_a, "motion"_a)
      .def("open_wall", &Simulation::open_wall, "wall"_a, "time"_a)
      .def("energy", &energy_of)
      .def("contacts", &contacts_of)
      .def("wall_force", &Simulation::wall_force, "wall"_a)
      .def("state_hash", &Simulation::state_hash);
}

}  // namespace
}  // namespace graintruth::sim

PYBIND11_MODULE(sim, module) {
  using namespace graintruth::sim;
  module.doc() = "Rigid clumps of overlapping spheres in contact; SI units, x right, z up.";
  add_particles(module);
  add_walls(module);
  add_scene(module);
  add_simulation(module);
}
