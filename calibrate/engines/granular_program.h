// What LAMMPS and LIGGGHTS have in common as engines: which scenes they can take, and how a deck is
// run and its frames become a recording.
#pragma once

#include <map>
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

// Throws datasets::InputError that names what of the scene the engine cannot take: nothing is left
// out in silence.
DeckScene deck_scene_of(const SimulationSpec& spec, std::string_view engine);

// Files of a deck by their names, of which `deck` is started.
struct Deck {
  std::map<std::string, std::string> files;
  std::string deck;
  std::string frames = "frames.txt";  // that it leaves: LAMMPS's text format of dumps
  // The columns of a frame: the number of the body from 1, x, y, z of its centre
};

// The deck's frames as a recording. A bad end is a status with a sentence, as is a body that is
// lost or stands at no number.
EngineRun run_deck(const SimulationSpec& spec,
                   const EngineOptions& options,
                   const DeckScene& scene,
                   const Deck& deck,
                   const std::string& program);

// What a program says of itself: the first line of `program -h` that names a date or a version.
// Throws datasets::InputError where it is not installed.
std::string version_of_program(const std::string& program, const std::string& package);

// The surfaces between a grain and a wall of the scene.
sim::Surfaces surfaces_of(const SimulationSpec& spec, int first, int second);

// As text with all its digits.
std::string digits(double value);

}  // namespace graintruth::calibrate
