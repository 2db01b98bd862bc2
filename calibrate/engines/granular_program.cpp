#include "calibrate/engines/granular_program.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "calibrate/engines/embedded.h"
#include "calibrate/engines/scratch_folder.h"
#include "datasets/store/external_program.h"
#include "datasets/store/input_error.h"
#include "datasets/store/run_folder.h"
#include "sim/laws/time_step.h"

namespace graintruth::calibrate {

namespace {

using datasets::InputError;
using datasets::SceneData;
using datasets::ScenePhase;
using datasets::SceneWall;

[[noreturn]] void refuse(std::string_view engine, const std::string& what) {
  throw InputError(fmt::format(
      "the engine '{}' cannot simulate this scene: {}; use the engine 'embedded'.", engine, what));
}

void require_plain_phases(const SceneData& scene, std::string_view engine) {
  for (const ScenePhase& phase : scene.phases) {
    if (phase.until_rest) refuse(engine, "a phase lasts until rest");
    if (phase.global_damping != 0.0 || phase.friction_between_particles ||
        phase.friction_with_walls || phase.restitution || phase.restitution_at_most ||
        phase.damping_ratio)
      refuse(engine, "a phase sets friction, restitution or damping of its own");
  }
  const datasets::SceneLaw usual;
  const datasets::SceneLaw& law = scene.law;
  if (law.normal_spring != usual.normal_spring ||
      law.tangential_spring != usual.tangential_spring ||
      law.coulomb_limit != usual.coulomb_limit || law.damping_form != usual.damping_form)
    refuse(engine, "its contact law is not the default one");
}

void require_plain_surfaces(const SceneData& scene, std::string_view engine) {
  for (const datasets::SceneSurfaces& surfaces : scene.surfaces) {
    if (surfaces.rolling_friction != 0.0) refuse(engine, "it has rolling friction");
    if (surfaces.static_friction != 0.0 && surfaces.static_friction != surfaces.friction)
      refuse(engine, "its static friction is not its friction");
  }
  for (const datasets::SceneParticle& particle : scene.particles) {
    if (particle.material != scene.particles.front().material)
      refuse(engine, "its grains are of several materials");
  }
  for (const SceneWall& wall : scene.walls) {
    if (wall.kind != SceneWall::Kind::plane)
      refuse(engine, fmt::format("the wall '{}' is no plane", wall.name));
    if (!(wall.drag == datasets::SceneMotion{}) || !wall.motion.angular_velocity.isZero(0.0))
      refuse(engine, fmt::format("the wall '{}' turns, or drags its surface", wall.name));
    if (!scene.materials[static_cast<std::size_t>(wall.material)].is_rigid)
      refuse(engine, fmt::format("the wall '{}' is not rigid", wall.name));
  }
}

// One frame of a dump: rows of numbers by the number of the body.
bool read_frame(std::istream& stream, std::size_t bodies, std::vector<sim::Vec3>& centres) {
  std::string line;
  std::size_t rows = 0;
  while (std::getline(stream, line)) {
    if (line.starts_with("ITEM: NUMBER OF")) {
      std::getline(stream, line);
      rows = static_cast<std::size_t>(std::strtoull(line.c_str(), nullptr, 10));
    }
    if (line.starts_with("ITEM: ATOMS") || line.starts_with("ITEM: ENTRIES")) break;
  }
  if (!stream || rows != bodies) return false;
  centres.assign(bodies, sim::Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
  for (std::size_t row = 0; row < rows; ++row) {
    if (!std::getline(stream, line)) return false;
    const char* at = line.c_str();
    char* end = nullptr;
    const double number = std::strtod(at, &end);
    if (end == at || !(number >= 1.0) || number > static_cast<double>(bodies)) return false;
    sim::Vec3& centre = centres[static_cast<std::size_t>(number) - 1];
    for (int axis = 0; axis < 3; ++axis) {
      at = end;
      centre[axis] = std::strtod(at, &end);
      if (end == at) return false;
    }
  }
  return std::all_of(
      centres.begin(), centres.end(), [](const sim::Vec3& c) { return c.allFinite(); });
}

void keep_frame(const SimulationSpec& spec,
                const DeckScene& scene,
                std::size_t frame,
                const std::vector<sim::Vec3>& centres,
                datasets::Recording& recording) {
  const double time =
      static_cast<double>(frame) * static_cast<double>(scene.steps_a_frame) * scene.time_step;
  if (auto& tracks = recording.tracks) {
    tracks->time[frame] = time;
    for (std::size_t i = 0; i < centres.size(); ++i) {
      datasets::Pose& pose = tracks->poses[tracks->index(frame, i)];
      pose.x = centres[i].x();
      pose.z = centres[i].z();
    }
  }
  if (spec.scene.exit_height) {
    double mass = 0.0;
    for (std::size_t i = 0; i < centres.size(); ++i) {
      const auto type = static_cast<std::size_t>(scene.built.scene.bodies[i].type);
      if (centres[i].z() < *spec.scene.exit_height) mass += scene.built.scene.types[type].mass;
    }
    recording.discharge->time.push_back(time);
    recording.discharge->mass.push_back(mass);
  }
  if (!spec.record.curves.empty()) {
    double highest = -std::numeric_limits<double>::infinity();
    for (const sim::Vec3& centre : centres) highest = std::max(highest, centre.z());
    datasets::Curve& curve = recording.curves["highest_grain_m"];
    curve.time.push_back(time);
    curve.value.push_back(highest);
  }
}

// The first line that says what went wrong.
std::string error_line(const datasets::ExternalEnd& end) {
  for (const std::string* text : {&end.out, &end.err}) {
    std::istringstream lines(*text);
    for (std::string line; std::getline(lines, line);) {
      if (line.find("ERROR") != std::string::npos) return ": " + line;
    }
  }
  return "";
}

// Throws datasets::InputError that names what of the scene the engine cannot take: nothing is left
// out in silence.
DeckScene deck_scene_of(const SimulationSpec& spec, std::string_view engine) {
  const SceneData& scene = spec.scene;
  // 1. What it takes
  if (scene.is_planar) refuse(engine, "it is of one layer");
  if (scene.period.is_given()) refuse(engine, "it is periodic");
  require_plain_phases(scene, engine);
  require_plain_surfaces(scene, engine);
  const bool rains = scene.fill.method == datasets::SceneFill::Method::rain &&
                     std::any_of(scene.particles.begin(),
                                 scene.particles.end(),
                                 [](const auto& particle) { return particle.count > 0; });
  if (rains) refuse(engine, "its grains rain in");
  for (const std::string& curve : spec.record.curves) {
    if (curve != "highest_grain_m") refuse(engine, fmt::format("it records no {}", curve));
  }
  DeckScene made{.built = start_of(spec)};
  for (const sim::Clump& grain : made.built.scene.types) {
    if (grain.spheres.size() > 1) refuse(engine, "its grains are clumps of several spheres");
  }
  // 2. Steps that hit every frame
  double interval = 0.0, before = 0.0, after = 0.0;
  double longest = std::numeric_limits<double>::infinity();
  for (std::size_t p = 0; p < scene.phases.size(); ++p) {
    const ScenePhase& phase = scene.phases[p];
    const bool is_after = p >= static_cast<std::size_t>(scene.event_phase);
    (is_after ? after : before) += phase.duration;
    use_surfaces(scene, phase, made.built.scene.surfaces);
    longest = std::min(longest,
                       sim::choose_time_step(made.built.scene,
                                             {.fraction = phase.time_step_fraction,
                                              .impact_speed = phase.fastest_impact}));
    if (!is_after) continue;
    if (interval != 0.0 && phase.output_interval != interval)
      refuse(engine, "its phases have different output intervals");
    interval = phase.output_interval;
  }
  if (!(interval > 0.0)) interval = after;
  made.steps_a_frame = static_cast<long>(std::ceil(interval / longest));
  made.time_step = interval / static_cast<double>(made.steps_a_frame);
  made.first_frame = static_cast<std::size_t>(std::lround(before / interval));
  if (std::abs(static_cast<double>(made.first_frame) * interval - before) > 1e-9 * interval)
    refuse(engine, "what comes before the start event is no multiple of the output interval");
  made.frames = static_cast<std::size_t>(std::floor(after / interval + 0.5)) + 1;
  made.steps = static_cast<long>(made.first_frame + made.frames - 1) * made.steps_a_frame;
  return made;
}

EngineRun run_deck(const SimulationSpec& spec,
                   const EngineOptions& options,
                   const DeckScene& scene,
                   const Deck& deck,
                   const std::string& program) {
  EngineRun run{.time_step = scene.time_step};
  if (options.step_limit > 0 && scene.steps > options.step_limit) {
    run.status = RunStatus::timed_out;
    run.message = fmt::format(
        "it takes {} steps, more than the limit of {}", scene.steps, options.step_limit);
    return run;
  }
  // 1. The program
  const ScratchFolder scratch(options.scratch);
  for (const auto& [name, content] : deck.files) {
    std::ofstream file(scratch.path() / name, std::ios::binary);
    file << content;
    if (!file.flush())
      throw InputError(fmt::format("{}: cannot be written.", (scratch.path() / name).string()));
  }
  const int ranks = spec.foreign ? spec.foreign->ranks : 1;
  datasets::ExternalCall call{.words = {}, .folder = scratch.path()};
  if (ranks > 1) {
    call.words = {"mpirun", "--oversubscribe", "-np", std::to_string(ranks)};
    if (::geteuid() == 0) call.words.insert(call.words.begin() + 1, "--allow-run-as-root");
  }
  call.words.insert(call.words.end(), {program, "-in", deck.deck, "-log", "none"});
  call.environment = {{"OMP_NUM_THREADS", "1"}};
  call.time_limit = options.time_limit;
  call.stop = options.stop;
  const datasets::ExternalEnd end = datasets::run_external(call);
  using How = datasets::ExternalEnd::How;
  if (end.how == How::stopped) throw Interrupted();
  const auto end_badly = [&](RunStatus status, const std::string& message) {
    run.status = status;
    run.message = message;
    run.recording = {};
    return run;
  };
  if (end.how == How::not_started)
    throw InputError(fmt::format("{} {}.", call.words.front(), end.words()));
  if (end.how == How::too_late) {
    return end_badly(RunStatus::timed_out,
                     fmt::format("{} did not end within {:.4g} s", program, options.time_limit));
  }
  if (!end.succeeded())
    return end_badly(RunStatus::unstable,
                     fmt::format("{} {}{}", program, end.words(), error_line(end)));
  // 2. Its frames
  const std::size_t bodies = scene.built.scene.bodies.size();
  if (spec.record.tracks)
    run.recording.tracks =
        datasets::make_trajectories(scene.frames, static_cast<int>(bodies), false);
  if (spec.scene.exit_height) run.recording.discharge.emplace();
  std::ifstream stream(scratch.path() / deck.frames);
  std::vector<sim::Vec3> centres;
  for (std::size_t frame = 0; frame < scene.first_frame + scene.frames; ++frame) {
    if (!read_frame(stream, bodies, centres)) {
      return end_badly(
          RunStatus::unstable,
          fmt::format("{} lost grains, or left numbers that are none, before {:.4g} s",
                      program,
                      static_cast<double>(frame * static_cast<std::size_t>(scene.steps_a_frame)) *
                          scene.time_step));
    }
    if (frame >= scene.first_frame)
      keep_frame(spec, scene, frame - scene.first_frame, centres, run.recording);
  }
  return run;
}

// The first line of `program -h` that names a date or a version.
std::string version_of_program(const std::string& program, const std::string& package) {
  if (!datasets::find_program(program)) {
    throw InputError(fmt::format(
        "the program '{}' is not installed; install the package {}, or use another engine.",
        program,
        package));
  }
  const datasets::ExternalEnd end =
      datasets::run_external({.words = {program, "-log", "none", "-h"}, .time_limit = 60.0});
  std::istringstream lines(end.out + end.err);
  for (std::string line; std::getline(lines, line);) {
    const auto version = line.find("(Version "), name = line.find("Simulator - ");
    if (version != std::string::npos) return line.substr(version + 9, line.find(',') - version - 9);
    if (name != std::string::npos) return line.substr(name + 12);
  }
  return "of an unknown version";
}

}  // namespace

std::string digits(double value) { return fmt::format("{:.17g}", value); }

std::string digits(const sim::Vec3& v) {
  return fmt::format("{} {} {}", digits(v.x()), digits(v.y()), digits(v.z()));
}

double neighbour_skin(const sim::Scene& scene) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const sim::Clump& grain : scene.types) smallest = std::min(smallest, grain.smallest_radius);
  return 0.2 * smallest;
}

