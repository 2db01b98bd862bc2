// Problems with exact answers, beside LAMMPS and LIGGGHTS: rebound of a clump on one and on two
// contacts, sliding down 30 degrees, free rotation about no principal axis.
// Usage: bench_sim_oracle [FIGURES_FILE]
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <iostream>
#include <numbers>
#include <sstream>

#include "bench/sim/child_process.h"
#include "bench/sim/lone_clump.h"

namespace {

using namespace graintruth;
using namespace graintruth::bench;
using sim::Vec3;

constexpr double kGravity = 9.81;  // m/s2
constexpr double kRadius = 0.010;  // m

const std::filesystem::path kFolder = "out/bench/oracle";

struct Engine {
  std::string name;
  std::function<SphereTrack(const LoneClump&)> track;
};

std::vector<Engine> engines() {
  std::vector<Engine> all{{"Graintruth", track_by_graintruth}};
  if (is_installed("lmp")) {
    all.push_back(
        {"LAMMPS", [](const LoneClump& c) { return track_by_lammps(c, kFolder / "lmp"); }});
  }
  if (is_installed("liggghts")) {
    all.push_back({"LIGGGHTS",
                   [](const LoneClump& c) { return track_by_liggghts(c, kFolder / "liggghts"); }});
  }
  return all;
}

// Of spheres that lie symmetrically about it.
Vec3 centre_of(const std::vector<Vec3>& spheres) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& centre : spheres) sum += centre;
  return sum / static_cast<double>(spheres.size());
}

// Rebound speed over impact speed of a two-sphere clump that meets the plane at 0.44 m/s, without
// weight: during the contact it would take away 0.2 %.
double restitution(const Engine& engine, double asked, bool is_upright) {
  constexpr double kGap = 1e-4, kHalfSpacing = 0.0075, kSpeed = 0.44;
  constexpr int kFirst = 1000, kSecond = 3000;
  LoneClump clump;
  clump.spheres = sim::chain_of_spheres(2, kRadius, 2.0 * kHalfSpacing);
  clump.restitution = asked;
  clump.is_upright = is_upright;
  clump.gravity.setZero();
  clump.velocity = Vec3(0.0, 0.0, -kSpeed);
  clump.position.z() = kRadius + (is_upright ? kHalfSpacing : 0.0) + kGap;
  clump.look_at_steps = {kFirst, kSecond};
  const SphereTrack track = engine.track(clump);
  const double way = centre_of(track[1]).z() - centre_of(track[0]).z();
  return way / ((kSecond - kFirst) * clump.time_step) / kSpeed;
}

// Relative error of the acceleration down 30 degrees, five spheres flat on the plane: second
// difference of three places, so that the stretching of the springs at the start does not count.
double slide_error(const Engine& engine, double friction) {
  constexpr int kSteps = 15000;
  const double incline = std::numbers::pi / 6.0;
  LoneClump clump;
  clump.spheres = sim::chain_of_spheres(5, kRadius, 0.005);
  clump.restitution = 0.5;
  clump.friction = friction;
  clump.gravity = kGravity * Vec3(std::sin(incline), 0.0, -std::cos(incline));
  // At the static overlap of its five contacts with a plane of its own elasticity:
  // W/5 = 4/3 E* sqrt(R) d^1.5, E* = E/(2 (1 - nu^2))
  const double nu = clump.material.poisson_ratio;
  const double modulus = clump.material.youngs_modulus / (2.0 * (1.0 - nu * nu));
  const double load = clump.mass * kGravity * std::cos(incline) / 5.0;
  const double overlap = std::pow(load / (4.0 / 3.0 * modulus * std::sqrt(kRadius)), 2.0 / 3.0);
  clump.position = Vec3(-0.9, 0.0, kRadius - overlap);
  clump.time_step = 1e-5;
  clump.look_at_steps = {kSteps, 2 * kSteps, 3 * kSteps};
  const SphereTrack track = engine.track(clump);
  const double time = kSteps * clump.time_step;
  const double acceleration =
      (centre_of(track[2]).x() - 2.0 * centre_of(track[1]).x() + centre_of(track[0]).x()) /
      (time * time);
  return acceleration / (kGravity * (std::sin(incline) - friction * std::cos(incline))) - 1.0;
}

