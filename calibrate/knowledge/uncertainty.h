// How well the data pin the parameters down: which values are not significantly worse than the
// best, when replicates and seeds could have been others.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "calibrate/compare/comparison.h"
#include "calibrate/knowledge/prior.h"
#include "calibrate/search/emulator.h"
#include "calibrate/search/surrogate.h"

namespace graintruth::calibrate {

struct Interval {
  double lower = 0.0;
  double upper = 0.0;
};

// How one end of an interval came about. An end that was not found stands at the bound of the
// search, so that the interval is never too narrow.
enum class EndKind {
  found,        // a value beyond it was shown to be worse
  open,         // every value up to the bound of the search fits as well as the best
  search_ended  // budget or time was used up before either was shown
};
// As result.json and tables call it: "found", "open", "budget_ended".
std::string_view name_of(EndKind end);

// How much worse an evaluation is than the reference, and by how much it may be worse before its
// parameters can be told from the true ones. With a prior the excess is that of the total, and what
// is allowed is what the prior was weighed by.
struct Excess {
  double objective = 0.0;  // above the reference's
  double allowed = 0.0;
  bool is_compatible() const { return objective <= allowed; }
};
// Of all evaluations. The cost of own widths is the median over those that are near enough to the
// best to be compared with it: one particle that did something else in one replicate may rule a
// single pair.
PooledChance pool_chance(const Comparison& comparison,
                         std::span<const Evaluation> evaluations,
                         double roughness);

Excess excess_over(const Comparison& comparison,
                   const Evaluation& reference,
                   const Evaluation& evaluation,
                   const PooledChance& chance,
                   const Prior& prior = {});

// Those of the evaluations that cannot be told apart from the reference.
std::vector<Evaluation> compatible_with(const Comparison& comparison,
                                        const Evaluation& reference,
                                        std::span<const Evaluation> evaluations,
                                        const PooledChance& chance,
                                        const Prior& prior = {});

// The most that is allowed to any of the evaluations that cannot be told from their best.
double largest_allowed_excess(const Comparison& comparison,
                              const ParameterSpace& space,
                              std::span<const Evaluation> evaluations);

// One value of one parameter, with the others where the emulator puts their best.
struct ProfilePoint {
  double value = 0.0;  // of the parameter
  double objective = 0.0;
  Excess excess;
};

// The 95 % interval of a parameter: the values from which the best cannot be told apart (the
// inversion of a test). From the outermost evaluation that is compatible, each end is sought by
// bisection on real simulations; it is the innermost value beyond that was shown to be
// incompatible.
struct Profile {
  std::string name;
  double best = 0.0;  // its value at the best evaluation
  Interval interval;
  EndKind below = EndKind::found;
  EndKind above = EndKind::found;
  std::vector<ProfilePoint> points;  // rising in value; the reference among them

  bool has_an_end() const { return below == EndKind::found || above == EndKind::found; }
};

struct ProfileOptions {
  Prior prior = {};                   // without one, or not weighed: of the data alone
  int rounds = 6;                     // of one evaluation on either side of every parameter
  std::vector<std::string> left_out;  // parameters that need no interval
  int max_evaluations = std::numeric_limits<int>::max();
  double first_step = 0.04;  // of the range; doubled while the value is compatible
  double tolerance = 0.015;  // of the range; an end known to this is not sought further
};

// `evaluate` runs new parameter sets with the seeds of the search. `evaluations` are those of the
// search so far; the best of them is the reference.
std::vector<Profile> profile_parameters(
    const Comparison& comparison,
    const ParameterSpace& space,
    std::span<const Evaluation> evaluations,
    const std::function<std::vector<Evaluation>(const std::vector<ParameterSet>&)>& evaluate,
    const ProfileOptions& options);

// The surrogate of ln(J + noise), J the objective, over the unit cube of `space`: differences below
// the noise of the lowest evaluations mean nothing, and where few numbers are measured J can be 0
// all along a line. Evaluations of which most runs
// failed are left out; the objective is cut off well above its minimum, where the landscape is a
// cliff (particles jam) that would hide the valley's lengths.
Surrogate fit_surrogate(const Comparison& comparison,
                        std::span<const Evaluation> evaluations,
                        const ParameterSpace& space);

// The same with the prior's penalty, once it is weighed.
Surrogate with_prior(Surrogate surrogate, const ParameterSpace& space, const Prior& prior);

// One coordinate that is held.
struct HeldCoordinate {
  std::size_t dimension = 0;
  double value = 0.0;
};

// What is predicted at each of many places; the lower the better.
using Landscape = std::function<std::vector<double>(std::span<const UnitPoint>)>;
Landscape landscape_of(const Surrogate& surrogate);
Landscape landscape_of(const Emulator& emulator, const ParameterSpace& space, const Prior& prior);

// The place of a landscape's minimum with the `held` coordinates at their values: on a regular
// grid, refined around its lowest place.
UnitPoint minimum_of(const Landscape& landscape,
                     std::size_t dimension,
                     std::span<const HeldCoordinate> held = {});

// Median noise of the few lowest evaluations: differences below it mean nothing.
double noise_of_lowest(const Comparison& comparison, std::span<const Evaluation> evaluations);

// The lowest total of objective and penalty first; equal ones in their order.
std::vector<const Evaluation*> by_objective(std::span<const Evaluation> evaluations,
                                            const Prior& prior = {});

const Evaluation& best_of(std::span<const Evaluation> evaluations, const Prior& prior = {});

}  // namespace graintruth::calibrate
