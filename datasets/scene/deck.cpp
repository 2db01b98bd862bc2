#include "datasets/scene/deck.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "datasets/store/input_error.h"
#include "datasets/store/text_file.h"
#include "datasets/store/toml_section.h"

namespace graintruth::datasets {

namespace {

using Eigen::Vector3d;

// Numbers beyond this are a slip: decks speak of centimetres, steps and grams.
constexpr double largest_number = 1e9;

// What the file beside a deck says.
struct Sidecar {
  bool is_planar = false;
  double elastic_modulus = 0.0;  // Pa
  double poisson_ratio = 0.0;
  bool rigid_walls = true;
  double length = 0.0;                  // m, of one deck unit; likewise below
  double speed = 0.0;                   // m/s
  double density = 0.0;                 // kg/m3
  double acceleration = 0.0;            // m/s2
  double turning = 0.0;                 // rad/s; FAN
  std::string moving;                   // piston, upper_lower or strips; MOV
  bool orifice_open = false;            // BOT
  bool slope_as_angle = false;          // CON, reading B of its fourth number
  std::optional<double> mass;           // kg
  std::vector<double> cycle_durations;  // s; in place of steps
};

struct Command {
  std::string keyword;  // first three letters
  std::vector<double> numbers;
  int line = 0;
};

// The state of the deck language: what commands have set by now.
struct Deck {
  std::filesystem::path file;
  std::string title;
  Command start, bottom, config, distances, moving, fan, flow;
  std::vector<double> radii;
  double density = 0.0, friction = 0.0, wall_friction = 0.0, fraction = 1.0;
  double global_damping = 0.0, damping_ratio = 0.0;
  Vector3d gravity = Vector3d::Zero();
  struct Cycle {
    double steps = 0.0, outputs = 0.0;
    double friction = 0.0, wall_friction = 0.0, fraction = 1.0;
    double global_damping = 0.0, damping_ratio = 0.0;
    bool after_event = false;
  };
  std::vector<Cycle> cycles;

