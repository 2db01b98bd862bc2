// The free surface of a bed at one moment, and what is read off it: of an outline, filmed or
// simulated alike.
#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "calibrate/observables/observable.h"

namespace graintruth::calibrate {

struct BedProfile {
  std::vector<double> x;  // m, middles of columns, rising in equal steps
  std::vector<double> z;  // m, of the surface; the floor where the bed does not reach, NaN where
                          // the surface is hidden
  std::vector<double> sigma;  // m; NaN where none is known
  double floor = 0.0;         // m, under the bed
};

// What a rig that is seen by its outline tells of one of its surfaces, by the name (empty where
// there is one without).
datasets::SeenOutline::Surface surface_of(const Situation& situation, std::string_view surface);

// Whether a bed runs out into another one that lies below it, and what stays of it rises outwards.
bool runs_out_below(const Situation& situation, std::string_view surface);

// The columns in which a surface is compared, m. The rig must have a seen outline.
std::vector<double> columns_of(const Situation& situation, std::string_view surface = {});

// The outline of a surface at one of its moments, in the columns of that surface: the mean of its
// own whose middles lie in each; where its own are wider, by a straight line between their middles.
// A stretch without grains is bare floor where the bed next to it is low, at most one and a half
// grains; between higher places something hides the surface.
BedProfile profile_at(const datasets::Outline& outline,
                      std::size_t moment,
                      const Situation& situation);

// Its last moment; nothing where an outline has none.
std::optional<BedProfile> profile_at_rest(const datasets::Recording& recording,
                                          const Situation& situation,
                                          std::string_view surface = {});

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

// The column where a bed that rises to both sides is lowest, the middle of several; none where
// nothing is seen.
std::optional<std::size_t> valley_of(const BedProfile& profile);

// A line through what rises outwards from there on one side: from the highest column of that side
// inwards, over columns between 80 and 20 % of its height above the floor, as far as they are above
// 20 %. The angle rises outwards. Nothing where fewer than three columns tell it.
std::optional<Flank> slope_of(const BedProfile& profile, Side side, const Situation& situation);

// m: where the bed ends on one side, walking outwards from the apex: where it falls below one grain
// diameter. Lone grains are no bed. NaN where something hides it.
double foot_of(const BedProfile& profile, Side side, const Situation& situation);

// m; none where it does not reach from anywhere to anywhere.
struct Span {
  double from = std::numeric_limits<double>::infinity(), to = -from;
  bool is_any() const { return to > from; }
  void reach(double x) {
    from = std::min(from, x);
    to = std::max(to, x);
  }
};

// Of the grains that surely stand on the floor of a surface before the event.
Span first_span(const Situation& situation, std::string_view surface);

// m: of what holds the bed before the event, a column or a tube with its wall.
// Of a surface of several, what stood on its floor; 0 where nothing did.
double first_width(const Situation& situation, std::string_view surface = {});

// An observable of one surface of the bed. Where a rig has several, the name of the surface stands
// at the end of its own: free_surface_upper.
class OfSurface : public Observable {
 public:
  explicit OfSurface(std::string surface) : surface_(std::move(surface)) {}

  std::string name() const final { return named(std::string(stem()), "_"); }
  ChannelWords words() const final {
    ChannelWords words = plain_words();
    words.title = named(std::move(words.title), ", ");
    return words;
  }
  bool needs_outline() const final { return true; }
  std::string lacking_words() const override;

 protected:
  virtual std::string_view stem() const = 0;     // free_surface
  virtual ChannelWords plain_words() const = 0;  // of a rig with one surface
  const std::string& surface() const { return surface_; }
  // Null where the recording does not tell it.
  const datasets::Outline* outline_in(const datasets::Recording& recording) const;

 private:
  std::string named(std::string words, std::string_view between) const;

  std::string surface_;
};

// Throws datasets::InputError where the experiment compares an outline that its rig does not have.
void require_surface(const datasets::Experiment& experiment,
                     std::string_view observable,
                     std::string_view surface);

// How an observable of a surface is made, for its kind.
template <class Made>
std::shared_ptr<const Observable> make_of_surface(const datasets::Experiment& experiment,
                                                  std::string_view surface) {
  const auto made = std::make_shared<Made>(std::string(surface));
  require_surface(experiment, made->name(), surface);
  return made;
}
template <class Made>
std::shared_ptr<const Observable> make_of_outlines(const datasets::Experiment& experiment,
                                                   datasets::TomlSection*) {
  return make_of_surface<Made>(experiment, {});
}

// m, in every column: the floor, or the shell of a drum, which is seen where no grains are.
std::vector<double> bottom_of(const Situation& situation, std::string_view surface = {});

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