std::string start_data(const sim::Scene& scene, std::size_t types) {
  std::string atoms, speeds;
  sim::Vec3 low = sim::Vec3::Constant(1e300), high = -low;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const sim::Body& body = scene.bodies[b];
    const sim::Clump& grain = scene.types[static_cast<std::size_t>(body.type)];
    const double radius = grain.spheres.front().radius;
    atoms += fmt::format("{} 1 {} {} {}\n",
                         b + 1,
                         digits(2.0 * radius),
                         digits(grain.mass / grain.volume),
                         digits(body.position));
    speeds +=
        fmt::format("{} {} {}\n", b + 1, digits(body.velocity), digits(body.angular_velocity));
    // Neighbours are looked for in boxes of the cutoff, of which at least one must fit in
    const sim::Vec3 margin = sim::Vec3::Constant(4.0 * radius);
    low = low.cwiseMin(body.position - margin);
    high = high.cwiseMax(body.position + margin);
  }
  std::string text =
      fmt::format("graintruth\n\n{} atoms\n{} atom types\n", scene.bodies.size(), types);
  for (int axis = 0; axis < 3; ++axis)
    text += fmt::format(
        "{} {} {}lo {}hi\n", digits(low[axis]), digits(high[axis]), "xyz"[axis], "xyz"[axis]);
  return text + "\nAtoms\n\n" + atoms + "\nVelocities\n\n" + speeds;
}