  bool has_bottom() const { return bottom.line > 0; }
  bool has_config() const { return config.line > 0; }
  bool has_moving() const { return moving.line > 0; }
  bool has_fan() const { return fan.line > 0; }
  bool has_flow() const { return flow.line > 0; }
  double xdim() const { return start.numbers[0]; }
  double ydim() const { return start.numbers[1]; }
  double zdim() const { return start.numbers[2]; }
  int particles() const { return static_cast<int>(start.numbers[5]); }
};

[[noreturn]] void fail(const Deck& deck, int line, const std::string& complaint) {
  throw InputError(fmt::format("{}:{}: {}.", deck.file.string(), line, complaint));
}

Command read_command(const Deck& deck, const std::string& text, int line) {
  std::istringstream words(text);
  Command command;
  command.line = line;
  std::string word;
  words >> command.keyword;
  for (char& letter : command.keyword) {
    letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
  }
  command.keyword = command.keyword.substr(0, 3);
  while (words >> word) {
    std::istringstream number(word);
    double value = 0.0;
    if (!(number >> value) || !number.eof() || !(std::abs(value) <= largest_number)) {
      fail(deck, line, fmt::format("'{}' is no number that a deck may hold", word));
    }
    command.numbers.push_back(value);
  }
  return command;
}

void require_count(const Deck& deck, const Command& command, std::size_t low, std::size_t high) {
  const std::size_t count = command.numbers.size();
  if (count >= low && count <= high) return;
  fail(deck,
       command.line,
       fmt::format("{} has {} numbers, but {} are needed",
                   command.keyword,
                   count,
                   low == high ? fmt::format("{}", low) : fmt::format("{} to {}", low, high)));
}

void require_positive(const Deck& deck, const Command& command) {
  for (const double number : command.numbers) {
    if (!(number > 0.0)) {
      fail(deck, command.line, fmt::format("{} needs numbers above 0", command.keyword));
    }
  }
}

// STA xdim ydim zdim nbox nballm npar ntype nwall (errata 23); nballm = npar ntype + nwall.
void read_start(Deck& deck, const Command& command) {
  require_count(deck, command, 8, 8);
  require_positive(deck, command);
  deck.start = command;
  const auto& n = command.numbers;
  if (n[5] > 1e5 || n[6] > 300 || n[5] != std::floor(n[5]) || n[6] != std::floor(n[6])) {
    fail(deck, command.line, "START needs whole numbers of particles and of spheres in each");
  }
  if (n[4] != n[5] * n[6] + n[7]) {
    fail(deck,
         command.line,
         fmt::format("START's fifth number is {}, but {} particles of {} spheres and {} walls make "
                     "{}",
                     n[4],
                     n[5],
                     n[6],
                     n[7],
                     n[5] * n[6] + n[7]));
  }
  if (n[7] != 5.0 && n[7] != 8.0 && n[7] != 10.0) {
    fail(deck, command.line, "START's last number, of walls, must be 5, 8 or 10");
  }
}

void read_radius(Deck& deck, const Command& command) {
  require_count(deck, command, 2, 2);
  require_positive(deck, command);
  if (command.numbers[1] != static_cast<double>(deck.radii.size()) + 1.0) {
    fail(deck,
         command.line,
         fmt::format("RAD is that of sphere {}, but sphere {} is next",
                     command.numbers[1],
                     deck.radii.size() + 1));
  }
  deck.radii.push_back(command.numbers[0]);
}

void read_cycle(Deck& deck, const Command& command) {
  require_count(deck, command, 1, 3);
  const auto& n = command.numbers;
  if (!(n[0] >= 1.0) || (n.size() > 1 && !(n[1] >= 1.0 && n[1] <= 1e5))) {
    fail(deck, command.line, "CYC needs a number of steps and one of outputs, both at least 1");
  }
  deck.cycles.push_back({.steps = n[0],
                         .outputs = n.size() > 1 ? n[1] : 1.0,
                         .friction = deck.friction,
                         .wall_friction = deck.wall_friction,
                         .fraction = deck.fraction,
                         .global_damping = deck.global_damping,
                         .damping_ratio = deck.damping_ratio,
                         .after_event = deck.has_moving() || deck.has_fan() || deck.has_flow()});
}

void read_once(const Deck& deck, const Command& command, Command& into) {
  if (into.line > 0) {
    fail(deck,
         command.line,
         fmt::format("{} is given a second time, first in line {}", command.keyword, into.line));
  }
  into = command;
}

void read_settings(Deck& deck, const Command& command) {
  const auto& n = command.numbers;
  const std::string& keyword = command.keyword;
  if (keyword == "DEN") {
    require_count(deck, command, 1, 1);
    require_positive(deck, command);
    deck.density = n[0];
  } else if (keyword == "FRI") {
    require_count(deck, command, 2, 2);
    if (!(n[0] >= 0.0 && n[0] <= 5.0 && n[1] >= 0.0 && n[1] <= 5.0)) {
      fail(deck, command.line, "FRIC needs two frictions from 0 to 5");
    }
    deck.friction = n[0];
    deck.wall_friction = n[1];
  } else if (keyword == "FRA") {
    require_count(deck, command, 1, 1);
    require_positive(deck, command);
    deck.fraction = n[0];
  } else if (keyword == "DAM") {
    require_count(deck, command, 2, 2);
    if (!(n[0] >= 0.0 && n[1] >= 0.0 && n[1] < 1.0)) {
      fail(deck, command.line, "DAMP needs a global coefficient not below 0 and a beta in [0, 1)");
    }
    deck.global_damping = n[0];
    deck.damping_ratio = n[1];
  } else if (keyword == "GRA") {
    require_count(deck, command, 3, 3);
    deck.gravity = {n[0], n[1], n[2]};
  } else {
    fail(
        deck,
        command.line,
        fmt::format("'{}' is no command; known are STA BOT CON RAD PRO DEN FRI FRA DAM GRA MOV FAN "
                    "FLO CYC STO",
                    keyword));
  }
}

void apply(Deck& deck, const Command& command) {
  const std::string& keyword = command.keyword;
  if (keyword == "BOT") {
    require_count(deck, command, 5, 5);
    require_positive(deck, command);
    read_once(deck, command, deck.bottom);
  } else if (keyword == "CON") {
    require_count(deck, command, 5, 5);
    require_positive(deck, command);
    read_once(deck, command, deck.config);
  } else if (keyword == "RAD") {
    read_radius(deck, command);
  } else if (keyword == "PRO") {
    read_once(deck, command, deck.distances);
  } else if (keyword == "MOV") {
    require_count(deck, command, 1, 2);
    read_once(deck, command, deck.moving);
  } else if (keyword == "FAN") {
    require_count(deck, command, 1, 1);
    read_once(deck, command, deck.fan);
  } else if (keyword == "FLO") {
    require_count(deck, command, 0, 1);
    read_once(deck, command, deck.flow);
  } else if (keyword == "CYC") {
    read_cycle(deck, command);
  } else {
    read_settings(deck, command);
  }
}

void check_deck(const Deck& deck, int last_line) {
  if (deck.start.line == 0) fail(deck, 1, "the deck must begin with START");
  const std::size_t spheres = static_cast<std::size_t>(deck.start.numbers[6]);
  if (deck.radii.size() != spheres || deck.distances.numbers.size() != spheres) {
    fail(deck,
         last_line,
         fmt::format("START speaks of {} spheres a particle, RAD gives {} and PRO {}",
                     spheres,
                     deck.radii.size(),
                     deck.distances.numbers.size()));
  }
  if (!(deck.density > 0.0)) fail(deck, last_line, "DENS is missing");
  if (deck.cycles.empty()) fail(deck, last_line, "CYC is missing: nothing is to be simulated");
  const double walls = deck.start.numbers[7];
  if ((walls == 10.0) != deck.has_bottom()) {
    fail(deck, deck.start.line, "ten walls need BOT, and BOT needs ten walls");
  }
  if ((walls == 8.0) != deck.has_config()) {
    fail(deck, deck.start.line, "eight walls need CON, and CON needs eight walls");
  }
  if (deck.has_bottom()) {
    const auto& w = deck.bottom.numbers;
    constexpr double tolerance = 1e-9;
    if (w[0] + w[1] > deck.xdim() + tolerance || 2.0 * w[2] >= deck.ydim()) {
      fail(deck, deck.bottom.line, "BOT makes a middle wall that is larger than the workspace");
    }
  }
  if (deck.has_config()) {
    const auto& c = deck.config.numbers;
    if (c[0] + c[2] >= deck.xdim() || c[1] >= deck.zdim()) {
      fail(deck, deck.config.line, "CON makes a column that is larger than the workspace");
    }
  }
  if (deck.has_moving() && !deck.has_config() && !deck.has_bottom()) {
    fail(deck, deck.moving.line, "MOV has nothing to move: it needs CON or BOT");
  }
  if ((deck.has_fan() || deck.has_flow()) && !deck.has_bottom()) {
    fail(deck, std::max(deck.fan.line, deck.flow.line), "FAN and FLO need BOT's orifice panel");
  }
}

Deck read_deck(const std::filesystem::path& file) {
  Deck deck;
  deck.file = file;
  std::istringstream stream(read_text(file, "save it as plain text").text);
  std::string text;
  int line = 0;
  while (std::getline(stream, text)) {
    ++line;
    if (line == 2) {
      deck.title = text;
      continue;
    }
    if (text.find_first_not_of(" \t") == std::string::npos) continue;
    const Command command = read_command(deck, text, line);
    if (line == 1) {
      if (command.keyword != "STA") fail(deck, 1, "the deck must begin with START");
      read_start(deck, command);
    } else if (command.keyword == "STO") {
      break;
    } else {
      apply(deck, command);
    }
  }
  check_deck(deck, std::max(line, 1));
  return deck;
}

double unit_named(TomlSection& section, std::string_view key, Units units) {
  const std::string name = section.text(key);
  std::string known;
  for (const Unit& unit : units) {
    if (unit.suffix == name) return unit.in_si;
    known += fmt::format("{}'{}'", known.empty() ? "" : ", ", unit.suffix);
  }
  section.fail(key, fmt::format("is '{}', but must be one of {}", name, known));
}

// All that decks leave out, in one sentence.
void require_keys(const Deck& deck, const std::filesystem::path& beside, TomlSection* root) {
  std::string missing;
  const auto need = [&](bool needed, const char* stem, const char* example) {
    bool is_there = !needed;
    if (root != nullptr && needed) {
      for (const std::string& key : root->keys()) is_there |= key.starts_with(stem);
    }
    if (!is_there) missing += fmt::format("{}{}", missing.empty() ? "" : ", ", example);
  };
  need(true, "elastic_modulus", "elastic_modulus_gpa");
  need(true, "poisson_ratio", "poisson_ratio");
  need(true, "walls", "walls = \"rigid\" or \"same\"");
  need(true, "dimensions", "dimensions = 2 or 3");
  need(true, "length_unit", "length_unit = \"cm\"");
  need(true, "density_unit", "density_unit = \"g_per_cm3\"");
  need(true, "acceleration_unit", "acceleration_unit = \"m_per_s2\"");
  need(deck.has_moving(), "speed_unit", "speed_unit = \"cm_per_s\"");
  need(deck.has_moving(), "moving", "moving = \"piston\", \"upper_lower\" or \"strips\"");
  need(deck.has_fan(), "turning_unit", "turning_unit = \"rad_per_s\"");
  need(deck.has_bottom(), "orifice", "orifice = \"open\" or \"closed\"");
  if (missing.empty()) return;
  throw InputError(fmt::format("{}: a deck does not say everything; {} lacks {}.",
                               deck.file.string(),
                               beside.string(),
                               missing));
}

Sidecar read_sidecar(const Deck& deck, TomlSection root) {
  constexpr Range modulus_range{1e3, 1e13, true, "a modulus from 1 kPa to 10 TPa"};
  constexpr Range poisson_range{-1.0, 0.4999, false, "a Poisson ratio above -1 and below 0.5"};
  constexpr Range duration_range{0.0, 1e5, false, "a time above 0 and at most 1e5 s"};
  Sidecar sidecar;
  sidecar.elastic_modulus = root.quantity("elastic_modulus", pressure_units, modulus_range);
  sidecar.poisson_ratio = root.quantity("poisson_ratio", plain, poisson_range);
  sidecar.is_planar = root.whole_number("dimensions", 2, 3) == 2;
  const std::string walls = root.text("walls");
  if (walls != "rigid" && walls != "same") root.fail("walls", "must be 'rigid' or 'same'");
  sidecar.rigid_walls = walls == "rigid";
  sidecar.length = unit_named(root, "length_unit", length_units);
  sidecar.density = unit_named(root, "density_unit", density_units);
  sidecar.acceleration = unit_named(root, "acceleration_unit", acceleration_units);
  if (root.has("speed_unit")) sidecar.speed = unit_named(root, "speed_unit", speed_units);
  if (root.has("turning_unit")) sidecar.turning = unit_named(root, "turning_unit", turning_units);
  sidecar.moving = root.optional_text("moving").value_or("");
  if (deck.has_moving()) {
    const bool is_piston = sidecar.moving == "piston";
    const bool is_pair = sidecar.moving == "upper_lower" || sidecar.moving == "strips";
    if (!(is_piston && deck.has_config() && deck.moving.numbers.size() == 1) &&
        !(is_pair && deck.has_bottom() && deck.moving.numbers.size() == 2)) {
      root.fail("moving",
                "must be 'piston' where MOV has one number and there is CON, 'upper_lower' or "
                "'strips' where it has two and there is BOT");
    }
  }
  if (const auto orifice = root.optional_text("orifice")) {
    if (*orifice != "open" && *orifice != "closed") {
      root.fail("orifice", "must be 'open' or 'closed'");
    }
    sidecar.orifice_open = *orifice == "open";
  }
  if (const auto reading = root.optional_text("con_reading")) {
    if (*reading != "A" && *reading != "B") root.fail("con_reading", "must be 'A' or 'B'");
    sidecar.slope_as_angle = *reading == "B";
  }
  sidecar.mass = root.optional_quantity("mass", mass_units, positive);
  if (const auto durations =
          root.optional_numbers("cycle_durations", deck.cycles.size(), time_units)) {
    for (const double duration : *durations) {
      if (!(duration > duration_range.lower && duration <= duration_range.upper)) {
        root.fail("cycle_durations_s", fmt::format("must list {}", duration_range.words));
      }
    }
    sidecar.cycle_durations = *durations;
  }
  root.finish();
  return sidecar;
}

// PRO gives distances without a sign: the side changes where they begin to grow again (errata 26).
std::vector<double> signed_distances(const std::vector<double>& distances) {
  std::size_t turn = 0;
  while (turn + 1 < distances.size() && distances[turn + 1] < distances[turn]) ++turn;
  std::vector<double> places;
  for (std::size_t i = 0; i < distances.size(); ++i) {
    const bool is_left = i <= turn && distances.size() > 1;
    places.push_back(is_left ? -distances[i] : distances[i]);
  }
  return places;
}

SceneParticle deck_particle(const Deck& deck, const Sidecar& sidecar) {
  SceneParticle particle;
  particle.name = "particle";
  particle.count = deck.particles();
  const std::vector<double> places = signed_distances(deck.distances.numbers);
  for (std::size_t i = 0; i < places.size(); ++i) {
    particle.spheres.push_back(
        {Vector3d(places[i] * sidecar.length, 0.0, 0.0), deck.radii[i] * sidecar.length});
  }
  particle.mass = sidecar.mass;
  if (!particle.mass) particle.density = deck.density * sidecar.density;
  return particle;
}

double length_of(const SceneParticle& particle) {
  double low = 0.0, high = 0.0;
  for (const SceneSphere& sphere : particle.spheres) {
    low = std::min(low, sphere.centre.x() - sphere.radius);
    high = std::max(high, sphere.centre.x() + sphere.radius);
  }
  return high - low;
}

// Adds walls in deck units: a plane, and a horizontal patch that is a segment in planar scenes.
class WallMaker {
 public:
  WallMaker(const Deck& deck, const Sidecar& sidecar, SceneFile& scene)
      : deck_(deck), sidecar_(sidecar), scene_(scene) {}

