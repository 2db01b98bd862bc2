// An observable that is one curve of a recording: for those of the user's own, and for others that
// an engine records under a name.
#pragma once

#include "calibrate/observables/observable.h"

namespace graintruth::calibrate {

// How a curve in time becomes one number, from the event to the last moment of the measurement.
enum class CurveNumber {
  end,     // its value at the last moment
  mean,    // of its values at all moments
  largest  // of all that was recorded
};

// The key `at` of an observable's settings; none where it is not stated.
std::optional<CurveNumber> read_curve_number(datasets::TomlSection& settings);

struct OwnCurve {
  std::string name;
  std::string column;        // of the replicates' tables
  std::string engine_curve;  // what an engine records of the same
  std::string unit;
  std::string title;
  // Given: curves are compared by this number. Else moment by moment, or by their end with
  // replicates that have one number.
  std::optional<CurveNumber> number = {};
};

class CurveObservable : public Observable {
 public:
  explicit CurveObservable(OwnCurve curve) : curve_(std::move(curve)) {}

  std::string name() const override { return curve_.name; }
  ChannelWords words() const override { return {curve_.title, curve_.unit, "time", "s"}; }
  std::vector<double> axis(const Situation& situation) const override;
  Channel measure(const datasets::Recording& recording,
                  const Situation& situation,
                  const Channel* like) const override;
  std::vector<std::string> curves() const override { return {curve_.engine_curve}; }
  bool needs_every_moment() const override { return true; }
  std::unique_ptr<Rule> rule(const RuleParts& parts) const override;
  std::string lacking_words() const override;

 private:
  OwnCurve curve_;
};

}  // namespace graintruth::calibrate