std::string weight(const SimulationSpec& spec) {
  const double gravity = spec.scene.gravity.norm();
  const sim::Vec3 down =
      gravity > 0.0 ? sim::Vec3(spec.scene.gravity / gravity) : sim::Vec3(0.0, 0.0, -1.0);
  return fmt::format("fix weight all gravity {} vector {}\n", digits(gravity), digits(down));
}

sim::Surfaces surfaces_of(const SimulationSpec& spec, int first, int second) {
  sim::SurfaceTable table;
  use_surfaces(spec.scene, spec.scene.phases.front(), table);
  return table.of(first, second);
}

std::string GranularProgram::version() const {
  std::call_once(asked_, [this] { version_ = version_of_program(program_, package_); });
  return fmt::format("{}, deck {}", version_, deck_version_);
}

double GranularProgram::largest_time_step_fraction(const SimulationSpec& spec) const {
  return embedded_engine().largest_time_step_fraction(spec);
}

EngineRun GranularProgram::run(const SimulationSpec& spec, const EngineOptions& options) const {
  try {
    const DeckScene scene = deck_scene_of(spec, name_);
    return run_deck(spec, options, scene, deck_of(spec, scene), program_);
  } catch (const std::invalid_argument& error) {
    return {.status = RunStatus::unstable, .message = error.what()};
  }
}

}  // namespace graintruth::calibrate