  SceneWall& add_plane(const std::string& name, const Vector3d& point, const Vector3d& normal) {
    SceneWall& wall = add(name, SceneWall::Kind::plane, {point});
    wall.normal = normal;
    return wall;
  }
  SceneWall& add_segment(
      const std::string& name, double from_x, double from_z, double to_x, double to_z) {
    return add(
        name, SceneWall::Kind::segment, {Vector3d(from_x, 0.0, from_z), Vector3d(to_x, 0.0, to_z)});
  }
  // [x0, x1] x [y0, y1] at height z; nothing where it has no area.
  SceneWall* add_patch(
      const std::string& name, double x0, double x1, double y0, double y1, double z) {
    constexpr double tolerance = 1e-9;
    if (x1 - x0 < tolerance || y1 - y0 < tolerance) return nullptr;
    if (sidecar_.is_planar) return &add_segment(name, x0, z, x1, z);
    return &add(
        name,
        SceneWall::Kind::polygon,
        {Vector3d(x0, y0, z), Vector3d(x1, y0, z), Vector3d(x1, y1, z), Vector3d(x0, y1, z)});
  }
  void add_sides() {
    add_plane("left", Vector3d::Zero(), Vector3d::UnitX());
    add_plane("right", Vector3d(deck_.xdim(), 0.0, 0.0), -Vector3d::UnitX());
    if (sidecar_.is_planar) return;
    add_plane("front", Vector3d::Zero(), Vector3d::UnitY());
    add_plane("back", Vector3d(0.0, deck_.ydim(), 0.0), -Vector3d::UnitY());
  }

