// What LAMMPS and LIGGGHTS have in common as engines: which scenes they can take, and how a deck is
// run and its frames become a recording.
#pragma once

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "calibrate/engines/engine.h"
#include "calibrate/engines/scene_build.h"

namespace graintruth::calibrate {

// A scene that has started, with its times in steps that are all equal.
struct DeckScene {
  BuiltScene built;
  double time_step = 0.0;             // s
  long steps_a_frame = 0, steps = 0;  // of all
  std::size_t first_frame = 0;        // the event's
  std::size_t frames = 0;             // from the event on
};

// Files of a deck by their names, of which `deck` is started.
struct Deck {
  std::map<std::string, std::string> files;
  std::string deck;
  std::string frames = "frames.txt";  // that it leaves: LAMMPS's text format of dumps
  // The columns of a frame: the number of the body from 1, x, y, z of its centre
};

// An engine that lets another program run a deck made from the spec. It takes grains of one sphere.
class GranularProgram : public Engine {
 public:
  std::string_view name() const override { return name_; }
  // Of the program, as it says itself, and of the deck. Throws datasets::InputError where it is not
  // installed.
  std::string version() const override;
  bool is_another_program() const override { return true; }
  std::vector<std::string> curves(const SimulationSpec&) const override {
    return {"highest_grain_m"};
  }
  double largest_time_step_fraction(const SimulationSpec& spec) const override;
  // The deck's frames as a recording. A bad end is a status with a sentence, as is a body that is
  // lost or stands at no number.
  EngineRun run(const SimulationSpec& spec, const EngineOptions& options) const override;

 protected:
  // `package` is Debian's that holds `program`. `deck_version` changes whenever the deck gives
  // other numbers.
  GranularProgram(std::string name,
                  std::string program,
                  std::string package,
                  std::string deck_version)
      : name_(std::move(name)),
        program_(std::move(program)),
        package_(std::move(package)),
        deck_version_(std::move(deck_version)) {}

  // Throws datasets::InputError that names what of the scene it cannot take.
  virtual Deck deck_of(const SimulationSpec& spec, const DeckScene& scene) const = 0;

 private:
  std::string name_, program_, package_, deck_version_;
  mutable std::once_flag asked_;
  mutable std::string version_;
};

// The surfaces between a grain and a wall of the scene.
sim::Surfaces surfaces_of(const SimulationSpec& spec, int first, int second);

// As text with all its digits.
std::string digits(double value);
std::string digits(const sim::Vec3& v);

// m: by how much neighbours are looked for beyond contact.
double neighbour_skin(const sim::Scene& scene);

// The file from which a deck reads its atoms, of so many types, and their velocities.
std::string start_data(const sim::Scene& scene, std::size_t types);

// The line of a deck that makes grains heavy.
std::string weight(const SimulationSpec& spec);

}  // namespace graintruth::calibrate