const Vec3 kInertia(1e-6, 2e-6, 3e-6);  // kg m2
const Vec3 kSpin(10.0, 5.0, 20.0);      // rad/s

// Direction of the body x axis after `time`: Euler's equations by fourth-order Runge-Kutta, 200000
// steps.
Vec3 exact_axis(double time) {
  struct Turning {
    Eigen::Vector4d rotation;  // w, x, y, z
    Vec3 spin;                 // body axes
  };
  const auto rate = [](const Turning& t) {
    const double w = t.rotation[0];
    const Vec3 u = t.rotation.tail<3>();
    Turning r;
    r.rotation << -0.5 * u.dot(t.spin), 0.5 * (w * t.spin + u.cross(t.spin));
    r.spin = -t.spin.cross(kInertia.cwiseProduct(t.spin)).cwiseQuotient(kInertia);
    return r;
  };
  const auto after = [](const Turning& t, const Turning& r, double h) {
    return Turning{t.rotation + h * r.rotation, t.spin + h * r.spin};
  };
  constexpr int kSteps = 200000;
  const double h = time / kSteps;
  Turning now{Eigen::Vector4d(1.0, 0.0, 0.0, 0.0), kSpin};
  for (int i = 0; i < kSteps; ++i) {
    const Turning a = rate(now), b = rate(after(now, a, 0.5 * h)), c = rate(after(now, b, 0.5 * h)),
                  d = rate(after(now, c, h));
    now = after(after(now, a, h / 6.0), b, h / 3.0);
    now = after(after(now, c, h / 3.0), d, h / 6.0);
  }
  const sim::Quat turn(now.rotation[0], now.rotation[1], now.rotation[2], now.rotation[3]);
  return turn.normalized() * Vec3::UnitX();
}

// Angle between the body x axis and the exact one after 1 s, rad.
double axis_error(const Engine& engine, double time_step) {
  constexpr double kTime = 1.0;
  static const Vec3 exact = exact_axis(kTime);
  LoneClump clump;
  clump.spheres = sim::chain_of_spheres(2, kRadius, 0.015);
  clump.inertia = kInertia;
  clump.angular_velocity = kSpin;
  clump.gravity.setZero();
  clump.position.z() = 0.2;
  clump.time_step = time_step;
  clump.look_at_steps = {static_cast<int>(std::lround(kTime / time_step))};
  const SphereTrack track = engine.track(clump);
  const Vec3 axis = (track[0][1] - track[0][0]).normalized();
  return std::atan2(axis.cross(exact).norm(), axis.dot(exact));
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::filesystem::path file = argc > 1 ? argv[1] : (kFolder / "oracle.figures").string();
    if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path());
    std::ofstream figures(file);
    const std::vector<Engine> all = engines();
    const auto row = [&](const std::string& title, const char* form, const auto& measure) {
      std::string line = title;
      for (const Engine& engine : all) {
        char text[64];
        std::snprintf(text, sizeof text, form, measure(engine));
        line += "; " + engine.name + " " + text;
      }
      std::cout << line << std::endl;
      figures << line << std::endl;
    };
    for (const bool is_upright : {true, false}) {
      for (const double e : {1.0, 0.8, 0.5}) {
        std::ostringstream title;
        title << "restitution " << e << " on " << (is_upright ? "one contact" : "two contacts");
        row(title.str(), "%.5f", [&](const Engine& engine) {
          return restitution(engine, e, is_upright);
        });
      }
    }
    for (const double friction : {0.1, 0.3, 0.5}) {
      std::ostringstream title;
      title << "slide down 30 degrees, friction " << friction << ", error of the acceleration in %";
      row(title.str(), "%+.4f", [&](const Engine& engine) {
        return 100.0 * slide_error(engine, friction);
      });
    }
    for (const double time_step : {1e-5, 1e-4}) {
      std::ostringstream title;
      title << "axis after 1 s of free rotation, time step " << time_step << " s, error in rad";
      row(title.str(), "%.2e", [&](const Engine& engine) { return axis_error(engine, time_step); });
    }
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return EXIT_FAILURE;
  }
}
