// What is measured and compared: an observable makes numbers of a recording, filmed or simulated by
// the same function, and says how they are compared. An observable is one file of this folder; one
// line of kinds.def makes it known by its name.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calibrate/compare/rule.h"
#include "calibrate/observables/channel.h"
#include "datasets/experiment/experiment.h"
#include "datasets/experiment/recording.h"

namespace graintruth::calibrate {

// What measuring needs to know besides the recording: the grain, the rig as it was, and when it is
// measured.
struct Situation {
  datasets::Particle particle;
  datasets::Rig rig;
  datasets::Measurement measurement;
};

// How a report names a channel and its axis.
struct ChannelWords {
  std::string title;  // "Discharge rate"
  std::string unit;   // SI, as result files write it: kg/s
  std::string axis;   // "time"; empty where there is one number
  std::string axis_unit;
};

struct Confirmed;
struct Evaluation;
struct Problem;
struct Results;
class Observables;

// Replicates as they were measured.
struct MeasuredExperiment {
  const datasets::Experiment& experiment;
  const Observables& observables;
  std::span<const datasets::Recording> recordings;
  std::span<const Situation> situations;
  std::span<const std::vector<Channel>> channels;
};

// What makes a rule: the channels of all replicates, and where they stand in a run.
struct RuleParts {
  datasets::ObjectiveForm form = datasets::ObjectiveForm::smooth;
  const Layout* layout = nullptr;
  const std::vector<Situation>* situations = nullptr;  // of the replicates
  // Of an observable by its name: its place in a run, and the replicates' channels
  struct Of {
    std::size_t channel = 0;
    std::vector<Channel> replicates;
  };
  std::function<std::optional<Of>(std::string_view observable)> of;
};

class Observable {
 public:
  virtual ~Observable() = default;

  virtual std::string name() const = 0;
  virtual ChannelWords words() const = 0;
  // Where the values of a channel with more than one lie on the axis, in the order of the moments;
  // empty where there is none.
  virtual std::vector<double> axis(const Situation&) const { return {}; }

  // Of a recording; nothing known where it cannot tell. A simulation is measured as the replicate
  // was that it is compared with: `like` is that replicate's channel.
  virtual Channel measure(const datasets::Recording& recording,
                          const Situation& situation,
                          const Channel* like = nullptr) const = 0;
  // What cannot be of a recording's channel, as a sentence without its end; empty where all can.
  virtual std::string contradiction(const Channel&, const Situation&) const { return ""; }
  // What a simulation has to record for it, beside tracks.
  virtual std::vector<std::string> curves() const { return {}; }
  virtual bool needs_tracks() const { return false; }
  virtual bool needs_outline() const { return false; }
  // Whether a recording that ends before the last moment of the measurement cannot give it.
  virtual bool needs_every_moment() const { return false; }
  // Whether its values give an agreement in percent.
  virtual bool gives_agreement() const { return false; }
  // Observables that are measured with it because its rule compares them.
  virtual std::vector<std::string> needs() const { return {}; }

  // Nothing where the replicates do not tell what it takes.
  virtual std::unique_ptr<Rule> rule(const RuleParts& parts) const = 0;
  // What the requested form of the objective compares in its place; empty: nothing.
  virtual std::vector<std::string> requested_form() const { return {name()}; }
  // What it adds to measured.json, its tables and what `track` prints: of the replicates alone.
  virtual void tell_measured(const MeasuredExperiment&, Results&) const {}
  // What it adds to the results of a calibration or validation, beside its channel.
  virtual void conclude(const Problem&, const Confirmed&, Results&) const {}
  // What it adds to one evaluation of the scenes that are calibrated on.
  virtual void tell_evaluation(const Problem&, const Evaluation&, Results&) const {}
  // One sentence where the recordings of an experiment cannot give it: what they lack.
  virtual std::string lacking_words() const = 0;
};

// The observables that an experiment asks for, with what they need. Throws InputError for a name
// that nobody knows, and for settings that cannot be.
class Observables {
 public:
  explicit Observables(const datasets::Experiment& experiment);

  const std::vector<std::shared_ptr<const Observable>>& all() const { return all_; }
  // Those that are compared, by their place among all, with their weights.
  struct Compared {
    std::size_t place = 0;
    double weight = 1.0;
  };
  const std::vector<Compared>& compared() const { return compared_; }
  // The one that tells the agreement in percent: the first compared that can. Null: none can.
  const Observable* of_agreement() const;
  // Those that the requested form compares.
  std::vector<Compared> compared_by_request() const;
  std::optional<std::size_t> find(std::string_view name) const;

  std::vector<Channel> measure(const datasets::Recording& recording,
                               const Situation& situation,
                               const std::vector<Channel>* like = nullptr) const;

 private:
  std::size_t add(const std::string& name, datasets::TomlSection* settings);

  const datasets::Experiment* experiment_;
  std::vector<std::shared_ptr<const Observable>> all_;
  std::vector<Compared> compared_;
};

// Makes an observable. `settings` is [measure.<name>] or null; what it states must all be read.
using MakeObservable = std::shared_ptr<const Observable> (*)(const datasets::Experiment& experiment,
                                                             datasets::TomlSection* settings);
struct ObservableKind {
  std::string_view name;
  MakeObservable make;
  // Of one of several surfaces of a rig, whose name follows the kind's own: free_surface_upper.
  // Null where there is no such thing.
  std::shared_ptr<const Observable> (*make_of_surface)(const datasets::Experiment& experiment,
                                                       std::string_view surface) = nullptr;
};

}  // namespace graintruth::calibrate
