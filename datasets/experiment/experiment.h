// What a laboratory did and wants to know: the experiment file, read, checked and in SI units.
// x right, z up, y out of the picture; the origin is the laboratory's own.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "datasets/experiment/camera.h"
#include "datasets/experiment/execution.h"
#include "datasets/experiment/particle.h"
#include "datasets/experiment/simulator.h"
#include "datasets/imports/track_files.h"
#include "datasets/parameters/parameter_set.h"
#include "datasets/rigs/rig.h"
#include "datasets/store/outline.h"

namespace graintruth::datasets {

// A bench value. The uncertainty is one standard deviation; 0 where the laboratory gave none.
struct BenchValue {
  double value = 0.0;
  double standard_uncertainty = 0.0;
};

// Elasticity, and the bench values of contact parameters by their names in the registry.
struct Material {
  double elastic_modulus = 0.0;                           // Pa
  double poisson_ratio = 0.0;                             // -
  std::vector<std::pair<std::string, BenchValue>> bench;  // those that are stated

  const BenchValue* stated(std::string_view parameter) const;
};

// Where a particle nominally lies before the event; gives it its number.
struct StartPlace {
  double x = 0.0, z = 0.0;  // m
  double angle = 0.0;       // rad
};

struct Replicate {
  std::string name;  // stem of the file unless given
  // One of the first three at most; one of all at least
  std::filesystem::path video;
  std::filesystem::path tracks;      // see track_files.h
  std::filesystem::path outline;     // see outline.h
  std::filesystem::path discharge;   // see discharge_curve.h
  std::filesystem::path curves;      // see curve_files.h
  Eye eye;                           // from where the file of an outline was seen
  TrackSource source;                // how the file of tracks is meant; event_time of all files
  std::optional<double> frame_rate;  // Hz, where it is not the camera's
  // As Camera::noted_event_time, of this film alone
  std::optional<double> noted_event_time;
  Rig rig;                            // as it was for this replicate
  std::filesystem::path corrections;  // CSV of corrections made by hand; empty where there are none
  // Kept out of the calibration, to be predicted. Where no replicate says so, see
  // calibrate/problem.h.
  std::optional<bool> held_out;

  const std::filesystem::path& file() const {
    return !video.empty()       ? video
           : !tracks.empty()    ? tracks
           : !outline.empty()   ? outline
           : !discharge.empty() ? discharge
                                : curves;
  }
};

class TomlSection;

// One observable that is compared, by its name in calibrate/observables.
struct RequestedObservable {
  std::string name;
  double weight = 1.0;
  std::shared_ptr<TomlSection> settings;  // [measure.<name>]; null where there is none
};

// When and what is compared.
struct Measurement {
  double frame_interval = 0.2;  // s
  int frames = 25;              // at 0, frame_interval, ... from the event
  std::vector<RequestedObservable> observables;

  double last_time() const { return frame_interval * (frames - 1); }
};

// A parameter that the calibration may move.
struct TunedParameter {
  std::string name;  // in the registry
  double lower = 0.0;
  double upper = 0.0;
  // What is known of it besides the data: the mean of a Gaussian and its standard deviation.
  std::optional<BenchValue> prior = {};
};

// How the time step is found: the largest at which the answer does not change, before the search;
// or as one more axis of the search, where it may be traded against the parameters.
enum class TimeStepRule { gate, joint };

// What the search minimises: the smooth distance of what was measured, or what the model is judged
// by in the end: one minus the agreement of tracks, and for bins the constants of Beverloo's law
// and of the kinematic model.
enum class ObjectiveForm { smooth, requested };
std::string_view name_of(ObjectiveForm form);

struct Experiment {
  std::filesystem::path file;
  std::filesystem::path annotation;  // the file that it includes; empty: none
  std::string name;                  // stem of the file: names the run folder
  std::string title;
  std::string note;     // provenance that every report must repeat, e.g. that films are synthetic
  std::string part_of;  // title of the joint calibration that it is read for; empty: none
  Particle particle;
  Material material;
  Rig rig;  // of all replicates; what only they tell is missing
  Camera camera;
  std::vector<StartPlace> starts;  // empty, or one a particle
  std::vector<Replicate> replicates;
  std::vector<std::filesystem::path> inputs;  // further files that were read
  std::vector<std::string> notes;             // sentences on how those were understood
  Measurement measurement;
  std::vector<TunedParameter> tuned;
  TimeStepRule time_step_rule = TimeStepRule::gate;
  ObjectiveForm objective = ObjectiveForm::smooth;
  Execution execution;
  Simulator simulator;
};

// The name that an experiment file gives to its run: its stem, or that of its folder where the file
// is called experiment.toml.
std::string experiment_name(const std::filesystem::path& file);

// Reads, converts to SI and checks an experiment file. Throws InputError with file, line and key
// for a key that is unknown or missing, a unit that does not fit, or a value that cannot be. Does
// not open videos, tracks or curves, but they must exist.
Experiment load_experiment(const std::filesystem::path& file,
                           Purpose purpose = Purpose::calibration);
// With this annotation in place of the one that the file names (annotation.h).
Experiment load_experiment(const std::filesystem::path& file,
                           const std::filesystem::path& annotation,
                           Purpose purpose);

// The experiment as one replicate was made and filmed: with its own rig and frame rate in `rig` and
// `camera`.
Experiment as_filmed(const Experiment& experiment, const Replicate& replicate);

// The bench value of a parameter: as stated, else that of the parameter which it follows, else the
// value at which it does nothing.
BenchValue bench_value(const Experiment& experiment, std::string_view parameter);

// The bench values of all parameters that the experiment states or tunes.
ParameterSet bench_parameters(const Experiment& experiment);

// A TOML file of parameters, name = value, with the units of experiment files. Throws InputError
// for an unknown name or an impossible value.
std::map<std::string, double> read_parameter_table(const std::filesystem::path& file);

}  // namespace graintruth::datasets
