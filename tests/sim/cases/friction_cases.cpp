// Friction: sliding, sticking and rolling on an incline and on the flat.
#include <array>
#include <numbers>

#include "sim/simulation.h"
#include "tests/sim/cases/check.h"
#include "tests/sim/cases/incline.h"
#include "tests/support/read_rows.h"

namespace graintruth::sim::cases {
namespace {

using tests::bundled_reference;
using tests::number;
using tests::read_rows;
using tests::Row;

constexpr double kDegree = std::numbers::pi / 180.0;

std::vector<Check> sliding_block() {
  const double incline = 30.0 * kDegree;
  Worst slides;
  for (const bool planar : {true, false}) {
    for (const double mu : {0.1, 0.2, 0.3, 0.4, 0.5}) {
      for (const double tangential_damping : {0.0, 1.0}) {
        Simulation simulation(
            on_incline(5, 0.01, incline, {.friction = mu, .restitution = 0.5}, planar),
            {.time_step = {.fraction = 1.0}, .tangential_damping = tangential_damping});
        // The springs must stretch before they slide, which leaves a speed of its own: compare two
        // later moments
        simulation.run_until(0.1);
        const double early = simulation.state().velocity[0].x();
        simulation.run_until(0.3);
        const double acceleration = (simulation.state().velocity[0].x() - early) / 0.2;
        slides.see_ratio(acceleration, kGravity * (std::sin(incline) - mu * std::cos(incline)));
      }
    }
  }
  Worst creeps;
  for (const double mu : {0.58, 0.7}) {
    Simulation simulation(on_incline(5, 0.01, incline, {.friction = mu, .restitution = 0.5}, true));
    // Gravity sets in at once, so the springs overshoot and may slip a little at first; afterwards
    // nothing creeps
    simulation.run_until(0.1);
    const double early = simulation.state().position[0].x();
    simulation.run_until(0.2);
    creeps.see((simulation.state().position[0].x() - early) / 0.01);
  }
  return {within("30 degrees, mu = 0.1 ... 0.5: acceleration, relative",
                 "thesis 3.6, model specification 6",
                 1e-3,
                 slides.value),
          within("30 degrees, mu = 0.58 and 0.7: creep in 0.1 s, of a radius",
                 "sticks when mu > tan 30 (model specification 6); round-off",
                 1e-8,
                 creeps.value)};
}

std::vector<Check> rolling_sphere_on_an_incline() {
  Worst acceleration, turning;
  for (const Row& row : read_rows(bundled_reference("rolling_sliding/incline_sphere.csv"))) {
    const double radius = 0.01, time = 0.2;
    const Surfaces surfaces{.friction = number(row, "mu"), .restitution = 0.5};
    Simulation simulation(
        on_incline(1, radius, number(row, "incline_deg") * kDegree, surfaces, false),
        {.time_step = {.fraction = 1.0}});
    simulation.run_until(time);
    const State& state = simulation.state();
    acceleration.see_ratio(state.velocity[0].x() / time, number(row, "acceleration_m_s2"));
    turning.see_ratio(radius * state.angular_velocity[0].y() / time,
                      number(row, "R_times_alpha_m_s2"));
  }
  const std::string source = "rolling_sliding (Ai et al. 2011), exact";
  return {
      within(
          "all inclines and frictions: acceleration, relative", source, 5e-3, acceleration.value),
      within("the same: angular acceleration, relative", source, 5e-3, turning.value)};
}

std::vector<Check> sliding_into_rolling() {
  Worst time, velocity, spin;
  for (const Row& row : read_rows(bundled_reference("rolling_sliding/slide_to_roll_sphere.csv"))) {
    const double radius = number(row, "R_m"), v0 = number(row, "v0_m_s");
    const double exact_time = number(row, "t_roll_s");
    Scene scene =
        on_incline(1, radius, 0.0, {.friction = number(row, "mu"), .restitution = 0.5}, true);
    scene.bodies[0].velocity.x() = v0;
    Simulation simulation(scene, {.time_step = {.fraction = 1.0}});
    double rolls_at = 0.0;
    const auto look = [&](const State& state) {
      const double slip = state.velocity[0].x() - radius * state.angular_velocity[0].y();
      if (rolls_at == 0.0 && slip <= 1e-3 * v0) rolls_at = state.time;
    };
    simulation.run_until(1.2 * exact_time, {.interval = 1e-3 * exact_time, .observer = look});
    const State& state = simulation.state();
    time.see_ratio(rolls_at, exact_time);
    velocity.see_ratio(state.velocity[0].x(), number(row, "v_roll_m_s"));
    spin.see_ratio(state.angular_velocity[0].y(), number(row, "omega_roll_rad_s"));
  }
  const std::string source = "rolling_sliding (Xiang et al. 2009), exact";
  return {within("time until it rolls, relative", source, 1e-2, time.value),
          within("speed when it rolls, relative", source, 2e-3, velocity.value),
          within("spin when it rolls, relative", source, 2e-3, spin.value)};
}

// Dosta et al. 2024: g = (5, 0, -5), mu = 0.2: slips, since tan 45 = 1 > 7/2 mu.
std::vector<Check> open_dem_slide() {
  const double radius = 0.001;
  Scene scene = on_incline(1,
                           radius,
                           45.0 * kDegree,
                           {.friction = 0.2, .restitution = 0.4},
                           false,
                           5.0 * std::numbers::sqrt2);
  Simulation simulation(scene);
  simulation.run_until(0.001);
  const State early = simulation.state();
  simulation.run_until(0.005);
  const State& late = simulation.state();
  const double time = late.time - early.time;
  Worst acceleration, turning;
  acceleration.see_ratio((late.velocity[0] - early.velocity[0]).x() / time, 4.0);
  turning.see_ratio(radius * (late.angular_velocity[0] - early.angular_velocity[0]).y() / time,
                    2.5);
  const std::string source = "Dosta et al. 2024, self test b; tolerance of rolling_sliding";
  return {
      within(
          "ball under (5, 0, -5) m/s2: acceleration, relative", source, 5e-3, acceleration.value),
      within("the same: angular acceleration, relative", source, 5e-3, turning.value)};
}

// mu_r = 0.05 under a ball that rolls without slipping:  7/5 m dv/dt = m g sin - mu_r m g cos
std::vector<Check> rolling_friction() {
  const double radius = 0.01, rolling = 0.05, v0 = 0.2;
  const Surfaces surfaces{.friction = 0.5, .restitution = 0.5, .rolling_friction = rolling};
  Worst flat, stop, down, holds, books;
  for (const bool planar : {true, false}) {
    Scene scene = on_incline(1, radius, 0.0, surfaces, planar);
    scene.bodies[0].velocity.x() = v0;
    scene.bodies[0].angular_velocity.y() = v0 / radius;
    const double decelerates = 5.0 / 7.0 * rolling * kGravity;
    const double rolls_for = v0 / decelerates;
    Simulation simulation(scene, {.tally_work = true});
    const double energy = simulation.energy().total();
    simulation.run_until(0.1 * rolls_for);
    const double early = simulation.state().velocity[0].x();
    simulation.run_until(0.9 * rolls_for);
    flat.see_ratio((early - simulation.state().velocity[0].x()) / (0.8 * rolls_for), decelerates);
    simulation.run_until(1.5 * rolls_for);
    stop.see_ratio(simulation.state().position[0].x(), 0.5 * v0 * rolls_for);
    const Energy after = simulation.energy();
    books.see_ratio(after.friction_loss + after.damping_loss, energy - after.total());

    for (const double incline : {0.04, 0.1}) {  // tan above and below mu_r
      Simulation tilted(on_incline(1, radius, incline, surfaces, planar));
      tilted.run_until(0.1);
      const State start = tilted.state();
      tilted.run_until(0.3);
      const double change = (tilted.state().velocity[0] - start.velocity[0]).x() / 0.2;
      if (std::tan(incline) > rolling) {
        down.see_ratio(change,
                       5.0 / 7.0 * kGravity * (std::sin(incline) - rolling * std::cos(incline)));
      } else {
        holds.see((tilted.state().position[0] - start.position[0]).x() / radius);
      }
    }
  }
  const std::string source = "closed form (Ai et al. 2011, model C); tolerance of rolling_sliding";
  return {
      within("on the flat, 5/7 mu_r g, relative", source, 5e-3, flat.value),
      within("on the flat: where it comes to rest, relative", source, 5e-3, stop.value),
      within("tan 0.1 > mu_r: 5/7 g (sin - mu_r cos), relative", source, 5e-3, down.value),
      within("tan 0.04 < mu_r: creep in 0.2 s, of a radius", "rests; round-off", 1e-8, holds.value),
      within("booked losses against what is gone", "validation plan 2", 1e-2, books.value)};
}

const std::string kModelC = "closed form (Ai et al. 2011, model C); tolerance of rolling_sliding";

// mu_r = 0.05 and several mu: rolls without slipping while tan <= 7/2 mu - 5/2 mu_r, else slides
// with
//   a = g (sin - mu cos), R alpha = 5/2 (mu - mu_r) g cos
std::vector<Check> rolling_friction_on_an_incline() {
  const double radius = 0.01, rolling = 0.05;
  Worst rolls, slides, turns;
  for (const bool planar : {true, false}) {
    for (const double mu : {0.1, 0.2, 0.4}) {
      for (const double incline : {0.1, 0.3, 0.8, 1.2}) {
        Simulation simulation(
            on_incline(1,
                       radius,
                       incline,
                       {.friction = mu, .restitution = 0.5, .rolling_friction = rolling},
                       planar));
        simulation.run_until(0.05);
        const State early = simulation.state();
        simulation.run_until(0.15);
        const State& late = simulation.state();
        const double acceleration = (late.velocity[0] - early.velocity[0]).x() / 0.1;
        const double turning =
            radius * (late.angular_velocity[0] - early.angular_velocity[0]).y() / 0.1;
        const double sine = std::sin(incline), cosine = std::cos(incline);
        if (sine / cosine <= 3.5 * mu - 2.5 * rolling) {
          const double exact = 5.0 / 7.0 * kGravity * (sine - rolling * cosine);
          rolls.see_ratio(acceleration, exact);
          turns.see_ratio(turning, exact);
        } else {
          slides.see_ratio(acceleration, kGravity * (sine - mu * cosine));
          turns.see_ratio(turning, 2.5 * (mu - rolling) * kGravity * cosine);
        }
      }
    }
  }
  return {within("rolls: 5/7 g (sin - mu_r cos), relative", kModelC, 5e-3, rolls.value),
          within("slides: g (sin - mu cos), relative", kModelC, 5e-3, slides.value),
          within("angular acceleration of both, relative", kModelC, 5e-3, turns.value)};
}

// A ball that turns on the spot without friction is held by the moment alone:
//   R dw/dt = -5/2 mu_r g
std::vector<Check> spin_down() {
  const double radius = 0.01, rolling = 0.05, start = 40.0;
  Worst decay, rests;
  for (const bool planar : {true, false}) {
    Scene scene = on_incline(
        1, radius, 0.0, {.friction = 0.0, .restitution = 0.5, .rolling_friction = rolling}, planar);
    scene.bodies[0].angular_velocity.y() = start;
    Simulation simulation(scene);
    const double stops_at = start * radius / (2.5 * rolling * kGravity);
    simulation.run_until(0.1 * stops_at);
    const double early = simulation.state().angular_velocity[0].y();
    simulation.run_until(0.9 * stops_at);
    const double late = simulation.state().angular_velocity[0].y();
    decay.see_ratio((early - late) / (0.8 * stops_at), start / stops_at);
    simulation.run_until(1.5 * stops_at);
    rests.see(simulation.state().angular_velocity[0].y() / start);
  }
  return {within("R dw/dt = -5/2 mu_r g, relative", kModelC, 5e-3, decay.value),
          within("then rests: what is left of the spin", "rests", 1e-3, rests.value)};
}

// A row of n balls that rolls across itself has n contacts, and each bears its part of the weight.
// So the moments add up to mu_r R m g, and it slows down as one ball does.
std::vector<Check> rolling_friction_of_rows() {
  const double radius = 0.01, rolling = 0.05, speed = 0.2;
  Worst flat, stop, down;
  const double slows = 5.0 / 7.0 * rolling * kGravity, incline = 0.1;
  for (const int spheres : {2, 3, 5}) {
    const Surfaces surfaces{.friction = 0.5, .restitution = 0.5, .rolling_friction = rolling};
    const auto row_on = [&](double angle) {
      Scene scene = on_incline(spheres, radius, angle, surfaces, false);
      scene.bodies[0].orientation = Quat(Eigen::AngleAxisd(90.0 * kDegree, Vec3::UnitZ()));
      return scene;
    };
    Scene scene = row_on(0.0);
    scene.bodies[0].velocity.x() = speed;
    scene.bodies[0].angular_velocity.y() = speed / radius;
    Simulation simulation(scene);
    simulation.run_until(0.1 * speed / slows);
    const double early = simulation.state().velocity[0].x();
    simulation.run_until(0.9 * speed / slows);
    flat.see_ratio((early - simulation.state().velocity[0].x()) / (0.8 * speed / slows), slows);
    simulation.run_until(1.5 * speed / slows);
    stop.see_ratio(simulation.state().position[0].x(), 0.5 * speed * speed / slows);
    Simulation tilted(row_on(incline));
    tilted.run_until(0.1);
    const double before = tilted.state().velocity[0].x();
    tilted.run_until(0.3);
    down.see_ratio((tilted.state().velocity[0].x() - before) / 0.2,
                   5.0 / 7.0 * kGravity * (std::sin(incline) - rolling * std::cos(incline)));
  }
  return {
      within("2, 3, 5 balls on the flat: 5/7 mu_r g, relative", kModelC, 5e-3, flat.value),
      within("the same: where it comes to rest, relative", kModelC, 5e-3, stop.value),
      within(
          "the same, tan 0.1 > mu_r: 5/7 g (sin - mu_r cos), relative", kModelC, 5e-3, down.value)};
}

// A ball in a drum that turns rolls on the spot, where the slope of the wall is mu_r: the moment
// mu_r R N takes the friction mu_r N, which carries the weight along the wall. Its spin is that of
// the drum times the ratio of the radii.
std::vector<Check> ball_in_a_turning_drum() {
  const double radius = 0.01, drum = 0.1, rolling = 0.15, rate = 3.0;
  Worst angle, spin;
  for (const bool planar : {true, false}) {
    for (const bool wall_turns : {true, false}) {
      Scene scene = on_incline(1,
                               radius,
                               0.0,
                               {.friction = 0.6, .restitution = 0.5, .rolling_friction = rolling},
                               planar);
      scene.walls.clear();
      const Vec3 axis(0.0, 1.0, drum);
      Wall wall = cylinder_wall({0.0, -1.0, drum}, axis, drum, {}, 1);
      WallMotion& motion = wall_turns ? wall.motion : wall.drag;
      motion.angular_velocity = Vec3(0.0, rate, 0.0);
      motion.pivot = axis;
      scene.add_wall(wall);
      // In its place: were that another one, it would swing about it
      const double start = -std::atan(rolling), reach = drum - radius;
      scene.bodies[0].angular_velocity.y() = rate * drum / radius;
      scene.bodies[0].position =
          Vec3(reach * std::sin(start), 0.0, drum - reach * std::cos(start) - 1e-7);
      Simulation simulation(scene);
      simulation.run_until(0.2);
      double sum = 0.0, sum_of_spins = 0.0;
      constexpr int kMoments = 100;
      for (int i = 1; i <= kMoments; ++i) {
        simulation.run_until(0.2 + 0.01 * i);
        const Vec3& place = simulation.state().position[0];
        sum += std::atan2(-place.x(), drum - place.z());
        sum_of_spins += simulation.state().angular_velocity[0].y();
      }
      angle.see_ratio(std::tan(sum / kMoments), rolling);
      spin.see_ratio(sum_of_spins / kMoments, rate * drum / radius);
    }
  }
  return {within("steady angle, tan = mu_r, relative", kModelC, 1e-2, angle.value),
          within("spin, that of the drum times the ratio of the radii, relative",
                 "rolls on the spot",
                 1e-2,
                 spin.value)};
}

constexpr std::array kCases = {
    Case{"SlidingBlock", "A row of balls that slides or sticks at 30 degrees", sliding_block},
    Case{"RollingSphereOnAnIncline", "A ball on an incline", rolling_sphere_on_an_incline},
    Case{"SlidingIntoRolling", "A ball that slides, then rolls", sliding_into_rolling},
    Case{"RollingFriction", "A ball with rolling friction", rolling_friction},
    Case{"RollingFrictionOnAnIncline",
         "Rolling friction on an incline",
         rolling_friction_on_an_incline},
    Case{"SpinDown", "Rolling friction without friction", spin_down},
    Case{"RollingFrictionOfRows", "Rolling friction of clumps", rolling_friction_of_rows},
    Case{"BallInATurningDrum", "A ball in a turning drum", ball_in_a_turning_drum},
    Case{"OpenDemSlide", "Sliding self test of the open benchmark", open_dem_slide}};

}  // namespace

std::span<const Case> friction_cases() { return kCases; }

}  // namespace graintruth::sim::cases
