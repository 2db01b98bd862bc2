// The free surface of a bed at one moment, and what is read off it: of an outline, filmed or
// simulated alike.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "calibrate/observables/observable.h"

namespace graintruth::calibrate {

struct BedProfile {
  std::vector<double> x;  // m, middles of columns, rising in equal steps
  std::vector<double> z;  // m, of the surface; the floor where the bed does not reach, NaN where
                          // the surface is hidden
  std::vector<double> sigma;  // m; NaN where none is known
};

// The columns in which a situation is compared, m. Its rig must have a seen outline.
std::vector<double> columns_of(const Situation& situation);

// The outline at one of its moments, in these columns: the mean of its own whose middles lie in
// each; where its own are wider, by a straight line between their middles. A stretch
// without grains is bare floor where the bed next to it is low, at most one and a half grains;
// between higher places something hides the surface.
BedProfile profile_at(const datasets::Outline& outline,
                      std::size_t moment,
                      const Situation& situation);

// Its last moment; nothing where an outline has none.
std::optional<BedProfile> profile_at_rest(const datasets::Recording& recording,
                                          const Situation& situation);

// The highest column; none where nothing is seen.
std::optional<std::size_t> apex_of(const BedProfile& profile);

enum class Side { left, right };

// A straight line through one flank, by least squares: from the apex down, over columns between 20
// and 80 % of the height of the apex above the floor, as far as they are above 20 %.
struct Flank {
  double angle = 0.0;               // rad, above the level, falling outwards
  double standard_error = 0.0;      // rad; from how far columns lie off the line, those within one
                                    // grain counted once
  double roughness = 0.0;           // m, root mean square of that
  double from_x = 0.0, to_x = 0.0;  // m, first and last column
  int columns = 0;
};
// Nothing where fewer than three columns tell it.
std::optional<Flank> flank_of(const BedProfile& profile, Side side, const Situation& situation);

// m: where the bed ends on one side, walking outwards from the apex: where it falls below one grain
// diameter. Lone grains are no bed. NaN where something hides it.
double foot_of(const BedProfile& profile, Side side, const Situation& situation);

// m: of what holds the bed before the event, a column or a tube with its wall.
double first_width(const Situation& situation);

// Throws datasets::InputError where the experiment compares an outline that its rig does not have.
void require_outline(const datasets::Experiment& experiment, std::string_view observable);

// How an observable of outlines is made, for its kind.
template <class OfOutlines>
std::shared_ptr<const Observable> make_of_outlines(const datasets::Experiment& experiment,
                                                   datasets::TomlSection*) {
  const auto made = std::make_shared<OfOutlines>();
  require_outline(experiment, made->name());
  return made;
}

// m, in every column: the floor, or the shell of a drum, which is seen where no grains are.
std::vector<double> bottom_of(const Situation& situation);

// The rule of values at many places or moments, each from its own replicates. What is claimed to be
// known better than by `least_error` (grain diameters) counts as known so well. `lacking` is what
// counts where a simulation has no value (repeated_rule.h). Null where nothing was measured.
std::unique_ptr<Rule> rule_of_outlines(const RuleParts& parts,
                                       std::string_view observable,
                                       double least_error,
                                       std::vector<double> lacking = {});

inline constexpr const char* lacking_outline =
    "an outline of the bed: a film of it, or a table with columns time_s, column_m and height_m";

}  // namespace graintruth::calibrate
