// Everything that decides the tracks of one film, as plain data: nothing else of an experiment can
// reach the tracker. Written as JSON it has one fingerprint; what is not written cannot matter.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "datasets/experiment/experiment.h"

namespace graintruth::datasets {

// Goes up whenever a tracker gives other numbers for the same film.
inline constexpr int tracker_version = 11;

// What is seen of a particle, and how many of them lie there.
struct SeenBody {
  std::string kind;                       // the trackers know the kinds, see tracking/registry.h
  std::vector<AxialSphere> balls;         // of a body of balls
  std::map<std::string, double> lengths;  // m, of other bodies, by the names of their kind
  std::optional<int> count;               // where the laboratory stated it
};

// Two upright walls on a level floor with an opening in its middle, closed until the start event.
// The origin is the middle of the opening on the floor's upper face.
struct OpenBox {
  double width = 0.0;    // m, between the walls
  double height = 0.0;   // m, of the walls above the floor
  double opening = 0.0;  // m
};

// What the camera sees besides the particles, as far as it is known.
struct SeenRig {
  std::vector<Wall> walls;
  std::optional<MovingFace> face;
  std::optional<OpenBox> box;
  double pane_gap = 0.0;  // m, between the panes; walls reach half of it towards the camera
  double gravity = 9.81;  // m/s2, along -z
  // Where the free surface of the bed is what is looked for, not its grains one by one
  std::optional<SeenOutline> outline;
};

struct TrackingSpec {
  int tracker = tracker_version;
  std::string film_hash;         // of what the film holds
  std::string corrections_hash;  // of the corrections made by hand; empty where there are none
  SeenBody body;
  Camera camera;                   // with the frame rate of this film
  std::vector<StartPlace> starts;  // empty, or one a particle
  SeenRig rig;
};

// Where a film lies. Names files, here and in sentences; decides nothing.
struct Film {
  std::string name;
  std::filesystem::path video;
  std::filesystem::path corrections;  // empty where there are none
  std::filesystem::path experiment;   // the file that names the film
};
Film film_of(const Experiment& experiment, const Replicate& replicate);

// How this replicate's film is to be tracked. Reads the film for its hash; throws InputError where
// that cannot be done.
TrackingSpec make_tracking_spec(const Experiment& experiment, const Replicate& replicate);

std::string fingerprint(const TrackingSpec& spec);

std::string json_text(const Camera& camera);

// The spec as JSON, and back. Throws std::invalid_argument where a field is missing or wrong.
std::string json_text(const TrackingSpec& spec);
TrackingSpec read_tracking_spec(const std::string& json);

}  // namespace graintruth::datasets