 private:
  SceneWall& add(const std::string& name, SceneWall::Kind kind, std::vector<Vector3d> points) {
    SceneWall wall;
    wall.name = name;
    wall.kind = kind;
    wall.material = 1;
    for (Vector3d& point : points) point *= sidecar_.length;
    wall.points = std::move(points);
    scene_.walls.push_back(std::move(wall));
    return scene_.walls.back();
  }

  const Deck& deck_;
  const Sidecar& sidecar_;
  SceneFile& scene_;
};

// BOT w1 w2 w3 w4 w5: the middle wall at height w5 of a left strip w1 long, a right strip, a front
// and a back strip w3 wide, and between them the orifice, w2 by w4, with its panel.
void add_middle_wall(const Deck& deck, const Sidecar& sidecar, WallMaker& maker) {
  const auto& w = deck.bottom.numbers;
  const double x1 = w[0], x2 = std::min(w[0] + w[1], deck.xdim()), z = w[4];
  const double y1 = w[2], y2 = deck.ydim() - w[2];
  const auto speed = [&](std::size_t i) {
    return Vector3d(deck.moving.numbers[i] * sidecar.speed, 0.0, 0.0);
  };
  const bool conveyors = deck.has_moving();
  SceneWall& floor = maker.add_plane("floor", Vector3d::Zero(), Vector3d::UnitZ());
  if (conveyors && sidecar.moving == "upper_lower") floor.drag.velocity = speed(1);
  if (SceneWall* left = maker.add_patch("left_strip", 0.0, x1, 0.0, deck.ydim(), z);
      left != nullptr && conveyors) {
    left->drag.velocity = speed(0);
  }
  if (SceneWall* right = maker.add_patch("right_strip", x2, deck.xdim(), 0.0, deck.ydim(), z);
      right != nullptr && conveyors && sidecar.moving == "strips") {
    right->drag.velocity = speed(1);
  }
  if (!sidecar.is_planar) {
    maker.add_patch("front_strip", x1, x2, 0.0, y1, z);
    maker.add_patch("back_strip", x1, x2, y2, deck.ydim(), z);
  }
  if (sidecar.orifice_open) return;
  SceneWall* panel = maker.add_patch("orifice_panel", x1, x2, y1, y2, z);
  if (panel == nullptr) return;
  if (deck.has_fan()) {
    panel->drag.angular_velocity = Vector3d(0.0, 0.0, deck.fan.numbers[0] * sidecar.turning);
    panel->drag.pivot = sidecar.length * Vector3d(0.5 * (x1 + x2), 0.5 * (y1 + y2), z);
  }
  if (deck.has_flow()) panel->opens_at = deck.flow.numbers.empty() ? 0.0 : deck.flow.numbers[0];
}

// CON x z w h gap: a column w wide whose left side is at x, its top at z, under slopes that reach
// the sides of the workspace at height h (reading A) or rise at h degrees (reading B).
void add_hopper(const Deck& deck, const Sidecar& sidecar, WallMaker& maker) {
  const auto& c = deck.config.numbers;
  const double left = c[0], right = c[0] + c[2], throat = c[1];
  const auto top = [&](double run) {
    return sidecar.slope_as_angle ? throat + run * std::tan(c[3] * radians_per_degree) : c[3];
  };
  maker.add_segment("slope_left", 0.0, top(left), left, throat);
  maker.add_segment("slope_right", deck.xdim(), top(deck.xdim() - right), right, throat);
  maker.add_segment("column_left", left, 0.0, left, throat);
  maker.add_segment("column_right", right, 0.0, right, throat);
  maker.add_plane("floor", Vector3d::Zero(), Vector3d::UnitZ());
  if (!sidecar.is_planar) {
    const double front = 0.5 * (deck.ydim() - c[4]);
    maker.add_plane("front", Vector3d(0.0, front, 0.0), Vector3d::UnitY());
    maker.add_plane("back", Vector3d(0.0, deck.ydim() - front, 0.0), -Vector3d::UnitY());
  }
  SceneWall& piston = maker.add_segment("piston", left, throat, right, throat);
  if (deck.has_moving()) {
    piston.motion.velocity = Vector3d(0.0, 0.0, deck.moving.numbers[0] * sidecar.speed);
  }
}

// The lattice stands on the left strip of conveyors, on the panel of a disk, else on all of the
// bottom of the upper box.
SceneFill deck_fill(const Deck& deck, const Sidecar& sidecar, double length) {
  double low_x = 0.0, high_x = deck.xdim(), low_y = 0.0, high_y = deck.ydim(), base = 0.0;
  if (deck.has_bottom()) {
    const auto& w = deck.bottom.numbers;
    base = w[4];
    if (deck.has_moving()) high_x = w[0];
    if (deck.has_fan()) {
      low_x = w[0];
      high_x = std::min(w[0] + w[1], deck.xdim());
      low_y = w[2];
      high_y = deck.ydim() - w[2];
    }
  }
  if (deck.has_config()) base = deck.config.numbers[1];
  SceneFill fill;
  fill.low = sidecar.length * Vector3d(low_x, low_y, base);
  fill.high = sidecar.length * Vector3d(high_x, high_y, deck.zdim());
  fill.clearance = 0.002 * length;  // deck (d) leaves no more between its walls
  // The workspace only bounds the cells of the old contact search: one layer always fits above
  fill.high.z() = std::max(fill.high.z(), fill.low.z() + 1.01 * length);
  return fill;
}

// The thesis's time step for FRAC 1, s:  R_min sqrt(rho/G)/(0.1631 nu + 0.8766), which is 1/pi of
// the Rayleigh step (errata 1).
double thesis_time_step(const Deck& deck, const Sidecar& sidecar) {
  const double smallest = *std::min_element(deck.radii.begin(), deck.radii.end());
  const double shear = sidecar.elastic_modulus / (2.0 * (1.0 + sidecar.poisson_ratio));
  return smallest * sidecar.length * std::sqrt(deck.density * sidecar.density / shear) /
         (0.1631 * sidecar.poisson_ratio + 0.8766);
}

std::vector<ScenePhase> deck_phases(const Deck& deck, const Sidecar& sidecar) {
  const double step = thesis_time_step(deck, sidecar);
  std::vector<ScenePhase> phases;
  for (std::size_t i = 0; i < deck.cycles.size(); ++i) {
    const Deck::Cycle& cycle = deck.cycles[i];
    ScenePhase phase;
    phase.name = fmt::format("cycle {}", i + 1);
    phase.duration = sidecar.cycle_durations.empty() ? cycle.steps * cycle.fraction * step
                                                     : sidecar.cycle_durations[i];
    phase.output_interval = phase.duration / cycle.outputs;
    phase.time_step_fraction = std::min(cycle.fraction / std::numbers::pi, 1.0);
    phase.global_damping = cycle.global_damping;
    phase.friction_between_particles = cycle.friction;
    phase.friction_with_walls = cycle.wall_friction;
    phase.damping_ratio = cycle.damping_ratio;
    phases.push_back(phase);
  }
  return phases;
}

}  // namespace

SceneFile load_deck(const std::filesystem::path& file, const std::filesystem::path& sidecar_file) {
  const Deck deck = read_deck(file);
  std::error_code error;
  if (!std::filesystem::is_regular_file(sidecar_file, error))
    require_keys(deck, sidecar_file, nullptr);
  TomlSection root = TomlFile(sidecar_file).root();
  require_keys(deck, sidecar_file, &root);
  const Sidecar sidecar = read_sidecar(deck, root);

  SceneFile scene;
  scene.file = file;
  scene.name = file.stem().string();
  scene.title = deck.title;
  scene.is_planar = sidecar.is_planar;
  scene.gravity = sidecar.acceleration * deck.gravity;
  scene.inputs = {sidecar_file};
  scene.materials = {{"particle", false, sidecar.elastic_modulus, sidecar.poisson_ratio},
                     {"wall", sidecar.rigid_walls, sidecar.elastic_modulus, sidecar.poisson_ratio}};
  scene.surfaces = {{0, 0, deck.friction, 1.0}, {0, 1, deck.wall_friction, 1.0}};
  scene.particles = {deck_particle(deck, sidecar)};
  WallMaker maker(deck, sidecar, scene);
  maker.add_sides();
  if (deck.has_bottom()) add_middle_wall(deck, sidecar, maker);
  if (deck.has_config()) add_hopper(deck, sidecar, maker);
  if (!deck.has_bottom() && !deck.has_config()) {
    maker.add_plane("floor", Vector3d::Zero(), Vector3d::UnitZ());
  }
  scene.fill = deck_fill(deck, sidecar, length_of(scene.particles[0]));
  scene.phases = deck_phases(deck, sidecar);
  while (scene.event_phase < static_cast<int>(deck.cycles.size()) &&
         !deck.cycles[scene.event_phase].after_event) {
    ++scene.event_phase;
  }
  if (scene.event_phase == static_cast<int>(deck.cycles.size())) scene.event_phase = 0;
  return scene;
}

}  // namespace graintruth::datasets
