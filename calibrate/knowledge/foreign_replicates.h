// Replicates that may not belong: what one of them shows lies farther from what the others show
// than these lie from each other.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibrate/observables/channel.h"
#include "calibrate/problem.h"
#include "datasets/verdict/warning.h"

namespace graintruth::calibrate {

// One quantity of every replicate.
struct RepeatedQuantity {
  std::string name;                         // "tracks", as sentences name it
  std::string unit;                         // of the values; empty where they have several
  std::vector<std::vector<double>> values;  // of the replicates; NaN or empty where not known
  std::vector<std::vector<double>> errors;  // standard deviations of the measurement, or empty
  std::vector<Difference> difference = {Difference::plain};  // in turn over the values
  // Where values are places in m: what a place can be off before it is another one's
  std::optional<double> width = {};
  // Conditions scatter alike, and if it says so, relative to what they show
  bool is_pooled = false, is_relative = false;
};

// Replicates that repeat each other, by their places among all.
struct RepeatedCondition {
  std::string name;  // "orifice width 65 mm"; empty where there is only one
  std::vector<std::size_t> replicates;
};

// The chance that a warning is given of an experiment all of whose replicates belong, and whose
// values scatter normally.
inline constexpr double false_alarm = 0.01;

// A warning of every replicate that may not belong: which, by what, and what it does to the mean.
// 1. Every replicate and quantity is tested against the others (rotation_test.h), by Holm's rule
//    over all of them. From three replicates on this can only tell what is far off: two others
//    hardly show how replicates scatter. With pooled quantities the other conditions show it too.
//    Others that agree by luck are not more exact than each of them says of itself.
// 2. Places are also held against the width of a grain: a replicate is named that is farther than
//    that from every other, and three times as far as the others are from each other.
// Two replicates disagree where they are as far apart, or, of a quantity that states its errors,
// farther than five of these; nobody can tell which of them is wrong.
std::vector<datasets::Warning> foreign_replicates(const std::vector<std::string>& names,
                                                  std::span<const RepeatedCondition> conditions,
                                                  std::span<const RepeatedQuantity> quantities);

// The places at which the grains start, of recordings of the experiment.
RepeatedQuantity starting_places(const datasets::Experiment& experiment,
                                 std::span<const datasets::Recording> recordings);

// The same of a problem: where its grains start, what is compared, and `more` that films tell.
// Counts of grains do not scatter normally (a single jam keeps many) and are left out.
std::vector<datasets::Warning> foreign_replicates(const Problem& problem,
                                                  std::span<const datasets::Recording> recordings,
                                                  std::span<const RepeatedQuantity> more = {});

}  // namespace graintruth::calibrate
